//! Errors of the gallery.

use super::NAMES;
use crate::endpoint::EndpointError;
use crate::scene::SceneError;

/// The reason for not building a scene of the gallery.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GalleryError {
    /// There is no scene of this name.
    #[error("there is no scene {name:?} in the gallery; it has {}", NAMES.join(", "))]
    UnknownScene {
        /// The name asked for.
        name: String,
    },
    /// The scene itself was refused.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// A camera or light was refused: a film without pixels, for instance.
    #[error("{0}")]
    Endpoint(#[from] EndpointError),
}
