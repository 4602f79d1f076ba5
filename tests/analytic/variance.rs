//! F: variances, and distributions that have none.

use crate::entry::{Entry, expected};
use crate::measure::Method::{self, Bidirectional, Emission, Light, Path, UniformArea};
use crate::measure::{Measured, Probe};
use crate::scenes::{self, Stage, camera, cap_sphere, footprint, furnace_sphere, lambert};
use crate::square_light::{self, Variances};
use pathspace::endpoint::PointLight;
use pathspace::film::{Contribution, FilmSample};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::{self, Caller, Depth, Integrator, Merging, PhotonMapping, Run};
use pathspace::math::Rgb;
use pathspace::math::statistics::Estimate;
use pathspace::path::{
    Counters, Edge, Heuristic, RandomWalk, Roulette, Scratch, Survival, Termination,
};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::{Material, Scene, SurfaceArea, World};
use std::f64::consts::PI;

fn assert_variance(what: &str, measured: &Measured, variance: f64, tolerance: f64) {
    let of_samples = measured.channels[1].variance();
    println!(
        "{what}: variance {of_samples:.6e}, expected {variance:.6e}, {} samples",
        measured.samples
    );
    assert!(
        (of_samples / variance - 1.0).abs() <= tolerance,
        "{what}: {of_samples}, expected {variance}"
    );
}

/// Cosine-weighted directions inside a sphere are uniform in area: path tracing that samples no
/// light has the variance of uniform-area sampling.
#[test]
fn f01_variance_of_hits() {
    let world = cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0);
    let eye = camera(DVec3::ZERO, DVec3::NEG_Z, 53.0);
    for k in 1..=3 {
        let probe =
            Probe { roulette: Roulette::NEVER, ..Probe::new(&world, &eye, Depth::exactly(k)) };
        for method in [UniformArea, Emission] {
            let measured = probe.sample(method, 300_000, 5);
            let mean = expected("F01", &format!("mean_k{k}"));
            assert!(measured.agrees([mean; 3], 0.0));
            assert_variance(
                &format!("F01 k = {k} {method:?}"),
                &measured,
                expected("F01", &format!("var_k{k}")),
                0.02,
            );
        }
    }
}

/// The variance of roulette. With p = 0.3 the fourth moment is infinite, so the measured variance
/// means nothing; the mean still does.
#[test]
fn f04_variance_of_roulette() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.5), 1.0);
    let eye = camera(DVec3::ZERO, DVec3::X, 60.0);
    for p in [0.5, 0.75, 0.3] {
        let roulette = Roulette { start: 0, survival: Survival::Fixed(p), ..Roulette::default() };
        let entry = Entry::new("F04", &world, &eye, Depth::default()).roulette(roulette);
        let measured = entry.probe.sample(Emission, 500_000, 6);
        assert!(
            measured.agrees([entry.expected("mean"); 3], if p == 0.3 { 0.02 } else { 0.0 }),
            "p = {p}: {measured:?}"
        );
        if p > 0.3 {
            assert_variance(
                &format!("F04 p = {p}"),
                &measured,
                entry.expected(&format!("var_p{p}")),
                entry.tolerance(),
            );
        }
        // No closed form of the variance, but the same mean.
        if p == 0.75 {
            entry.check(&[Light, Bidirectional, UniformArea], "mean");
        }
    }
}

/// A survival capped at 0.95 has infinite variance above the albedo √0.95; the rule has no cap.
#[test]
fn f05_no_cap() {
    for albedo in [0.9f64, 0.97, 0.99, 0.999] {
        assert_eq!(Roulette::default().decide(100, 1.0, || 0.0), Termination::Continue);
        let Termination::Survived { q } =
            Roulette::default().decide(100, albedo, || 1.0f64.next_down())
        else {
            panic!("{albedo}")
        };
        // p > ρ²: finite variance.
        assert!((1.0 - q - albedo).abs() < 1e-15 && 1.0 - q > albedo * albedo);
    }
    assert!((expected("F05", "rho_threshold_cap0.95") - 0.95f64.sqrt()).abs() < 1e-12);
}

