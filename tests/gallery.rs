//! The scenes of the gallery: they build, refuse what they must, and the Cornell box has the
//! published look.

use pathspace::endpoint::PinholeCamera;
use pathspace::gallery::{self, GalleryError, NAMES};
use pathspace::geometry::{Quad, SurfacePoint};
use pathspace::glam::{DAffine3, DVec3, UVec2};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer, UniformArea};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Render, Settings};
use pathspace::scene::{Emission, Material, Mesh, Scene, World, WorldBuilder};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::collections::BTreeSet;

fn mean(
    integrator: &dyn Render<World>,
    world: &World,
    camera: &dyn pathspace::endpoint::Camera,
    samples: u32,
) -> Rgb {
    let settings = Settings { budget: Budget::Samples(samples), seed: 3, ..Settings::default() };
    let rendering = integrator.render(world, camera, &settings).unwrap();
    assert_eq!(rendering.counters.non_finite, 0);
    rendering.image.mean()
}

fn assert_close(name: &str, mean: Rgb, expected: [f64; 3], bound: f64) {
    for (channel, expected) in expected.into_iter().enumerate() {
        let error = mean[channel] / expected - 1.0;
        assert!(
            error.abs() < bound,
            "{name}, channel {channel}: {} instead of {expected}",
            mean[channel]
        );
    }
}

#[test]
fn every_scene_builds_and_renders() {
    for name in NAMES {
        let scene = gallery::build(name, UVec2::new(9, 7)).unwrap();
        assert_eq!((scene.name, Some(scene.description)), (name, gallery::description(name)));
        assert_eq!(scene.camera.film().resolution, UVec2::new(9, 7));
        assert!(scene.world.light_count() > 0 && scene.world.warnings().is_empty());
        // Nothing in it is lost beside the rest.
        assert_eq!(scene.world.tree_statistics().trees, 1, "{name}");
        let integrators: [(&dyn Render<World>, bool); 4] = [
            (&UniformArea::default(), scene.claims.uniform_area),
            (&PathTracer::default(), scene.claims.path_tracing),
            (&LightTracer::default(), scene.claims.light_tracing),
            (&Bidirectional::default(), scene.claims.bidirectional),
        ];
        for (integrator, claimed) in integrators {
            // Few paths pass the slit of a door.
            let most = if claimed { 16 } else { 4 };
            let mut means = (4..=most)
                .step_by(4)
                .map(|exponent| mean(integrator, &scene.world, &*scene.camera, 1 << exponent));
            let is_lit = means.any(|mean| {
                assert!(mean.is_finite(), "{name}: {mean:?}");
                !mean.is_black()
            });
            assert!(is_lit || !claimed, "{name}");
        }
    }
}

#[test]
fn errors_name_the_reason() {
    let error = gallery::build("cornell box", UVec2::ONE).unwrap_err();
    assert!(matches!(error, GalleryError::UnknownScene { .. }));
    assert!(error.to_string().contains("cornell box") && error.to_string().contains("cornell-box"));
    assert_eq!(gallery::description("nothing"), None);
    for name in NAMES {
        assert!(matches!(gallery::build(name, UVec2::new(0, 5)), Err(GalleryError::Endpoint(_))));
    }
}

/// Scenes for light tracing hide what it cannot see from the camera: the first hit of no pixel may
/// be a Dirac lobe.
#[test]
fn light_tracing_claims_scenes_without_visible_glass() {
    use pathspace::bsdf::Lobes;
    for name in NAMES {
        let scene = gallery::build(name, UVec2::new(160, 120)).unwrap();
        let lens =
            scene.camera.sample_point(0.5, pathspace::glam::DVec2::splat(0.5)).unwrap().point;
        let sees_dirac = (0..160 * 120).any(|pixel| {
            let u = pathspace::glam::DVec2::new(
                (f64::from(pixel % 160) + 0.5) / 160.0,
                (f64::from(pixel / 160) + 0.5) / 120.0,
            );
            let direction = scene.camera.sample_direction(&lens, u).unwrap().direction;
            let hit = scene.world.intersect(&lens, direction);
            hit.is_some_and(|x| {
                pathspace::bsdf::Bsdf::lobes(&scene.world.bsdf(&x)).intersects(Lobes::DIRAC)
            })
        });
        assert_eq!(sees_dirac, !scene.claims.light_tracing, "{name}");
    }
}

/// Nothing looks out of the water but through its surface, not even along the basin's edges.
#[test]
fn the_pool_is_watertight() {
    let world = gallery::build("pool", UVec2::ONE).unwrap().world;
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut seen = BTreeSet::new();
    for _ in 0..200_000 {
        let [x, y, z] = [0.0; 3].map(|_| rng.random_range(-1.0..1.0));
        let inside = SurfacePoint::dirac(DVec3::new(x, 0.475 * y - 0.525, z));
        let ends = [0.0; 3].map(|_: f64| {
            if rng.random() {
                rng.random_range(-1.0..1.0f64).signum()
            } else {
                rng.random_range(-1.0..1.0)
            }
        });
        let direction = (DVec3::from(ends) - inside.position).normalize();
        let hit = world.intersect(&inside, direction).expect("a surface all around");
        let name = world.surface_name(&hit).unwrap();
        assert!(name != "water" || hit.geometric_normal.dot(direction) > 0.0);
        seen.insert(name.to_owned());
    }
    let expected = ["back wall", "ball", "floor", "front wall", "left wall", "right wall", "water"];
    assert!(seen.iter().eq(&expected), "{seen:?}");
}

