//! The cost of a host that says at compile time what its scene needs (one concrete BSDF, lights
//! that can be hit, no environment, nothing Dirac), beside the same host that says it needs
//! everything, and one behind `dyn`.
//!
//! `LEAVE_OUT_HOST=constant valgrind --tool=callgrind target/release/deps/leave_out-…` counts
//! instructions of one of them (`constant`, `everything`, `dyn`) instead;
//! `LEAVE_OUT_INTEGRATOR=bidirectional` of the other integrator.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{DownCamera, Random, SphereCap, film_sample};
use criterion::{Criterion, Throughput};
use glam::DVec3;
use pathspace::bsdf::Bsdf;
use pathspace::endpoint::{Light, LightId};
use pathspace::film::{Contribution, Sink};
use pathspace::geometry::SurfacePoint;
use pathspace::integrator::{Bidirectional, Caller, Integrator, PathTracer, Run, Stage, WithNeeds};
use pathspace::math::Rgb;
use pathspace::path::Scratch;
use pathspace::scene::{Needs, Scene};
use std::hint::black_box;

const SAMPLES: u32 = 20_000;

/// The sphere with an emissive cap, which says what it needs by a constant.
struct Constant(SphereCap);

/// The same behind a dynamic BSDF, which says it needs everything.
struct Dynamic(SphereCap, common::Lambertian);

macro_rules! host {
    ($host:ty, $life:lifetime, $bsdf:ty, $short:ty, $make:expr, $needs:expr) => {
        impl Scene for $host {
            type Bsdf<$life> = $bsdf;
            type Light = dyn Light;
            #[inline]
            fn intersect(&self, from: &SurfacePoint, w: DVec3) -> Option<SurfacePoint> {
                self.0.intersect(from, w)
            }
            #[inline]
            fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
                self.0.visible(a, b)
            }
            #[inline]
            fn bsdf(&self, _: &SurfacePoint) -> $short {
                let make: fn(&Self) -> $short = $make;
                make(self)
            }
            #[inline]
            fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
                self.0.light_at(x)
            }
            fn light(&self, id: LightId) -> &Self::Light {
                self.0.light(id)
            }
            fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
                self.0.pick_light(u)
            }
            fn pick_pmf(&self, id: LightId) -> f64 {
                self.0.pick_pmf(id)
            }
            #[inline]
            fn needs(&self) -> Needs {
                $needs
            }
        }
    };
}

const NEEDED: Needs = Needs::HITTABLE_LIGHTS
    .union(Needs::CONNECTIBLE_LIGHTS)
    .union(Needs::FINITE_LOBES)
    .union(Needs::ILLUMINATION)
    .union(Needs::INTERREFLECTION);

host!(
    Constant,
    'a,
    common::Lambertian,
    common::Lambertian,
    |host| common::Lambertian { albedo: host.0.albedo, is_opaque: true },
    NEEDED
);
host!(Dynamic, 'a, &'a dyn Bsdf, &dyn Bsdf, |host| &host.1, Needs::ALL);

#[derive(Default)]
struct Sum(Rgb);

impl Sink for Sum {
    fn add(&mut self, _sample: usize, contribution: &Contribution) {
        self.0 += contribution.value * contribution.weight;
    }
}

fn run<S: Scene, I: Integrator<S>>(scene: &S, integrator: &I) -> Rgb {
    let camera = DownCamera { half_width: 1.0 };
    let (mut sampler, mut scratch, mut sum) = (Random::new(1), Scratch::default(), Sum::default());
    let run = integrator.start(Stage::new(scene, &camera), &Caller).expect("a run");
    for _ in 0..SAMPLES {
        let film = film_sample(&mut sampler);
        run.sample(film, &mut sampler, &mut sum, &mut scratch);
    }
    sum.0
}

fn main() {
    let cap = || SphereCap::new(0.5, 0.1);
    let (constant, dynamic, plain) = (
        Constant(cap()),
        Dynamic(cap(), common::Lambertian { albedo: 0.5, is_opaque: true }),
        cap(),
    );
    let (path, both) = (PathTracer::up_to(4), Bidirectional::up_to(4));
    if let Ok(host) = std::env::var("LEAVE_OUT_HOST") {
        let bidirectional =
            std::env::var("LEAVE_OUT_INTEGRATOR").is_ok_and(|name| name == "bidirectional");
        black_box(match (host.as_str(), bidirectional) {
            ("constant", false) => run(&constant, &path),
            ("everything", false) => run(&plain, &WithNeeds::all(path)),
            (_, false) => run(&dynamic, &path),
            ("constant", true) => run(&constant, &both),
            ("everything", true) => run(&plain, &WithNeeds::all(both)),
            (_, true) => run(&dynamic, &both),
        });
        return;
    }
    let mut criterion = Criterion::default().configure_from_args();
    let mut group = criterion.benchmark_group("host");
    group.throughput(Throughput::Elements(u64::from(SAMPLES))).sample_size(10);
    group.bench_function("path-tracing, constant needs", |b| b.iter(|| run(&constant, &path)));
    group.bench_function("path-tracing, everything", |b| {
        b.iter(|| run(&plain, &WithNeeds::all(path)))
    });
    group.bench_function("path-tracing, dyn BSDF, everything", |b| b.iter(|| run(&dynamic, &path)));
    group.bench_function("bidirectional, constant needs", |b| b.iter(|| run(&constant, &both)));
    group.bench_function("bidirectional, everything", |b| {
        b.iter(|| run(&plain, &WithNeeds::all(both)))
    });
    group
        .bench_function("bidirectional, dyn BSDF, everything", |b| b.iter(|| run(&dynamic, &both)));
    group.finish();
    criterion.final_summary();
}
