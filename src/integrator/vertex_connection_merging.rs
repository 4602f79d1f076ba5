//! Vertex connection and merging: bidirectional path tracing with merges as further techniques
//! (Georgiev, Křivánek, Davidovič and Slusallek 2012; Hachisuka, Pantaleoni and Jensen 2012).
//!
//! ```text
//! connect (s, t):   T_s T_t f f G V                      p = p_s p_t
//! merge   (s, t):   T_t f Φ_s / (N π r²)                 p = p_s p_t π r²,  n = N
//! ```
//!
//! All weights are those of one sum over both kinds. Where connections can draw a path, the weight
//! of a merge vanishes with the radius, and so does its bias; a path that no connection can draw,
//! such as a caustic seen through water, is left to the merges.

#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::any_run::on_world;
use super::bidirectional::Pairs;
use super::shared::{Merges, Merging};
use super::{
    Bidirectional, Crew, Integrator, IntegratorError, Notes, Run, Stage, StartOnWorld, Started,
};
use crate::film::{Sample, Sink};
use crate::path::{Counters, Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::Scene;

/// Vertex connection and merging.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexConnectionMerging {
    /// Connections, path lengths, termination and heuristic.
    pub bidirectional: Bidirectional,
    /// Radius and light walks of the merges.
    pub merging: Merging,
    /// True if weights count the light walks of a merge by how independent they are
    /// ([`PathDensities::correlation`](crate::path::PathDensities::correlation)); takes time in
    /// proportion to the length of a path, and some 400 bytes more for each vertex of a light walk.
    pub correlation_aware: bool,
}

/// A rendering by pairs of subpaths and by the photon maps of passes.
pub struct MergingPairs<'a, S: Scene + ?Sized> {
    pub(super) pairs: Pairs<'a, S>,
    pub(super) merges: Merges<'a, S>,
}

impl<S: Scene + ?Sized> Integrator<S> for VertexConnectionMerging {
    type Run<'a>
        = MergingPairs<'a, S>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::vertex_connection_merging);

    fn name(&self) -> &'static str {
        "vcm"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<MergingPairs<'a, S>> {
        let merges = self.merging.light_walks(stage.film.pixels());
        let techniques = TechniqueSet { merges, ..self.bidirectional.techniques };
        let mut pairs = Bidirectional { techniques, ..self.bidirectional }.run(stage);
        if self.correlation_aware {
            pairs.weighting = pairs.weighting.correlation_aware();
        }
        let merges = Merges::new(self.merging, &pairs.plan, Integrator::<S>::name(self))?;
        Ok(MergingPairs { pairs, merges })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for MergingPairs<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.pairs.plan.techniques
    }

    fn notes(&self) -> Notes {
        self.merges.maps.notes(&self.pairs.plan)
    }

    fn prepares(&self) -> bool {
        self.pairs.plan.techniques.merges > 0
    }

    fn take_preparation(&mut self) -> Counters {
        std::mem::take(&mut self.merges.maps.counters)
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        let Pairs { plan, roulette, weighting } = &mut self.pairs;
        self.merges.begin_pass(pass, crew, (plan, roulette), weighting)
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        let Self { pairs, merges } = self;
        pairs.draw_and_merge(samples, sink, scratch, |site| {
            merges.for_each(&pairs.weighting, site, |_, merged, out| out.add(&merged));
        });
    }
}
