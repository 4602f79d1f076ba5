//! Ten ready-made scenes, each of which asks something else of an integrator.
//!
//! ```
//! use pathspace::glam::UVec2;
//! use pathspace::gallery;
//!
//! let scene = gallery::build("cornell-box", UVec2::new(64, 64))?;
//! assert!(scene.claims.bidirectional);
//! # Ok::<(), gallery::GalleryError>(())
//! ```
//!
//! | scene | difficulty |
//! |---|---|
//! | cornell-box | diffuse surfaces, one area light: for all integrators |
//! | sphere-cap | exact answer: every pixel is 0.1 |
//! | lamp-room | lamps that cannot be connected to: hard for path tracing |
//! | caustic | light focused by glass that is itself seen: paths from both ends |
//! | glossy-plates | plates and lights of many sizes: multiple importance sampling (Veach 1997) |
//! | smooth-mesh | shading normals, light at infinity: transport modes |
//! | pool | caustics seen through the water that makes them: hard for all unbiased integrators |
//! | door-ajar | light through a slit: few walks find it (Veach and Guibas 1997) |
//! | door-ajar-narrow | the same, a hundred times as rare |
//! | mirror-chain | light over mirrors and glass, seen in a mirror: paths with Dirac lobes at both ends |
//!
//! [`Claims`] tell which integrators see every path of a scene.

mod caustic;
mod cornell_box;
mod door_ajar;
mod error;
mod glossy_plates;
mod lamp_room;
mod materials;
mod mirror_chain;
mod pool;
mod shapes;
mod smooth_mesh;
mod sphere_cap;

pub use error::GalleryError;

use crate::endpoint::Camera;
use crate::scene::{Variation, World, WorldBuilder};
use glam::UVec2;

/// A scene of the gallery.
pub struct GalleryScene {
    /// The name, one of [`NAMES`].
    pub name: &'static str,
    /// A sentence about the scene.
    pub description: &'static str,
    /// Surfaces, materials and lights.
    pub world: World,
    /// The camera, with the film.
    pub camera: Box<dyn Camera + Send>,
    /// The number of scattering events after which longer paths do not matter; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The integrators that see every path of the image.
    pub claims: Claims,
}

/// The integrators that can draw every path that contributes to a scene's image. The mean of an
/// integrator that cannot is too low. A claim is about the mean alone, of a consistent integrator
/// about its limit: the noise may be too large for any budget, as that of uniform-area sampling on
/// narrow lobes is.
///
/// [`Metropolis`](crate::integrator::Metropolis) sampling and [`Guiding`](crate::integrator::Guiding)
/// draw the paths of the integrator that they are put around, [`Adaptive`](crate::integrator::Adaptive)
/// and [`Multiplexed`](crate::integrator::Multiplexed) those of bidirectional path tracing.
/// [`Regularization`](crate::integrator::Regularization) over path tracing draws all, since no Dirac
/// lobe is left.
///
/// A vertex is finite if it scatters through a lobe that is a function, as diffuse and glossy ones
/// are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Claims {
    /// [`UniformArea`](crate::integrator::UniformArea): no Dirac lobes, no light at infinity.
    pub uniform_area: bool,
    /// [`PathTracer`](crate::integrator::PathTracer): no Dirac light behind a Dirac lobe.
    pub path_tracing: bool,
    /// [`LightTracer`](crate::integrator::LightTracer): the camera sees no Dirac lobe.
    pub light_tracing: bool,
    /// [`Bidirectional`](crate::integrator::Bidirectional): no path with Dirac lobes between a
    /// Dirac light and a Dirac lens.
    pub bidirectional: bool,
    /// [`PhotonMapping`](crate::integrator::PhotonMapping), which merges light walks with the camera
    /// walk at its first finite vertex: no Dirac light seen through Dirac lobes alone, or directly by
    /// a lens of finite area.
    pub photon_mapping: bool,
    /// [`InstantRadiosity`](crate::integrator::InstantRadiosity), which connects virtual lights to
    /// the finite vertices of camera walks: behind a Dirac lobe at a Dirac light, no path without
    /// two finite vertices in a row.
    pub instant_radiosity: bool,
    /// [`VertexConnectionMerging`](crate::integrator::VertexConnectionMerging): no path that both
    /// bidirectional path tracing and photon mapping miss.
    pub vcm: bool,
}

impl Claims {
    /// Every integrator sees everything.
    pub const ALL: Self = Self {
        uniform_area: true,
        path_tracing: true,
        light_tracing: true,
        bidirectional: true,
        photon_mapping: true,
        instant_radiosity: true,
        vcm: true,
    };
}

/// The names of the scenes.
pub const NAMES: [&str; 10] = [
    "cornell-box",
    "sphere-cap",
    "lamp-room",
    "caustic",
    "glossy-plates",
    "smooth-mesh",
    "pool",
    "door-ajar",
    "door-ajar-narrow",
    "mirror-chain",
];

/// The subject of a scene, in one sentence; `None` if there is no such scene.
#[must_use]
pub fn description(name: &str) -> Option<&'static str> {
    let index = NAMES.iter().position(|known| *known == name)?;
    let descriptions = [
        cornell_box::DESCRIPTION,
        sphere_cap::DESCRIPTION,
        lamp_room::DESCRIPTION,
        caustic::DESCRIPTION,
        glossy_plates::DESCRIPTION,
        smooth_mesh::DESCRIPTION,
        pool::DESCRIPTION,
        door_ajar::DESCRIPTION,
        door_ajar::NARROW,
        mirror_chain::DESCRIPTION,
    ];
    Some(descriptions[index])
}

/// Builds a scene with a film of the given resolution.
///
/// # Errors
/// There is no scene of this name, or the film has no pixels.
pub fn build(name: &str, resolution: UVec2) -> Result<GalleryScene, GalleryError> {
    build_varied(name, resolution, Variation::default())
}

/// Builds a scene whose lamps or materials are changed. Its description and its
/// [claims](GalleryScene::claims) are those of the unchanged scene.
///
/// # Errors
/// There is no scene of this name, the film has no pixels, or the variation is out of range.
pub fn build_varied(
    name: &str,
    resolution: UVec2,
    variation: Variation,
) -> Result<GalleryScene, GalleryError> {
    let builder = WorldBuilder::varied(variation);
    match name {
        "cornell-box" => cornell_box::build(resolution, builder),
        "sphere-cap" => sphere_cap::build(resolution, builder),
        "lamp-room" => lamp_room::build(resolution, builder),
        "caustic" => caustic::build(resolution, builder),
        "glossy-plates" => glossy_plates::build(resolution, builder),
        "smooth-mesh" => smooth_mesh::build(resolution, builder),
        "pool" => pool::build(resolution, builder),
        "door-ajar" => door_ajar::wide(resolution, builder),
        "door-ajar-narrow" => door_ajar::narrow(resolution, builder),
        "mirror-chain" => mirror_chain::build(resolution, builder),
        _ => Err(GalleryError::UnknownScene { name: name.to_owned() }),
    }
}

impl std::fmt::Debug for GalleryScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GalleryScene")
            .field("name", &self.name)
            .field("world", &self.world)
            .field("film", &self.camera.film())
            .field("max_bounces", &self.max_bounces)
            .field("claims", &self.claims)
            .finish_non_exhaustive()
    }
}
