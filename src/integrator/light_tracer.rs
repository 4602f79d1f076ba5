//! Light tracing: a walk from a light, every vertex of which is connected to the lens (t = 1), the
//! reverse of path tracing.
//!
//! ```text
//! T_s f G V We / p_lens         with T = Le / (p_light p⊥) · Π f/p⊥
//! ```
//!
//! The importance We is normalised over the whole film and recorded where the connection meets it
//! (Dutré and Willems 1994; Veach 1997, section 10.3.4). It sees caustics that path tracing cannot,
//! and nothing that a Dirac lobe shows to the camera.

use super::{Crew, Depth, Integrator, SingleWalk, Stage, Started};
use crate::film::{Contribution, Sample, Technique};
use crate::path::{
    Counters, LensConnection, RandomWalk, Roulette, Site, Steps, TechniqueSet, Vertex, Visit,
    sample_lens_connection,
};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, Scene};
use std::ops::ControlFlow;

/// Light tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightTracer {
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
}

impl LightTracer {
    /// Light tracing up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    pub(super) fn run<S: Scene + ?Sized>(self, stage: Stage<'_, S>) -> SingleWalk<'_, S, Self> {
        let techniques = TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE };
        SingleWalk::new(stage, self, techniques, self.depth)
    }
}

impl<S: Scene + ?Sized> Integrator<S> for LightTracer {
    type Run<'a>
        = SingleWalk<'a, S, Self>
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "light-tracing"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Self::Run<'a>> {
        Ok(self.run(stage))
    }
}

impl<'a, S: Scene + ?Sized> Steps<'a, S> for SingleWalk<'a, S, LightTracer> {
    #[inline(always)]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let Site { sample, subpaths, out, counters } = site;
        subpaths.light.clear();
        if !self.techniques.lens_sampling {
            return None;
        }
        let scene = self.stage.scene;
        let (walk, start) = RandomWalk::from_light(scene, &mut sample.sampler, counters)?;
        if let Some(found) = self.connect(&start, 0, sample, counters) {
            let ends = [out.keep(&found.lens), out.keep(&found.end)];
            out.connect(ends, contribution(0, &found));
        }
        // Without a vertex that could be connected the walk would be for nothing.
        let has_use = self.depth.limit() > 0 && self.stage.needs.contains(Needs::FINITE_LOBES);
        walk?.if_useful(has_use, counters)
    }

    #[inline(always)]
    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let Visit { walk, vertex, end, sample, out, counters } = visit;
        let bounces = walk.bounces() + 1;
        if vertex.is_connectible()
            && let Some(found) = self.connect(vertex, bounces, sample, counters)
        {
            let lens = out.keep(&found.lens);
            out.connect([lens, *end], contribution(bounces, &found));
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.scatter(&self.settings.roulette).flow()?;
        visit.limit(self.depth.limit())
    }
}

impl<S: Scene + ?Sized> SingleWalk<'_, S, LightTracer> {
    /// The connection of a vertex to the lens, after so many scattering events, this one included.
    #[inline(always)]
    fn connect<P: Sampler>(
        &self,
        vertex: &Vertex<S::Bsdf<'_>>,
        bounces: u32,
        sample: &mut Sample<P>,
        counters: &mut Counters,
    ) -> Option<LensConnection> {
        if !self.depth.contains(bounces) {
            return None;
        }
        sample.sampler.stream(Stream::LensSampling(bounces));
        let Stage { scene, camera, .. } = self.stage;
        let found = sample_lens_connection(scene, camera, vertex, sample, counters)?;
        counters.shadow_rays += 1;
        Some(found)
    }
}

fn contribution(bounces: u32, found: &LensConnection) -> Contribution {
    let LensConnection { raster, value, .. } = *found;
    let technique = Technique::new(bounces as u16 + 1, 1);
    Contribution { raster, value, weight: 1.0, technique }
}
