//! The ready-made scene: meshes, spheres, quads and disks, named materials, and lights of any kind.
//!
//! The ray kernel answers rays, a primitive's surface leads to its material and its light, and
//! lights are chosen by a [`LightTree`]. [`Needs`] are computed once, when the world is built.

mod fingerprint;
mod flat;
mod media;
mod needs;
mod rays;
#[cfg(test)]
mod tests;

use self::flat::Flat;
pub use self::flat::FlatSurfaces;
pub(crate) use self::flat::{DIFFUSE, Diffuse, FlatHit, Meeting};
pub(super) use self::media::Media;
use super::lights::Choice;
use super::surface::{MaterialId, Surface, SurfaceId};
use super::{Needs, Warning};
#[cfg(feature = "import")]
use super::{SceneError, lights};
#[cfg(feature = "import")]
use crate::endpoint::SceneExtent;
use crate::endpoint::{AnyLight, Light, LightId};
use crate::geometry::{Bounds, Shape, SurfacePoint};
use crate::light_tree::LightTree;
use crate::material::{Finish, SurfaceBsdf};
use crate::tree::{Forest, TreeStatistics};

/// A scene made by a [`WorldBuilder`](super::WorldBuilder). Immutable; share it between threads.
///
/// Primitives are numbered surface by surface in the order in which surfaces were added. Of
/// surfaces at the same distance, a ray sees that of the lowest number.
pub struct World {
    forest: Forest,
    bounds: Bounds,
    materials: Vec<Finish>,
    media: Media,
    material_names: Vec<String>,
    surfaces: Vec<Surface>,
    /// The surface of each primitive.
    surface_of: Vec<u32>,
    /// The primitives of a world of few, as far as they are flat.
    flat: Vec<Option<Flat>>,
    /// True if all lights are flat.
    has_flat_lights: bool,
    /// True if parts of surfaces are cut out.
    has_cutouts: bool,
    lights: Vec<(String, AnyLight)>,
    environment: Option<LightId>,
    light_tree: LightTree,
    area_choice: Choice,
    total_area: f64,
    needs: Needs,
    warnings: Vec<Warning>,
}

impl World {
    #[allow(clippy::too_many_arguments)]
    pub(in crate::scene) fn assemble(
        forest: Forest,
        bounds: Bounds,
        (materials, material_names): (Vec<Finish>, Vec<String>),
        (surfaces, media): (Vec<Surface>, Media),
        lights: Vec<(String, AnyLight)>,
        environment: Option<LightId>,
        light_tree: LightTree,
        areas: &[f64],
        warnings: Vec<Warning>,
    ) -> Self {
        let mut surface_of = Vec::with_capacity(areas.len());
        for (id, surface) in surfaces.iter().enumerate() {
            surface_of.resize(surface_of.len() + surface.primitives as usize, id as u32);
        }
        let flat = Flat::prepare(forest.shapes(), &surface_of, &surfaces, &materials);
        let has_flat_lights = lights.iter().all(|(_, light)| light.as_flat().is_some());
        let has_cutouts = surfaces.iter().any(|surface| surface.cutout.is_some());
        let needs = needs::needs(&materials, &surfaces, &lights, environment, &forest, &bounds);
        let (area_choice, total_area) = (Choice::new(areas), areas.iter().sum());
        Self {
            forest,
            bounds,
            materials,
            media,
            material_names,
            surfaces,
            surface_of,
            flat,
            has_flat_lights,
            has_cutouts,
            lights,
            environment,
            light_tree,
            area_choice,
            total_area,
            needs,
            warnings,
        }
    }

    /// The same world, which had no environment, in one.
    #[cfg(feature = "import")]
    pub(crate) fn with_environment(
        mut self,
        name: String,
        environment: impl Light + Send + 'static,
    ) -> Result<Self, SceneError> {
        self.environment = Some(LightId(self.lights.len() as u32));
        self.lights.push((name, environment.into_any()));
        let extent = SceneExtent::covering(self.forest.shapes().iter().map(Shape::bounds));
        self.light_tree = lights::prepare(&mut self.lights, &extent)?;
        self.has_flat_lights = false;
        self.needs = needs::needs(
            &self.materials,
            &self.surfaces,
            &self.lights,
            self.environment,
            &self.forest,
            &self.bounds,
        );
        Ok(self)
    }

    /// The box around all surfaces; empty if there is none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Number of triangles, spheres, quads and disks.
    #[must_use]
    pub fn primitive_count(&self) -> usize {
        self.surface_of.len()
    }

    /// Number of surfaces: what was added by one call.
    #[must_use]
    pub fn surface_count(&self) -> usize {
        self.surfaces.len()
    }

    /// Number of lights, emissive surfaces and the environment included.
    #[must_use]
    pub fn light_count(&self) -> usize {
        self.lights.len()
    }

    /// Number of triangles that were left out because they have no area.
    #[must_use]
    pub fn dropped_triangles(&self) -> usize {
        let dropped = |warning: &Warning| {
            if let Warning::DroppedTriangles { dropped, .. } = warning { *dropped } else { 0 }
        };
        self.warnings.iter().map(dropped).sum()
    }

    /// Demands of this scene on the arithmetic beyond its limits. The scene renders all the same.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// The light of a name; an emissive surface's light has the name of the surface.
    #[must_use]
    pub fn light_by_name(&self, name: &str) -> Option<LightId> {
        self.lights.iter().position(|(n, _)| n == name).map(|index| LightId(index as u32))
    }

    /// The name of a light.
    #[must_use]
    pub fn light_name(&self, id: LightId) -> Option<&str> {
        self.lights.get(id.0 as usize).map(|(name, _)| name.as_str())
    }

    /// The names of the materials, in their order.
    #[must_use]
    pub fn material_names(&self) -> &[String] {
        &self.material_names
    }

    /// The surface of a name.
    #[must_use]
    pub fn surface_by_name(&self, name: &str) -> Option<SurfaceId> {
        self.surfaces.iter().position(|s| s.name == name).map(|index| SurfaceId(index as u32))
    }

    /// The name of the surface that a point lies on.
    #[must_use]
    pub fn surface_name(&self, x: &SurfacePoint) -> Option<&str> {
        self.surfaces.get(x.surface as usize).map(|s| s.name.as_str())
    }

    /// The material of the surface that a point lies on, and how it scatters there.
    #[inline]
    #[must_use]
    pub fn material_at(&self, x: &SurfacePoint) -> Option<(MaterialId, SurfaceBsdf<'_>)> {
        let id = self.surfaces.get(x.surface as usize)?.material;
        self.materials
            .get(id.0 as usize)
            .map(|material| (id, SurfaceBsdf::new(material, x.uv, || self.vertex_site(x))))
    }

    /// The shape of a primitive.
    #[must_use]
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        self.forest.shape(primitive)
    }

    /// The parts of the acceleration structure.
    #[must_use]
    pub fn tree_statistics(&self) -> TreeStatistics {
        self.forest.statistics()
    }
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lights: Vec<&str> = self.lights.iter().map(|(name, _)| name.as_str()).collect();
        f.debug_struct("World")
            .field("forest", &self.forest)
            .field("bounds", &self.bounds)
            .field("surfaces", &self.surfaces.len())
            .field("materials", &self.materials)
            .field("lights", &lights)
            .field("needs", &self.needs)
            .finish_non_exhaustive()
    }
}
