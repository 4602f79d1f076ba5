//! The scenes and integrators to choose from.

use pathspace::gallery::{self, Claims};
use pathspace::integrator::{
    Adaptive, Bidirectional, Depth, Estimator, Guiding, InstantRadiosity, LightTracer, Merging,
    Metropolis, Multiplexed, PathTracer, PhotonMapping, Regularization, UniformArea,
    VertexConnectionMerging,
};
use pathspace::render::Render;
use pathspace::scene::World;
use serde::Serialize;

/// The scenes and integrators to choose from.
#[derive(Clone, Debug, Serialize)]
pub struct Catalogue {
    version: &'static str,
    scenes: Vec<SceneEntry>,
    integrators: Vec<IntegratorEntry>,
}

#[derive(Clone, Debug, Serialize)]
struct SceneEntry {
    name: &'static str,
    description: &'static str,
    max_bounces: Option<u32>,
    /// The integrator that draws references.
    reference: &'static str,
    /// The integrators that see every path.
    sees: Vec<&'static str>,
}

#[derive(Clone, Debug, Serialize)]
struct IntegratorEntry {
    name: &'static str,
    title: &'static str,
    description: &'static str,
    /// `unbiased`, `consistent` or `biased`.
    estimator: &'static str,
    /// True if it has a radius within which subpaths merge.
    radius: bool,
}

/// An integrator of the page.
pub(crate) struct Entry {
    pub name: &'static str,
    title: &'static str,
    description: &'static str,
    estimator: Estimator,
    radius: bool,
    pub build: fn(Depth, Option<f64>) -> Box<dyn Render<World>>,
    sees: fn(&Claims) -> bool,
}

/// All of them, under the names of the command line.
pub(crate) const INTEGRATORS: [Entry; 14] = [
    Entry {
        name: "path-tracing",
        title: "Path tracing",
        description: "Walks from the camera; at every vertex a point on a light is sampled, too.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(path_tracer(depth)),
        sees: |claims| claims.path_tracing,
    },
    Entry {
        name: "light-tracing",
        title: "Light tracing",
        description: "Walks from the lights; every vertex is connected to the lens.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(LightTracer { depth, ..LightTracer::default() }),
        sees: |claims| claims.light_tracing,
    },
    Entry {
        name: "uniform-area",
        title: "Uniform-area sampling",
        description: "Every vertex uniform on all surfaces: the integral over paths as it stands.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(UniformArea { depth, ..UniformArea::default() }),
        sees: |claims| claims.uniform_area,
    },
    Entry {
        name: "bidirectional",
        title: "Bidirectional path tracing",
        description: "A walk from each end, and every connection between them, weighted.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(bidirectional(depth)),
        sees: |claims| claims.bidirectional,
    },
    Entry {
        name: "photon-mapping",
        title: "Photon mapping",
        description: "Light walks that all pixels share, met within a radius that shrinks.",
        estimator: Estimator::Consistent,
        radius: true,
        build: |depth, radius| {
            let merging = merging(radius);
            Box::new(PhotonMapping { depth, merging, ..PhotonMapping::default() })
        },
        sees: |claims| claims.photon_mapping,
    },
    Entry {
        name: "instant-radiosity",
        title: "Instant radiosity",
        description: "A few light walks become virtual lights that all pixels share.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| {
            let path_tracer = path_tracer(depth);
            Box::new(InstantRadiosity { path_tracer, ..InstantRadiosity::default() })
        },
        sees: |claims| claims.instant_radiosity,
    },
    Entry {
        name: "vcm",
        title: "Vertex connection and merging",
        description: "Bidirectional path tracing and photon mapping, weighted together.",
        estimator: Estimator::Consistent,
        radius: true,
        build: |depth, radius| {
            Box::new(VertexConnectionMerging {
                bidirectional: bidirectional(depth),
                merging: merging(radius),
                ..VertexConnectionMerging::default()
            })
        },
        sees: |claims| claims.vcm,
    },
    Entry {
        name: "adaptive",
        title: "Adaptive",
        description: "As much of bidirectional path tracing as pays, which a pilot finds out.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(Adaptive { depth, ..Adaptive::default() }),
        sees: |claims| claims.bidirectional,
    },
    Entry {
        name: "metropolis",
        title: "Metropolis",
        description: "Markov chains that move the random numbers of bidirectional path tracing.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(Metropolis::over(bidirectional(depth))),
        sees: |claims| claims.bidirectional,
    },
    Entry {
        name: "metropolis-path-tracing",
        title: "Metropolis path tracing",
        description: "Markov chains that move the random numbers of path tracing.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(Metropolis::over(path_tracer(depth))),
        sees: |claims| claims.path_tracing,
    },
    Entry {
        name: "multiplexed",
        title: "Multiplexed Metropolis",
        description: "Markov chains over one technique at a time, which they choose as well.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| {
            Box::new(Metropolis::over(Multiplexed { bidirectional: bidirectional(depth) }))
        },
        sees: |claims| claims.bidirectional,
    },
    Entry {
        name: "regularized",
        title: "Regularised path tracing",
        description: "Mirrors and glass are slightly blurred, less from pass to pass.",
        estimator: Estimator::Consistent,
        radius: false,
        build: |depth, _| Box::new(Regularization::new(path_tracer(depth))),
        sees: |_| true,
    },
    Entry {
        name: "guided",
        title: "Guided path tracing",
        description: "Walks learn first where light comes from, if that pays.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(Guiding::new(path_tracer(depth))),
        sees: |claims| claims.path_tracing,
    },
    Entry {
        name: "guided-bidirectional",
        title: "Guided bidirectional",
        description: "The camera walks of bidirectional path tracing learn where light comes from.",
        estimator: Estimator::Unbiased,
        radius: false,
        build: |depth, _| Box::new(Guiding::new(bidirectional(depth))),
        sees: |claims| claims.bidirectional,
    },
];