#[test]
fn every_pixel_of_the_sphere_with_a_cap_is_a_tenth() {
    let scene = gallery::build("sphere-cap", UVec2::new(16, 16)).unwrap();
    for integrator in [
        &PathTracer::default() as &dyn Render<World>,
        &LightTracer::default(),
        &Bidirectional::default(),
    ] {
        assert_close(
            "sphere-cap",
            mean(integrator, &scene.world, &*scene.camera, 1000),
            [0.1; 3],
            0.015,
        );
    }
}

/// Light that was scattered at most once, at most seven times, and without limit: means of the
/// image.
struct References {
    direct: [f64; 3],
    seven_bounces: [f64; 3],
    unbounded: [f64; 3],
}

/// Within 1 %, about four times the standard error of these renderings.
fn assert_references(
    world: &World,
    camera: &dyn pathspace::endpoint::Camera,
    references: &References,
) {
    let up_to =
        |max_bounces| PathTracer { depth: Depth::up_to(max_bounces), ..PathTracer::default() };
    assert_close("direct", mean(&up_to(1), world, camera, 128), references.direct, 0.01);
    assert_close(
        "seven bounces",
        mean(&up_to(7), world, camera, 128),
        references.seven_bounces,
        0.01,
    );
    assert_close(
        "unbounded",
        mean(&PathTracer::default(), world, camera, 128),
        references.unbounded,
        0.01,
    );
    assert_close(
        "light tracing",
        mean(&LightTracer::default(), world, camera, 96),
        references.unbounded,
        0.01,
    );
    assert_close(
        "bidirectional",
        mean(&Bidirectional::default(), world, camera, 32),
        references.unbounded,
        0.01,
    );
}

/// References: Mitsuba 3.9.1 (scalar_rgb, box filter, 2048 samples per pixel, standard errors below
/// 0.2 %) on the same quadrilaterals.
#[test]
fn the_cornell_box_has_the_means_of_an_independent_renderer() {
    let scene = gallery::build("cornell-box", UVec2::new(64, 64)).unwrap();
    let references = References {
        direct: [0.16575, 0.11553, 0.05267],
        seven_bounces: [0.24107, 0.14205, 0.06039],
        unbounded: [0.24502, 0.14222, 0.06036],
    };
    assert_references(&scene.world, &*scene.camera, &references);
}

/// The box that Mitsuba 3 builds in: a cube of side 2 with two blocks that are exact boxes.
/// References as above.
#[test]
fn a_regular_cornell_box_has_the_means_of_an_independent_renderer() {
    let references = References {
        direct: [0.1638, 0.1141, 0.0520],
        seven_bounces: [0.2399, 0.1410, 0.0599],
        unbounded: [0.2442, 0.1413, 0.0600],
    };
    let position = DVec3::new(0.0, 0.0, 3.9);
    let camera =
        PinholeCamera::new(position, DVec3::ZERO, DVec3::Y, 39.3077, UVec2::new(64, 64)).unwrap();
    assert_references(&regular_cornell_box(), &camera, &references);
}

fn regular_cornell_box() -> World {
    let mut builder = WorldBuilder::new();
    let mut diffuse = |name: &str, albedo: [f64; 3]| {
        builder.add_material(name, Material::Lambert { albedo: Rgb(albedo) }).unwrap()
    };
    let white = diffuse("white", [0.885809, 0.698859, 0.666422]);
    let green = diffuse("green", [0.105421, 0.37798, 0.076425]);
    let red = diffuse("red", [0.570068, 0.0430135, 0.0443706]);
    let mut quad = |name: &str, origin: [f64; 3], edge_u: DVec3, edge_v: DVec3, material| {
        let quad = Quad { origin: DVec3::from_array(origin), edge_u, edge_v };
        builder.add_quad(name, quad, material).unwrap()
    };
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    quad("floor", [-1.0, -1.0, -1.0], z, x, white);
    quad("ceiling", [-1.0, 1.0, -1.0], x, z, white);
    quad("back", [-1.0, -1.0, -1.0], x, y, white);
    quad("right", [1.0, -1.0, -1.0], z, y, green);
    quad("left", [-1.0, -1.0, -1.0], y, z, red);
    let lamp = quad("lamp", [-0.23, 0.99, -0.18], DVec3::X * 0.46, DVec3::Z * 0.38, white);
    builder
        .set_emission(
            lamp,
            Emission { radiance: Rgb::new(18.387, 13.9873, 6.75357), two_sided: false },
        )
        .unwrap();
    let blocks = [
        ("small", [0.335, -0.7, 0.38], -17.0f64, [0.3, 0.3, 0.3]),
        ("large", [-0.33, -0.4, -0.28], 18.25f64, [0.3, 0.61, 0.3]),
    ];
    for (name, center, degrees, half) in blocks {
        let place = DAffine3::from_translation(DVec3::from_array(center))
            * DAffine3::from_rotation_y(degrees.to_radians());
        let place = place * DAffine3::from_scale(DVec3::from_array(half));
        builder.add_mesh(name, &cube(), place, white).unwrap();
    }
    builder.build().unwrap()
}

/// The cube [-1, 1]³; two-sided materials do not mind the order of vertices.
fn cube() -> Mesh {
    let positions = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - 1.0)
        .collect();
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let indices = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    Mesh { positions, indices, ..Mesh::default() }
}
