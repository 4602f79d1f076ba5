//! Integrators that leave nothing out.

use super::common::AnyIntegrator;
use pathspace::integrator::{
    Bidirectional, Depth, LightTracer, PathTracer, UniformArea, WithNeeds,
};
use pathspace::report::Method;
use pathspace::scene::World;

/// The integrator that leaves nothing out; `None` for the adaptive one, whose whole is the
/// bidirectional one's.
pub fn build(
    integrator: AnyIntegrator,
    max_bounces: Option<u32>,
) -> Option<Box<dyn Method<World>>> {
    let depth = Depth { min_bounces: 0, max_bounces };
    Some(match integrator {
        AnyIntegrator::PathTracing => {
            Box::new(WithNeeds::all(PathTracer { depth, ..PathTracer::default() }))
        }
        AnyIntegrator::LightTracing => {
            Box::new(WithNeeds::all(LightTracer { depth, ..LightTracer::default() }))
        }
        AnyIntegrator::UniformArea => {
            Box::new(WithNeeds::all(UniformArea { depth, ..UniformArea::default() }))
        }
        AnyIntegrator::Bidirectional => {
            Box::new(WithNeeds::all(Bidirectional { depth, ..Bidirectional::default() }))
        }
        AnyIntegrator::Adaptive => return None,
    })
}
