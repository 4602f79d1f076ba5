//! Flat diffuse vertices in lanes: connections to points on flat lights and to a pinhole, and the
//! directions of reflection.

use super::edge;
use crate::bsdf::{lambert, on_same_side, shading};
use crate::endpoint::{FlatLanes, View};
use crate::lanes::{Lane, Mask, Vector};
use std::f64::consts::FRAC_1_PI;

/// The state of a connection that carries nothing.
pub(super) const BLACK: f64 = 0.0;
/// The state of one that carries something.
pub(super) const LIT: f64 = 1.0;
/// The state where the edge is too short or too long for the formula of lanes.
pub(super) const INEXACT: f64 = 2.0;
/// The state of a connection that the camera does not see.
pub(super) const UNSEEN: f64 = -1.0;

/// Vertices on flat diffuse surfaces.
pub(super) struct Diffuse<L> {
    pub position: Vector<L>,
    pub normal: Vector<L>,
    pub to_previous: Vector<L>,
    pub throughput: Vector<L>,
    /// On the side that is seen.
    pub albedo: Vector<L>,
}

/// Points sampled on lights, seen from vertices.
pub(super) struct LightPoints<L> {
    pub position: Vector<L>,
    pub error: L,
    pub uv: [L; 2],
    /// Direction and geometry term of the edge.
    pub direction: Vector<L>,
    pub geometry: L,
    /// Unweighted estimates `T f G Le / p`.
    pub value: Vector<L>,
    pub state: L,
}

/// Connections to a pinhole.
pub(super) struct Pinhole<L> {
    /// Place on the full film, pixels.
    pub raster: [L; 2],
    /// Unweighted estimates `T f G We`.
    pub value: Vector<L>,
    pub state: L,
}

impl<L: Lane> Diffuse<L> {
    /// The fields in their order.
    #[inline(always)]
    pub fn new(numbers: [L; 15]) -> Self {
        let [px, py, pz, nx, ny, nz, wx, wy, wz, t0, t1, t2, a0, a1, a2] = numbers;
        Self {
            position: Vector::new(px, py, pz),
            normal: Vector::new(nx, ny, nz),
            to_previous: Vector::new(wx, wy, wz),
            throughput: Vector::new(t0, t1, t2),
            albedo: Vector::new(a0, a1, a2),
        }
    }

    /// Next events at points of lights that are uniform by area, given two random numbers and the
    /// densities.
    #[inline(always)]
    pub fn next_event(&self, light: &FlatLanes<L>, u: [L; 2], pdf: L) -> LightPoints<L> {
        let (position, error, uv) = light.point_at(u);
        let (direction, geometry, is_exact) = edge::between(self.position, position, |w| {
            self.normal.dot(w).abs() * light.normal.dot(w).abs()
        });
        let emits = light.normal.dot(-direction).is_positive();
        let reflects = on_same_side(self.normal.dot(direction), self.normal.dot(self.to_previous));
        let throughput = pdf.constant(1.0) / pdf;
        let [red, green, blue] = light.radiance;
        let incoming = Vector::new(red, green, blue) * throughput * geometry;
        let value = self.throughput * self.f() * incoming;
        let state = (emits & reflects & !is_black(value)).indicator(pdf);
        let state = is_exact.choose(state, pdf.constant(INEXACT));
        LightPoints { position, error, uv, direction, geometry, value, state }
    }

    /// Connections to a pinhole.
    #[inline(always)]
    pub fn lens_connection(&self, view: &View) -> Pinhole<L> {
        let z_to_previous = self.normal.dot(self.to_previous);
        let reflects = |to_lens| on_same_side(z_to_previous, self.normal.dot(to_lens));
        to_pinhole(view, self.position, self.normal, self.throughput * self.f(), reflects)
    }

    /// Directions of reflection, and where they are any.
    #[inline(always)]
    pub fn reflected(&self, u: [L; 2]) -> (Vector<L>, L::Mask) {
        reflected(self.normal, self.to_previous, u)
    }

    #[inline(always)]
    fn f(&self) -> Vector<L> {
        self.albedo * self.albedo.x.constant(FRAC_1_PI)
    }
}

/// Connections of points to a pinhole, given the throughput with the light that they send to it, and
/// whether they do so into a direction.
#[inline(always)]
pub(super) fn to_pinhole<L: Lane>(
    view: &View,
    position: Vector<L>,
    normal: Vector<L>,
    sent: Vector<L>,
    sends: impl FnOnce(Vector<L>) -> L::Mask,
) -> Pinhole<L> {
    let lens = Vector::constant(view.position, position.x);
    let (direction, geometry, is_exact) = edge::between(lens, position, |w| normal.dot(w).abs());
    let (raster, is_seen) = view.raster(direction);
    let value = sent * (geometry * view.pinhole_density(direction));
    let constant = |x| geometry.constant(x);
    let state = (sends(-direction) & !is_black(value)).indicator(geometry);
    let state = is_seen.choose(state, constant(UNSEEN));
    Pinhole { raster, value, state: is_exact.choose(state, constant(INEXACT)) }
}

/// Directions of Lambertian reflection, given normals, the directions that light comes from or goes
/// to and two random numbers; and where they are any.
#[inline(always)]
pub(super) fn reflected<L: Lane>(
    normal: Vector<L>,
    fixed: Vector<L>,
    u: [L; 2],
) -> (Vector<L>, L::Mask) {
    let (local, is_reflected) = lambert::reflected(normal.dot(fixed), u);
    (shading::to_world(normal, local), is_reflected)
}

#[inline(always)]
fn is_black<L: Lane>(v: Vector<L>) -> L::Mask {
    let zero = v.x.constant(0.0);
    v.x.equals(zero) & v.y.equals(zero) & v.z.equals(zero)
}
