//! Errors of scenes.

use crate::bsdf::BsdfError;
use crate::endpoint::EndpointError;

/// The reason for refusing a scene or a part of it. Every message names the object and the reason.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a surface nor a light.
    #[error("the scene has neither a surface nor a light")]
    Empty,
    /// The name is taken: surfaces and lights share one set of names, materials have another.
    #[error("the name \"{name}\" is already taken")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// No object of this name or id.
    #[error("there is no {kind} \"{name}\"")]
    Missing {
        /// The kind of object looked for: "material", "surface".
        kind: &'static str,
        /// The name or number looked for.
        name: String,
    },
    /// A second environment.
    #[error("environment \"{name}\": the scene has an environment already")]
    SecondEnvironment {
        /// The environment that was refused.
        name: String,
    },
    /// A number outside its range, infinite or not a number.
    #[error("\"{object}\": {parameter} is {value}, but must be {requirement}")]
    Parameter {
        /// The object.
        object: String,
        /// One of its parameters, "radius" for instance.
        parameter: &'static str,
        /// The value.
        value: f64,
        /// The range.
        requirement: &'static str,
    },
    /// A parameter of a material outside its range.
    #[error("material \"{name}\": {reason}")]
    Material {
        /// The material.
        name: String,
        /// The error of the model or of the light.
        #[source]
        reason: BsdfError,
    },
    /// More than 65 535 different media that absorb.
    #[error("\"{object}\": there are more than 65535 different absorbing media")]
    TooManyMedia {
        /// The surface behind which is one too many.
        object: String,
    },
    /// A parameter of a light outside its range.
    #[error("\"{name}\": {reason}")]
    Light {
        /// The light.
        name: String,
        /// The error of the model or of the light.
        #[source]
        reason: EndpointError,
    },
    /// A vertex position, normal or texture coordinate that is infinite, not a number, or beyond
    /// [`SceneError::MAX_COORDINATE`].
    #[error("\"{object}\": {attribute} of vertex {vertex} is {reason}")]
    Vertex {
        /// The mesh.
        object: String,
        /// The attribute.
        attribute: &'static str,
        /// Index of the vertex.
        vertex: usize,
        /// The fault.
        reason: &'static str,
    },
    /// A triangle that refers to a vertex which does not exist.
    #[error("\"{object}\": triangle {triangle} refers to vertex {index}, but there are {vertices}")]
    IndexOutOfRange {
        /// The mesh.
        object: String,
        /// Index of the triangle.
        triangle: usize,
        /// The vertex that it refers to.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Normals or texture coordinates that are not as many as positions.
    #[error("\"{object}\": {found} {attribute}s for {expected} vertices")]
    AttributeCount {
        /// The mesh.
        object: String,
        /// The attribute.
        attribute: &'static str,
        /// The number of them.
        found: usize,
        /// The number of vertices.
        expected: usize,
    },
    /// A transform that is not finite or not invertible.
    #[error("\"{object}\": the transform is not invertible or not finite")]
    SingularTransform {
        /// The object.
        object: String,
    },
    /// A quad without area.
    #[error("\"{object}\": the quad has no area")]
    Degenerate {
        /// The object.
        object: String,
    },
    /// An emissive surface whose total area is zero.
    #[error("\"{object}\": a surface without area cannot emit")]
    LightWithoutArea {
        /// The surface.
        object: String,
    },
    /// A light shines although its power is 0.
    #[error(
        "light {name:?} shines, but its power is 0, by which it is chosen: Light::power must be an \
         estimate of its flux"
    )]
    PowerlessLight {
        /// The light.
        name: String,
    },
    /// More primitives than ids.
    #[error("the scene has more than 2³¹ - 1 primitives")]
    TooManyPrimitives,
}

impl SceneError {
    /// Largest admissible size of a coordinate or radius: products of three of them, and their
    /// squares, must not overflow.
    pub const MAX_COORDINATE: f64 = 1e50;
}

/// Checks one number.
pub(crate) fn check(
    object: &str,
    parameter: &'static str,
    value: f64,
    requirement: &'static str,
    holds: impl Fn(f64) -> bool,
) -> Result<(), SceneError> {
    if value.is_finite() && holds(value) {
        Ok(())
    } else {
        Err(SceneError::Parameter { object: object.to_owned(), parameter, value, requirement })
    }
}

/// Checks each component of a radiance.
pub(crate) fn check_radiance(object: &str, value: crate::math::Rgb) -> Result<(), SceneError> {
    value
        .0
        .iter()
        .try_for_each(|&c| check(object, "radiance", c, "finite and not negative", |c| c >= 0.0))
}

/// Checks the coordinates of a point.
pub(crate) fn check_point(
    object: &str,
    parameter: &'static str,
    p: glam::DVec3,
) -> Result<(), SceneError> {
    let fits = |c: f64| c.abs() <= SceneError::MAX_COORDINATE;
    p.to_array()
        .iter()
        .try_for_each(|&c| check(object, parameter, c, "finite and at most 1e50 in size", fits))
}
