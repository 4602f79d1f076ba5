//! The integrators by name.

use super::arguments::{
    MANY, parse_bound, parse_count, parse_mollifier, parse_probability, parse_radius,
};
use clap::{Args, ValueEnum};
use pathspace::gallery::Claims;
use pathspace::integrator::{
    Adaptive, Bidirectional, Depth, Guiding, InstantRadiosity, LightTracer, Merging, Metropolis,
    Multiplexed, PathTracer, PhotonMapping, Regularization, UniformArea, VertexConnectionMerging,
};
use pathspace::path::Roulette;
use pathspace::report::Method;
use pathspace::scene::World;

/// One of the integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum AnyIntegrator {
    /// Path tracing from the camera; light is hit by chance and sampled at every vertex.
    #[value(alias = "pt")]
    PathTracing,
    /// Light tracing from the lights; every vertex is connected to the lens.
    #[value(alias = "lt")]
    LightTracing,
    /// Every vertex uniform on the area of the scene: the definition of the integral, sampled.
    /// Noisy.
    UniformArea,
    /// Bidirectional path tracing from both ends, with every connection between them.
    #[value(alias = "bdpt")]
    Bidirectional,
    /// As much of bidirectional path tracing as pays, which a pilot finds out.
    Adaptive,
    /// Photons of light walks that all pixels share, met at the first surface that is no mirror;
    /// blurred by a radius that shrinks from pass to pass.
    #[value(alias = "pm")]
    PhotonMapping,
    /// Virtual lights from light walks that all pixels share; what is too near to one is path
    /// traced.
    #[value(alias = "ir")]
    InstantRadiosity,
    /// Vertex connection and merging: bidirectional path tracing and photon mapping, weighted.
    Vcm,
    /// Metropolis sampling in primary sample space: Markov chains that move the random numbers of
    /// bidirectional path tracing to where they contribute much.
    #[value(alias = "pssmlt")]
    Metropolis,
    /// The same over path tracing.
    MetropolisPathTracing,
    /// Multiplexed Metropolis light transport: chains over one technique of bidirectional path
    /// tracing in each sample, which they choose as well.
    #[value(alias = "mmlt")]
    Multiplexed,
    /// Path tracing among mirrors and glass that are slightly blurred, by a radius that shrinks from
    /// pass to pass.
    Regularized,
    /// Path tracing whose walks learn first where light comes from, if that pays.
    Guided,
    /// The same for the camera walks of bidirectional path tracing.
    GuidedBidirectional,
}

/// Settings of the integrators.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct Tuning {
    #[command(flatten)]
    shared: SharedWalks,
    #[command(flatten)]
    chains: Chains,
    /// Radius of what mirrors and glass are blurred by in the first pass, in radians near the
    /// normal; for regularized [default: 0.1]
    #[arg(long, value_parser = parse_mollifier)]
    epsilon: Option<f64>,
    /// Probability of going on by the BSDF alone and not by what was learnt; for guided and
    /// guided-bidirectional [default: 0.5]
    #[arg(long, value_name = "P", value_parser = parse_probability)]
    bsdf_fraction: Option<f64>,
}

/// Markov chains.
#[derive(Args, Clone, Copy, Debug, Default)]
struct Chains {
    /// Independent samples from which chains begin and that tell the mean of the image; for
    /// metropolis, metropolis-path-tracing and multiplexed [default: one per pixel, at least 4096]
    #[arg(long, value_parser = parse_count::<u32, 1, MANY>)]
    candidates: Option<u32>,
    /// Passes after which chains begin anew; for the same [default: 256]
    #[arg(long, value_name = "PASSES", value_parser = parse_count::<u32, 1, MANY>)]
    restart: Option<u32>,
    /// Probability of a large step, which draws all random numbers anew; for the same [default: 0.3]
    #[arg(long, value_name = "P", value_parser = parse_probability)]
    large_step: Option<f64>,
}

impl Chains {
    fn over<I>(self, integrator: I) -> Metropolis<I> {
        let default = Metropolis::over(integrator);
        Metropolis {
            candidates: self.candidates,
            restart: self.restart.unwrap_or(default.restart),
            large_step: self.large_step.unwrap_or(default.large_step),
            ..default
        }
    }
}

/// Light walks that all pixels share.
#[derive(Args, Clone, Copy, Debug, Default)]
struct SharedWalks {
    /// Radius within which photons are met in the first pass, in units of the scene; for
    /// photon-mapping and vcm [default: twice the size of a pixel on what is seen]
    #[arg(long, value_parser = parse_radius)]
    radius: Option<f64>,
    /// Light walks of a pass that all pixels share; for photon-mapping, vcm and instant-radiosity
    /// [default: 64 for instant-radiosity, else one per pixel, at most 262144]
    #[arg(long, value_parser = parse_count::<u32, 1, MANY>)]
    walks: Option<u32>,
    /// Weigh the light walks of a merge by how independent they are; for vcm
    #[arg(long)]
    correlation_aware: bool,
    /// Bound on the geometry term of connections to virtual lights, per area, or inf; for
    /// instant-radiosity [default: 16 over the area that the camera sees]
    #[arg(long, value_name = "G", value_parser = parse_bound)]
    bound: Option<f64>,
    /// Lose what the bound cuts off, in place of path tracing it; for instant-radiosity
    #[arg(long)]
    clamp: bool,
}

