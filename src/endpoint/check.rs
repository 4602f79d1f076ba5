//! Checks that constructors of endpoints share.

use super::EndpointError;
use crate::math::{Rgb, unit};
use glam::DVec3;

/// The colour, if it is finite and non-negative.
pub(super) fn emission(
    object: &'static str,
    quantity: &'static str,
    value: Rgb,
) -> Result<Rgb, EndpointError> {
    if !value.is_finite() {
        return Err(EndpointError::NotFinite { object, quantity });
    }
    if value.0.iter().any(|c| *c < 0.0) {
        return Err(EndpointError::Negative { object, quantity });
    }
    Ok(value)
}

/// The position, if it is finite.
pub(super) fn position(
    object: &'static str,
    quantity: &'static str,
    value: DVec3,
) -> Result<DVec3, EndpointError> {
    if value.is_finite() { Ok(value) } else { Err(EndpointError::NotFinite { object, quantity }) }
}

/// The unit vector of a direction of any length but zero.
pub(super) fn direction(
    object: &'static str,
    quantity: &'static str,
    value: DVec3,
) -> Result<DVec3, EndpointError> {
    let value = position(object, quantity, value)?;
    unit(value).ok_or(EndpointError::ZeroDirection { object, quantity })
}

/// The number, if it is positive and finite.
pub(super) fn positive(
    object: &'static str,
    quantity: &'static str,
    value: f64,
) -> Result<f64, EndpointError> {
    if !value.is_finite() {
        return Err(EndpointError::NotFinite { object, quantity });
    }
    if value > 0.0 {
        Ok(value)
    } else {
        Err(EndpointError::NotPositive { object, quantity, value })
    }
}
