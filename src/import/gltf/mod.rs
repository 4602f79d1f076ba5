//! Scenes in glTF 2.0, the Khronos format: `.gltf` with its buffers and images, and `.glb`.
//!
//! # What is read
//!
//! The default scene, or the first: meshes of triangles, strips and fans with normals, tangents,
//! colours and two sets of texture coordinates, morphed and skinned as they are at rest; perspective
//! and orthographic cameras; metallic-roughness materials with their textures; normal maps; emission;
//! alpha; sparse accessors; data URIs; and the extensions `KHR_lights_punctual`,
//! `KHR_materials_emissive_strength`, `_ior`, `_transmission`, `_volume`, `KHR_texture_transform`,
//! `KHR_mesh_quantization`, `EXT_mesh_gpu_instancing`, `EXT_meshopt_compression`, with the feature
//! `draco` `KHR_draco_mesh_compression`, and with `webp` `EXT_texture_webp`. What else a file holds
//! is a [`Warning`](super::Warning), what else it *requires* an [`Error`].
//!
//! # Conventions
//!
//! * **Units.** glTF is photometric: candela for point and spot lights, lux for directional ones,
//!   candela per square metre for emission. The numbers are taken as they are for radiant
//!   intensity, irradiance and radiance, so that the image is in cd/m². Luminance and radiance
//!   differ by a constant of the light's spectrum (683 lm/W at 555 nm), which glTF does not know
//!   and which would scale all lights alike.
//! * **Materials** are [`MetallicRoughness`](crate::bsdf::MetallicRoughness). Backs of surfaces
//!   that are not double-sided are [culled](crate::bsdf::Culled) unless they transmit light or
//!   [the options](Options::back_faces) want them; they do not emit.
//! * **Alpha.** Where it says that there is nothing, rays pass without an event. Between 0 and 1
//!   `BLEND` lets light [straight through](crate::scene::Material::Null) in proportion to 1 -
//!   alpha, which counts as a scattering event. Emission is multiplied by alpha.
//! * **Environment.** [The one of the options](Options::environment), or a white one if neither
//!   punctual lights nor emission light the scene.
//! * **Transmission** is glass where the file gives it a volume, a
//!   [pane](crate::bsdf::ThinDielectric) where it does not, both with Fresnel's equations.
//! * **Normal maps** change shading normals ([`Relief`](crate::material::Relief)). Where a mesh has
//!   no tangents, they are those of MikkTSpace for the normal map's own, transformed coordinates.
//! * **Occlusion textures** are not needed, since light transport finds out what is occluded.
//! * **Film.** A file does not say how many pixels: a camera's film is the largest of its aspect
//!   ratio in the given resolution. Clipping planes and the scale of a camera's node have no
//!   effect. A file without cameras is seen as a whole from the front.
//! * **Spot lights** fall off by the specification's formula, `t²` with t linear in the cosine
//!   between the cones.

mod accessor;
mod clear_coat;
mod document;
mod draco;
mod ends;
mod instances;
mod material;
mod meshopt;
mod pose;
mod repair;
mod scene;
mod solid;
mod tangents;
mod texture;

use super::{Error, Import, Options};
use glam::UVec2;
use std::path::Path;

/// Reads the scene of a file, `.gltf` or `.glb`; both are told apart by their content. Images are
/// `resolution` wide or high, or both.
///
/// # Errors
/// If the file or a buffer that it refers to cannot be read, breaks the rules of the format,
/// requires an unknown extension, exceeds a limit or leaves nothing to render; if the resolution is
/// 0; in strict mode, for the first warning.
pub fn load(path: impl AsRef<Path>, resolution: UVec2, options: &Options) -> Result<Import, Error> {
    let mut document = document::Document::open(path.as_ref(), options)?;
    scene::build(&mut document, resolution)
}

/// Reads the scene in the bytes of a file, `.gltf` or `.glb`, which refers to no other files:
/// buffers and images are in it, or in data URIs. Errors and warnings name it by `name`.
///
/// # Errors
/// Those of [`load`], and if it refers to another file.
pub fn from_slice(
    name: &str,
    bytes: &[u8],
    resolution: UVec2,
    options: &Options,
) -> Result<Import, Error> {
    let mut document = document::Document::parse(Path::new(name), bytes, options)?;
    scene::build(&mut document, resolution)
}
