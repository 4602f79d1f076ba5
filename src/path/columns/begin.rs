//! Walks that begin in columns.

use super::{Columns, Shared, Walk, lanes};
use crate::bsdf::TransportMode;
use crate::endpoint::{FlatLight, Light, LightId, View};
use crate::film::Sample;
use crate::geometry::SurfacePoint;
use crate::lanes::dispatch;
use crate::math::Rgb;
use crate::path::Plan;
use crate::path::diffuse::BLACK;
use crate::sampler::{Sampler, Stream};
use crate::scene::{FlatHit, Scene};
use fearless_simd::Level;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// The beginning of walks that advance in columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// As [`Steps::begin`](crate::path::Steps::begin) has it.
    Shown,
    /// At the camera, where nothing is done.
    AtCamera,
    /// At a light, which is connected to the lens.
    AtLight {
        /// True if it is of use to go on from there.
        goes_on: bool,
    },
}

/// The place of a walk that begins at the camera.
const NOWHERE: FlatHit = FlatHit { primitive: SurfacePoint::NONE, u: 0.0, v: 0.0 };

impl<'s> Columns<'s> {
    /// Begins the walks of all samples, if they begin as columns can.
    pub fn begin<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        shared: &mut Shared<'_, 's, S, P>,
    ) -> bool {
        let stage = &shared.plan.stage;
        let Some(view) = stage.camera.as_pinhole() else { return false };
        self.bounces = 0;
        match shared.steps.begin {
            Begin::Shown => return false,
            Begin::AtCamera => self.begin_at_camera(view, shared.level, shared.samples),
            Begin::AtLight { .. } if !shared.plan.techniques.lens_sampling => {}
            Begin::AtLight { goes_on } => {
                let Some(id) = stage.only_light() else { return false };
                let Some(light) = stage.scene.light(id).as_flat() else { return false };
                self.begin_at_light((id, light), goes_on, shared);
            }
        }
        true
    }

    fn begin_at_camera<P: Sampler>(
        &mut self,
        view: &View,
        level: Level,
        samples: &mut [Sample<P>],
    ) {
        self.mode = Some(TransportMode::Radiance);
        self.numbers.clear();
        for Sample { film, sampler } in samples.iter_mut() {
            sampler.stream(Stream::Lens);
            sampler.skip_1d();
            sampler.skip_2d();
            self.numbers.push_row(view.film.to_window(film.raster + film.offset).to_array());
        }
        self.from_lens.resize(samples.len());
        through_film(level, self, view);
        for sample in 0..samples.len() {
            let [x, y, z, state] = self.from_lens.get(sample);
            if state != BLACK {
                let walk = Walk { sample: sample as u32, at: NOWHERE };
                self.under_way.push(
                    walk,
                    [view.position.x, view.position.y, view.position.z, x, y, z],
                    [1.0; 5],
                );
            }
        }
    }

    fn begin_at_light<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        (id, light): (LightId, &FlatLight),
        goes_on: bool,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        let Shared { plan: Plan { depth, .. }, level, samples, counters, .. } = shared;
        self.mode = Some(TransportMode::Importance);
        self.emission.clear();
        for Sample { sampler, .. } in samples.iter_mut() {
            sampler.stream(Stream::Emission);
            // There is no choice of a light, nor of a shape of it.
            sampler.skip_1d();
            sampler.skip_1d();
            let (u, v) = (sampler.next_2d(), sampler.next_2d());
            self.emission.push_row([u.x, u.y, v.x, v.y]);
        }
        counters.light_subpaths += samples.len() as u64;
        self.points.resize(samples.len());
        self.from_light.resize(samples.len());
        emit(*level, self, light);
        let start = Rgb::splat(1.0 / light.pdf.value());
        for sample in 0..samples.len() {
            let [.., u, v, _] = self.from_light.get(sample);
            let at = FlatHit { primitive: light.primitive, u, v };
            self.walks.push(Walk { sample: sample as u32, at });
            self.carried.push([DVec3::ZERO, DVec3::from_array(start.0)], [0.0; 2]);
        }
        if depth.contains(0) {
            self.connect_to_lens(Some(id), shared);
        }
        let throughput = light.radiance / FRAC_1_PI * start;
        let [red, green, blue] = throughput.0;
        let carried = [red, green, blue, throughput.max_component(), 1.0];
        for (k, walk) in self.walks.iter().enumerate() {
            let [ray @ .., _, _, leaves] = self.from_light.get(k);
            if leaves == 0.0 {
                continue;
            }
            shared.counters.ledger.emitted += throughput;
            if goes_on {
                self.under_way.push(*walk, ray, carried);
            } else {
                shared.counters.truncate(TransportMode::Importance, throughput, 0);
            }
        }
        self.forget_vertices();
    }
}

#[inline(never)]
fn through_film(level: Level, Columns { numbers, from_lens, .. }: &mut Columns<'_>, view: &View) {
    dispatch!(level, simd => lanes::begin(simd, view, numbers, from_lens));
}

#[inline(never)]
fn emit(level: Level, columns: &mut Columns<'_>, light: &FlatLight) {
    let Columns { emission, points, from_light, .. } = columns;
    dispatch!(level, simd => lanes::emit(simd, light, emission, points, from_light));
}