fn path_tracer(depth: Depth) -> PathTracer {
    PathTracer { depth, ..PathTracer::default() }
}

pub(crate) fn bidirectional(depth: Depth) -> Bidirectional {
    Bidirectional { depth, ..Bidirectional::default() }
}

/// Merging within a radius of the first pass, or the usual one.
pub(crate) fn merging(radius: Option<f64>) -> Merging {
    Merging { radius, ..Merging::default() }
}

/// The integrator whose image of a scene is the nearest to the truth after a short time: where
/// bidirectional path tracing meets bright paths too rarely, its image is too dark, and seems to have
/// little noise.
fn reference(scene: &str) -> &'static str {
    match scene {
        "caustic" | "pool" | "door-ajar" | "door-ajar-narrow" | "mirror-chain" => "vcm",
        _ => "bidirectional",
    }
}

/// The word for the mean of an estimate.
pub(crate) fn word(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Unbiased => "unbiased",
        Estimator::Consistent => "consistent",
        _ => "biased",
    }
}

/// All scenes and integrators.
#[must_use]
pub fn catalogue() -> Catalogue {
    let scenes = gallery::NAMES.into_iter().filter_map(|name| {
        // The film does not matter.
        let scene = gallery::build(name, glam::UVec2::ONE).ok()?;
        let sees = INTEGRATORS.iter().filter(|entry| (entry.sees)(&scene.claims));
        Some(SceneEntry {
            name,
            description: scene.description,
            max_bounces: scene.max_bounces,
            reference: reference(name),
            sees: sees.map(|entry| entry.name).collect(),
        })
    });
    let integrator = |entry: &Entry| IntegratorEntry {
        name: entry.name,
        title: entry.title,
        description: entry.description,
        estimator: word(entry.estimator),
        radius: entry.radius,
    };
    Catalogue {
        version: env!("CARGO_PKG_VERSION"),
        scenes: scenes.collect(),
        integrators: INTEGRATORS.iter().map(integrator).collect(),
    }
}
