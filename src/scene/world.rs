//! The ready-made scene: meshes, spheres, quads and disks, named materials, and lights of any kind.

use super::builder::{MaterialId, Surface, SurfaceId};
use super::bvh::{Bvh, TreeStatistics};
use super::lights::{BoxedLight, Choice};
use super::mesh::Shading;
use super::query::{Hit, Query, Segment};
use super::scattering::{Scattering, SurfaceBsdf};
use super::{Needs, Scene, SurfaceArea, Warning};
use crate::bsdf::Lobes;
use crate::endpoint::{Light, LightId};
use crate::geometry::{Bounds, Ray, Shape, SurfacePoint, Triangle};
use glam::{DVec2, DVec3};

/// A scene made by a [`WorldBuilder`](super::WorldBuilder). Immutable; share it between threads.
///
/// Primitives are numbered surface by surface in the order in which surfaces were added. Of
/// surfaces at the same distance, a ray sees that of the lowest number.
pub struct World {
    bvh: Bvh,
    bounds: Bounds,
    materials: Vec<Scattering>,
    surfaces: Vec<Surface>,
    /// The surface of each primitive.
    surface_of: Vec<u32>,
    lights: Vec<(String, BoxedLight)>,
    environment: Option<LightId>,
    light_choice: Choice,
    area_choice: Choice,
    total_area: f64,
    needs: Needs,
    warnings: Vec<Warning>,
}

impl World {
    #[allow(clippy::too_many_arguments)]
    pub(super) fn assemble(
        bvh: Bvh,
        bounds: Bounds,
        materials: Vec<Scattering>,
        surfaces: Vec<Surface>,
        lights: Vec<(String, BoxedLight)>,
        environment: Option<LightId>,
        light_choice: Choice,
        areas: &[f64],
        warnings: Vec<Warning>,
    ) -> Self {
        let mut surface_of = Vec::with_capacity(areas.len());
        for (id, surface) in surfaces.iter().enumerate() {
            surface_of.resize(surface_of.len() + surface.primitives as usize, id as u32);
        }
        let needs = needs(&materials, &surfaces, &lights, environment, &bvh, &bounds);
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
            warnings,
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
        let dropped = |warning: &Warning| {
            if let Warning::DroppedTriangles { dropped, .. } = warning { *dropped } else { 0 }
        };
        self.warnings.iter().map(dropped).sum()
    }

    /// What this scene asks of the arithmetic beyond its limits. The scene renders all the same.
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
    #[must_use]
    pub fn material_at(&self, x: &SurfacePoint) -> Option<(MaterialId, SurfaceBsdf<'_>)> {
        let id = self.surfaces.get(x.surface as usize)?.material;
        self.materials.get(id.0 as usize).map(|material| (id, SurfaceBsdf::new(material, x.uv)))
    }

