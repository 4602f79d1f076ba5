//! Rays against their closed forms.

use super::{contributions, rooms, worlds};
use glam::{DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::geometry::{Disk, Quad};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::path::{Counters, Roulette};
use pathspace::scene::Emission;
use rooms::lambert;

/// Rays in a closed box with a lamp are never more than the closed forms (row F17 of
/// tests/data/analytic.json), which hold where nothing is culled.
#[test]
fn culling_keeps_rays_below_the_closed_forms() {
    let at = worlds::Placement::UNIT;
    let mut builder = pathspace::scene::WorldBuilder::new();
    let wall = builder.add_material("wall", lambert(0.7, 0.7, 0.7)).expect("valid");
    for (i, (n, u, w)) in [
        (DVec3::X, DVec3::Y, DVec3::Z),
        (DVec3::Y, DVec3::Z, DVec3::X),
        (DVec3::Z, DVec3::X, DVec3::Y),
    ]
    .into_iter()
    .enumerate()
    {
        for side in [-1.0, 1.0] {
            let (u, w) = if side < 0.0 { (u, w) } else { (w, u) };
            builder
                .add_quad(
                    format!("{i} {side}"),
                    Quad { origin: n * side - u - w, edge_u: u * 2.0, edge_v: w * 2.0 },
                    wall,
                )
                .expect("valid");
        }
    }
    let lamp = Disk { center: at.point(0.0, 0.99, 0.0), normal: DVec3::NEG_Y, radius: 0.3 };
    let lamp = builder.add_disk("lamp", lamp, wall).expect("valid");
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).expect("valid");
    let world = builder.build().expect("valid");
    let camera =
        PinholeCamera::new(at.point(0.0, 0.0, 0.9), DVec3::ZERO, DVec3::Y, 60.0, UVec2::splat(8))
            .expect("valid");
    let roulette = Roulette::NEVER;
    for edges in [2u32, 3, 5, 10] {
        let (depth, d) = (Depth::up_to(edges - 1), f64::from(edges));
        let rays = |counters: Counters| counters.rays() as f64 / counters.samples as f64;
        let path = rays(
            contributions(
                &world,
                &camera,
                &PathTracer { depth, roulette, ..PathTracer::default() },
                500,
            )
            .1,
        );
        let light = rays(contributions(&world, &camera, &LightTracer { depth, roulette }, 500).1);
        let both = rays(
            contributions(
                &world,
                &camera,
                &Bidirectional { depth, roulette, ..Bidirectional::default() },
                500,
            )
            .1,
        );
        let bound = d + (d - 1.0) + 2.0 * (d - 1.0) + 0.5 * (d - 1.0) * (d - 2.0);
        assert!(path < 2.0 * d - 1.0 && path > d, "path tracing, D = {d}: {path}");
        assert!(light < 2.0 * d - 1.0 && light > d - 1.0, "light tracing, D = {d}: {light}");
        assert!(both < bound && both > 2.0 * d - 1.0, "bidirectional, D = {d}: {both} of {bound}");
    }
}
