//! The ends of connections in lanes.

use crate::bsdf::{Bsdf, Lambert, LaneForm, on_same_side};
use crate::endpoint::FlatLight;
use crate::geometry::SurfacePoint;
use crate::lanes::{Lane, Vector};
use crate::path::Vertex;
use crate::path::mis::Side;
use crate::tree::LaneEnd;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Numbers of a vertex: position, normal, direction to the previous vertex, throughput, f, error
/// bound, primitive, and what weights take of its [`Side`]. All are 0 where lanes have no form for
/// it.
pub(in crate::path) const END: usize = 23;

/// The vectors among the numbers of a vertex, and the others.
type Numbers = ([DVec3; 5], [f64; 8]);

/// The reflector of a vertex, if lanes have a form for it.
#[inline]
pub(super) fn lambert<B: Bsdf>(vertex: &Vertex<B>) -> Option<Lambert> {
    match vertex.lane_form()? {
        LaneForm::Lambert(lambert) => Some(lambert),
        _ => None,
    }
}

/// The numbers of a vertex with a reflector.
#[inline]
pub(super) fn of_surface<B: Bsdf>(
    vertex: &Vertex<B>,
    lambert: Option<Lambert>,
    side: impl FnOnce() -> Side<f64>,
) -> Numbers {
    let Some(lambert) = lambert else { return Numbers::default() };
    let f = (lambert.albedo() * FRAC_1_PI).0.into();
    let x = &vertex.point;
    let throughput = vertex.throughput.0.into();
    let vectors = [x.position, x.geometric_normal, vertex.to_previous, throughput, f];
    (vectors, rest(x, side()))
}

/// The numbers of the start of a light subpath on a flat light: what it emits is reflected light
/// that comes along the normal.
#[inline]
pub(super) fn of_start<B>(
    start: &Vertex<B>,
    light: Option<&FlatLight>,
    side: impl FnOnce() -> Side<f64>,
) -> Numbers {
    let Some(light) = light else { return Numbers::default() };
    let (position, normal) = (start.point.position, start.point.geometric_normal);
    let [throughput, radiance] = [start.throughput, light.radiance].map(|colour| colour.0.into());
    ([position, normal, normal, throughput, radiance], rest(&start.point, side()))
}

fn rest(x: &SurfacePoint, side: Side<f64>) -> [f64; 8] {
    let [density, share, geometry, density_before, partial, merges] = side.numbers();
    [x.error, bits(x.primitive), density, share, geometry, density_before, partial, merges]
}

/// A number of which lanes keep the bits, as those of an f64, and that they compute nothing with.
#[inline]
pub(super) fn bits(primitive: u32) -> f64 {
    f64::from_bits(primitive.into())
}

/// A vertex in each lane.
pub(super) struct End<L> {
    /// The point, as an end of a shadow ray.
    pub point: LaneEnd<L>,
    /// Its [bits].
    pub primitive: L,
    to_previous: Vector<L>,
    throughput: Vector<L>,
    f: Vector<L>,
    pub side: Side<L>,
}

impl<L: Lane> End<L> {
    #[inline(always)]
    pub fn new(n: [L; END]) -> Self {
        Self {
            point: LaneEnd {
                position: Vector::new(n[0], n[1], n[2]),
                normal: Vector::new(n[3], n[4], n[5]),
                error: n[15],
            },
            primitive: n[16],
            to_previous: Vector::new(n[6], n[7], n[8]),
            throughput: Vector::new(n[9], n[10], n[11]),
            f: Vector::new(n[12], n[13], n[14]),
            side: Side::new([n[17], n[18], n[19], n[20], n[21], n[22]]),
        }
    }

    /// True where lanes have a form for it: a normal of length 0 is no vertex.
    #[inline(always)]
    pub fn is_known(&self) -> L::Mask {
        self.point.normal.length_squared().is_positive()
    }

    /// Throughput times f.
    #[inline(always)]
    pub fn scattered(&self) -> Vector<L> {
        self.throughput * self.f
    }

    #[inline(always)]
    pub fn cosine(&self, direction: Vector<L>) -> L {
        self.point.normal.dot(direction).abs()
    }

    /// True where it reflects between the previous vertex and a direction.
    #[inline(always)]
    pub fn reflects(&self, direction: Vector<L>) -> L::Mask {
        on_same_side(self.point.normal.dot(direction), self.point.normal.dot(self.to_previous))
    }
}
