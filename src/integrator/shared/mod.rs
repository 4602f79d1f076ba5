//! Light walks that all pixels of a pass share, and what is made of them: photons to merge with, and
//! virtual lights to connect to.

mod merges;
mod merging;
mod photon_maps;
mod virtual_lights;
mod walks;

pub(super) use merges::Merges;
pub use merging::Merging;
pub use photon_maps::PhotonMaps;
pub(super) use virtual_lights::VirtualLights;
pub use walks::{LightWalks, SharedWalks};
