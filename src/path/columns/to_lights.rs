//! Next event estimation in columns.

use super::lanes::{IS_FORWARD, STATE};
use super::{Columns, Shared, lanes};
use crate::endpoint::{FlatLight, Light, LightId};
use crate::film::{Contribution, Technique};
use crate::geometry::SurfacePoint;
use crate::lanes::dispatch;
use crate::math::{PerArea, Rgb};
use crate::path::connect::{emitter_at, next_event_at};
use crate::path::diffuse::{INEXACT, LIT};
use crate::path::{Heuristic, Out, SampledEndpoint};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use crate::tree::Ends;
use fearless_simd::Level;
use glam::{DVec2, DVec3};

/// A connection to a point on a light, which two random numbers choose.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPoint<'s> {
    id: LightId,
    pub light: &'s FlatLight,
    /// The density of the point.
    pdf: PerArea,
    u: DVec2,
}

impl<'s> Columns<'s> {
    /// Connects each vertex to a point on a light.
    pub(super) fn connect_to_lights<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        self.lights.clear();
        self.light_numbers.clear();
        self.shadow_ends.clear();
        let only = shared.plan.stage.only_light();
        for k in 0..self.walks.len() {
            let light = self.sample_light(k, only, shared);
            let (u, pdf) = light.map_or((DVec2::ZERO, 1.0), |light| (light.u, light.pdf.value()));
            self.light_numbers.push_row([u.x, u.y, pdf]);
            self.lights.push(light);
        }
        self.to_lights.resize(self.walks.len());
        let has_hits = shared.plan.techniques.bsdf_sampling;
        let how = (shared.steps.heuristic, has_hits, shared.flats.forest().center());
        connect_to_lights(shared.level, self, how);
        for k in 0..self.walks.len() {
            let Some(light) = &self.lights[k] else {
                self.shadow_ends.push(Ends::FREE);
                continue;
            };
            let (state, at) = (self.to_lights.number(k, STATE), self.walks[k].at);
            let (origin, end) = match self.to_lights.number(k, IS_FORWARD) {
                0.0 => (light.light.primitive, at.primitive),
                _ => (at.primitive, light.light.primitive),
            };
            self.shadow_ends.push(Ends { origin, end });
            if state == INEXACT {
                let LightPoint { id, light, pdf, u } = *light;
                let point = light.point_at(u);
                let emitter = SampledEndpoint { point, light: Some(id), pdf, radiance: None };
                self.connect_alone(k, &emitter, shared);
                continue;
            }
            shared.counters.connections += 1;
            shared.counters.shadow_rays += u64::from(state == LIT);
        }
        let (segments, ends, free) = (&self.to_lights, &self.shadow_ends, &mut self.free);
        shared.flats.forest().are_free_in_columns(segments, ends, free);
        let technique = Technique::new(1, self.bounces as u16 + 2);
        for (k, _) in self.free.iter().enumerate().filter(|(_, free)| **free) {
            let [.., red, green, blue, weight, state] = self.to_lights.get(k);
            if state == LIT && self.lights[k].is_some() {
                let sample = self.walks[k].sample as usize;
                let raster = shared.samples[sample].film.raster;
                let value = Rgb::new(red, green, blue);
                shared.sink.add(sample, &Contribution { raster, value, weight, technique });
            }
        }
    }

    /// Samples a point on a light for a vertex, and connects it to that if lanes cannot.
    #[inline(always)]
    fn sample_light<S: Scene + ?Sized, P: Sampler>(
        &self,
        k: usize,
        only: Option<LightId>,
        shared: &mut Shared<'_, 's, S, P>,
    ) -> Option<LightPoint<'s>> {
        let sampler = &mut shared.samples[self.walks[k].sample as usize].sampler;
        sampler.stream(Stream::NextEvent(self.bounces + 1));
        let (u0, (u1, u)) = (sampler.next_1d(), sampler.next_1d_2d());
        let [x, y, z, error, nx, ny, nz, ..] = self.points.get(k);
        let position = DVec3::new(x, y, z);
        let receiver = || SurfacePoint {
            primitive: self.walks[k].at.primitive,
            ..SurfacePoint::on_surface(position, error, DVec3::new(nx, ny, nz))
        };
        let stage = &shared.plan.stage;
        let (id, pmf) = match only {
            Some(id) => (id, 1.0),
            None => stage.pick_light_for(&receiver(), u0)?,
        };
        if let Some(light) = stage.scene.light(id).as_flat()
            && !light.is_near(position)
        {
            return Some(LightPoint { id, light, pdf: light.pdf * pmf, u });
        }
        if let Some(emitter) = emitter_at(stage, &receiver(), (id, pmf), u1, u) {
            self.connect_alone(k, &emitter, shared);
        }
        None
    }

    /// Connects a vertex to a point on a light without lanes.
    #[inline(never)]
    fn connect_alone<S: Scene + ?Sized, P>(
        &self,
        k: usize,
        emitter: &SampledEndpoint,
        Shared { plan, flats, steps, samples, sink, connections, counters, .. }: &mut Shared<
            '_,
            's,
            S,
            P,
        >,
    ) {
        let Some(vertex) = self.vertex(k, plan.stage.scene, flats) else { return };
        let sample = self.walks[k].sample as usize;
        let mut out = Out { sample, sink: &mut **sink, connections };
        let Some(next) = next_event_at(plan, &vertex, emitter, &mut out, counters) else { return };
        counters.shadow_rays += 1;
        let hit = next.pdf_of_hit.value();
        let contribution = Contribution {
            raster: samples[sample].film.raster,
            value: next.value,
            weight: steps.heuristic.weight([hit / next.pdf.value()]),
            technique: Technique::new(1, self.bounces as u16 + 2),
        };
        let end = out.keep(&vertex.point);
        out.connect([end, next.end], contribution);
    }
}

#[inline(never)]
fn connect_to_lights(level: Level, columns: &mut Columns<'_>, how: (Heuristic, bool, DVec3)) {
    let Columns { points, carried, lights, light_numbers, to_lights, .. } = columns;
    let vertices = (&*points, &*carried);
    dispatch!(level, simd => {
        lanes::connect_to_lights(simd, vertices, (lights, light_numbers), how, to_lights)
    });
}
