//! The points that vertices are connected to.

use super::{Batch, Drawn};
use crate::bsdf::TransportMode;
use crate::path::{Plan, Steps, sample_lens_connection, sample_next_event};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use std::ops::ControlFlow;

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Batch<'_, 's, S, P> {
    /// Samples a point on a light for each vertex of a camera walk, and one on the lens for each of
    /// a light walk, where a connection can carry light and paths of that length count.
    #[inline]
    pub(super) fn sample_points(&mut self, steps: &impl Steps<'s, S>) {
        let Plan { stage, techniques, depth, .. } = self.plan;
        self.visit(|_, visit| {
            *visit.drawn = Drawn::Nothing;
            let bounces = visit.walk.bounces() + 1;
            let mode = visit.walk.mode();
            let is_drawn = match mode {
                TransportMode::Radiance => techniques.next_event,
                TransportMode::Importance => techniques.lens_sampling,
            };
            if is_drawn
                && depth.contains(bounces)
                && visit.vertex.is_connectible()
                && steps.samples_point(visit)
            {
                let (vertex, out, counters) =
                    (&*visit.vertex, &mut visit.out, &mut *visit.counters);
                *visit.drawn = match mode {
                    TransportMode::Radiance => {
                        visit.sample.sampler.stream(Stream::NextEvent(bounces));
                        let sampler = &mut visit.sample.sampler;
                        sample_next_event(self.plan, vertex, sampler, out, counters)
                            .map_or(Drawn::Nothing, Drawn::NextEvent)
                    }
                    TransportMode::Importance => {
                        let from = (vertex, Some(visit.end));
                        sample_lens_connection(stage, from, bounces, visit.sample, out, counters)
                            .map_or(Drawn::Nothing, Drawn::LensConnection)
                    }
                };
            }
            ControlFlow::Continue(())
        });
    }
}
