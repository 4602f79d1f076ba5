//! Why a scene of the gallery could not be built.

use super::NAMES;
use crate::endpoint::EndpointError;
use crate::scene::SceneError;
use std::fmt;

/// Why a scene of the gallery could not be built.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum GalleryError {
    /// There is no scene of this name.
    UnknownScene {
        /// The name asked for.
        name: String,
    },
    /// The scene itself was refused.
    Scene(SceneError),
    /// A camera or light was refused: a film without pixels, for instance.
    Endpoint(EndpointError),
}

impl fmt::Display for GalleryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownScene { name } => {
                write!(f, "there is no scene {name:?} in the gallery; it has {}", NAMES.join(", "))
            }
            Self::Scene(error) => error.fmt(f),
            Self::Endpoint(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for GalleryError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::UnknownScene { .. } => None,
            Self::Scene(error) => Some(error),
            Self::Endpoint(error) => Some(error),
        }
    }
}

impl From<SceneError> for GalleryError {
    fn from(error: SceneError) -> Self {
        Self::Scene(error)
    }
}

impl From<EndpointError> for GalleryError {
    fn from(error: EndpointError) -> Self {
        Self::Endpoint(error)
    }
}
