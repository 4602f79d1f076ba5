//! The answers of a world: the rays and segments of the [`Scene`] trait, and plain ones.

use super::{FlatSurfaces, World};
use crate::endpoint::{AnyLight, Light, LightId, LightKind};
use crate::geometry::{Intersection, NormalOrigin, Place, SurfacePoint, Triangle};
use crate::light_tree::LightTree;
use crate::material::{Ground, Relief, SurfaceBsdf, VertexSite};
use crate::math::Rgb;
use crate::scene::mesh::Shading;
use crate::scene::{Needs, Scene, SurfaceArea};
use crate::tree::{Hit, Query, Segment};
use glam::{DVec2, DVec3};

impl World {
    /// The primitive that a ray meets first and its distance: [`Scene::intersect`] without the
    /// surface point, for whoever needs no more, from an origin that lies on no surface. A
    /// direction that is not of unit length is made so; a ray that is none hits nothing. What is cut
    /// out of surfaces is hit, too.
    #[must_use]
    pub fn first_hit(&self, origin: DVec3, direction: DVec3) -> Option<(u32, f64)> {
        self.forest.closest(Query::free(origin, direction), primitive_and_distance)
    }

    /// [`first_hit`](Self::first_hit) of many rays, given by origin and direction. `found` gets
    /// each answer once, with the ray's place in the iterator, in any order.
    pub fn first_hits(
        &self,
        rays: impl Iterator<Item = (DVec3, DVec3)>,
        mut found: impl FnMut(usize, Option<(u32, f64)>),
    ) {
        let queries = rays.map(|(origin, direction)| Query::free(origin, direction));
        self.forest
            .closest_many(queries, |index, _, hit| found(index, hit.map(primitive_and_distance)));
    }

    /// True if a ray meets nothing nearer than `length`: [`Scene::visible`] for an origin and an
    /// end that lie on no surface. What is cut out of surfaces is met, too.
    #[must_use]
    pub fn is_clear(&self, origin: DVec3, direction: DVec3, length: f64) -> bool {
        self.forest.is_free(&Segment::free(origin, direction, length))
    }

    /// [`is_clear`](Self::is_clear) of many rays, given by origin, direction and length. `answer`
    /// gets each answer once, with the ray's place in the iterator, in any order.
    pub fn are_clear(
        &self,
        rays: impl Iterator<Item = (DVec3, DVec3, f64)>,
        answer: impl FnMut(usize, bool),
    ) {
        self.forest.are_free(
            rays.map(|(origin, direction, length)| Ok(Segment::free(origin, direction, length))),
            answer,
        );
    }

    /// True if there is nothing of its surface at a point.
    fn is_cut_out(&self, x: &SurfacePoint) -> bool {
        let surface = self.surfaces.get(x.surface as usize);
        let cutout = surface.and_then(|surface| surface.cutout.as_ref());
        cutout.is_some_and(|there| there.seen(x.uv, &|| self.vertex_site(x)).is_black())
    }

