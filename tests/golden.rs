//! Films of every integrator on every scene of the gallery with every sampler, as hashes: a change
//! that is not meant to change images does not change a bit of them.
//!
//! `PATHSPACE_BLESS=1 cargo test --release -p pathspace-tests --test golden` writes the hashes anew.
//! They hold where the standard library's functions round as on x86-64 Linux.
#![allow(missing_docs, reason = "a test program")]
#![cfg(all(target_arch = "x86_64", target_os = "linux"))]

use glam::UVec2;
use pathspace::gallery;
use pathspace::integrator::{
    Adaptive, Bidirectional, Depth, InstantRadiosity, LightTracer, PathTracer, PathTracing,
    PhotonMapping, UniformArea, VertexConnectionMerging,
};
use pathspace::path::{LightSubpaths, TechniqueSet};
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::World;
use std::error::Error;
use std::fmt::Write;
use std::process::Command;

const SIDE: u32 = 16;
const PASSES: u32 = 4;
const SAMPLERS: [SamplerKind; 3] =
    [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol];
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/golden.txt");

fn integrators(depth: Depth) -> Vec<(&'static str, Box<dyn Render<World>>)> {
    let path = PathTracer { depth, ..PathTracer::default() };
    let both = Bidirectional { depth, ..Bidirectional::default() };
    let walks = |exponent| {
        let light_subpaths = LightSubpaths::power_of_two(exponent).unwrap_or_default();
        Bidirectional {
            techniques: TechniqueSet { light_subpaths, ..TechniqueSet::BIDIRECTIONAL },
            ..both
        }
    };
    vec![
        ("uniform-area", Box::new(UniformArea { depth, ..UniformArea::default() })),
        ("path-tracing", Box::new(path)),
        ("path-tracing/emission", Box::new(PathTracer { mode: PathTracing::EmissionOnly, ..path })),
        (
            "path-tracing/next-event",
            Box::new(PathTracer { mode: PathTracing::NextEventOnly, ..path }),
        ),
        ("light-tracing", Box::new(LightTracer { depth, ..LightTracer::default() })),
        ("bidirectional", Box::new(both)),
        ("bidirectional/2-walks", Box::new(walks(1))),
        ("bidirectional/quarter-walk", Box::new(walks(-2))),
        ("adaptive", Box::new(Adaptive { depth, ..Adaptive::default() })),
        ("photon-mapping", Box::new(PhotonMapping { depth, ..PhotonMapping::default() })),
        (
            "photon-mapping/next-event",
            Box::new(PhotonMapping { depth, next_event: true, ..PhotonMapping::default() }),
        ),
        (
            "instant-radiosity",
            Box::new(InstantRadiosity { path_tracer: path, ..InstantRadiosity::default() }),
        ),
        (
            "vcm",
            Box::new(VertexConnectionMerging {
                bidirectional: both,
                ..VertexConnectionMerging::default()
            }),
        ),
    ]
}

/// FNV-1a (Fowler, Noll and Vo) over the bits of numbers.
fn hash(numbers: impl Iterator<Item = f64>) -> u64 {
    let bytes = numbers.flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn films_are_the_same_to_the_bit() -> Result<(), Box<dyn Error>> {
    let mut found = String::new();
    for name in gallery::NAMES {
        let scene = gallery::build(name, UVec2::splat(SIDE))?;
        let depth = Depth { max_bounces: scene.max_bounces, ..Depth::default() };
        for (integrator_name, integrator) in integrators(depth) {
            for sampler in SAMPLERS {
                let settings = Settings {
                    budget: Budget::Samples(PASSES),
                    seed: 1,
                    sampler,
                    ..Settings::default()
                };
                let rendering = integrator.render(&scene.world, &*scene.camera, &settings)?;
                let hash = hash(rendering.film.sums().flat_map(|sum| sum.0));
                writeln!(found, "{name} {integrator_name} {sampler:?} {hash:016x}")?;
            }
        }
    }
    if std::env::var_os("PATHSPACE_BLESS").is_some() {
        std::fs::write(FILE, &found)?;
    }
    let expected = std::fs::read_to_string(FILE)?;
    let changed: Vec<_> = expected
        .lines()
        .zip(found.lines())
        .filter(|(expected, found)| expected != found)
        .map(|(_, found)| found)
        .collect();
    assert!(
        changed.is_empty() && expected.lines().count() == found.lines().count(),
        "changed:\n{}",
        changed.join("\n")
    );
    Ok(())
}

/// Lanes of other instruction sets give the same bits; one that the processor lacks is not tried.
#[test]
fn films_are_the_same_on_every_instruction_set() -> Result<(), Box<dyn Error>> {
    for level in ["sse2", "avx2"] {
        let output = Command::new(std::env::current_exe()?)
            .args(["--exact", "films_are_the_same_to_the_bit"])
            .env("PATHSPACE_SIMD", level)
            .env_remove("PATHSPACE_BLESS")
            .output()?;
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && text.contains("1 passed"), "{level}: {text}");
    }
    Ok(())
}