    /// The shape of a primitive.
    #[must_use]
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        self.bvh.shape(primitive)
    }

    /// What the acceleration structure consists of.
    #[must_use]
    pub fn tree_statistics(&self) -> TreeStatistics {
        self.bvh.statistics()
    }

    /// The primitive that a ray meets first and its distance: [`Scene::intersect`] without the
    /// surface point, for whoever needs no more, from an origin that lies on no surface. A
    /// direction that is not of unit length is made so; a ray that is none hits nothing.
    #[must_use]
    pub fn first_hit(&self, origin: DVec3, direction: DVec3) -> Option<(u32, f64)> {
        self.bvh.closest(Query::free(origin, direction), primitive_and_distance)
    }

    /// [`first_hit`](Self::first_hit) of many rays, given by origin and direction. `found` gets
    /// each answer once, with the ray's place in the iterator, in any order.
    pub fn first_hits(
        &self,
        rays: impl Iterator<Item = (DVec3, DVec3)>,
        mut found: impl FnMut(usize, Option<(u32, f64)>),
    ) {
        let queries = rays.map(|(origin, direction)| Query::free(origin, direction));
        self.bvh.closest_many(queries, |index, hit| found(index, hit.map(primitive_and_distance)));
    }

    /// Whether a ray meets nothing nearer than `length`: [`Scene::visible`] for an origin and an
    /// end that lie on no surface.
    #[must_use]
    pub fn is_clear(&self, origin: DVec3, direction: DVec3, length: f64) -> bool {
        self.bvh.is_free(&Segment::free(origin, direction, length))
    }

    /// [`is_clear`](Self::is_clear) of many rays, given by origin, direction and length. `answer`
    /// gets each answer once, with the ray's place in the iterator, in any order.
    pub fn are_clear(
        &self,
        rays: impl Iterator<Item = (DVec3, DVec3, f64)>,
        answer: impl FnMut(usize, bool),
    ) {
        self.bvh.are_free(
            rays.map(|(origin, direction, length)| Ok(Segment::free(origin, direction, length))),
            answer,
        );
    }

    /// The surface point of a hit.
    #[inline(always)]
    fn point_of(&self, hit: &Hit<'_>) -> Option<SurfacePoint> {
        let Some(triangle) = self.bvh.triangle_of(hit) else { return self.point_of_other(hit) };
        let x = triangle.point_at(hit.intersection.u, hit.intersection.v);
        Some(self.complete(hit.primitive, Some(triangle), x))
    }

    /// The same for a shape that is no triangle. Apart, so that points of triangles need not be
    /// where it leaves its own.
    #[inline(never)]
    fn point_of_other(&self, hit: &Hit<'_>) -> Option<SurfacePoint> {
        let x = self
            .bvh
            .shape(hit.primitive)?
            .point_at_hit(&Ray::new(hit.origin, hit.direction), &hit.intersection);
        Some(self.complete(hit.primitive, None, x))
    }

    /// Gives a point of a shape, perhaps of a triangle, what the scene knows about it.
    #[inline(always)]
    fn complete(
        &self,
        primitive: u32,
        triangle: Option<Triangle>,
        x: SurfacePoint,
    ) -> SurfacePoint {
        let id = self.surface_of[primitive as usize];
        let surface = &self.surfaces[id as usize];
        let mut shading = Shading::of(&x);
        if let (Some(attributes), Some(triangle)) = (&surface.attributes, triangle) {
            shading =
                attributes.at((primitive - surface.first_primitive) as usize, triangle, shading);
        }
        // All fields at once, so that the point is made where it is needed.
        SurfacePoint {
            primitive,
            surface: id,
            shading_normal: shading.normal,
            tangent: shading.tangent,
            uv: shading.uv,
            ..x
        }
    }
}

impl Scene for World {
    type Bsdf<'a> = SurfaceBsdf<'a>;
    type Light = dyn Light;

    #[inline]
    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        // The point is made where it is needed.
        self.bvh
            .closest(Query::leaving(from, direction), |hit| hit)
            .and_then(|hit| self.point_of(&hit))
    }

    /// Coincident points, two points at infinity and points that are not finite do not see each
    /// other: they have no geometry term.
    #[inline]
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        Segment::between(a, b, self.bvh.center())
            .map_or_else(|visible| visible, |segment| self.bvh.is_free(&segment))
    }

    #[inline]
    fn intersect_many<'a>(
        &self,
        rays: impl Iterator<Item = (&'a SurfacePoint, DVec3)>,
        mut found: impl FnMut(usize, Option<SurfacePoint>),
    ) {
        let queries = rays.map(|(from, direction)| Query::leaving(from, direction));
        self.bvh.closest_many(queries, |index, hit| {
            found(index, hit.and_then(|hit| self.point_of(&hit)))
        });
    }

    #[inline]
    fn visible_many<'a>(
        &self,
        segments: impl Iterator<Item = (&'a SurfacePoint, &'a SurfacePoint)>,
        answer: impl FnMut(usize, bool),
    ) {
        self.bvh.are_free(segments.map(|(a, b)| Segment::between(a, b, self.bvh.center())), answer);
    }

    #[inline]
    fn bsdf(&self, x: &SurfacePoint) -> SurfaceBsdf<'_> {
        self.material_at(x)
            .map_or(SurfaceBsdf::new(&Scattering::BLACK, DVec2::ZERO), |(_, bsdf)| bsdf)
    }

    #[inline]
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.surfaces.get(x.surface as usize)?.light
    }

    #[inline]
    fn environment(&self) -> Option<LightId> {
        self.environment
    }

    /// # Panics
    /// The id is not one of this world.
    fn light(&self, id: LightId) -> &Self::Light {
        &*self.lights[id.0 as usize].1
    }

    #[inline]
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.light_choice.sample_light(u)
    }

    #[inline]
    fn pick_pmf(&self, id: LightId) -> f64 {
        self.light_choice.pmf(id.0)
    }

    #[inline]
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
            Some((primitive, shape)) => {
                self.complete(primitive, shape.as_triangle(), shape.sample_area(u2))
            }
            // A world without surfaces: a point that nothing is known about and that scatters
            // nothing.
            None => SurfacePoint::dirac(DVec3::ZERO),
        }
    }
}

