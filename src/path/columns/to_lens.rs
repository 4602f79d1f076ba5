//! Connections to a pinhole in columns.

use super::{Columns, Shared, Walk, lanes};
use crate::endpoint::{LightId, View};
use crate::film::{Contribution, Sample, Technique};
use crate::geometry::SurfacePoint;
use crate::lanes::{Rows, dispatch};
use crate::math::{PerArea, Rgb};
use crate::path::connect::lens_connection_at;
use crate::path::diffuse::{INEXACT, LIT, UNSEEN};
use crate::path::{Out, Plan, SampledEndpoint};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use crate::tree::Ends;
use fearless_simd::Level;
use glam::{DVec2, DVec3};

/// Shadow rays to the lens, and what they carry.
#[derive(Debug, Default)]
pub(super) struct ShadowRays {
    /// Origin, direction, length.
    segments: Rows<7>,
    ends: Vec<Ends>,
    carried: Vec<(u32, Contribution)>,
}

impl<'s> Columns<'s> {
    /// Connects the vertices to the pinhole; they are the starts of walks at a light if one is given.
    pub(super) fn connect_to_lens<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        start: Option<LightId>,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        let bounces = self.bounces + u32::from(start.is_none());
        let stage = &shared.plan.stage;
        let Some(view) = stage.camera.as_pinhole() else { return };
        self.to_lens.resize(self.walks.len());
        let center = shared.flats.forest().center();
        connect_to_pinhole(shared.level, self, (view, center, start.is_some()));
        let mut inexact = Vec::new();
        let ShadowRays { segments, ends, carried } = &mut self.shadow_rays;
        for (k, Walk { sample, at }) in self.walks.iter().enumerate() {
            let Sample { film, sampler } = &mut shared.samples[*sample as usize];
            sampler.stream(Stream::LensSampling(bounces));
            sampler.skip_1d();
            sampler.skip_2d();
            let [segment @ .., is_forward, red, green, blue, x, y, state] = self.to_lens.get(k);
            if state == INEXACT {
                inexact.push(k);
                continue;
            }
            if state == UNSEEN {
                continue;
            }
            let raster = DVec2::new(x, y) - film.offset;
            if stage.film.pixel_index(raster).is_none() {
                continue;
            }
            shared.counters.connections += 1;
            if state == LIT {
                let value = Rgb::new(red, green, blue);
                let technique = Technique::new(bounces as u16 + 1, 1);
                segments.push_row(segment);
                let (origin, end) = match is_forward {
                    0.0 => (SurfacePoint::NONE, at.primitive),
                    _ => (at.primitive, SurfacePoint::NONE),
                };
                ends.push(Ends { origin, end });
                carried.push((*sample, Contribution { raster, value, weight: 1.0, technique }));
            }
        }
        shared.counters.shadow_rays += ends.len() as u64;
        shared.flats.forest().are_free_in_columns(segments, ends, &mut self.free);
        let seen = carried.iter().zip(&self.free).filter(|(_, free)| **free);
        for ((sample, contribution), _) in seen {
            shared.sink.add(*sample as usize, contribution);
        }
        segments.clear();
        ends.clear();
        carried.clear();
        inexact.into_iter().for_each(|k| self.connect_to_lens_alone(k, start, view, shared));
    }

    /// Connects a vertex to the pinhole without lanes.
    #[inline(never)]
    fn connect_to_lens_alone<S: Scene + ?Sized, P>(
        &self,
        k: usize,
        start: Option<LightId>,
        view: &View,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        let Shared { plan: Plan { stage, .. }, flats, samples, sink, counters, .. } = shared;
        let Some(mut vertex) = self.vertex(k, stage.scene, flats) else { return };
        if start.is_some() {
            (vertex.bsdf, vertex.light) = (None, start);
        }
        let sample = self.walks[k].sample as usize;
        let mut out = Out { sample, sink: &mut **sink, connections: shared.connections };
        let point = SurfacePoint::dirac(view.position);
        let lens = SampledEndpoint { point, light: None, pdf: PerArea(1.0), radiance: None };
        let (end, film) = (out.keep(&vertex.point), &samples[sample].film);
        let bounces = self.bounces + u32::from(start.is_none());
        let from = (&vertex, Some(end));
        let found = lens_connection_at(stage, from, bounces, film, &lens, &mut out, counters);
        if let Some(found) = found {
            out.connect(found.ends, found.contribution);
        }
    }
}

#[inline(never)]
fn connect_to_pinhole(level: Level, columns: &mut Columns<'_>, how: (&View, DVec3, bool)) {
    let Columns { points, carried, to_lens, .. } = columns;
    let vertices = (&*points, &*carried);
    dispatch!(level, simd => lanes::connect_to_pinhole(simd, vertices, how, to_lens));
}
