//! Distributions, and walks that they guide, where the answers are known.

use super::{Field, Guided, GuidedBsdf, Quadtree};
use crate::bsdf::check::check;
use crate::bsdf::{
    Bsdf, Dielectric, Ggx, Lambert, Mirror, Mixture, Model, Reflectance, RoughConductor,
    RoughDielectric, TransportMode,
};
use crate::endpoint::PinholeCamera;
use crate::film::{Contribution, FilmSample, Sample};
use crate::geometry::{Sphere, SurfacePoint};
use crate::integrator::{Caller, Depth, Integrator, PathTracer, PathTracing, Run, Stage};
use crate::math::Rgb;
use crate::math::statistics::chi_square;
use crate::path::Scratch;
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::{Emission, Material, World, WorldBuilder};
use glam::{DVec2, DVec3, UVec2};
use std::f64::consts::PI;

/// Numbers without an order, a quarter of them 0.
fn random(cell: DVec2) -> f64 {
    let x = (cell.dot(DVec2::new(12.9898, 78.233)).sin() * 43_758.545_3).fract().abs();
    if x < 0.25 { 0.0 } else { x }
}

fn sampler(seed: u64) -> impl Sampler {
    Independent { seed }.sampler(0, 0)
}

#[test]
fn directions_follow_their_density() {
    const SIDE: usize = 32;
    let tree = Quadtree::of(5, &random);
    let area = 4.0 * PI / (SIDE * SIDE) as f64;
    let at = |x: f64, y: f64| {
        let (sin, cos) = (2.0 * PI * (x - 0.5)).sin_cos();
        let z = 2.0 * y - 1.0;
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    };
    let middle = |i: usize| (i as f64 + 0.5) / SIDE as f64;
    let samples = 400_000;
    let expected: Vec<f64> = (0..SIDE * SIDE)
        .map(|i| tree.density(at(middle(i % SIDE), middle(i / SIDE))).value() * area)
        .collect();
    assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let (mut observed, mut sampler) = (vec![0.0; SIDE * SIDE], sampler(1));
    for _ in 0..samples {
        let w = tree.sample(sampler.next_2d());
        assert!(tree.density(w).value() > 0.0 && (w.length() - 1.0).abs() < 1e-15);
        let x = (0.5 + w.y.atan2(w.x) / (2.0 * PI)) * SIDE as f64;
        let y = (0.5 + 0.5 * w.z) * SIDE as f64;
        observed[x as usize + SIDE * y as usize] += 1.0;
    }
    let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(samples)).collect();
    let test = chi_square(&observed, &expected, 5.0);
    assert!(test.p_value > 1e-3, "{test:?}");
}

fn models() -> Vec<(&'static str, Box<dyn Bsdf>)> {
    let lambert = Lambert::new(Rgb::new(0.8, 0.5, 0.2)).unwrap();
    let mirror = Mirror::new(Rgb::splat(0.9)).unwrap();
    let ggx = Ggx::new(0.4, 0.4).unwrap();
    let metal = RoughConductor::new(Reflectance::Constant(Rgb::splat(0.9)), ggx);
    let glass = Dielectric::new(1.5).unwrap();
    let both = |a, b| Mixture::new([a, b], [0.4, 0.5]).unwrap();
    vec![
        ("lambert", Box::new(lambert)),
        ("metal", Box::new(metal)),
        ("frosted", Box::new(RoughDielectric::new(1.5, Ggx::new(0.5, 0.5).unwrap()).unwrap())),
        ("glass", Box::new(glass)),
        ("lambert and mirror", Box::new(both(Model::Lambert(lambert), Model::Mirror(mirror)))),
        ("glass and metal", Box::new(both(Model::Dielectric(glass), Model::RoughConductor(metal)))),
    ]
}

const FIXED: [DVec3; 3] = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, -0.8)];
const MODES: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

