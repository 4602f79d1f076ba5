//! The integrators by name.

use clap::ValueEnum;
use pathspace::gallery::Claims;
use pathspace::integrator::{Adaptive, Bidirectional, Depth, LightTracer, PathTracer, UniformArea};
use pathspace::path::Roulette;
use pathspace::report::Method;
use pathspace::scene::World;

/// One of the integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum AnyIntegrator {
    /// Path tracing from the camera; light is hit by chance and sampled at every vertex.
    PathTracing,
    /// Light tracing from the lights; every vertex is connected to the lens.
    LightTracing,
    /// Every vertex uniform on the area of the scene: the definition of the integral, sampled.
    /// Noisy.
    UniformArea,
    /// Bidirectional path tracing from both ends, with every connection between them.
    Bidirectional,
    /// As much of bidirectional path tracing as pays, which a pilot finds out.
    Adaptive,
}

impl AnyIntegrator {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::PathTracing,
        Self::LightTracing,
        Self::UniformArea,
        Self::Bidirectional,
        Self::Adaptive,
    ];

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

    /// The integrator itself.
    pub fn build(self, depth: Depth, roulette: Roulette) -> Box<dyn Method<World>> {
        match self {
            Self::PathTracing => Box::new(PathTracer { depth, roulette, ..PathTracer::default() }),
            Self::LightTracing => Box::new(LightTracer { depth, roulette }),
            Self::UniformArea => Box::new(UniformArea { depth, roulette }),
            Self::Bidirectional => {
                Box::new(Bidirectional { depth, roulette, ..Bidirectional::default() })
            }
            Self::Adaptive => Box::new(Adaptive { depth, roulette, ..Adaptive::default() }),
        }
    }

    /// The integrator for paths of any length up to a limit, with the usual roulette.
    pub fn build_up_to(self, max_bounces: Option<u32>) -> Box<dyn Method<World>> {
        self.build(Depth { min_bounces: 0, max_bounces }, Roulette::default())
    }

    /// True if it sees every path of a scene that makes these claims.
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
