//! Directions of Lambertian reflection.

use crate::bsdf::{Bsdf, BsdfSample, LaneForm};
use crate::lanes::{Mask, Rows, Vector, dispatch, load, store};
use crate::math::{PerProjected, Rgb};
use crate::path::Vertex;
use crate::path::diffuse::reflected;
use crate::path::steps::Drawn;
use fearless_simd::{Level, Simd};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// The walks that are reflected by Lambert's law, and where they go.
#[derive(Debug, Default)]
pub(super) struct Reflections {
    /// The number of each walk, and the albedo.
    walks: Vec<(u32, Rgb)>,
    /// Normal, direction to the previous vertex, two random numbers.
    given: Rows<8>,
    /// Direction; 0 if there is none, else 1.
    sampled: Rows<4>,
}

impl Reflections {
    pub(super) fn clear(&mut self) {
        self.walks.clear();
        self.given.clear();
    }

    /// Accepts a vertex that lanes can sample a direction for. Returns true if it is one.
    #[inline(always)]
    pub(super) fn accept<B: Bsdf>(&mut self, walk: usize, vertex: &Vertex<B>, u: DVec2) -> bool {
        let Some(LaneForm::Lambert(lambert)) = vertex.lane_form() else { return false };
        self.walks.push((walk as u32, lambert.albedo()));
        self.given.push([vertex.point.shading_normal, vertex.to_previous], [u.x, u.y]);
        true
    }

    /// Samples the directions, and enters them by the numbers of their walks.
    #[inline(never)]
    pub(super) fn sample(&mut self, level: Level, drawn: &mut [Drawn]) {
        self.sampled.resize(self.walks.len());
        dispatch!(level, simd => sample(simd, &self.given, &mut self.sampled));
        for (k, &(i, weight)) in self.walks.iter().enumerate() {
            let [x, y, z, state] = self.sampled.get(k);
            let pdf = PerProjected(FRAC_1_PI);
            drawn[i as usize] = Drawn::Direction((state != 0.0).then_some(BsdfSample {
                next: DVec3::new(x, y, z),
                weight,
                pdf,
                pdf_reverse: pdf,
                dirac: false,
                relative_ior: 1.0,
            }));
        }
    }
}

#[inline(always)]
fn sample<S: Simd>(simd: S, given: &Rows<8>, sampled: &mut Rows<4>) {
    for (given, sampled) in given.groups().iter().zip(sampled.groups_mut()) {
        let [nx, ny, nz, fx, fy, fz, u1, u2] = load(simd, given);
        let (normal, fixed) = (Vector::new(nx, ny, nz), Vector::new(fx, fy, fz));
        let (next, is_reflected) = reflected(normal, fixed, [u1, u2]);
        store(sampled, [next.x, next.y, next.z, is_reflected.indicator(u1)]);
    }
}