/// Samples, densities in both directions, Dirac lobes and the albedo.
#[test]
fn guided_bsdfs_pass_the_check() {
    // Cells whose edges are those of the cells of the check.
    let field = Field::of(Quadtree::of(2, &random));
    let point = SurfacePoint::on_surface(DVec3::ZERO, 0.0, DVec3::Z);
    let models = models();
    let checks = models.len() * FIXED.len() * MODES.len();
    for (name, model) in models {
        let bsdf = GuidedBsdf::new(&*model, &point, &field, 0.3);
        for mode in MODES {
            for fixed in FIXED {
                let report = check(&bsdf, fixed, mode, &mut sampler(2), 100_000);
                report
                    .verdict(0.001, checks)
                    .unwrap_or_else(|e| panic!("{name} {fixed} {mode:?}: {e}"));
            }
        }
    }
}

#[test]
fn densities_are_the_same_to_the_bit_and_bound_the_weights() {
    let field = Field::of(Quadtree::of(5, &random));
    let normal = DVec3::new(0.36, 0.48, -0.8);
    let point = SurfacePoint::on_surface(DVec3::ONE, 0.0, normal);
    for (name, model) in models() {
        let bsdf = GuidedBsdf::new(&*model, &point, &field, 0.5);
        let mut sampler = sampler(3);
        for _ in 0..20_000 {
            let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
            let Some(sample) = bsdf.sample(FIXED[1], TransportMode::Radiance, u1, u2) else {
                continue;
            };
            if sample.dirac {
                continue;
            }
            let pdf = bsdf.pdf(FIXED[1], sample.next, TransportMode::Radiance);
            assert_eq!(pdf.value().to_bits(), sample.pdf.value().to_bits(), "{name}");
            // No more than the model's own over α.
            let plain = model.pdf(FIXED[1], sample.next, TransportMode::Radiance).value();
            assert!(plain <= 2.0 * pdf.value() * (1.0 + 1e-12), "{name}");
        }
    }
}

/// Samples are those of the model to the bit where nothing is known, or α is 1.
#[test]
fn nothing_is_guided_where_nothing_is_known() {
    let point = SurfacePoint::on_surface(DVec3::ZERO, 0.0, DVec3::Z);
    let (unknown, known) = (Field::unknown(), Field::of(Quadtree::of(3, &random)));
    for (name, model) in models() {
        for (field, alpha) in [(&unknown, 0.5), (&known, 1.0)] {
            let bsdf = GuidedBsdf::new(&*model, &point, field, alpha);
            let mut sampler = sampler(4);
            for _ in 0..1000 {
                let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
                for mode in MODES {
                    let plain = model.sample(FIXED[1], mode, u1, u2);
                    assert_eq!(bsdf.sample(FIXED[1], mode, u1, u2), plain, "{name}");
                }
            }
        }
    }
    for alpha in [0.0, -0.5, 1.5, f64::NAN] {
        assert!(Guided::new(&cap_sphere(0.8), &unknown, alpha).is_none());
    }
}

/// The inside of a unit sphere of albedo 1/2 whose cap above a height emits radiance 1.
fn cap_sphere(height: f64) -> World {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let sphere = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    builder.add_sphere("wall", Sphere { cos_max: height, ..sphere }, grey).unwrap();
    let cap = builder.add_sphere("cap", Sphere { cos_min: height, ..sphere }, grey).unwrap();
    builder.set_emission(cap, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    builder.build().unwrap()
}

/// Values of single samples by hits alone, of paths with one scattering event, at the pole opposite
/// to the cap.
fn values(world: &World, field: &Field, alpha: f64, samples: u32) -> Vec<f64> {
    let size = UVec2::ONE;
    let camera = PinholeCamera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1e-4, size).unwrap();
    let scene = Guided::new(world, field, alpha).unwrap();
    let mode = PathTracing::EmissionOnly;
    let tracer = PathTracer { mode, depth: Depth::exactly(1), ..PathTracer::default() };
    let run = Integrator::start(&tracer, Stage::new(&scene, &camera), &Caller).unwrap();
    let samples = (0..samples).map(|i| Sample {
        film: FilmSample { raster: DVec2::splat(0.5), ..FilmSample::default() },
        sampler: Independent { seed: 5 }.sampler(0, i),
    });
    let mut samples: Vec<_> = samples.collect();
    let mut values = vec![0.0; samples.len()];
    let sink = &mut |i: usize, c: &Contribution| values[i] += c.value.g() * c.weight;
    run.draw(&mut samples, sink, &mut (), &mut Scratch::default());
    values
}

