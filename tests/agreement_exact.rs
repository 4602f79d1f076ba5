//! Exact answers for all integrators that can see them; `analytic.json` entries are named by their
//! ids.

#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "agreement_exact/direct.rs"]
mod direct;
#[path = "agreement_exact/enclosures.rs"]
mod enclosures;
#[path = "common/rooms.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod rooms;
#[path = "agreement_exact/weights.rs"]
mod weights;

use compare::{Comparison, measure};
use glam::{DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::integrator::{
    Bidirectional, Depth, LightTracer, PathTracer, PathTracing, UniformArea,
};
use pathspace::path::Heuristic;
use pathspace::render::Render;
use pathspace::scene::{Material, World};

const BLACK: Material = Material::Black;

fn path(depth: Depth) -> PathTracer {
    PathTracer { depth, ..PathTracer::default() }
}

fn path_mode(mode: PathTracing, depth: Depth) -> PathTracer {
    PathTracer { mode, depth, ..PathTracer::default() }
}

fn bidirectional(depth: Depth, heuristic: Heuristic) -> Bidirectional {
    Bidirectional { depth, heuristic, ..Bidirectional::default() }
}

type Team = Vec<(&'static str, Box<dyn Render<World>>)>;

/// Path tracing (both techniques, and hits alone) and bidirectional path tracing.
fn from_camera(depth: Depth) -> Team {
    vec![
        ("path", Box::new(path(depth))),
        ("emission only", Box::new(path_mode(PathTracing::EmissionOnly, depth))),
        ("bidirectional, power", Box::new(bidirectional(depth, Heuristic::Power(2.0)))),
        ("bidirectional, balance", Box::new(bidirectional(depth, Heuristic::Balance))),
    ]
}

/// And light tracing and uniform-area sampling.
fn everybody(depth: Depth) -> Team {
    let mut team = from_camera(depth);
    team.push(("light", Box::new(LightTracer { depth, ..LightTracer::default() })));
    team.push(("uniform area", Box::new(UniformArea { depth, ..UniformArea::default() })));
    team
}

fn assert_all(
    case: &str,
    world: &World,
    camera: &PinholeCamera,
    team: &Team,
    expected: [f64; 3],
    error: f64,
) {
    println!("{case}");
    let comparison = Comparison { target: 0.7 * error, most: 20_000, ..Comparison::default() };
    for (name, integrator) in team {
        measure(world, camera, (name, integrator.as_ref()), &comparison)
            .assert_mean(expected, error);
    }
}

/// A camera that sees as good as one point.
fn narrow(position: DVec3, target: DVec3) -> PinholeCamera {
    let up = if (target - position).normalize().z.abs() > 0.9 { DVec3::X } else { DVec3::Z };
    PinholeCamera::new(position, target, up, 0.02, UVec2::splat(4)).expect("valid camera")
}
