//! Photon mapping: light walks whose vertices, the photons, are kept for all pixels, and camera
//! walks that end at the first vertex which takes a finite lobe, to meet the photons in reach
//! (Jensen 1996; with a radius that shrinks from pass to pass: Knaus and Zwicker 2011).
//!
//! ```text
//! L(y → camera) ≈ 1/(N π r²) Σ_{|z - y| < r} f(z.to_previous, y.to_previous) Φ_z
//! ```
//!
//! with the flux Φ of a light walk, its throughput Le/(p_A p⊥) Π f/p⊥. Each path is drawn by one
//! technique alone, a merge at its first finite lobe or a hit if it has none, so there are no
//! weights; and caustics seen through glass or water cost no more than others.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::any_run::on_world;
use super::shared::{Merging, PhotonMaps};
use super::{Crew, Depth, Integrator, IntegratorError, Notes, Run, Stage, StartOnWorld, Started};
use crate::endpoint::Light;
use crate::film::{Contribution, Sample, Sink};
use crate::path::{Counters, Plan, Roulette, Scratch, Steps, TechniqueSet, Visit, advance};
use crate::photon_map::Photon;
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::ops::ControlFlow;

/// Photon mapping.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonMapping {
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
    /// Radius and light walks.
    pub merging: Merging,
    /// True if lights that can be connected to light surfaces by next event estimation (s = 1) and
    /// not by photons, which is sharp and unbiased.
    pub next_event: bool,
}

/// A rendering by the photon maps of passes.
pub struct PhotonPasses<'a, S: Scene + ?Sized> {
    plan: Plan<'a, S>,
    roulette: Roulette,
    maps: PhotonMaps<Photon>,
}

impl<S: Scene + ?Sized> Integrator<S> for PhotonMapping {
    type Run<'a>
        = PhotonPasses<'a, S>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::photon_mapping);

    fn name(&self) -> &'static str {
        "photon-mapping"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<PhotonPasses<'a, S>> {
        let merges = self.merging.light_walks(stage.film.pixels());
        let (bsdf_sampling, next_event) = (true, self.next_event);
        let techniques = TechniqueSet { bsdf_sampling, next_event, merges, ..TechniqueSet::NONE };
        let plan = Plan::new(stage, techniques, self.depth);
        let maps = PhotonMaps::new(self.merging, &plan, Integrator::<S>::name(self))?;
        Ok(PhotonPasses { plan, roulette: self.roulette.without_constant(), maps })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for PhotonPasses<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.plan.techniques
    }

    fn notes(&self) -> Notes {
        self.maps.notes(&self.plan)
    }

    fn prepares(&self) -> bool {
        self.plan.techniques.merges > 0
    }

    fn take_preparation(&mut self) -> Counters {
        std::mem::take(&mut self.maps.counters)
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        let Self { plan, roulette, maps } = self;
        let scene = plan.stage.scene;
        let is_connected =
            |light| plan.techniques.next_event && scene.light(light).can_be_connected();
        maps.begin_pass(pass, crew, (plan, roulette), |subpath, photons| {
            let is_direct = subpath.first().and_then(|start| start.light).is_some_and(is_connected);
            let first = if is_direct { 3 } else { 2 };
            photons.extend(Photon::of(subpath).filter(|photon| photon.s >= first));
        })
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        advance(&self.plan, self, samples, sink, scratch);
    }
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for PhotonPasses<'a, S> {
    const CONNECTS: bool = true;

    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let raster = visit.sample.film.raster;
        if let Some((_, value)) = visit.emitted() {
            visit.out.add(&visit.contribution(0, value, 1.0));
        }
        visit.limit(self.plan.depth.limit())?;
        for (technique, value) in self.maps.estimates(visit) {
            visit.out.add(&Contribution { raster, value, weight: 1.0, technique });
        }
        ControlFlow::Continue(())
    }

    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        if let Some(next) = visit.next_event() {
            visit.connect(&next, 1.0);
        }
    }

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        // Where a finite lobe was sampled, the photons have seen to the rest.
        visit.scatter(&self.roulette).flow()?;
        if visit.vertex.dirac { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}