impl SharedWalks {
    fn merging(self) -> Merging {
        Merging { radius: self.radius, light_walks: self.walks, ..Merging::default() }
    }
}

impl AnyIntegrator {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::PathTracing,
        Self::LightTracing,
        Self::UniformArea,
        Self::Bidirectional,
        Self::Adaptive,
        Self::PhotonMapping,
        Self::InstantRadiosity,
        Self::Vcm,
        Self::Metropolis,
        Self::MetropolisPathTracing,
        Self::Multiplexed,
        Self::Regularized,
        Self::Guided,
        Self::GuidedBidirectional,
    ];

    /// The name that the library and the command line use.
    pub fn name(self) -> &'static str {
        match self {
            Self::PathTracing => "path-tracing",
            Self::LightTracing => "light-tracing",
            Self::UniformArea => "uniform-area",
            Self::Bidirectional => "bidirectional",
            Self::Adaptive => "adaptive",
            Self::PhotonMapping => "photon-mapping",
            Self::InstantRadiosity => "instant-radiosity",
            Self::Vcm => "vcm",
            Self::Metropolis => "metropolis",
            Self::MetropolisPathTracing => "metropolis-path-tracing",
            Self::Multiplexed => "multiplexed",
            Self::Regularized => "regularized",
            Self::Guided => "guided",
            Self::GuidedBidirectional => "guided-bidirectional",
        }
    }

    /// The integrator itself.
    pub fn build(self, depth: Depth, roulette: Roulette, tuning: Tuning) -> Box<dyn Method<World>> {
        let Tuning { shared, chains, epsilon, bsdf_fraction } = tuning;
        let path_tracer = PathTracer { depth, roulette, ..PathTracer::default() };
        let bidirectional = Bidirectional { depth, roulette, ..Bidirectional::default() };
        let merging = shared.merging();
        match self {
            Self::PathTracing => Box::new(path_tracer),
            Self::LightTracing => Box::new(LightTracer { depth, roulette }),
            Self::UniformArea => Box::new(UniformArea { depth, roulette }),
            Self::Bidirectional => Box::new(bidirectional),
            Self::Adaptive => Box::new(Adaptive { depth, roulette, ..Adaptive::default() }),
            Self::PhotonMapping => {
                Box::new(PhotonMapping { depth, roulette, merging, ..PhotonMapping::default() })
            }
            Self::InstantRadiosity => {
                let default = InstantRadiosity::default();
                let light_walks = shared.walks.unwrap_or(default.light_walks);
                let SharedWalks { bound, clamp, .. } = shared;
                Box::new(InstantRadiosity { path_tracer, light_walks, bound, compensates: !clamp })
            }
            Self::Vcm => Box::new(VertexConnectionMerging {
                bidirectional,
                merging,
                correlation_aware: shared.correlation_aware,
            }),
            Self::Metropolis => Box::new(chains.over(bidirectional)),
            Self::MetropolisPathTracing => Box::new(chains.over(path_tracer)),
            Self::Multiplexed => Box::new(chains.over(Multiplexed { bidirectional })),
            Self::Regularized => {
                let default = Regularization::new(path_tracer);
                let epsilon = epsilon.unwrap_or(default.epsilon);
                Box::new(Regularization { epsilon, ..default })
            }
            Self::Guided => Box::new(guiding(path_tracer, bsdf_fraction)),
            Self::GuidedBidirectional => Box::new(guiding(bidirectional, bsdf_fraction)),
        }
    }

    /// The integrator for paths of any length up to a limit, with the usual roulette.
    pub fn build_up_to(self, max_bounces: Option<u32>) -> Box<dyn Method<World>> {
        let depth = Depth { min_bounces: 0, max_bounces };
        self.build(depth, Roulette::default(), Tuning::default())
    }

    /// True if it sees every path of a scene that makes these claims.
    pub fn sees_all(self, claims: &Claims) -> bool {
        match self {
            Self::PathTracing | Self::MetropolisPathTracing | Self::Guided => claims.path_tracing,
            Self::LightTracing => claims.light_tracing,
            Self::UniformArea => claims.uniform_area,
            Self::Bidirectional
            | Self::Adaptive
            | Self::Metropolis
            | Self::Multiplexed
            | Self::GuidedBidirectional => claims.bidirectional,
            Self::PhotonMapping => claims.photon_mapping,
            Self::InstantRadiosity => claims.instant_radiosity,
            Self::Vcm => claims.vcm,
            // Among glossy lobes path tracing sees everything.
            Self::Regularized => true,
        }
    }
}

fn guiding<I>(integrator: I, bsdf_fraction: Option<f64>) -> Guiding<I> {
    let default = Guiding::new(integrator);
    Guiding { alpha: bsdf_fraction.unwrap_or(default.alpha), ..default }
}

impl std::fmt::Display for AnyIntegrator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