/// A point light of flux 1 in the middle of a black sphere.
fn photon_sphere() -> World {
    let mut stage = Stage::default();
    let sphere = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    stage.sphere(sphere, Material::Black);
    stage.light(PointLight::new(DVec3::ZERO, Rgb::splat(0.25 / PI)).expect("valid"));
    stage.build()
}

/// The photons that a thousand light walks leave in a ball around a point of the sphere are a
/// binomial number, and the estimate of the density is without bias for every radius.
#[test]
fn f08_variance_of_a_photon_count() {
    let (world, point) = (photon_sphere(), DVec3::new(0.48, -0.6, 0.64));
    let lens = camera(DVec3::ZERO, DVec3::X, 90.0);
    let stage = integrator::Stage::new(&world, &lens);
    let (walks, passes, radius) = (1000u32, 40_000u32, 0.2f64);
    let mut irradiance = Estimate::default();
    for pass in 0..passes {
        let mut flux = 0.0;
        for i in 0..walks {
            let mut sampler = Independent { seed: 4 }.sampler(pass, i);
            let (walk, _) = RandomWalk::from_light(&stage, &mut sampler, &mut Counters::default())
                .expect("light");
            let walk = walk.expect("a ray");
            let (from, direction) = walk.ray();
            let photon = world.intersect(from, direction).expect("a closed sphere");
            if photon.position.distance(point) < radius {
                flux += walk.throughput().g();
            }
        }
        irradiance.push(flux / (f64::from(walks) * PI * radius * radius));
    }
    let (mean, variance) = (expected("F08", "mean_E"), expected("F08", "variance_E"));
    assert!((irradiance.mean() - mean).abs() <= 4.0 * (variance / f64::from(passes)).sqrt());
    assert!((irradiance.variance() / variance - 1.0).abs() <= 0.02, "{irradiance:?}");
}

/// The same as what the camera sees by photon mapping, of a sphere that is white and not black, by
/// one sample a pass.
#[test]
fn f08_variance_of_photon_mapping() {
    let mut stage = Stage::default();
    let sphere = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    stage.sphere(sphere, lambert(1.0));
    stage.light(PointLight::new(DVec3::ZERO, Rgb::splat(0.25 / PI)).expect("valid"));
    let (world, eye) = (stage.build(), camera(DVec3::new(0.3, 0.1, -0.2), DVec3::X, 60.0));
    let merging = Merging { light_walks: Some(1000), ..Merging::fixed(0.2) };
    let integrator =
        PhotonMapping { depth: Depth::exactly(1), merging, ..PhotonMapping::default() };
    let stage = integrator::Stage { seed: 4, ..integrator::Stage::new(&world, &eye) };
    let mut run = integrator.start(stage, &Caller).expect("a run");
    let (mut irradiance, mut scratch) = (Estimate::default(), Scratch::default());
    let passes = 10_000;
    for pass in 0..passes {
        run.begin_pass(pass, &Caller).expect("memory");
        let mut found = Vec::<Contribution>::new();
        let film = FilmSample { raster: DVec2::splat(0.5), offset: DVec2::ZERO };
        run.sample(film, Independent { seed: 5 }.sampler(0, pass), &mut found, &mut scratch);
        irradiance.push(PI * found.iter().map(|found| found.value.g()).sum::<f64>());
    }
    let (mean, variance) = (expected("F08", "mean_E"), expected("F08", "variance_E"));
    assert!((irradiance.mean() - mean).abs() <= 4.0 * (variance / f64::from(passes)).sqrt());
    // A variance of so many has a standard error of √(2/10000).
    assert!((irradiance.variance() / variance - 1.0).abs() <= 0.06, "{irradiance:?}");
}

