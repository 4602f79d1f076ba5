//! Closed forms: variances, variance × rays, tails and slopes, measured as the report measures
//! them.

use super::common::SphereCap;
use super::square_light::{self, Variances};
use super::{Synthetic, against, cornell_box, exactly};
use pathspace::endpoint::PinholeCamera;
use pathspace::film::{Contribution, Sample, Sink, Technique};
use pathspace::geometry::{Disk, Quad};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{
    Bidirectional, Crew, Depth, Integrator, PathTracer, PathTracing, Run, Stage, Started,
    UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, Roulette, Scratch, Survival, TechniqueSet};
use pathspace::render::{Budget, Settings};
use pathspace::report::{Interval, Method, MethodReport, Plan};
use pathspace::sampler::Sampler;
use pathspace::scene::{Emission, Material, Scene, World, WorldBuilder};

/// The exact value is inside the interval of 95 %, widened to one that is left once in some
/// thousand tests.
fn assert_inside(name: &str, interval: Interval, exact: f64) {
    let (low, high) = (interval.value - interval.low, interval.high - interval.value);
    let inside = interval.value - 2.0 * low <= exact && exact <= interval.value + 2.0 * high;
    println!(
        "{name}: {:.4e} ({:.4e} … {:.4e}), exact {exact:.4e}",
        interval.value, interval.low, interval.high
    );
    assert!(inside, "{name}: {interval:?}, expected {exact}");
    assert!(high < 0.1 * exact, "{name}: {interval:?} is too wide to mean anything");
}

fn assert_unbiased(method: &MethodReport) {
    let bias = &method.bias;
    assert!(
        !bias.flagged && bias.mean.abs() < 4.0 * bias.mean_standard_error.max(1e-12),
        "{}: {bias:?}",
        method.name
    );
}

/// A small floor under a square light of radiance 1, seen in one point; one bounce.
fn square_light() -> (World, PinholeCamera) {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let black = builder.add_material("black", Material::Lambert { albedo: Rgb::BLACK }).unwrap();
    builder
        .add_disk("floor", Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 10.0 }, grey)
        .unwrap();
    let quad = Quad {
        origin: DVec3::new(-1.0, -1.0, 2.0),
        edge_u: DVec3::Y * 2.0,
        edge_v: DVec3::X * 2.0,
    };
    let lamp = builder.add_quad("lamp", quad, black).unwrap();
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    let camera = PinholeCamera::new(
        DVec3::new(0.0, -3.0, 1.0),
        DVec3::ZERO,
        DVec3::Z,
        1e-4,
        UVec2::new(32, 32),
    )
    .unwrap();
    (builder.build().unwrap(), camera)
}

/// Optimal weights (Kondapaneni et al. 2019) for one light sample a and one cosine sample c: with
/// the densities' share u = p_c/(p_a + p_c), which the balance heuristic's weights tell,
///
/// ```text
/// α_a + α_c + Σ (f/(p_a + p_c) - α_a (1 - u) - α_c u)
/// ```
///
/// over both samples. A cosine sample that misses the light has f = 0, u = 1.
#[derive(Debug)]
struct OptimalWeights {
    balance: PathTracer,
    alpha: [f64; 2],
}

/// A rendering by the balance heuristic, with optimal weights in place of its own.
struct Optimal<'a, R>(&'a OptimalWeights, R);

impl<S: Scene + ?Sized> Integrator<S> for OptimalWeights {
    type Run<'a>
        = Optimal<'a, <PathTracer as Integrator<S>>::Run<'a>>
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "optimal weights"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Self::Run<'a>> {
        Ok(Optimal(self, self.balance.start(stage, crew)?))
    }
}

impl<'a, S: Scene + ?Sized + 'a, R: Run<'a, S>> Run<'a, S> for Optimal<'a, R> {
    type Chunk = R::Chunk;

    fn techniques(&self) -> TechniqueSet {
        self.1.techniques()
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: &mut R::Chunk,
        scratch: &mut Scratch<'a, S>,
    ) {
        let mut all = vec![Vec::<Contribution>::new(); samples.len()];
        let mut keep = |number: usize, found: &Contribution| all[number].push(*found);
        self.1.draw(samples, &mut keep, chunk, scratch);
        let [a, c] = self.0.alpha;
        for (number, contributions) in all.into_iter().enumerate() {
            let hit = contributions.iter().any(|contribution| contribution.technique.s == 0);
            let mut total = if hit { a + c } else { a };
            for Contribution { value, weight, technique, .. } in contributions {
                let u = if technique.s == 0 { weight } else { 1.0 - weight };
                total += value.r() * weight - a * (1.0 - u) - c * u;
            }
            let raster = samples[number].film.raster;
            let (value, technique) = (Rgb::splat(total), Technique::new(1, 2));
            sink.add(number, &Contribution { raster, value, weight: 1.0, technique });
        }
    }
}

