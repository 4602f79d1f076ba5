//! The directions in which walks go on.

use super::Batch;
use crate::bsdf::{BsdfSample, LaneForm, lambert, shading};
use crate::lanes::{Mask, Rows, Vector, load, store};
use crate::math::{PerProjected, Rgb};
use crate::path::steps::Drawn;
use crate::sampler::Sampler;
use crate::scene::Scene;
use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::ops::ControlFlow;

/// The walks that are reflected by Lambert's law, and where they go.
#[derive(Debug, Default)]
pub(in crate::path) struct Reflections {
    /// The number of each walk, and the albedo.
    walks: Vec<(u32, Rgb)>,
    /// Normal, direction to the previous vertex, two random numbers.
    given: Rows<8>,
    /// Direction; 0 if there is none, else 1.
    sampled: Rows<4>,
}

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Batch<'_, 's, S, P> {
    /// Samples the directions in which the walks go on that have not ended.
    #[inline]
    pub(super) fn sample_directions(&mut self) {
        let mut reflections = std::mem::take(&mut self.scratch.reflections);
        reflections.walks.clear();
        reflections.given.clear();
        self.visit(|i, visit| {
            *visit.drawn = Drawn::Nothing;
            let Some(bsdf) = &visit.vertex.bsdf else { return ControlFlow::Break(()) };
            let sampler = &mut visit.sample.sampler;
            let Some((u1, u2)) = visit.walk.begin_scattering(sampler, visit.counters) else {
                return ControlFlow::Break(());
            };
            let fixed = visit.vertex.to_previous;
            match bsdf.lane_form(fixed) {
                Some(LaneForm::Lambert(lambert)) => {
                    let normal = visit.vertex.point.shading_normal;
                    reflections.walks.push((i as u32, lambert.albedo()));
                    reflections.given.push([
                        normal.x, normal.y, normal.z, fixed.x, fixed.y, fixed.z, u2.x, u2.y,
                    ]);
                }
                Some(LaneForm::Black) => *visit.drawn = Drawn::Direction(None),
                _ => {
                    let mode = visit.walk.mode();
                    *visit.drawn = Drawn::Direction(bsdf.sample(fixed, mode, u1, u2));
                }
            }
            ControlFlow::Continue(())
        });
        reflections.sample(self.scratch.level);
        for (k, &(i, weight)) in reflections.walks.iter().enumerate() {
            let [x, y, z, state] = reflections.sampled.get(k);
            let pdf = PerProjected(FRAC_1_PI);
            self.scratch.drawn[i as usize] =
                Drawn::Direction((state != 0.0).then_some(BsdfSample {
                    next: DVec3::new(x, y, z),
                    weight,
                    pdf,
                    pdf_reverse: pdf,
                    dirac: false,
                    relative_ior: 1.0,
                }));
        }
        self.scratch.reflections = reflections;
    }
}

impl Reflections {
    /// Samples the directions.
    #[inline(never)]
    fn sample(&mut self, level: Level) {
        self.sampled.resize(self.walks.len());
        dispatch!(level, simd => sample(simd, &self.given, &mut self.sampled));
    }
}

#[inline(always)]
fn sample<S: Simd>(simd: S, given: &Rows<8>, sampled: &mut Rows<4>) {
    for (given, sampled) in given.groups().iter().zip(sampled.groups_mut()) {
        let [nx, ny, nz, fx, fy, fz, u1, u2] = load(simd, given);
        let (normal, fixed) = (Vector::new(nx, ny, nz), Vector::new(fx, fy, fz));
        let (local, is_reflected) = lambert::reflected(normal.dot(fixed), [u1, u2]);
        let next = shading::to_world(normal, local);
        store(sampled, [next.x, next.y, next.z, is_reflected.indicator(u1)]);
    }
}