/// P(G > g) ~ g^(-3/2) between two squares that meet in an edge.
#[test]
fn f09_tail_of_a_corner() {
    let mut stage = Stage::default();
    stage.face(Quad { origin: DVec3::ZERO, edge_u: DVec3::X, edge_v: DVec3::Y }, lambert(0.5));
    stage.face(Quad { origin: DVec3::ZERO, edge_u: DVec3::Y, edge_v: DVec3::Z }, lambert(0.5));
    let world = stage.build();
    let (low, high) = (20.0, 200.0);
    let (mut above_low, mut above_high, mut sum, mut pairs) = (0u32, 0u32, 0.0, 0u32);
    for i in 0..4_000_000 {
        let mut u = Independent { seed: 1 }.sampler(0, i);
        // One point on each: the squares have the same area, so the first number chooses between
        // them.
        let mut on = |square: f64| {
            world.sample_surface(0.5 * (square + u.next_1d()), DVec2::new(u.next_1d(), u.next_1d()))
        };
        let (a, b) = (on(0.0), on(1.0));
        if a.primitive == b.primitive {
            continue;
        }
        let g = Edge::between(&a, &b).expect("distinct points").geometry;
        pairs += 1;
        sum += g;
        above_low += u32::from(g > low);
        above_high += u32::from(g > high);
    }
    let mean = sum / f64::from(pairs);
    let index = (f64::from(above_low) / f64::from(above_high)).ln() / (high / low).ln();
    println!(
        "F09 mean {mean:.4}, tail index {index:.3} from {above_low} and {above_high} of {pairs}"
    );
    assert!((index / expected("F09", "tail_index") - 1.0).abs() < 0.05);
    // The mean converges with N^(-1/3): 0.6 % for 4e6.
    assert!((mean / expected("F09", "E[G]") - 1.0).abs() < 0.03);
}

#[test]
fn f10_no_variance_under_a_point_light() {
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(0.5));
    stage.light(
        PointLight::new(2.0 * DVec3::new(0.5, 0.0, 0.75f64.sqrt()), Rgb::splat(5.0))
            .expect("valid"),
    );
    let (world, eye) = (stage.build(), footprint(DVec3::ZERO, 1.0, 1e-9));
    let probe = Probe { fixed: true, ..Probe::new(&world, &eye, Depth::exactly(1)) };
    for method in [Path, Bidirectional] {
        let measured = probe.sample(method, 10_000, 8);
        assert!(measured.channels[1].variance() <= 1e-24, "{method:?}: {measured:?}");
    }
}

#[test]
fn f12_variances_under_a_square_light() {
    let world = scenes::square_light(0.5, DVec3::ZERO, 1.0, 1.0);
    let eye = footprint(DVec3::ZERO, 1.0, 1e-4);
    let probe = |heuristic| Probe {
        heuristic,
        roulette: Roulette::NEVER,
        ..Probe::new(&world, &eye, Depth::exactly(1))
    };
    // The entry's numbers are of points uniform by area; so near a light they are uniform in solid
    // angle.
    let area = Variances::of(square_light::by_area);
    for (variance, key) in [
        (area.light, "var_area_sampling"),
        (area.cosine, "var_cosine_sampling"),
        (area.balance, "var_balance"),
        (area.power, "var_power2"),
    ] {
        let exact = expected("F12", key);
        assert!((variance / exact - 1.0).abs() < 1e-4, "{key}: {variance}, expected {exact}");
    }
    let near = Variances::of(square_light::by_solid_angle());
    let cases: [(Method, Heuristic, f64); 3] = [
        (Emission, Heuristic::Balance, near.cosine),
        (Path, Heuristic::Balance, near.balance),
        (Path, Heuristic::Power(2.0), near.power),
    ];
    for (method, heuristic, variance) in cases {
        let measured = probe(heuristic).sample(method, 500_000, 9);
        assert!(measured.agrees([expected("F12", "mean"); 3], 0.0));
        assert_variance(&format!("F12 {method:?} {heuristic:?}"), &measured, variance, 0.02);
    }
    let next_event = pathspace::integrator::PathTracer {
        mode: pathspace::integrator::PathTracing::NextEventOnly,
        depth: Depth::exactly(1),
        ..Default::default()
    };
    let measured = probe(Heuristic::Balance).run(&next_event, 300_000, 9);
    assert_variance("F12 next event estimation", &measured, near.light, 0.02);
}

/// Means in a sphere that emits everywhere, so that next event estimation and BSDF sampling have
/// the same density.
#[test]
fn f15_means_in_an_emissive_sphere() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.9), 1.0);
    let eye = camera(DVec3::new(0.3, 0.1, -0.2), DVec3::X, 60.0);
    for (k, key) in [(1, "one_bounce"), (2, "two_bounce")] {
        Entry::new("F15", &world, &eye, Depth::up_to(k)).check(&[Path, Bidirectional], key);
    }
}