    /// The first hit where nothing is cut out, and its ray, from the nearest hit of a ray.
    #[inline(never)]
    fn hit_beyond<'a>(&'a self, ray: &Query, hit: &Hit<'a>) -> Option<(Query, Hit<'a>)> {
        let (mut ray, mut hit) = (*ray, *hit);
        loop {
            let x = self.point_of(&ray, &hit)?;
            if !self.is_cut_out(&x) {
                return Some((ray, hit));
            }
            ray = Query::leaving(&x, ray.direction);
            hit = self.forest.closest(ray, |hit| hit)?;
        }
    }

    /// The surface point that a ray meets, from its nearest hit.
    #[inline(always)]
    fn point_met(&self, ray: &Query, hit: &Hit<'_>) -> Option<SurfacePoint> {
        let beyond;
        let (ray, hit) = if self.has_cutouts {
            beyond = self.hit_beyond(ray, hit)?;
            (&beyond.0, &beyond.1)
        } else {
            (ray, hit)
        };
        self.point_of(ray, hit)
    }

    /// The segment that must be free for two points to see each other, or what is known without.
    #[inline(always)]
    fn segment(&self, a: &SurfacePoint, b: &SurfacePoint) -> Result<Segment, bool> {
        if self.has_cutouts {
            return Err(self.visible_beyond(a, b));
        }
        Segment::between(a, b, self.forest.center())
    }

    /// The answer of [`Scene::visible`] where parts of surfaces are cut out.
    #[inline(never)]
    fn visible_beyond(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let (mut x, end) = if a.place == Place::Infinite { (*b, a) } else { (*a, b) };
        let direction = match end.place {
            Place::Infinite => -end.geometric_normal,
            Place::Area | Place::Dirac => (end.position - x.position).normalize_or_zero(),
        };
        loop {
            match Segment::between(&x, end, self.forest.center()) {
                Err(visible) => return visible,
                Ok(segment) if self.forest.is_free(&segment) => return true,
                Ok(_) => {}
            }
            let ray = Query::leaving(&x, direction);
            match self.forest.closest(ray, |hit| hit).and_then(|hit| self.point_of(&ray, &hit)) {
                Some(next)
                    if self.is_cut_out(&next)
                        && (end.position - next.position).dot(direction) > 0.0 =>
                {
                    x = next;
                }
                _ => return false,
            }
        }
    }

    /// The surface point of a ray's hit.
    #[inline(always)]
    pub(super) fn point_of(&self, ray: &Query, hit: &Hit<'_>) -> Option<SurfacePoint> {
        let Intersection { u, v, .. } = hit.intersection;
        if let Some(Some(flat)) = self.flat.get(hit.primitive as usize)
            && let Some(point) = flat.point_at(hit.primitive, u, v)
        {
            return Some(point);
        }
        let Some(triangle) = self.forest.triangle_of(hit) else {
            return self.point_of_other(ray, hit);
        };
        Some(self.complete(hit.primitive, Some(triangle), triangle.point_at(u, v)))
    }

    /// The same for a shape that is no triangle. Apart, so that points of triangles need not be
    /// where it leaves its own.
    #[inline(never)]
    fn point_of_other(&self, ray: &Query, hit: &Hit<'_>) -> Option<SurfacePoint> {
        let ray = hit.ray_of(ray)?;
        let x = self.forest.shape(hit.primitive)?.point_at_hit(&ray, &hit.intersection);
        Some(self.complete(hit.primitive, None, x))
    }

    /// Completes a point of a shape, perhaps of a triangle, with everything that the scene knows
    /// about it.
    #[inline(always)]
    pub(super) fn complete(
        &self,
        primitive: u32,
        triangle: Option<Triangle>,
        x: SurfacePoint,
    ) -> SurfacePoint {
        let id = self.surface_of[primitive as usize];
        let surface = &self.surfaces[id as usize];
        if let Some(relief) = &surface.relief {
            return self.complete_in_relief(relief, primitive, triangle, x);
        }
        self.complete_unmapped(primitive, triangle, x)
    }

    /// A point where a map makes the shading normal. Apart, so that it costs other points nothing.
    #[inline(never)]
    fn complete_in_relief(
        &self,
        relief: &Relief,
        primitive: u32,
        triangle: Option<Triangle>,
        x: SurfacePoint,
    ) -> SurfacePoint {
        let point = self.complete_unmapped(primitive, triangle, x);
        let surface = &self.surfaces[point.surface as usize];
        let index = (primitive - surface.first_primitive) as usize;
        let attributes = surface.attributes.as_ref();
        let other = relief.texture().has_other_coordinates();
        let partials = match (attributes, triangle) {
            (Some(attributes), Some(triangle)) => attributes.partials(index, triangle, other),
            _ => self.forest.shape(primitive).map_or([DVec3::ZERO; 2], |shape| shape.partials(&x)),
        };
        let uv = match self.vertex_site(&point) {
            Some(site) if other => site.uv(true),
            _ => point.uv,
        };
        let ground = Ground {
            normal: point.shading_normal,
            geometric_normal: point.geometric_normal,
            tangent: point.tangent,
            handedness: attributes.and_then(|attributes| attributes.handedness(index)),
            uv,
            partials,
        };
        SurfacePoint {
            shading_normal: relief.normal(&ground),
            normal_origin: NormalOrigin::Map,
            ..point
        }
    }

    /// The place of a point on a mesh that has colours or two sets of texture coordinates.
    #[inline(never)]
    pub(super) fn vertex_site(&self, x: &SurfacePoint) -> Option<VertexSite<'_>> {
        let surface = self.surfaces.get(x.surface as usize)?;
        let values =
            Some(surface.attributes.as_ref()?.values()).filter(|values| values.has_more())?;
        let triangle = self.forest.shape(x.primitive)?.as_triangle()?;
        Some(VertexSite {
            values,
            index: x.primitive - surface.first_primitive,
            barycentric: triangle.barycentric(x.position),
        })
    }

    #[inline(always)]
    fn complete_unmapped(
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
    type Light = AnyLight;

    fn fingerprint(&self) -> Option<u64> {
        Some(self.print())
    }

    const AS_WORLD: Option<fn(&Self) -> &World> = Some(|world| world);

    #[inline]
    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        // The point is made where it is needed.
        let ray = Query::leaving(from, direction);
        self.forest.closest(ray, |hit| hit).and_then(|hit| self.point_met(&ray, &hit))
    }

    /// Coincident points, two points at infinity and points that are not finite do not see each
    /// other: they have no geometry term.
    #[inline]
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.segment(a, b).map_or_else(|visible| visible, |segment| self.forest.is_free(&segment))
    }

    #[inline]
    fn intersect_many<'a>(
        &self,
        rays: impl Iterator<Item = (&'a SurfacePoint, DVec3)>,
        mut found: impl FnMut(usize, Option<SurfacePoint>),
    ) {
        // `found` has one place, in which it is inlined: else points of surfaces are copied.
        let queries = rays.map(|(from, direction)| Query::leaving(from, direction));
        self.forest.closest_many(queries, |index, ray, hit| {
            found(index, hit.and_then(|hit| self.point_met(ray, &hit)))
        });
    }

    #[inline]
    fn visible_many<'a>(
        &self,
        segments: impl Iterator<Item = (&'a SurfacePoint, &'a SurfacePoint)>,
        answer: impl FnMut(usize, bool),
    ) {
        self.forest.are_free(segments.map(|(a, b)| self.segment(a, b)), answer);
    }

    #[inline]
    fn transmittance(&self, a: &SurfacePoint, b: &SurfacePoint) -> Rgb {
        if self.media.is_empty() { Rgb::WHITE } else { self.passing(a, b) }
    }

    #[inline]
    fn medium_towards(&self, x: &SurfacePoint, direction: DVec3) -> u16 {
        if self.media.is_empty() { 0 } else { self.medium_beyond(x, direction) }
    }

    #[inline]
    fn medium_at(&self, x: &SurfacePoint) -> u16 {
        if self.media.is_empty() { 0 } else { self.medium_around(x) }
    }

    #[inline]
    fn bsdf(&self, x: &SurfacePoint) -> SurfaceBsdf<'_> {
        let surface = self.surfaces.get(x.surface as usize);
        match surface.and_then(|surface| self.materials.get(surface.material.0 as usize)) {
            Some(_) if self.has_cutouts && self.is_cut_out(x) => SurfaceBsdf::BLACK,
            Some(material) => SurfaceBsdf::new(material, x.uv, || self.vertex_site(x)),
            None => SurfaceBsdf::BLACK,
        }
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
    #[inline]
    fn light(&self, id: LightId) -> &AnyLight {
        &self.lights[id.0 as usize].1
    }

    #[inline]
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.light_tree.sample_regardless(None, u).map(of_light)
    }

    #[inline]
    fn pick_pmf(&self, id: LightId) -> f64 {
        self.light_tree.pmf_regardless(None, id.0)
    }

    #[inline]
    fn pick_light_for(&self, receiver: &SurfacePoint, u: f64) -> Option<(LightId, f64)> {
        self.light_tree.sample(receiver, None, u).map(of_light)
    }

    #[inline]
    fn pick_pmf_for(&self, receiver: &SurfacePoint, id: LightId) -> f64 {
        self.light_tree.pmf(receiver, None, id.0)
    }

    #[inline]
    fn light_tree(&self) -> Option<&LightTree> {
        Some(&self.light_tree)
    }

    fn light_names(&self, kind: LightKind) -> Option<Vec<&str>> {
        let is_seen = |light: &AnyLight| !light.is_black() && light.kind() == kind;
        let lights = self.lights.iter().filter(|(_, light)| is_seen(light));
        Some(lights.map(|(name, _)| name.as_str()).collect())
    }

    #[inline]
    fn flat_surfaces(&self) -> Option<FlatSurfaces<'_>> {
        (self.media.is_empty() && !self.has_cutouts).then_some(FlatSurfaces(self))
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
        match chosen.and_then(|primitive| Some((primitive, self.forest.shape(primitive)?))) {
            Some((primitive, shape)) => {
                self.complete(primitive, shape.as_triangle(), shape.sample_area(u2))
            }
            // A world without surfaces: a point that nothing is known about and that scatters
            // nothing.
            None => SurfacePoint::dirac(DVec3::ZERO),
        }
    }
}

/// The light of an item of the tree.
#[inline]
fn of_light((item, pmf): (u32, f64)) -> (LightId, f64) {
    (LightId(item), pmf)
}

/// A hit without its surface point.
#[inline(always)]
fn primitive_and_distance(hit: Hit<'_>) -> (u32, f64) {
    (hit.primitive, hit.moved + hit.intersection.t)
}
