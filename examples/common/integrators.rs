//! The integrators by name.

use clap::ValueEnum;
use pathspace::integrator::{Adaptive, Bidirectional, Depth, LightTracer, PathTracer, UniformArea};
use pathspace::path::TechniqueSet;
use pathspace::report::{Everything, Method};
use pathspace::scene::World;
use pathspace::scene::gallery::Claims;

/// One of the integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum AnyIntegrator {
    /// From the camera; light is hit by chance and sampled at every vertex.
    PathTracing,
    /// From the lights; every vertex is connected to the lens.
    LightTracing,
    /// Every vertex uniform on the area of the scene: the definition of the integral, sampled. Noisy.
    UniformArea,
    /// From both ends, with every connection between them.
    Bidirectional,
    /// As much of bidirectional path tracing as pays; a pilot finds out.
    Adaptive,
}

impl AnyIntegrator {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::PathTracing, Self::LightTracing, Self::UniformArea, Self::Bidirectional, Self::Adaptive];

    /// The name that the library and the command line use.
    pub fn name(self) -> &'static str {
        match self {
            Self::PathTracing => "path-tracing",
            Self::LightTracing => "light-tracing",
            Self::UniformArea => "uniform-area",
            Self::Bidirectional => "bidirectional",
            Self::Adaptive => "adaptive",
        }
    }

    /// The integrator itself, over paths with `min_bounces` to `max_bounces` scattering events.
    pub fn build(self, min_bounces: u32, max_bounces: Option<u32>) -> Box<dyn Method<World>> {
        let depth = Depth { min_bounces, max_bounces };
        match self {
            Self::PathTracing => Box::new(PathTracer { depth, ..PathTracer::default() }),
            Self::LightTracing => Box::new(LightTracer { depth, ..LightTracer::default() }),
            Self::UniformArea => Box::new(UniformArea { depth, ..UniformArea::default() }),
            Self::Bidirectional => Box::new(Bidirectional { depth, ..Bidirectional::default() }),
            Self::Adaptive => Box::new(Adaptive { depth, ..Adaptive::default() }),
        }
    }

    /// The same leaving nothing out; bidirectional path tracing with all techniques is what nothing is left out of by a pilot.
    pub fn build_everything(self, min_bounces: u32, max_bounces: Option<u32>) -> Box<dyn Method<World>> {
        let depth = Depth { min_bounces, max_bounces };
        match self {
            Self::PathTracing => Box::new(Everything(PathTracer { depth, ..PathTracer::default() })),
            Self::LightTracing => Box::new(Everything(LightTracer { depth, ..LightTracer::default() })),
            Self::UniformArea => Box::new(Everything(UniformArea { depth, ..UniformArea::default() })),
            Self::Bidirectional => Box::new(Everything(Bidirectional { depth, ..Bidirectional::default() })),
            Self::Adaptive => {
                let techniques = Some(TechniqueSet::BIDIRECTIONAL);
                Box::new(Everything(Adaptive { depth, techniques, ..Adaptive::default() }))
            }
        }
    }

    /// Whether it sees every path of a scene that makes these claims.
    pub fn sees_all(self, claims: &Claims) -> bool {
        match self {
            Self::PathTracing => claims.path_tracing,
            Self::LightTracing => claims.light_tracing,
            Self::UniformArea => claims.uniform_area,
            Self::Bidirectional | Self::Adaptive => claims.bidirectional,
        }
    }
}

impl std::fmt::Display for AnyIntegrator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
