//! Integrators that leave nothing out.

use super::common::AnyIntegrator;
use pathspace::endpoint::Camera;
use pathspace::integrator::{
    Bidirectional, Depth, Integrator, LightTracer, PathTracer, UniformArea,
};
use pathspace::path::{LeftOut, TechniqueSet};
use pathspace::render::{Progress, Render, RenderError, Rendering, Settings};
use pathspace::report::Method;
use pathspace::scene::{Needs, WithNeeds, World};
use std::ops::ControlFlow;

/// An integrator on a world that claims to need everything.
struct Unpruned<I>(I);

impl<I: for<'a> Integrator<WithNeeds<'a, World>>> Render<World> for Unpruned<I> {
    fn techniques(&self, _: &World) -> TechniqueSet {
        self.0.techniques(&Needs::ALL)
    }

    fn left_out(&self, _: &World) -> LeftOut {
        self.0.left_out(&Needs::ALL)
    }

    fn render(
        &self,
        scene: &World,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError> {
        pathspace::render::render(&WithNeeds::all(scene), camera, &self.0, settings, progress)
    }
}

impl<I: for<'a> Integrator<WithNeeds<'a, World>>> Method<World> for Unpruned<I> {}

/// The integrator that leaves nothing out; `None` for the adaptive one, whose whole is the
/// bidirectional one's.
pub fn build(
    integrator: AnyIntegrator,
    max_bounces: Option<u32>,
) -> Option<Box<dyn Method<World>>> {
    let depth = Depth { min_bounces: 0, max_bounces };
    Some(match integrator {
        AnyIntegrator::PathTracing => {
            Box::new(Unpruned(PathTracer { depth, ..PathTracer::default() }))
        }
        AnyIntegrator::LightTracing => {
            Box::new(Unpruned(LightTracer { depth, ..LightTracer::default() }))
        }
        AnyIntegrator::UniformArea => {
            Box::new(Unpruned(UniformArea { depth, ..UniformArea::default() }))
        }
        AnyIntegrator::Bidirectional => {
            Box::new(Unpruned(Bidirectional { depth, ..Bidirectional::default() }))
        }
        AnyIntegrator::Adaptive => return None,
    })
}