/// Variances of the estimators of light from a square, and variance × rays without
/// that of the camera.
#[test]
fn variances_on_the_square_light_are_the_exact_ones() {
    let (world, camera) = square_light();
    let one_bounce = |mode, heuristic| PathTracer {
        mode,
        heuristic,
        depth: Depth::exactly(1),
        roulette: Roulette::NEVER,
    };
    let light = one_bounce(PathTracing::NextEventOnly, Heuristic::Balance);
    let cosine = one_bounce(PathTracing::EmissionOnly, Heuristic::Balance);
    let balance = one_bounce(PathTracing::Both, Heuristic::Balance);
    let power = one_bounce(PathTracing::Both, Heuristic::Power(2.0));
    let exact = Variances::of(square_light::by_solid_angle());
    let optimal = OptimalWeights { balance, alpha: exact.alpha };
    let without_hits = TechniqueSet { next_event: true, ..TechniqueSet::NONE };
    let kernel = Bidirectional {
        techniques: without_hits,
        depth: Depth::exactly(1),
        roulette: Roulette::NEVER,
        heuristic: Heuristic::Balance,
    };
    let kernel_balance = Bidirectional {
        techniques: TechniqueSet { bsdf_sampling: true, ..without_hits },
        ..kernel
    };
    let methods: [(&str, &dyn Method<World>); 7] = [
        ("light", &light),
        ("cosine", &cosine),
        ("balance", &balance),
        ("power", &power),
        ("optimal", &optimal),
        ("bidirectional light", &kernel),
        ("bidirectional balance", &kernel_balance),
    ];
    let report = against(&world, &camera, &methods, 0.119_728_235_230_386_77, 16 * 32, 16);
    let Variances { light, cosine, balance, power, optimal, .. } = exact;
    let exact = [
        (light, 1.0),
        (cosine, 1.0),
        (balance, 2.0),
        (power, 2.0),
        (optimal, 2.0),
        (light, 1.0),
        (balance, 2.0),
    ];
    for (method, (variance, rays)) in report.methods.iter().zip(exact) {
        assert_inside(&method.name, method.variance_per_sample, variance);
        assert_eq!(method.rays_per_sample, 1.0 + rays, "{}", method.name);
        let Interval { value, low, high } = method.variance_times_rays;
        let [value, low, high] = [value, low, high].map(|x| x * rays / (1.0 + rays));
        assert_inside(
            &format!("{}, variance × rays", method.name),
            Interval { value, low, high },
            variance * rays,
        );
        assert_unbiased(method);
        let slope = &method.slopes[0];
        assert!(
            (slope.value.value + 1.0).abs() < 4.0 * slope.standard_error.max(0.01),
            "{}: {slope:?}",
            method.name
        );
        assert!(!method.infinite_variance, "{}: {:?}", method.name, method.tail);
        assert_eq!(method.non_finite_contributions, 0);
    }
    assert!(report.is_clean(), "{:?}", report.pairs);
    // Runs are paired.
    let speed_up = &report.methods[2].speed_up.unwrap().rays;
    assert_inside("speed-up in rays", *speed_up, light * 2.0 / (balance * 3.0));
}

/// Looks down into the sphere; all pixels have the same distribution.
fn down() -> PinholeCamera {
    PinholeCamera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 50.0, UVec2::new(32, 32)).unwrap()
}

