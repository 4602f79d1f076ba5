//! Virtual lights: the vertices of light walks that all pixels of a pass connect to.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::SharedWalks;
use super::merging::pixel_footprint;
use crate::endpoint::Light;
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::integrator::{Crew, Estimator, InstantRadiosity, IntegratorError, Notes};
use crate::path::{Counters, Edge, Plan, Roulette, Scratch, Stage, Steps, Vertex, Visit, advance};
use crate::sampler::Sampler;
use crate::scene::Scene;

/// The virtual lights of a pass, and the share of a path that a connection to one draws.
pub struct VirtualLights<'a, S: Scene + ?Sized + 'a> {
    integrator: &'static str,
    lights: Vec<VirtualLight<S::Bsdf<'a>>>,
    walks: u32,
    /// g, above which geometry terms count as g.
    bound: f64,
    compensates: bool,
    /// Counts of the work for them.
    pub counters: Counters,
}

/// A vertex of a light subpath.
struct VirtualLight<B> {
    vertex: Vertex<B>,
    /// Number of vertices of the subpath up to here.
    s: u16,
    /// True if other techniques can draw what lies behind: hits, next event estimation, or virtual
    /// lights across an edge between finite lobes.
    has_rival: bool,
}

impl<'a, S: Scene + ?Sized + 'a> VirtualLights<'a, S> {
    /// Those of a run by some settings.
    ///
    /// # Errors
    /// If the bound is negative or not a number.
    pub fn new(
        stage: Stage<'a, S>,
        integrator: &'static str,
        &InstantRadiosity { light_walks, bound, compensates, .. }: &InstantRadiosity,
    ) -> Result<Self, IntegratorError> {
        let bound = bound.unwrap_or_else(|| default_bound(stage));
        if bound.is_nan() || bound < 0.0 {
            let reason = format!("the bound is {bound}, but must be 0 or positive");
            return Err(IntegratorError { integrator, reason });
        }
        let (lights, counters) = (Vec::new(), Counters::default());
        Ok(Self { integrator, lights, walks: light_walks, bound, compensates, counters })
    }

    /// The notes of a run that connects to the lights.
    pub fn notes(&self, plan: &Plan<'_, S>) -> Notes {
        let is_exact =
            self.compensates || !plan.techniques.connections || self.bound == f64::INFINITY;
        let estimator = if is_exact { Estimator::Unbiased } else { Estimator::Biased };
        Notes { estimator, is_correlated: plan.techniques.connections, ..Notes::of(plan) }
    }

    /// Draws the light walks of a pass.
    pub fn begin_pass(
        &mut self,
        pass: u32,
        crew: &dyn Crew,
        (plan, roulette): (&Plan<'a, S>, &Roulette),
    ) -> Result<(), IntegratorError> {
        let (scene, techniques) = (plan.stage.scene, plan.techniques);
        let walks = SharedWalks { plan, roulette, count: self.walks, shortest: 2 };
        let (lights, counters) = walks.draw(pass, crew, self.integrator, |walk, lights| {
            let Some(light) = walk.first().and_then(|start| start.light) else { return };
            let light = scene.light(light);
            let mut is_drawn = techniques.bsdf_sampling && light.can_be_hit();
            let mut is_before_finite = techniques.next_event && light.can_be_connected();
            for (s, vertex) in (1..).zip(walk.drain(..)).skip(1) {
                let (has_rival, is_finite) = (is_drawn || is_before_finite, !vertex.dirac);
                is_drawn |= is_before_finite && is_finite;
                is_before_finite = is_finite;
                if vertex.is_connectible() {
                    lights.push(VirtualLight { vertex, s, has_rival });
                }
            }
        })?;
        self.lights = lights;
        self.counters += counters;
        self.counters.photons += self.lights.len() as u64;
        self.counters.share(size_of_val(self.lights.as_slice()));
        Ok(())
    }

    /// Draws samples, so many at a time that their shadow rays do not fill the memory.
    pub fn advance<P: Sampler>(
        &self,
        plan: &Plan<'a, S>,
        steps: &impl Steps<'a, S>,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
    ) {
        const CONNECTIONS: usize = 1 << 14;
        let batch = (CONNECTIONS / self.lights.len().max(1)).max(1);
        for (number, samples) in samples.chunks_mut(batch).enumerate() {
            let sink = &mut |i: usize, found: &Contribution| sink.add(number * batch + i, found);
            advance(plan, steps, samples, sink, scratch);
        }
    }

    /// c of an edge between surfaces that take finite lobes.
    fn share(&self, geometry: f64) -> f64 {
        if geometry > self.bound { self.bound / geometry } else { 1.0 }
    }

    /// The weight of what is drawn by finite lobes of a vertex: that of the walk, less what virtual
    /// lights draw across the edge that led there.
    pub fn rest<P>(&self, Visit { plan, walk, vertex, .. }: &Visit<'_, 'a, S, P>) -> f64 {
        match walk.is_from_connectible() && plan.techniques.connections {
            false => walk.weight,
            true if !self.compensates => 0.0,
            true => walk.weight * (1.0 - self.share(vertex.geometry)),
        }
    }

    /// Adds the connections of a vertex to all virtual lights, each with its share; what is cut off
    /// and not drawn otherwise is recorded.
    pub fn connect<P>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        let Visit { plan, walk, vertex: y, .. } = visit;
        let (plan, weight, t) = (*plan, walk.weight, walk.bounces() as u16 + 2);
        let scene = plan.stage.scene;
        let Some(at_camera) = y.finite_bsdf() else { return };
        for VirtualLight { vertex: z, s, has_rival } in &self.lights {
            let technique = Technique::new(*s, t);
            let (Some(edge), Some(at_light)) = (Edge::between(&y.point, &z.point), &z.bsdf) else {
                continue;
            };
            if !plan.depth.contains(technique.bounces().into()) {
                continue;
            }
            visit.counters.connections += 1;
            // ANCHOR: connect
            let f = at_camera.eval(edge.direction, y.to_previous);
            let from_light = at_light.eval(z.to_previous, -edge.direction) * z.throughput;
            let value = y.throughput * f * (edge.geometry / f64::from(self.walks) * from_light);
            // ANCHOR_END: connect
            let value = value * scene.transmittance(&y.point, &z.point);
            if value.is_black() {
                continue;
            }
            let is_bounded = *has_rival || !self.compensates;
            let share = if is_bounded { self.share(edge.geometry) } else { 1.0 };
            if !self.compensates && share < 1.0 && scene.visible(&y.point, &z.point) {
                visit.counters.ledger.clamped += value * (weight * (1.0 - share));
            }
            visit.counters.shadow_rays += 1;
            let raster = visit.sample.film.raster;
            let contribution = Contribution { raster, value, weight: weight * share, technique };
            let end = visit.out.keep(&z.point);
            visit.out.connect([visit.end, end], contribution);
        }
    }
}

/// A bound on geometry terms that leaves most of a view to virtual lights: 16 over the area that
/// the camera sees. Infinite if it sees nothing.
fn default_bound<S: Scene + ?Sized>(stage: Stage<'_, S>) -> f64 {
    let area = |pixel: f64| pixel * pixel * f64::from(stage.film.pixels());
    pixel_footprint(stage).map_or(f64::INFINITY, |pixel| 16.0 / area(pixel))
}
