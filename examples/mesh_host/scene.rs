//! A host whose geometry is triangles of f32 numbers in a tree of obvhs, as a scene.
//!
//! # A recipe for f32 geometry
//!
//! Integrators compute in f64, and a coordinate in f32 is one in f64, too. So nothing is lost if the
//! f32 part of a host finds candidates, and what a path is made of is computed from the same
//! vertices in f64:
//!
//! 1. **The tree decides nothing.** Its boxes are f32 and are tested in f32: ray origin and
//!    direction are rounded to 2⁻²⁴ of their size, slabs to a few times that. Boxes that are wider
//!    by 2⁻²⁰ of the largest coordinate are passed by every ray that meets what is in them, from
//!    anywhere within eight times that size.
//! 2. **Triangles are tested in f64**, by a test that is watertight at shared edges
//!    ([`Shape::intersect_apart_from`]): its edges are the same f32 vertices for both neighbours. A
//!    test in f32 will do if it is watertight; keep its triangle and barycentric coordinates and
//!    throw away its distance.
//! 3. **`error` is the distance of the position from the true surface.** Computed in f64 from
//!    barycentric coordinates ([`Triangle::point_at`]), however inexact these are, the position is
//!    off the plane of the triangle by a few 2⁻⁵³ of its coordinates, and not by what f32
//!    distances lose. A host that computes `origin + t · direction` in f32 owes
//!    `error = 2⁻²⁴ · 8 · (|origin| + t)` instead.
//! 4. **Both ends of a ray are moved** beyond their error by [`SurfacePoint::origin_towards`], to the
//!    side where the other end is, and the triangle that an end lies on cannot be hit at that end
//!    ([`Contact`]). So there is no epsilon in a unit of length, and no minimum distance that
//!    would let light through where walls meet.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::RayHit;
use pathspace::bsdf::Lambert;
use pathspace::endpoint::{AreaLight, EndpointError, LightId};
use pathspace::geometry::{Contact, Intersection, Ray, Shape, SurfacePoint, Triangle};
use pathspace::glam::DVec3;
use pathspace::math::Rgb;
use pathspace::scene::{Needs, Scene};
use std::time::Duration;

/// Diffuse triangles, the last ones of which emit.
pub struct MeshScene {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    material: Lambert,
    tree: Bvh2,
    /// The margin of the boxes.
    margin: f32,
    lamp: AreaLight,
    first_of_lamp: u32,
}

impl MeshScene {
    /// Triangles, of which those from `first_of_lamp` on emit on their front, which sees their
    /// vertices counter-clockwise.
    ///
    /// # Errors
    /// If the lamp has no area.
    pub fn new(
        vertices: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        material: Lambert,
        (first_of_lamp, radiance): (u32, Rgb),
    ) -> Result<Self, EndpointError> {
        let largest = vertices.iter().flatten().fold(0.0, |m: f32, c| m.max(c.abs()));
        let margin = largest / (1 << 20) as f32;
        let corner = |of: fn(f32, f32) -> f32, t: &[u32; 3], margin: f32| {
            let [a, b, c] = t.map(|vertex| vertices[vertex as usize]);
            [0, 1, 2].map(|axis| of(of(a[axis], b[axis]), c[axis]) + margin).into()
        };
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|t| Aabb { min: corner(f32::min, t, -margin), max: corner(f32::max, t, margin) })
            .collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let shapes = (first_of_lamp as usize..triangles.len())
            .map(|i| shape(&vertices, &triangles[i]))
            .collect();
        let lamp = AreaLight::new(shapes, first_of_lamp, first_of_lamp, radiance, false)?;
        Ok(Self { vertices, triangles, material, tree, margin, lamp, first_of_lamp })
    }

    fn ray(&self, ray: &Ray, length: f64) -> obvhs::ray::Ray {
        let single = |v: DVec3| v.to_array().map(|c| c as f32).into();
        obvhs::ray::Ray::new(single(ray.origin), single(ray.direction), 0.0, self.beyond(length))
    }

    /// A distance in f32 at which a box is not passed before the given one.
    fn beyond(&self, t: f64) -> f32 {
        (t * (1.0 + 1.0 / (1 << 20) as f64)) as f32 + self.margin
    }

    /// The test of the primitive in a slot of the tree; `contact` is known of it.
    fn hit(
        &self,
        ray: &Ray,
        slot: usize,
        contact: impl Fn(u32) -> Contact,
    ) -> Option<(u32, Intersection)> {
        let triangle = self.tree.primitive_indices[slot];
        let shape = shape(&self.vertices, &self.triangles[triangle as usize]);
        Some((triangle, shape.intersect_apart_from(ray, contact(triangle))?))
    }
}

/// A triangle in f64.
fn shape(vertices: &[[f32; 3]], triangle: &[u32; 3]) -> Shape {
    let vertices = triangle.map(|i| DVec3::from_array(vertices[i as usize].map(f64::from)));
    Shape::Triangle(Triangle { vertices })
}

impl Scene for MeshScene {
    type Bsdf<'a> = Lambert;
    type Light = AreaLight;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        let ray = Ray::new(from.origin_towards(direction), direction);
        let leaves = |triangle| {
            if triangle == from.primitive { Contact::Origin } else { Contact::None }
        };
        let mut nearest: Option<(u32, Intersection)> = None;
        let ray_f32 = self.ray(&ray, f64::INFINITY);
        self.tree.ray_traverse(ray_f32, &mut RayHit::none(), |_, slot| {
            match self.hit(&ray, slot, leaves) {
                Some(hit) if nearest.is_none_or(|nearest| hit.1.t < nearest.1.t) => {
                    nearest = Some(hit);
                    self.beyond(hit.1.t)
                }
                _ => f32::INFINITY,
            }
        });
        let (primitive, hit) = nearest?;
        let point =
            shape(&self.vertices, &self.triangles[primitive as usize]).point_at_hit(&ray, &hit);
        let surface = if primitive < self.first_of_lamp { 0 } else { self.first_of_lamp };
        Some(SurfacePoint { primitive, surface, ..point })
    }

    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let towards = b.position - a.position;
        let (start, end) = (a.origin_towards(towards), b.origin_towards(-towards));
        let (length, direction) = ((end - start).length(), (end - start).normalize_or_zero());
        let ray = Ray::new(start, direction);
        let ends = |triangle| match (triangle == a.primitive, triangle == b.primitive) {
            (false, false) => Contact::None,
            (true, false) => Contact::Origin,
            (false, true) => Contact::End(length),
            (true, true) => Contact::Both,
        };
        self.tree.ray_traverse_miss(self.ray(&ray, length), |_, slot| {
            let is_between = self.hit(&ray, slot, ends).is_some_and(|(_, hit)| hit.t < length);
            if is_between { 0.0 } else { f32::INFINITY }
        })
    }

    fn bsdf(&self, _x: &SurfacePoint) -> Lambert {
        self.material
    }

    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        (x.surface == self.first_of_lamp).then_some(LightId(0))
    }

    fn light(&self, _id: LightId) -> &AreaLight {
        &self.lamp
    }

    fn pick_light(&self, _u: f64) -> Option<(LightId, f64)> {
        Some((LightId(0), 1.0))
    }

    fn pick_pmf(&self, _id: LightId) -> f64 {
        1.0
    }

    /// Optional: integrators leave out what the scene does not need.
    fn needs(&self) -> Needs {
        Needs::HITTABLE_LIGHTS
            | Needs::CONNECTIBLE_LIGHTS
            | Needs::FINITE_LOBES
            | Needs::ILLUMINATION
            | Needs::INTERREFLECTION
    }
}
