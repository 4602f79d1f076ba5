//! The integrators by name.

use clap::ValueEnum;
use pathspace::gallery::Claims;
use pathspace::integrator::{
    Adaptive, Bidirectional, Depth, Integrator, LightTracer, PathTracer, UniformArea,
};
use pathspace::path::{Roulette, TechniqueSet};
use pathspace::report::{Contestant, Everything, Method};
use pathspace::scene::{WithNeeds, World};

/// One of the integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum AnyIntegrator {
    /// From the camera; light is hit by chance and sampled at every vertex.
    PathTracing,
    /// From the lights; every vertex is connected to the lens.
    LightTracing,
    /// Every vertex uniform on the area of the scene: the definition of the integral, sampled.
    /// Noisy.
    UniformArea,
    /// From both ends, with every connection between them.
    Bidirectional,
    /// As much of bidirectional path tracing as pays; a pilot finds out.
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
        self.build_with(depth, roulette, false)
    }

    /// The integrator for paths of any length up to a limit, with the usual roulette.
    pub fn build_up_to(self, max_bounces: Option<u32>) -> Box<dyn Method<World>> {
        self.build(Depth { min_bounces: 0, max_bounces }, Roulette::default())
    }

    /// The same, and what leaves nothing out.
    pub fn build_both(self, max_bounces: Option<u32>) -> [Box<dyn Method<World>>; 2] {
        [false, true].map(|everything| {
            self.build_with(Depth { min_bounces: 0, max_bounces }, Roulette::default(), everything)
        })
    }

    fn build_with(
        self,
        depth: Depth,
        roulette: Roulette,
        everything: bool,
    ) -> Box<dyn Method<World>> {
        match self {
            Self::PathTracing => {
                boxed(PathTracer { depth, roulette, ..PathTracer::default() }, everything)
            }
            Self::LightTracing => boxed(LightTracer { depth, roulette }, everything),
            Self::UniformArea => boxed(UniformArea { depth, roulette }, everything),
            Self::Bidirectional => {
                boxed(Bidirectional { depth, roulette, ..Bidirectional::default() }, everything)
            }
            Self::Adaptive => {
                // All techniques are what nothing is left out of by a pilot.
                let techniques = everything.then_some(TechniqueSet::BIDIRECTIONAL);
                boxed(Adaptive { depth, roulette, techniques, ..Adaptive::default() }, everything)
            }
        }
    }

    /// What [`build_both`](Self::build_both) gave, as an entry of a study on a scene that makes
    /// these claims.
    pub fn contestant<'a>(
        self,
        [method, everything]: &'a [Box<dyn Method<World>>; 2],
        claims: &Claims,
    ) -> Contestant<'a, World> {
        Contestant {
            everything: Some(&**everything),
            ..Contestant::new(self.name(), &**method, self.sees_all(claims))
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

fn boxed<I>(integrator: I, everything: bool) -> Box<dyn Method<World>>
where
    I: Method<World> + for<'a> Integrator<WithNeeds<'a, World>> + 'static,
{
    if everything { Box::new(Everything(integrator)) } else { Box::new(integrator) }
}
