//! Errors of the parameters of a scattering model.

use crate::math::Rgb;

/// A parameter out of its range. The message does not name the object: whoever knows its name adds
/// it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BsdfError {
    /// A component of an albedo or reflectance is not in [0, 1].
    #[error("reflectance must be in [0, 1] per channel, but is {:?}", .0.0)]
    Reflectance(Rgb),
    /// A relative index of refraction is not in [1e-6, 1e6].
    #[error("relative index of refraction must be in [1e-6, 1e6], but is {0}")]
    RelativeIor(f64),
    /// A component of a complex index of refraction `eta + i k` is not in [0, 1e6].
    #[error(
        "complex index of refraction must be in [0, 1e6] per channel, but eta is {:?} and k is \
         {:?}",
        .0.0, .1.0
    )]
    ComplexIor(Rgb, Rgb),
    /// A roughness is not in [0, 10].
    #[error("roughness alpha must be in [0, 10], but is ({0}, {1})")]
    Roughness(f64, f64),
    /// A metalness or roughness of the metallic-roughness model is not in [0, 1].
    #[error("metalness and roughness must be in [0, 1], but are {0} and {1}")]
    MetallicRoughness(f64, f64),
    /// The radius of mollifiers is not in (0, 1].
    #[error("radius of mollifiers must be in (0, 1], but is {0}")]
    Mollifier(f64),
    /// The share or the roughness of a clear coat is not in [0, 1].
    #[error("share and roughness of a clear coat must be in [0, 1], but are {0} and {1}")]
    ClearCoat(f64, f64),
    /// A parameter of the principled BSDF is not in [0, 1].
    #[error("parameters of the principled BSDF must be in [0, 1], but one is {0}")]
    Principled(f64),
    /// A mixture's weights or probabilities are negative, not finite, all zero, or a weighted
    /// component can never be chosen.
    #[error(
        "weights and probabilities of a mixture must be finite, not negative and not all zero, \
         and a component with a weight needs a probability, but one is {0}"
    )]
    MixtureWeight(f64),
    /// A component of a mixture is a mixture.
    #[error("a component of a mixture must not be a mixture")]
    NestedMixture,
    /// A BSDF of a user's own is tinted, blended, mixed, or one side of two.
    #[error("a BSDF of a user's own must stand alone, without tint, sides, blend or mixture")]
    NestedCustom,
    /// Beckmann's distribution, or a roughness that varies, is asked of a material that is not rough.
    #[error(
        "Beckmann's distribution and varying roughness need a rough mirror, rough conductor or \
         rough dielectric; Beckmann's may be that of rough plastic, too"
    )]
    NotRough,
    /// A material that differs between its sides transmits light.
    #[error("a material that differs between its sides must not transmit light")]
    SidedTransmission,
}

/// `reflectance`, if every channel is in [0, 1].
pub(super) fn checked_reflectance(reflectance: Rgb) -> Result<Rgb, BsdfError> {
    let valid = reflectance.0.iter().all(|channel| (0.0..=1.0).contains(channel));
    if valid { Ok(reflectance) } else { Err(BsdfError::Reflectance(reflectance)) }
}
