//! The rooms in which many walks are worked on at a time, eight of them in lanes; what lanes have no
//! form for is done one by one on the way.

use super::lens::PinholeConnections;
use super::next_event::FlatConnections;
use super::scattering::Reflections;
use crate::bsdf::TransportMode;
use crate::endpoint::{Light, View};
use crate::path::connect::{emitter_at, next_event_at};
use crate::path::steps::Drawn;
use crate::path::{Plan, Visit, sample_lens_connection};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use fearless_simd::Level;
use std::ops::ControlFlow;

/// The work that is done for many walks at a time.
#[derive(Debug, Default)]
pub(in crate::path) struct Rooms<'s> {
    flat: FlatConnections<'s>,
    pinhole: PinholeConnections,
    reflections: Reflections,
}

impl<'s> Rooms<'s> {
    pub(super) fn clear(&mut self) {
        self.flat.clear();
        self.pinhole.clear();
        self.reflections.clear();
    }

    /// Samples a point on a light for a vertex of a camera walk.
    #[inline(always)]
    pub(super) fn next_event<S: Scene + ?Sized + 's, P: Sampler>(
        &mut self,
        plan: &Plan<'s, S>,
        i: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) {
        let Visit { walk, vertex, sample, out, counters, drawn, .. } = visit;
        let sampler = &mut sample.sampler;
        sampler.stream(Stream::NextEvent(walk.bounces() + 1));
        // All numbers are drawn first, so that later dimensions do not depend on the outcome.
        let (u0, (u1, u2)) = (sampler.next_1d(), sampler.next_1d_2d());
        let stage = &plan.stage;
        let Some((light, pmf)) = stage.pick_light_for(&vertex.point, u0) else { return };
        if let Some(flat) = stage.scene.light(light).as_flat()
            && self.flat.accept(i, vertex, (light, pmf, flat), u2)
        {
            return;
        }
        let found = emitter_at(stage, &vertex.point, (light, pmf), u1, u2)
            .as_ref()
            .and_then(|emitter| next_event_at(plan, vertex, emitter, out, counters));
        **drawn = found.map_or(Drawn::Nothing, Drawn::NextEvent);
    }

    /// Samples a point on the lens for a vertex of a light walk.
    #[inline(always)]
    pub(super) fn lens_connection<S: Scene + ?Sized + 's, P: Sampler>(
        &mut self,
        Plan { stage, .. }: &Plan<'s, S>,
        i: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) {
        let Visit { walk, vertex, end, sample, out, counters, drawn, .. } = visit;
        let bounces = walk.bounces() + 1;
        if stage.camera.as_pinhole().is_some()
            && self.pinhole.accept(i, vertex, &mut sample.sampler, bounces)
        {
            return;
        }
        let from = (&**vertex, Some(*end));
        let found = sample_lens_connection(stage, from, bounces, sample, out, counters);
        **drawn = found.map_or(Drawn::Nothing, Drawn::LensConnection);
    }

    /// Evaluates the connections that were accepted.
    #[inline]
    pub(super) fn connect(&mut self, level: Level, pinhole: Option<&View>) {
        self.flat.connect(level);
        if let Some(view) = pinhole {
            self.pinhole.connect(level, view);
        }
    }

    /// Hands out the connection of a walk, if one was accepted. Walks come in their order.
    #[inline(always)]
    pub(super) fn connection<S: Scene + ?Sized + 's, P>(
        &mut self,
        i: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) {
        match visit.walk.mode() {
            TransportMode::Radiance => {
                if let Some(found) = self.flat.take(i, visit) {
                    *visit.drawn = found.map_or(Drawn::Nothing, Drawn::NextEvent);
                }
            }
            TransportMode::Importance => {
                if let Some(found) = self.pinhole.take(i, visit) {
                    *visit.drawn = found.map_or(Drawn::Nothing, Drawn::LensConnection);
                }
            }
        }
    }

    /// Samples the direction in which a walk goes on.
    #[inline(always)]
    pub(super) fn direction<S: Scene + ?Sized + 's, P: Sampler>(
        &mut self,
        i: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) -> ControlFlow<()> {
        let Visit { walk, vertex, sample, counters, drawn, .. } = visit;
        let Some(bsdf) = &vertex.bsdf else { return ControlFlow::Break(()) };
        let Some((u1, u2)) = walk.begin_scattering(&mut sample.sampler, counters) else {
            return ControlFlow::Break(());
        };
        if !self.reflections.accept(i, vertex, u2) {
            let sampled = bsdf.sample(vertex.to_previous, walk.mode(), u1, u2);
            **drawn = Drawn::Direction(sampled);
        }
        ControlFlow::Continue(())
    }

    /// Samples the directions that were accepted.
    #[inline]
    pub(super) fn sample_directions(&mut self, level: Level, drawn: &mut [Drawn]) {
        self.reflections.sample(level, drawn);
    }
}
