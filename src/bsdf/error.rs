//! What can be wrong with the parameters of a scattering model.

use crate::math::Rgb;
use std::fmt;

/// A parameter out of its range. The message does not name the object: whoever knows its name adds
/// it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BsdfError {
    /// A component of an albedo or reflectance is not in [0, 1].
    Reflectance(Rgb),
    /// A relative index of refraction is not in [1e-6, 1e6].
    RelativeIor(f64),
    /// A component of a complex index of refraction `eta + i k` is not in [0, 1e6].
    ComplexIor(Rgb, Rgb),
    /// A roughness is not in [0, 10].
    Roughness(f64, f64),
    /// A metalness or roughness of the metallic-roughness model is not in [0, 1].
    MetallicRoughness(f64, f64),
    /// A mixture's weights or probabilities are negative, not finite, all zero, or a weighted
    /// component can never be chosen.
    MixtureWeight(f64),
    /// A component of a mixture is a mixture.
    NestedMixture,
    /// A BSDF of a user's own is tinted, blended, mixed, or one side of two.
    NestedCustom,
    /// Beckmann's distribution is asked of a material that is not rough.
    NotRough,
    /// A material that differs between its sides transmits light.
    SidedTransmission,
}

impl fmt::Display for BsdfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reflectance(value) => {
                write!(f, "reflectance must be in [0, 1] per channel, but is {:?}", value.0)
            }
            Self::RelativeIor(value) => {
                write!(f, "relative index of refraction must be in [1e-6, 1e6], but is {value}")
            }
            Self::ComplexIor(eta, k) => {
                write!(
                    f,
                    "complex index of refraction must be in [0, 1e6] per channel, but eta is {:?} and k is {:?}",
                    eta.0, k.0
                )
            }
            Self::Roughness(x, y) => {
                write!(f, "roughness alpha must be in [0, 10], but is ({x}, {y})")
            }
            Self::MetallicRoughness(metalness, roughness) => {
                write!(
                    f,
                    "metalness and roughness must be in [0, 1], but are {metalness} and {roughness}"
                )
            }
            Self::MixtureWeight(value) => write!(
                f,
                "weights and probabilities of a mixture must be finite, not negative and not all zero, \
                 and a component with a weight needs a probability, but one is {value}"
            ),
            Self::NotRough => write!(
                f,
                "Beckmann's distribution needs a rough mirror, rough conductor or rough dielectric"
            ),
            Self::SidedTransmission => {
                write!(f, "a material that differs between its sides must not transmit light")
            }
            Self::NestedCustom => write!(
                f,
                "a BSDF of a user's own must stand alone, without tint, sides, blend or mixture"
            ),
            Self::NestedMixture => write!(f, "a component of a mixture must not be a mixture"),
        }
    }
}

impl std::error::Error for BsdfError {}

/// `reflectance`, if every channel is in [0, 1].
pub(super) fn checked_reflectance(reflectance: Rgb) -> Result<Rgb, BsdfError> {
    let valid = reflectance.0.iter().all(|channel| (0.0..=1.0).contains(channel));
    if valid { Ok(reflectance) } else { Err(BsdfError::Reflectance(reflectance)) }
}
