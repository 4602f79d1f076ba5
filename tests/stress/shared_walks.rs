//! Light walks that all pixels share: none, too many, all at one place, and next to each other.

use crate::measure::{Measured, Method, Probe};
use crate::scenes::{Beam, Stage, camera, cap_sphere, footprint, lambert, mirror};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera, SpotLight};
use pathspace::film::{Contribution, FilmSample};
use pathspace::geometry::Quad;
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::{
    self, Bidirectional, Caller, Depth, InstantRadiosity, Integrator, Merging, PathTracer,
    PhotonMapping, Run, SharedWalks,
};
use pathspace::math::Rgb;
use pathspace::path::{Plan, Roulette, Scratch, TechniqueSet};
use pathspace::report::stats::{Largest, Tail};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::World;
use std::f64::consts::PI;

/// No light, and one that meets nothing.
#[test]
fn stress_s54_no_photons() {
    for lit in [false, true] {
        let mut stage = Stage::default();
        stage.square(0.0, 1.0, true, lambert(0.5));
        if lit {
            stage.light(SpotLight::new(DVec3::Z, DVec3::Z, Rgb::WHITE, 4.0, 5.0).expect("valid"));
        }
        let (world, eye) = (stage.build(), footprint(DVec3::ZERO, 0.5, 0.1));
        for method in Method::SHARED {
            let measured = Probe::new(&world, &eye, Depth::default()).sample(method, 1000, 1);
            assert!(measured.deviation([0.0; 3]) == 0.0, "{method:?} {measured:?}");
            assert_eq!(measured.non_finite, 0);
        }
    }
}

/// A beam of flux 1 much thinner than the radius: every photon is met.
fn all_in_one_cell(light_walks: u32) {
    let (radius, half) = (0.01, 1e-9);
    let mut stage = Stage::default();
    stage.square(0.0, 1.0, true, lambert(0.5));
    stage.light(Beam::onto_floor(half, 1.0, 1.0 / (4.0 * half * half)));
    let (world, eye) = (stage.build(), footprint(DVec3::ZERO, 0.5, 1e-3));
    let merging = Merging { light_walks: Some(light_walks), ..Merging::fixed(radius) };
    let integrator =
        PhotonMapping { depth: Depth::exactly(1), merging, ..PhotonMapping::default() };
    let mut run = integrator.start(integrator::Stage::new(&world, &eye), &Caller).expect("a run");
    run.begin_pass(0, &Caller).expect("memory");
    let (mut scratch, mut found) = (Scratch::default(), Vec::<Contribution>::new());
    let film = FilmSample { raster: DVec2::splat(0.5), offset: DVec2::ZERO };
    run.sample(film, Independent { seed: 1 }.sampler(0, 0), &mut found, &mut scratch);
    assert_eq!(scratch.counters.merges, u64::from(light_walks));
    let (value, expected) =
        (found.iter().map(|c| c.value.g()).sum::<f64>(), 0.5 / (PI * PI * radius * radius));
    assert!((value / expected - 1.0).abs() < 1e-9, "{value}, expected {expected}");
}

#[test]
fn stress_s54_all_photons_in_one_cell() {
    all_in_one_cell(100_000);
}

#[test]
#[ignore = "takes gigabytes"]
fn stress_s54_ten_million_photons_in_one_cell() {
    all_in_one_cell(10_000_000);
}

/// More than the address space holds.
#[test]
fn stress_s54_memory_is_refused_before_walks_are_drawn() {
    let (world, eye) =
        (cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0), camera(DVec3::ZERO, DVec3::NEG_Z, 53.0));
    let stage = integrator::Stage::new(&world, &eye);
    let plan = Plan::new(stage, TechniqueSet::BIDIRECTIONAL, Depth::default());
    let roulette = Roulette::default();
    let walks = SharedWalks { plan: &plan, roulette: &roulette, count: u32::MAX, shortest: 1 };
    let refused =
        walks.draw::<[u8; 1 << 20]>(0, &Caller, "test", |_, _| unreachable!("refused before"));
    let error = refused.map(|(taken, _)| taken.len()).expect_err("no memory");
    assert!(error.to_string().contains("no memory for 4294967295 vertices"), "{error}");
}

/// Two squares that meet in an edge, under a sky; the camera looks at one of them up to the edge.
fn corner(radiance: f64) -> (World, PinholeCamera) {
    let mut stage = Stage::default();
    stage.face(Quad { origin: DVec3::ZERO, edge_u: DVec3::X, edge_v: DVec3::Y }, lambert(0.5));
    stage.face(Quad { origin: DVec3::ZERO, edge_u: DVec3::Y, edge_v: DVec3::Z }, lambert(0.5));
    stage.environment(ConstantEnvironment::new(Rgb::splat(radiance)).expect("valid"));
    (stage.build(), footprint(DVec3::new(0.25, 0.5, 0.0), 0.5, 0.25))
}