/// A sphere with an emitting cap, a host's own scene: uniform-area sampling, next event estimation,
/// and both with hits in the balance and the power heuristic.
#[test]
fn variances_in_the_sphere_with_a_cap_are_the_exact_ones() {
    let (scene, camera) = (SphereCap::new(0.5, 0.1), down());
    for k in 1..=3 {
        let uniform = UniformArea { depth: Depth::exactly(k), roulette: Roulette::NEVER };
        let mean = 0.1 * 0.5f64.powi(k as i32);
        let report = against(&scene, &camera, &[("uniform area", &uniform)], mean, 32 * 8, 32);
        assert_inside(
            &format!("k = {k}"),
            report.methods[0].variance_per_sample,
            0.25f64.powi(k as i32) * 0.1 * 0.9,
        );
        assert_unbiased(&report.methods[0]);
    }
    let one_bounce = |mode, heuristic| PathTracer {
        mode,
        heuristic,
        depth: Depth::exactly(1),
        roulette: Roulette::NEVER,
    };
    let next_event = one_bounce(PathTracing::NextEventOnly, Heuristic::Balance);
    let report = against(&scene, &camera, &[("next event", &next_event)], 0.05, 64, 8);
    assert!(report.methods[0].variance_per_sample.value < 1e-24 && !report.methods[0].bias.flagged);
    let (balance, power) = (
        one_bounce(PathTracing::Both, Heuristic::Balance),
        one_bounce(PathTracing::Both, Heuristic::Power(2.0)),
    );
    let report =
        against(&scene, &camera, &[("balance", &balance), ("power", &power)], 0.05, 32 * 8, 32);
    for (method, exact) in
        report.methods.iter().zip([0.000_185_950_413_223_140_49, 2.205_666_111_165_572e-6])
    {
        assert_inside(&method.name, method.variance_per_sample, exact);
        assert_unbiased(method);
    }
}

fn emission_only(survival: Survival, depth: Depth) -> PathTracer {
    let roulette = Roulette { start: 0, survival, ..Roulette::default() };
    PathTracer { mode: PathTracing::EmissionOnly, roulette, depth, ..PathTracer::default() }
}

/// Roulette with survival p in the furnace, V = ρ² (1 - p) / ((1 - ρ)² (p - ρ²)). With p = 0.3
/// that is 14, but the fourth moment is infinite, so no number of samples measures it; cut off
/// after K events everything is finite: Σ r^k with r = ρ/p over k up to min(N, K), P(N ≥ k) = p^k.
#[test]
fn roulette_in_the_furnace_has_the_exact_variance() {
    const K: u32 = 6;
    let (albedo, p) = (0.5f64, 0.3f64);
    let power = |x: f64, k: u32| x.powi(k as i32);
    let pairs = (0..=K).flat_map(|i| (0..=K).map(move |j| (i, j)));
    let cut_mean: f64 = (0..=K).map(|k| power(albedo, k)).sum();
    let cut_variance =
        pairs.map(|(i, j)| power(albedo / p, i + j) * power(p, i.max(j))).sum::<f64>()
            - cut_mean * cut_mean;

    let (scene, camera) = (SphereCap::new(albedo, 1.0), down());
    let [half, more, whole] =
        [0.5, 0.75, p].map(|p| emission_only(Survival::Fixed(p), Depth::default()));
    let report = against(
        &scene,
        &camera,
        &[("0.5", &half), ("0.75", &more), ("0.3", &whole)],
        2.0,
        32 * 32,
        32,
    );
    for (method, exact) in report.methods.iter().zip([2.0, 0.5]) {
        assert_inside(&format!("p = {}", method.name), method.variance_per_sample, exact);
    }
    report.methods.iter().for_each(assert_unbiased);
    let cut = emission_only(Survival::Fixed(p), Depth::up_to(K));
    let report = against(&scene, &camera, &[("0.3, cut", &cut)], cut_mean, 32 * 32, 32);
    assert_inside("p = 0.3, cut", report.methods[0].variance_per_sample, cut_variance);
    assert_unbiased(&report.methods[0]);
}

