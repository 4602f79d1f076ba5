//! The ready-made scene: meshes, spheres, quads and disks, named materials, and lights of any kind.

use super::builder::{MaterialId, Surface, SurfaceId};
use super::bvh::{Bvh, Ends, unit};
use super::lights::{BoxedLight, Choice};
use super::{Needs, Scene, SurfaceArea};
use crate::bsdf::{Bsdf, Lobes, Model};
use crate::endpoint::{Light, LightId};
use crate::geometry::{Bounds, Place, Shape, SurfacePoint};
use glam::{DVec2, DVec3};

/// A scene made by a [`WorldBuilder`](super::WorldBuilder). Immutable; share it between threads.
///
/// Primitives are numbered surface by surface in the order in which surfaces were added. Of surfaces at the same distance, a ray sees
/// that of the lowest number.
pub struct World {
    bvh: Bvh,
    bounds: Bounds,
    materials: Vec<Model>,
    surfaces: Vec<Surface>,
    /// The surface of each primitive.
    surface_of: Vec<u32>,
    lights: Vec<(String, BoxedLight)>,
    environment: Option<LightId>,
    light_choice: Choice,
    area_choice: Choice,
    total_area: f64,
    needs: Needs,
    dropped_triangles: usize,
}

impl World {
    #[allow(clippy::too_many_arguments)]
    pub(super) fn assemble(
        bvh: Bvh,
        bounds: Bounds,
        materials: Vec<Model>,
        surfaces: Vec<Surface>,
        lights: Vec<(String, BoxedLight)>,
        environment: Option<LightId>,
        light_choice: Choice,
        areas: &[f64],
        dropped_triangles: usize,
    ) -> Self {
        let mut surface_of = Vec::with_capacity(areas.len());
        for (id, surface) in surfaces.iter().enumerate() {
            surface_of.resize(surface_of.len() + surface.primitives as usize, id as u32);
        }
        let needs = needs(&materials, &surfaces, &lights, environment);
        let (area_choice, total_area) = (Choice::new(areas), areas.iter().sum());
        Self {
            bvh,
            bounds,
            materials,
            surfaces,
            surface_of,
            lights,
            environment,
            light_choice,
            area_choice,
            total_area,
            needs,
            dropped_triangles,
        }
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
        self.dropped_triangles
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

    /// The material of the surface that a point lies on, as the model that it became.
    #[must_use]
    pub fn material_at(&self, x: &SurfacePoint) -> Option<(MaterialId, &Model)> {
        let id = self.surfaces.get(x.surface as usize)?.material;
        self.materials.get(id.0 as usize).map(|material| (id, material))
    }

    /// The shape of a primitive.
    #[must_use]
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        self.bvh.shape(primitive)
    }

    /// Gives a point of a shape what the scene knows about it.
    fn complete(&self, primitive: u32, shape: &Shape, mut x: SurfacePoint) -> SurfacePoint {
        x.primitive = primitive;
        x.surface = self.surface_of[primitive as usize];
        let surface = &self.surfaces[x.surface as usize];
        if let Some(attributes) = &surface.attributes {
            attributes.apply((primitive - surface.first_primitive) as usize, shape, &mut x);
        }
        x
    }

    /// The end of a segment at which to start the ray: the one closer to the scene's centre, whose rounding is the smaller one. So the
    /// answer does not depend on the order of the ends.
    fn starts_segment(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let center = if self.bounds.is_empty() { DVec3::ZERO } else { self.bounds.center() };
        let key = |x: &SurfacePoint| {
            let p = x.position;
            [(p - center).length_squared(), p.x, p.y, p.z, f64::from(x.primitive)]
        };
        key(a).partial_cmp(&key(b)) != Some(std::cmp::Ordering::Greater)
    }
}

impl Scene for World {
    type Bsdf<'a> = &'a Model;
    type Light = dyn Light;

