//! Integrators that leave nothing out.

use super::common::AnyIntegrator;
use pathspace::integrator::{
    Bidirectional, Depth, InstantRadiosity, LightTracer, PathTracer, PhotonMapping, UniformArea,
    VertexConnectionMerging, WithNeeds,
};
use pathspace::report::Method;
use pathspace::scene::World;

/// The integrator that leaves nothing out; `None` for those around another one, whose whole is that
/// one's.
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
        AnyIntegrator::PhotonMapping => {
            Box::new(WithNeeds::all(PhotonMapping { depth, ..PhotonMapping::default() }))
        }
        AnyIntegrator::InstantRadiosity => {
            let path_tracer = PathTracer { depth, ..PathTracer::default() };
            Box::new(WithNeeds::all(InstantRadiosity { path_tracer, ..Default::default() }))
        }
        AnyIntegrator::Vcm => {
            let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
            Box::new(WithNeeds::all(VertexConnectionMerging {
                bidirectional,
                ..Default::default()
            }))
        }
        AnyIntegrator::Adaptive
        | AnyIntegrator::Metropolis
        | AnyIntegrator::MetropolisPathTracing
        | AnyIntegrator::Multiplexed
        | AnyIntegrator::Regularized
        | AnyIntegrator::Guided
        | AnyIntegrator::GuidedBidirectional => return None,
    })
}