fn two_bounces(bound: f64, light_walks: u32) -> InstantRadiosity {
    InstantRadiosity {
        path_tracer: PathTracer { depth: Depth::exactly(2), ..PathTracer::default() },
        light_walks,
        bound: Some(bound),
        compensates: true,
    }
}

/// Contributions of some passes of samples.
fn draw(
    (world, eye): &(World, PinholeCamera),
    integrator: &InstantRadiosity,
    passes: u32,
    samples: u32,
    mut take: impl FnMut(&[Contribution]),
) {
    let stage = integrator::Stage { seed: 3, ..integrator::Stage::new(world, eye) };
    let mut run = integrator.start(stage, &Caller).expect("a run");
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    for pass in 0..passes {
        run.begin_pass(pass, &Caller).expect("memory");
        found.clear();
        for i in 0..samples {
            let mut sampler = Independent { seed: 1 }.sampler(pass, i);
            let film = FilmSample { raster: sampler.next_2d(), offset: DVec2::ZERO };
            run.sample(film, sampler, &mut found, &mut scratch);
        }
        take(&found);
    }
    assert_eq!(scratch.counters.non_finite, 0);
}

fn weighted(found: &[Contribution]) -> f64 {
    found.iter().map(|c| c.value.g() * c.weight).sum()
}

/// Next to the edge geometry terms, and with them what virtual lights bring, have the tail index 3/2 and no
/// variance. A bound with compensation leaves neither of its two parts a tail.
#[test]
fn stress_s61_a_bound_takes_the_tail_away() {
    let scene = corner(1.0);
    let tail = |bound: f64| {
        let mut largest = Largest::new(1 << 15);
        draw(&scene, &two_bounces(bound, 64), 1000, 64, |found| {
            found.iter().for_each(|c| largest.push(c.value.g() * c.weight));
        });
        largest.tail().expect("enough contributions")
    };
    let (without, with) = (tail(f64::INFINITY), tail(4.0));
    println!("without {without:?}, with {with:?}");
    assert!((without.index - 1.5).abs() < 0.15 && without.is_infinite_variance(), "{without:?}");
    assert!(with.index > Tail::INFINITE_VARIANCE && !with.is_infinite_variance(), "{with:?}");
}

/// The mean distance from the mean, which is finite without a variance, too, falls as the number of
/// samples to -1/2 with the bound, and to -1/3, 1/α - 1 with a tail index of α = 3/2, without it.
#[test]
fn stress_s61_a_bound_makes_errors_fall_as_the_square_root() {
    let scene = corner(1.0);
    let expected =
        Probe::new(&scene.0, &scene.1, Depth::exactly(2)).sample(Method::Path, 400_000, 1);
    let expected = expected.channels[1].mean();
    let slope = |bound: f64| {
        let mut values = Vec::new();
        draw(&scene, &two_bounces(bound, 1), 1 << 18, 1, |found| values.push(weighted(found)));
        let distance = |length: usize| {
            let blocks = values.chunks_exact(length);
            let count = blocks.len() as f64;
            let off = |b: &[f64]| (b.iter().sum::<f64>() / length as f64 - expected).abs();
            blocks.map(off).sum::<f64>() / count
        };
        (distance(1 << 12) / distance(1 << 4)).ln() / 256f64.ln()
    };
    let (without, with) = (slope(f64::INFINITY), slope(4.0));
    println!("without {without:.3}, with {with:.3}");
    assert!((with + 0.5).abs() < 0.05, "{with}");
    assert!(without > -0.42, "{without}");
}

fn assert_same(name: &str, a: &Measured, b: &Measured, error: f64) {
    let [(x, e), (y, f)] = [a, b].map(|m| (m.channels[1].mean(), m.channels[1].standard_error()));
    println!("{name}: {x} ± {e}, {y} ± {f}");
    assert_eq!(a.non_finite + b.non_finite, 0);
    assert!((x - y).abs() <= 4.0 * e.hypot(f), "{name}: {x} ± {e}, {y} ± {f}");
    assert!(e.hypot(f) <= error * x, "{name}: the errors {e} and {f} are too large");
}

