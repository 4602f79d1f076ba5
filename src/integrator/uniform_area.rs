//! Uniform-area path sampling: behind the first surface that the camera sees, every vertex is drawn
//! uniformly on the total area A of the scene's surfaces, and visibility is tested edge by edge,
//!
//! ```text
//! Le(x_k → x_{k-1}) · Π_{i=1}^{k-1} f(x_i) G(x_i, x_{i+1}) / p_A,       p_A = 1/A.
//! ```
//!
//! All path lengths share one chain of vertices. It knows neither lights nor BSDFs, and 1/r² is in
//! no density: the variance is infinite wherever surfaces meet in a corner. It is the definition,
//! sampled, and cannot see Dirac lobes, Dirac lights or infinity behind the first vertex.

use super::any_run::on_world;
use super::{Crew, Depth, Integrator, SingleWalk, Stage, StartOnWorld, Started};
use crate::bsdf::{TransportMode, shading::ShadedBsdf};
use crate::endpoint::Endpoint;
use crate::film::{Contribution, Sample, Technique};
use crate::math::Rgb;
use crate::path::{Edge, RandomWalk, Roulette, Site, Steps, TechniqueSet, Vertex, Visit};
use crate::sampler::{Sampler, Stream};
use crate::scene::SurfaceArea;
use std::ops::ControlFlow;

/// Uniform-area path sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UniformArea {
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination.
    pub roulette: Roulette,
}

impl UniformArea {
    /// Uniform-area path sampling up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }
}

impl<S: SurfaceArea + ?Sized> Integrator<S> for UniformArea {
    type Run<'a>
        = SingleWalk<'a, S, Self>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::uniform_area);

    fn name(&self) -> &'static str {
        "uniform-area"
    }

    fn chooses_lights(&self) -> bool {
        false
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Self::Run<'a>> {
        let techniques = TechniqueSet { uniform_area: true, ..TechniqueSet::NONE };
        Ok(SingleWalk::new(stage, *self, techniques, self.depth))
    }
}

impl<'a, S: SurfaceArea + ?Sized + 'a> Steps<'a, S> for UniformArea {
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let (walk, _) = site.plan.stage.camera_walk(site.sample)?;
        site.plan.techniques.uniform_area.then_some(walk)
    }

    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        if let Some((_, radiance)) = visit.vertex.emission(visit.plan.stage.scene)
            && visit.plan.depth.contains(0)
        {
            visit.out.add(&visit.contribution(0, visit.vertex.throughput * radiance, 1.0));
        }
        visit.limit(visit.plan.depth.limit())
    }

    /// Draws the chain of vertices behind the first surface.
    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let Visit { plan, vertex, sample: Sample { film, sampler }, out, counters, .. } = visit;
        let (scene, mode) = (plan.stage.scene, TransportMode::Radiance);
        let mut add = |bounces: u32, value: Rgb| {
            let technique = Technique::new(0, bounces as u16 + 2);
            if !value.is_black() {
                out.add(&Contribution { raster: film.raster, value, weight: 1.0, technique });
            }
        };
        let Vertex { mut point, to_previous: mut to_camera, mut throughput, .. } = **vertex;
        let (reference, area) = (throughput.max_component(), scene.total_area());
        // ANCHOR: chain
        for bounces in 1..=plan.depth.limit() {
            sampler.stream(Stream::CameraVertex(bounces));
            let mut next = scene.sample_surface(sampler.next_1d(), sampler.next_2d());
            counters.scattered += 1;
            let Some(edge) = Edge::between(&point, &next) else { break };
            next.medium = scene.medium_towards(&point, edge.direction);
            counters.connections += 1;
            let bsdf = ShadedBsdf::new(scene.bsdf(&point), &point);
            throughput *= bsdf.eval(edge.direction, to_camera) * (edge.geometry * area);
            throughput *= scene.transmittance(&point, &next);
            counters.shadow_rays += u64::from(!throughput.is_black());
            if throughput.is_black() || !scene.visible(&point, &next) {
                break;
            }
            let light = scene.light_at(&next).filter(|_| plan.depth.contains(bounces));
            if let Some(light) = light {
                add(bounces, throughput * scene.light(light).emit(&next, -edge.direction));
            }
            let relative = throughput.max_component() / reference;
            let on =
                self.roulette.play(mode, bounces, relative, &mut throughput, || sampler.next_1d());
            add(bounces + 1, on.constant);
            if !on.goes_on {
                break;
            }
            (point, to_camera) = (next, -edge.direction);
        }
        // ANCHOR_END: chain
        ControlFlow::Break(())
    }
}
