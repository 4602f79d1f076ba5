//! The directions in which walks go on.

use super::{Batch, Drawn};
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::ops::ControlFlow;

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Batch<'_, 's, S, P> {
    /// Samples the directions in which the walks go on that have not ended.
    #[inline]
    pub(super) fn sample_directions(&mut self) {
        self.visit(|_, visit| {
            *visit.drawn = Drawn::Nothing;
            let Some(bsdf) = &visit.vertex.bsdf else { return ControlFlow::Break(()) };
            let sampler = &mut visit.sample.sampler;
            if let Some((u1, u2)) = visit.walk.begin_scattering(sampler, visit.counters) {
                let (to_previous, mode) = (visit.vertex.to_previous, visit.walk.mode());
                *visit.drawn = Drawn::Direction(bsdf.sample(to_previous, mode, u1, u2));
            }
            ControlFlow::Continue(())
        });
    }
}