/// Any bound has path tracing's mean, from 0, with which virtual lights draw nothing, on; and so it
/// is for light of any power.
#[test]
fn stress_s61_bounds_and_powers() {
    let (world, eye) = corner(1.0);
    let probe = Probe { pass: 8, ..Probe::new(&world, &eye, Depth::exactly(2)) };
    let path = probe.sample(Method::Path, 200_000, 1);
    for bound in [0.0, 1e-300, 1e-3, 4.0] {
        let measured = probe.run(&two_bounces(bound, 16), 50_000, 2);
        assert_same(&format!("bound {bound:e}"), &measured, &path, 0.0125);
    }
    let unit = probe.run(&two_bounces(4.0, 16), 1000, 2);
    for power in [1e-30, 1e30] {
        let (world, eye) = corner(power);
        let probe = Probe { pass: 8, ..Probe::new(&world, &eye, Depth::exactly(2)) };
        let measured = probe.run(&two_bounces(4.0, 16), 1000, 2);
        let ratio = measured.channels[1].mean() / (power * unit.channels[1].mean());
        assert!((ratio - 1.0).abs() < 1e-12 && measured.non_finite == 0, "{power}: {ratio}");
    }
}

/// Inside a sphere all geometry terms are the same, and so is what each virtual light brings.
#[test]
fn stress_s61_a_hundred_thousand_virtual_lights() {
    let (world, eye) =
        (cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0), camera(DVec3::ZERO, DVec3::NEG_Z, 53.0));
    draw(&(world, eye), &two_bounces(f64::INFINITY, 100_000), 1, 5, |found| {
        let mean = weighted(found) / 5.0;
        assert!((mean / 0.025 - 1.0).abs() < 1e-9, "{mean}");
    });
}

/// A beam ever thinner leaves virtual lights ever nearer to what is looked at, down to where they
/// are one point, all in one plane; they light a wall, which lights the floor.
#[test]
fn stress_s61_virtual_lights_next_to_what_they_light() {
    for half in [1e-3, 1e-12, 1e-150] {
        let mut stage = Stage::default();
        stage.square(0.0, 1.0, true, lambert(0.5));
        stage.quad(DVec3::new(0.5, -0.5, 0.0), DVec3::Z, DVec3::Y, lambert(0.5));
        stage.light(Beam::onto_floor(half, 1.0, 1.0 / (4.0 * half * half)));
        let (world, eye) = (stage.build(), footprint(DVec3::ZERO, 0.5, 1e-9));
        let depth = Depth::exactly(3);
        let probe = Probe { fixed: true, pass: 8, ..Probe::new(&world, &eye, depth) };
        let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
        let reference = probe.run(&bidirectional, 200_000, 1);
        for compensates in [true, false] {
            let integrator = InstantRadiosity {
                path_tracer: PathTracer { depth, ..PathTracer::default() },
                bound: Some(100.0),
                compensates,
                ..InstantRadiosity::default()
            };
            let name = format!("half side {half:e}, {compensates}");
            assert_same(&name, &probe.run(&integrator, 20_000, 2), &reference, 0.0125);
        }
    }
}

/// A spot light that only a mirror can see, and nothing but virtual lights therefore: what a bound
/// cuts off of connections to the first vertex behind the mirror would be drawn by nobody.
#[test]
fn stress_s61_a_bound_leaves_what_nothing_else_draws() {
    let mut stage = Stage::default();
    stage.square(0.0, 1.0, true, lambert(0.7));
    stage.square(2.0, 1.0, false, mirror(0.9));
    stage.quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::Y * 2.0, DVec3::Z * 2.0, lambert(0.7));
    stage.light(SpotLight::new(DVec3::Z, DVec3::Z, Rgb::WHITE, 20.0, 25.0).expect("valid"));
    let (world, eye) = (stage.build(), footprint(DVec3::new(-0.7, 0.0, 0.0), 0.5, 0.2));
    for bounces in [3, 4] {
        let depth = Depth::exactly(bounces);
        let probe = Probe { pass: 8, ..Probe::new(&world, &eye, depth) };
        assert_eq!(probe.sample(Method::Path, 10_000, 1).deviation([0.0; 3]), 0.0);
        // Light that meets the mirror again before the last surface takes a connection to the lens.
        let techniques = TechniqueSet { lens_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
        let bidirectional = Bidirectional { depth, techniques, ..Bidirectional::default() };
        let reference = probe.run(&bidirectional, 250_000, 1);
        for bound in [0.0, 0.05, 4.0] {
            let integrator = InstantRadiosity {
                path_tracer: PathTracer { depth, ..PathTracer::default() },
                bound: Some(bound),
                ..InstantRadiosity::default()
            };
            let name = format!("{bounces} bounces, bound {bound}");
            assert_same(&name, &probe.run(&integrator, 25_000, 2), &reference, 0.03);
        }
    }
}