/// The tail under survival capped at 0.95: in the furnace the weight grows by ρ/0.95 per event, and
/// so the tail index is ln(1/0.95)/ln(ρ/0.95).
#[test]
fn a_cap_on_survival_is_recognised_as_heavy_tailed() {
    const CAP: f64 = 0.95;
    let camera = down();
    let tail = |albedo: f64, survival, samples| {
        let (scene, tracer) =
            (SphereCap::new(albedo, 1.0), emission_only(survival, Depth::default()));
        let settings =
            Settings { budget: Budget::Samples(samples), seed: 5, ..Plan::default().settings };
        let reference = exactly(1.0 / (1.0 - albedo), UVec2::new(32, 32));
        tracer.probe(&scene, &camera, &settings, reference.image()).unwrap().tail.unwrap()
    };
    let cases = [
        (0.97, 2.461_989_077_167_264_6, 512),
        (0.99, 1.243_686_103_294_557_6, 128),
        (0.999, 1.019_893_512_627_473_7, 128),
    ];
    for (albedo, index, samples) in cases {
        let capped = tail(albedo, Survival::Fixed(CAP), samples);
        println!("albedo {albedo}: {capped:?}, exact {index:.4}");
        // The sum over a path has the tail of its last term from Σ r^k ≈ r^n r/(r - 1) on, which is
        // off by r^-n: 6 % for 0.97.
        assert!(
            (capped.index - index).abs() < 0.06 * index + 4.0 * capped.standard_error,
            "{albedo}: {capped:?}, expected {index}"
        );
        assert!(
            capped.standard_error < 0.1 * index && capped.is_infinite_variance() == (index < 2.0),
            "{albedo}: {capped:?}"
        );
        let uncapped = tail(albedo, Survival::Throughput, 8);
        assert!(uncapped.index > 3.0, "{albedo}: {uncapped:?}");
    }

    let scene = SphereCap::new(0.99, 1.0);
    let (capped, uncapped) = (
        emission_only(Survival::Fixed(CAP), Depth::default()),
        emission_only(Survival::Throughput, Depth::default()),
    );
    let report =
        against(&scene, &camera, &[("uncapped", &uncapped), ("capped", &capped)], 100.0, 8 * 14, 8);
    let [honest, heavy] = [&report.methods[0], &report.methods[1]];
    assert!(
        heavy.infinite_variance && heavy.speed_up.is_none() && heavy.time_to_target.is_none(),
        "{:?}",
        heavy.tail
    );
    assert_eq!(heavy.slopes[0].measure, "MedSE");
    assert!(
        report.verdicts().iter().any(|v| v.starts_with("Heavy tail: the variance of capped")),
        "{:?}",
        report.verdicts()
    );
    assert!(
        !honest.infinite_variance && honest.speed_up.is_some() && honest.slopes[0].measure == "MSE"
    );
    assert_unbiased(honest);
}

/// The roulette formula with a constant c, as an integrator.
#[test]
fn roulette_with_a_constant_has_the_exact_variance() {
    let box_ = cornell_box(32);
    let roulette = |c: f64| {
        Synthetic(move |s: &mut dyn Sampler| {
            let (xi, u) = (s.next_1d(), s.next_1d());
            Roulette::apply(0.4, c, xi, || 0.5 + (3.0 * 0.04f64).sqrt() * (2.0 * u - 1.0))
        })
    };
    let (some, none, best) = (roulette(0.3), roulette(0.0), roulette(0.5));
    let report = against(
        &box_.world,
        &*box_.camera,
        &[("0.3", &some), ("0", &none), ("0.5", &best)],
        0.5,
        8 * 64,
        8,
    );
    for (method, exact) in report.methods.iter().zip([
        0.093_333_333_333_333_34,
        0.233_333_333_333_333_34,
        0.066_666_666_666_666_67,
    ]) {
        assert_inside(&method.name, method.variance_per_sample, exact);
    }
}

/// Two unit squares at a right angle; the geometry term of uniform points has the tail index
/// 3/2, and errors fall as N^(-1/3).
#[test]
fn the_corner_is_recognised_as_heavy_tailed() {
    let corner = Synthetic(|s: &mut dyn Sampler| {
        let (a, b) = (s.next_2d(), s.next_2d());
        let difference = DVec3::new(a.x, a.y, 0.0) - DVec3::new(0.0, b.x, b.y);
        let r2 = difference.length_squared();
        if r2 > 0.0 { a.x * b.y / (r2 * r2) } else { 0.0 }
    });
    let box_ = cornell_box(32);
    let report = against(
        &box_.world,
        &*box_.camera,
        &[("corner", &corner)],
        0.628_456_057_314_848_2,
        8 * 1024,
        8,
    );
    let method = &report.methods[0];
    let tail = method.tail.unwrap();
    assert!(
        (tail.index - 1.5).abs() < 4.0 * tail.standard_error && tail.standard_error < 0.15,
        "{tail:?}"
    );
    assert!(method.infinite_variance && method.speed_up.is_none());
    let slope = &method.slopes[0];
    assert_eq!(slope.measure, "MedSE");
    assert!((slope.value.value + 2.0 / 3.0).abs() < 0.05 + 2.0 * slope.standard_error, "{slope:?}");
}