/// The variance for a field that is uniform on the cap, over (ρ Le)²: `f / (α + (1 - α)/f) - f²`
/// with the cap's part f of the area.
#[test]
fn a_field_of_the_light_alone_has_the_exact_variance() {
    const LEVELS: u32 = 10;
    let edge = 998.0 / 1024.0;
    // The cosine under which the pole sees the cap's edge, and the part that the cap is.
    let cos: f64 = 2.0 * edge - 1.0;
    let part = 1.0 - cos * cos;
    let world = cap_sphere(2.0 * cos * cos - 1.0);
    // Uniform by area on the cap is uniform per projected solid angle at the pole.
    let light = |cell: DVec2| if cell.y > edge { 2.0 * cell.y - 1.0 } else { 0.0 };
    let field = Field::of(Quadtree::of(LEVELS, &light));
    let samples = 400_000;
    for alpha in [1.0, 0.5, 0.25, 1e-9] {
        let values = values(&world, &field, alpha, samples);
        let n = f64::from(samples);
        let mean = values.iter().sum::<f64>() / n;
        let moment = |k| values.iter().map(|x| (x - mean).powi(k)).sum::<f64>() / n;
        let (variance, fourth) = (moment(2) / 0.25, moment(4) / 0.0625);
        let exact = part / (alpha + (1.0 - alpha) / part) - part * part;
        let error = ((fourth - variance * variance) / n).sqrt();
        // The cells that the density is constant in leave a ten-thousandth.
        let tolerance = 4.0 * error + 1e-4 * part * part;
        assert!((variance - exact).abs() < tolerance, "{alpha}: {variance} ± {error}, not {exact}");
        assert!(error < 0.01 * exact + 1e-4 * part * part);
        let error = 0.5 * (variance / n).sqrt();
        assert!((mean - 0.5 * part).abs() < 4.0 * error + 1e-4 * part, "{alpha}: {mean}");
    }
}

/// Records of one direction alone, at points along a line.
fn narrow(direction: DVec3) -> Field {
    let mut field = Field::unknown();
    for _ in 0..8 {
        let records: Vec<_> = (0..4096)
            .map(|i| {
                let point = DVec3::X * f64::from(i);
                field.record(point, direction, 1.0, [1.0, 1e-3], 0.5).unwrap()
            })
            .collect();
        field.learn(&records);
        field.update();
    }
    field
}

#[test]
fn one_direction_alone_has_a_finite_density() {
    let direction = DVec3::new(0.48, -0.6, 0.64);
    let field = narrow(direction);
    assert!(field.known() > 1);
    let tree = field.at(DVec3::ZERO).unwrap();
    assert_eq!(tree.density(direction).value(), 4f64.powi(20) * 0.25 / PI);
    assert_eq!(tree.density(DVec3::Z).value(), 0.0);
    let mut sampler = sampler(6);
    for _ in 0..1000 {
        let w = tree.sample(sampler.next_2d());
        assert!(w.distance(direction) < 1e-5 && tree.density(w).value() >= 0.0);
    }
}

#[test]
fn what_is_no_number_is_not_learnt() {
    let mut field = Field::unknown();
    let record = |energy, pdfs| field.record(DVec3::ZERO, DVec3::Z, energy, pdfs, 0.5);
    assert!(record(f64::NAN, [1.0; 2]).is_none() && record(f64::INFINITY, [1.0; 2]).is_none());
    // Records without energy leave nothing to know.
    let records = [record(0.0, [1.0; 2]).unwrap(); 100];
    field.learn(&records);
    field.update();
    assert!(field.at(DVec3::ZERO).is_none() && field.known() == 0);
}

/// A part of space that knows of the wrong directions leaves the mean as it is: at the cap's pole,
/// within 4 standard errors, by a field of one direction and by one that has no order.
#[test]
fn the_mean_does_not_depend_on_the_field() {
    let world = cap_sphere(0.8);
    let fields = [narrow(DVec3::NEG_Z), narrow(DVec3::X), Field::of(Quadtree::of(4, &random))];
    for field in &fields {
        let values = values(&world, field, 0.8, 2_000_000);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        let error = (variance / n).sqrt();
        assert!((mean - 0.05).abs() < 4.0 * error && error < 0.0025 * 0.05, "{mean} ± {error}");
    }
}