/// A hit without its surface point.
#[inline(always)]
fn primitive_and_distance(hit: Hit<'_>) -> (u32, f64) {
    (hit.primitive, hit.moved + hit.intersection.t)
}

fn needs(
    materials: &[Scattering],
    surfaces: &[Surface],
    lights: &[(String, BoxedLight)],
    environment: Option<LightId>,
    shapes: &Bvh,
    bounds: &Bounds,
) -> Needs {
    let when = |condition: bool, need: Needs| if condition { need } else { Needs::NONE };
    let any_light = |is: &dyn Fn(&BoxedLight) -> bool| {
        lights.iter().any(|(_, light)| !light.is_black() && is(light))
    };
    let lobes = surfaces
        .iter()
        .fold(Lobes::NONE, |lobes, s| lobes | materials[s.material.0 as usize].lobes());
    let smooth = surfaces.iter().any(|s| s.attributes.as_ref().is_some_and(|a| a.is_smooth()));
    let is_textured = |s: &Surface| {
        let emits_pattern =
            s.emission.as_ref().is_some_and(|(radiance, _)| radiance.as_constant().is_none());
        emits_pattern || materials[s.material.0 as usize].is_textured()
    };
    let is_flat = |shape: &Shape| !matches!(shape, Shape::Sphere(_));
    let is_ball = |shape: &Shape| matches!(shape, Shape::Sphere(sphere) if sphere.is_whole() && !sphere.inward);
    let single = match surfaces {
        [surface] if surface.primitives == 1 => shapes.shape(0).map(|shape| (surface, shape)),
        _ => None,
    };
    // Nothing on a flat surface sees anything else of it; nor on a ball from outside, where light
    // of the sky and its own stays.
    let convex = single.is_some_and(|(surface, shape)| {
        let outside = lights.len()
            == usize::from(environment.is_some()) + usize::from(surface.light.is_some());
        let own = surface.emission.as_ref().is_none_or(|(_, two_sided)| !two_sided);
        is_flat(shape)
            || (is_ball(shape) && outside && own && !lobes.intersects(Lobes::TRANSMISSION))
    });
    when(surfaces.iter().any(is_textured), Needs::TEXTURES)
        | when(any_light(&|light| light.can_be_hit()), Needs::HITTABLE_LIGHTS)
        | when(any_light(&|light| !light.can_be_hit()), Needs::DIRAC_LIGHTS)
        | when(any_light(&|light| light.can_be_connected()), Needs::CONNECTIBLE_LIGHTS)
        | when(any_light(&|light| !light.can_be_connected()), Needs::UNCONNECTIBLE_LIGHTS)
        | when(any_light(&|light| light.can_illuminate(bounds)), Needs::ILLUMINATION)
        | when(!convex, Needs::INTERREFLECTION)
        | when(lobes.intersects(Lobes::FINITE), Needs::FINITE_LOBES)
        | when(lobes.intersects(Lobes::GLOSSY), Needs::GLOSSY_LOBES)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::endpoint::{DirectionSample, Endpoint, PointSample};
    use crate::geometry::{Quad, Sphere};
    use crate::math::{PerArea, PerProjected, Rgb};
    use crate::scene::Material;
    use crate::scene::{Emission, SceneError, WorldBuilder};

    /// A light of a given power that is proportional to the radius of the scene.
    struct Stub {
        power: f64,
        radius: f64,
    }

    impl Endpoint for Stub {
        fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
            None
        }
        fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
            PerArea::ZERO
        }
        fn sample_direction(&self, _: &SurfacePoint, _: DVec2) -> Option<DirectionSample> {
            None
        }
        fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
            PerProjected::ZERO
        }
        fn emit(&self, _: &SurfacePoint, _: DVec3) -> Rgb {
            Rgb::BLACK
        }
    }

    impl Light for Stub {
        fn power(&self) -> Rgb {
            Rgb::splat(self.power * self.radius)
        }
        fn can_be_hit(&self) -> bool {
            false
        }
        fn set_scene_bounds(&mut self, bounds: &Bounds) {
            self.radius = bounds.radius();
        }
    }

    fn stub(power: f64) -> Stub {
        Stub { power, radius: f64::NAN }
    }

    #[test]
    fn lights_are_picked_by_power_and_found_by_name() -> Result<(), SceneError> {
        let mut builder = WorldBuilder::new();
        let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
        builder.add_light("off", stub(0.0))?;
        builder.add_light("on", stub(2.0))?;
        builder.set_environment("sky", stub(1.0))?;
        assert_eq!(
            builder.set_environment("heaven", stub(1.0)),
            Err(SceneError::SecondEnvironment { name: "heaven".into() })
        );
        assert_eq!(
            builder.add_light("on", stub(1.0)),
            Err(SceneError::DuplicateName { name: "on".into() })
        );
        builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), grey)?;
        let lamp = builder.add_quad(
            "lamp",
            Quad { origin: DVec3::Z * 2.0, edge_u: DVec3::X, edge_v: DVec3::Y },
            grey,
        )?;
        let power_of_others =
            3.0 * Bounds { min: DVec3::splat(-1.0), max: DVec3::new(1.0, 1.0, 2.0) }.radius();
        let radiance = Rgb::splat(power_of_others / std::f64::consts::PI);
        builder.set_emission(lamp, Emission { radiance, two_sided: false })?;
        let world = builder.build()?;

        let id = |name: &str| world.light_by_name(name).expect("added");
        assert_eq!((world.light_count(), world.environment()), (4, Some(id("sky"))));
        for (name, pmf) in [("off", 0.0), ("on", 1.0 / 3.0), ("sky", 1.0 / 6.0), ("lamp", 0.5)] {
            approx::assert_relative_eq!(world.pick_pmf(id(name)), pmf, max_relative = 1e-12);
        }
        for i in 0..1000 {
            let (light, pmf) = world.pick_light(f64::from(i) / 1000.0).expect("there are lights");
            assert!(pmf > 0.0 && pmf == world.pick_pmf(light) && light != id("off"));
        }
        let hit = world
            .intersect(&SurfacePoint::dirac(DVec3::new(0.5, 0.5, 5.0)), -DVec3::Z)
            .expect("the lamp");
        assert_eq!(
            (world.surface_name(&hit), world.light_at(&hit)),
            (Some("lamp"), Some(id("lamp")))
        );
        let expected = Needs::HITTABLE_LIGHTS
            | Needs::DIRAC_LIGHTS
            | Needs::CONNECTIBLE_LIGHTS
            | Needs::FINITE_LOBES
            | Needs::ENVIRONMENT
            | Needs::ILLUMINATION
            | Needs::INTERREFLECTION;
        assert_eq!(world.needs(), expected);
        Ok(())
    }

    #[test]
    fn a_world_of_an_environment_alone_is_valid() -> Result<(), SceneError> {
        let mut builder = WorldBuilder::new();
        builder.set_environment("sky", stub(1.0))?;
        let world = builder.build()?;
        let (a, b) = (SurfacePoint::dirac(DVec3::ZERO), SurfacePoint::dirac(DVec3::X * 1e9));
        assert!(world.intersect(&a, DVec3::X).is_none());
        assert!(world.visible(&a, &b));
        assert_eq!((world.pick_light(0.5), world.total_area()), (None, 0.0));
        assert_eq!(
            world.bsdf(&world.sample_surface(0.5, DVec2::ZERO)).model(true),
            crate::bsdf::Model::BLACK
        );
        Ok(())
    }

    #[test]
    fn lights_without_a_proper_power_are_refused() {
        for power in [-1.0, f64::NAN, f64::INFINITY] {
            let mut builder = WorldBuilder::new();
            builder
                .add_light("bad", Stub { power, radius: 1.0 })
                .expect("power is known only when the scene is");
            builder.set_environment("sky", stub(1.0)).expect("valid");
            let black = builder.add_material("black", Material::Black).expect("valid");
            builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), black).expect("valid");
            assert!(matches!(
                builder.build(),
                Err(SceneError::Parameter { parameter: "power", .. })
            ));
        }
    }

    #[test]
    fn worlds_are_shared_between_threads() {
        fn check<T: Send + Sync>() {}
        check::<World>();
        check::<WorldBuilder>();
    }
}