    #[inline]
    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        let direction = unit(direction);
        let hit = self.bvh.closest(from.origin_towards(direction), direction, contact(from))?;
        Some(self.complete(hit.primitive, hit.shape, hit.shape.point_at_hit(&hit.ray, &hit.intersection)))
    }

    /// Coincident points, two points at infinity and points that are not finite do not see each other: they have no geometry term.
    #[inline]
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let (a, b) = match (a.place, b.place) {
            (Place::Infinite, Place::Infinite) => return false,
            (Place::Infinite, _) => (b, a),
            (_, Place::Infinite) => (a, b),
            _ if self.starts_segment(a, b) => (a, b),
            _ => (b, a),
        };
        let (origin, direction, length) = if b.place == Place::Infinite {
            let direction = unit(-b.geometric_normal);
            let origin = a.origin_towards(direction);
            (origin, direction, (b.position - origin).dot(direction))
        } else {
            let between = b.position - a.position;
            if between == DVec3::ZERO {
                return false;
            }
            // Each end is moved towards the other, so that neither end's own surface is in the way.
            let (origin, end) = (a.origin_towards(between), b.origin_towards(-between));
            let segment = end - origin;
            if segment.dot(between) <= 0.0 {
                // Closer to each other than their error bounds: nothing can be in between.
                return true;
            }
            let length = segment.length();
            (origin, segment / length, length)
        };
        if !(origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO && length.is_finite()) {
            return false;
        }
        // Hits within the rounding of the distance itself belong to the end.
        let length = length * (1.0 - crate::geometry::gamma(8));
        self.bvh.is_free(origin, direction, length, Ends { origin: contact(a), end: contact(b) })
    }

    #[inline]
    fn bsdf(&self, x: &SurfacePoint) -> &Model {
        self.material_at(x).map_or(&Model::BLACK, |(_, model)| model)
    }

    #[inline]
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.surfaces.get(x.surface as usize)?.light
    }

    fn environment(&self) -> Option<LightId> {
        self.environment
    }

    /// # Panics
    /// The id is not one of this world.
    fn light(&self, id: LightId) -> &Self::Light {
        &*self.lights[id.0 as usize].1
    }

    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.light_choice.sample_light(u)
    }

    fn pick_pmf(&self, id: LightId) -> f64 {
        self.light_choice.pmf(id.0)
    }

    fn needs(&self) -> Needs {
        self.needs
    }
}

impl SurfaceArea for World {
    fn total_area(&self) -> f64 {
        self.total_area
    }

    fn sample_surface(&self, u1: f64, u2: DVec2) -> SurfacePoint {
        let chosen = self.area_choice.sample(u1).map(|(index, _)| index);
        match chosen.and_then(|primitive| Some((primitive, self.bvh.shape(primitive)?))) {
            Some((primitive, shape)) => self.complete(primitive, shape, shape.sample_area(u2)),
            // A world without surfaces: a point that nothing is known about and that scatters nothing.
            None => SurfacePoint::dirac(DVec3::ZERO),
        }
    }
}

/// The primitive that a ray from a point must not hit again.
fn contact(x: &SurfacePoint) -> u32 {
    if x.place == Place::Area { x.primitive } else { SurfacePoint::NONE }
}

fn needs(materials: &[Model], surfaces: &[Surface], lights: &[(String, BoxedLight)], environment: Option<LightId>) -> Needs {
    let when = |condition: bool, need: Needs| if condition { need } else { Needs::NONE };
    let lobes = surfaces.iter().fold(Lobes::NONE, |lobes, s| lobes | materials[s.material.0 as usize].lobes());
    let smooth = surfaces.iter().any(|s| s.attributes.as_ref().is_some_and(|a| a.is_smooth()));
    when(lights.iter().any(|(_, light)| light.can_be_hit()), Needs::HITTABLE_LIGHTS)
        | when(lights.iter().any(|(_, light)| light.can_be_connected()), Needs::CONNECTIBLE_LIGHTS)
        | when(lobes.intersects(Lobes::FINITE), Needs::FINITE_LOBES)
        | when(lobes.intersects(Lobes::DIRAC), Needs::DIRAC_LOBES)
        | when(lobes.intersects(Lobes::TRANSMISSION), Needs::TRANSMISSION)
        | when(environment.is_some(), Needs::ENVIRONMENT)
        | when(smooth, Needs::SMOOTH_NORMALS)
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lights: Vec<&str> = self.lights.iter().map(|(name, _)| name.as_str()).collect();
        f.debug_struct("World")
            .field("bvh", &self.bvh)
            .field("bounds", &self.bounds)
            .field("surfaces", &self.surfaces.len())
            .field("materials", &self.materials)
            .field("lights", &lights)
            .field("needs", &self.needs)
            .finish_non_exhaustive()
    }
}
