//! The camera of a file that has none.

use crate::endpoint::{EndpointError, PinholeCamera};
use crate::geometry::Bounds;
use glam::{DVec3, UVec2};

/// Field of view of the camera of a file that has none.
const FIELD_OF_VIEW: f64 = 40.0;

/// A camera that sees everything, from the front, which is +z, a little from the right and above.
pub(crate) fn framing(bounds: Bounds, resolution: UVec2) -> Result<PinholeCamera, EndpointError> {
    let (center, radius) = (bounds.center(), bounds.radius().max(1e-9));
    let narrower = (f64::from(resolution.x) / f64::from(resolution.y)).min(1.0);
    let half_angle = libm::atan(narrower * libm::tan(0.5 * FIELD_OF_VIEW.to_radians()));
    let position =
        center + DVec3::new(0.35, 0.25, 1.0).normalize() * (radius / libm::sin(half_angle));
    PinholeCamera::new(position, center, DVec3::Y, FIELD_OF_VIEW, resolution)
}
