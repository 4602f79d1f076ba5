//! Every scattering model against its own density, its reciprocity, its energy and the exact answers.

use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::check::{Failure, Report, check, directional_albedo};
use pathspace::bsdf::fresnel::Reflectance;
use pathspace::bsdf::*;
use pathspace::math::statistics::Estimate;
use pathspace::math::{PerProjected, Rgb};
use pathspace::sampler::Sampler;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

struct Independent(Pcg64Mcg);

impl Independent {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }
}

impl Sampler for Independent {
    fn next_1d(&mut self) -> f64 {
        self.0.random()
    }
}

const COSINES: [f64; 4] = [1.0, 0.7, 0.2, 0.01];
const ROUGHNESS: [(f64, f64); 4] = [(0.05, 0.05), (0.3, 0.3), (1.0, 1.0), (0.1, 0.5)];

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
}

fn lambert() -> SimpleModel {
    Lambert::new(Rgb::new(0.2, 0.5, 0.9)).unwrap().into()
}

fn glass(relative_ior: f64) -> SimpleModel {
    Dielectric::new(relative_ior).unwrap().into()
}

fn gold() -> Reflectance {
    Reflectance::conductor(Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6)).unwrap()
}

fn rough_conductor(alpha: (f64, f64)) -> SimpleModel {
    RoughConductor::new(gold(), Ggx::new(alpha.0, alpha.1).unwrap()).into()
}

fn rough_glass(relative_ior: f64, alpha: (f64, f64)) -> SimpleModel {
    RoughDielectric::new(relative_ior, Ggx::new(alpha.0, alpha.1).unwrap()).unwrap().into()
}

fn beckmann(alpha: (f64, f64)) -> Beckmann {
    Beckmann::new(alpha.0, alpha.1).unwrap()
}

fn plastic(specular: Rgb, colour_shift: bool) -> SimpleModel {
    Plastic::new(Rgb::new(0.2, 0.5, 0.9), specular, 1.5, colour_shift).unwrap().into()
}

fn metallic_roughness(metalness: f64, roughness: f64) -> SimpleModel {
    MetallicRoughness::new(Rgb::new(0.2, 0.5, 0.9), metalness, roughness, 1.5).unwrap().into()
}

fn pane() -> SimpleModel {
    ThinDielectric::new(1.5).unwrap().into()
}

fn smooth_models() -> Vec<(String, Model)> {
    let mirror: SimpleModel = Mirror::new(Rgb::new(0.3, 0.6, 1.0)).unwrap().into();
    let conductor: SimpleModel = Conductor::new(Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6)).unwrap().into();
    let mixture = |components, weights| Mixture::new(components, weights).unwrap();
    let rough = rough_conductor((0.3, 0.3));
    let probabilities = Mixture::with_probabilities([glass(1.5), rough_glass(1.5, (0.3, 0.2))], [0.6, 0.4], [3.0, 1.0]).unwrap();
    [
        ("lambert", lambert().into()),
        ("mirror", mirror.into()),
        ("conductor", conductor.into()),
        ("glass 1.5", glass(1.5).into()),
        ("glass 1/1.33", glass(1.0 / 1.33).into()),
        ("glass 1", glass(1.0).into()),
        ("null", Null.into()),
        ("black", Model::BLACK),
        ("pane", pane().into()),
        ("smooth metallic-roughness", metallic_roughness(0.3, 0.0).into()),
        ("smooth metallic-roughness metal", metallic_roughness(1.0, 0.005).into()),
        ("smooth metallic-roughness + mirror", mixture([metallic_roughness(0.3, 0.0), mirror], [0.5, 0.5]).into()),
        ("plastic", plastic(Rgb::WHITE, false).into()),
        ("saturated plastic", plastic(Rgb::new(0.5, 1.0, 0.0), true).into()),
        ("plastic + pane", mixture([plastic(Rgb::WHITE, true), pane()], [0.5, 0.5]).into()),
        ("tinted conductor", Mixture::tinted([conductor], [Rgb::new(0.0, 0.3, 1.0)], [1.0]).unwrap().into()),
        ("tinted mixture", Mixture::tinted([lambert(), rough], [Rgb::new(0.0, 0.3, 1.0), Rgb::BLACK], [0.7, 0.2]).unwrap().into()),
        ("lambert + mirror", mixture([lambert(), mirror], [0.5, 0.5]).into()),
        ("lambert + glass", mixture([lambert(), glass(1.5)], [0.3, 0.7]).into()),
        ("lambert + rough", mixture([lambert(), rough], [0.6, 0.4]).into()),
        ("mirror + glass", mixture([mirror, glass(1.5)], [0.5, 0.25]).into()),
        ("null + conductor", mixture([Null.into(), conductor], [0.5, 0.5]).into()),
        ("glass + rough glass", probabilities.into()),
    ]
    .map(|(name, model)| (name.to_owned(), model))
    .into()
}

fn rough_models() -> Vec<(String, Model)> {
    let mut models = Vec::new();
    for alpha in ROUGHNESS {
        models.push((format!("rough conductor {alpha:?}"), rough_conductor(alpha).into()));
        models.push((format!("Beckmann conductor {alpha:?}"), SimpleModel::from(RoughConductor::new(gold(), beckmann(alpha))).into()));
        let glass = RoughDielectric::new(1.5, beckmann(alpha)).unwrap();
        models.push((format!("Beckmann glass {alpha:?}"), SimpleModel::from(glass).into()));
        if alpha.0 == alpha.1 {
            for metalness in [0.0, 0.4, 1.0] {
                models.push((format!("metallic-roughness {metalness} {alpha:?}"), metallic_roughness(metalness, alpha.0.sqrt()).into()));
            }
        }
        // from both sides, so that the inverse indices are covered
        for relative_ior in [1.5, 1.05] {
            models.push((format!("rough glass {relative_ior} {alpha:?}"), rough_glass(relative_ior, alpha).into()));
        }
    }
    models
}

/// Fixed directions on both sides of the surface with a walk.
fn cases() -> impl Iterator<Item = (DVec3, Walk)> + Clone {
    let walks = [Walk::Camera, Walk::Light];
    let sides = |cosine| [direction(cosine, 0.4), direction(cosine, 0.4) * DVec3::new(1.0, 1.0, -1.0)];
    COSINES.into_iter().flat_map(sides).flat_map(move |fixed| walks.map(|walk| (fixed, walk)))
}

/// Runs all checks at the level 1 % for all together.
fn check_all(models: &[(String, Model)], cases: impl Iterator<Item = (DVec3, Walk)> + Clone, samples: u32) {
    let checks = models.len() * cases.clone().count();
    for (index, (name, model)) in models.iter().enumerate() {
        for (fixed, walk) in cases.clone() {
            let report = check(model, fixed, walk, &mut Independent::new(index as u64 + 1), samples);
            let verdict = report.verdict(0.01, checks);
            assert_eq!(verdict, Ok(()), "{name} at {fixed} on a {walk:?} walk: {report:?}");
            assert!(report.pdf_error < 1e-10 && report.pdf_reverse_error < 1e-10, "{name} at {fixed} {walk:?}: {report:?}");
        }
    }
}

#[test]
fn smooth_models_and_mixtures_agree_with_themselves() {
    check_all(&smooth_models(), cases(), 20_000);
}

#[test]
fn rough_models_agree_with_themselves() {
    // alternating walks: their density is the same, and its quadrature takes the time
    let alternating = cases().enumerate().filter(|(k, (_, walk))| (*walk == Walk::Light) == (k / 4 % 2 == (k / 2) % 2));
    check_all(&rough_models(), alternating.map(|(_, case)| case), 20_000);
}

/// A model with one deliberate fault, which the check must find.
#[derive(Clone, Copy)]
enum Fault {
    Density,
    SampledDensity,
    Squeeze,
    Weight,
    Direction,
    Energy,
    Reverse,
}

struct Faulty(Model, Fault);

impl Bsdf for Faulty {
    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let value = self.0.eval(to_light, to_camera);
        match self.1 {
            // refraction without n_c²: 1.5 inside
            Fault::Squeeze if to_camera.z < 0.0 && to_light.z > 0.0 => value / 2.25,
            Fault::Energy => value * 1.2,
            _ => value,
        }
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected {
        let pdf = self.0.pdf(fixed, next, walk);
        if matches!(self.1, Fault::Density | Fault::SampledDensity) { pdf * 1.01 } else { pdf }
    }

    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let u2 = if matches!(self.1, Fault::Direction) { DVec2::new(u2.x, u2.y.powf(1.1)) } else { u2 };
        let mut sample = self.0.sample(fixed, walk, u1, u2)?;
        match self.1 {
            Fault::SampledDensity => {
                sample.pdf = sample.pdf * 1.01;
                sample.pdf_reverse = sample.pdf_reverse * 1.01;
                sample.weight = sample.weight / 1.01;
            }
            Fault::Weight => sample.weight *= 1.00001,
            Fault::Energy => sample.weight *= 1.2,
            Fault::Reverse => sample.pdf_reverse = sample.pdf,
            _ => {}
        }
        Some(sample)
    }
}

#[test]
fn faults_are_found() {
    let faults = |relative_ior: f64, fault: Fault, cosine: f64| -> Option<Failure> {
        let model = Faulty(rough_glass(relative_ior, (0.3, 0.3)).into(), fault);
        check(&model, direction(cosine, 0.4), Walk::Light, &mut Independent::new(1), 100_000).verdict(0.01, 1).err()
    };
    assert!(matches!(faults(1.5, Fault::Density, 0.7), Some(Failure::Pdf(_))));
    assert!(matches!(faults(1.5, Fault::SampledDensity, 0.7), Some(Failure::Density(_) | Failure::Normalization(_))));
    assert!(matches!(faults(1.5, Fault::Squeeze, 0.7), Some(Failure::Weight(_) | Failure::Reciprocity(_))));
    assert!(matches!(faults(1.5, Fault::Weight, 0.7), Some(Failure::Weight(_))));
    assert!(matches!(faults(1.5, Fault::Direction, 0.7), Some(Failure::Density(_))));
    assert!(matches!(faults(1.5, Fault::Energy, 0.7), Some(Failure::Energy(..))));
    assert!(matches!(faults(1.5, Fault::Reverse, 0.7), Some(Failure::PdfReverse(_))));
}

/// Smooth refraction without n² in the weight of a camera walk.
struct Unsqueezed(Dielectric);

impl Bsdf for Unsqueezed {
    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }
    fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }
    fn pdf(&self, _: DVec3, _: DVec3, _: Walk) -> PerProjected {
        PerProjected::ZERO
    }
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        self.0.sample(fixed, walk, u1, u2).map(|sample| BsdfSample { weight: Rgb::WHITE, ..sample })
    }
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        self.0.eval_dirac(to_light, to_camera)
    }
}

#[test]
fn missing_squeeze_of_smooth_glass_is_found() {
    let model = Unsqueezed(Dielectric::new(1.5).unwrap());
    let report = |walk| check(&model, direction(0.7, 0.0), walk, &mut Independent::new(1), 1000).verdict(0.01, 1);
    assert!(matches!(report(Walk::Camera), Err(Failure::Weight(_))));
    assert_eq!(report(Walk::Light), Ok(()));
}

/// Dirac coefficients of a refraction, against the definition of `DiracValue`.
#[test]
fn refraction_of_smooth_glass() {
    let glass = Dielectric::new(1.5).unwrap();
    let outside = direction(0.6, 1.1);
    for (fixed, walk) in [(outside, Walk::Camera), (outside, Walk::Light)] {
        let sample = glass.sample(fixed, walk, 1.0f64.next_down(), DVec2::ZERO).unwrap();
        let transmittance = fresnel::dielectric(0.6, 0.8, 1.5).transmittance;
        assert_relative_eq!(sample.next.truncate().length(), 0.8 / 1.5, max_relative = 1e-14);
        assert_eq!(sample.relative_ior, 1.5);
        let squeeze = if walk == Walk::Camera { 1.0 / 2.25 } else { 2.25 };
        let weight = if walk == Walk::Camera { squeeze } else { 1.0 };
        assert_relative_eq!(sample.weight.r(), weight, max_relative = 1e-14);
        let (pdf, reverse) = if walk == Walk::Camera { (1.0, squeeze) } else { (squeeze, 1.0) };
        assert_relative_eq!(sample.pdf.value(), transmittance * pdf, max_relative = 1e-14);
        assert_relative_eq!(sample.pdf_reverse.value(), transmittance * reverse, max_relative = 1e-14);
    }
    // n = 1 passes straight through, whatever the roughness
    for model in [Model::from(glass_of(1.0)), rough_glass(1.0, (0.5, 0.5)).into()] {
        let sample = model.sample(outside, Walk::Camera, 0.0, DVec2::splat(0.5)).unwrap();
        assert_eq!((sample.next, sample.weight, sample.dirac), (-outside, Rgb::WHITE, true));
        assert_eq!(model.lobes(), Lobes::DIRAC_TRANSMISSION);
    }
    // total reflection 1e-7 beyond the critical angle
    let angle = (1.0f64 / 1.5).asin() + 1e-7;
    let inside = DVec3::new(angle.sin(), 0.0, -angle.cos());
    let sample = glass.sample(inside, Walk::Camera, 1.0f64.next_down(), DVec2::ZERO).unwrap();
    assert_eq!((sample.pdf, sample.next), (PerProjected(1.0), DVec3::new(-inside.x, 0.0, inside.z)));
}

fn glass_of(relative_ior: f64) -> Dielectric {
    Dielectric::new(relative_ior).unwrap()
}

/// Single-scattering albedo of height-correlated GGX with R = 1, within 4 standard errors and 0.1 %.
#[test]
fn white_furnace_of_ggx() {
    let expected = [
        (0.1, [0.988_304_056_520_612, 0.969_204_984_411_689_5, 0.883_455_001_867_146_2]),
        (0.3, [0.877_358_415_788_612_7, 0.821_711_003_150_766_1, 0.888_803_659_233_124_8]),
        (0.5, [0.687_848_515_110_236_4, 0.698_250_696_927_548_4, 0.860_105_072_667_923]),
        (1.0, [0.306_852_819_440_054_7, 0.450_693_855_665_945_2, 0.760_210_472_720_163]),
    ];
    for (alpha, albedos) in expected {
        let model = RoughConductor::new(Reflectance::constant(Rgb::WHITE).unwrap(), Ggx::isotropic(alpha).unwrap());
        for (cosine, albedo) in [1.0, 0.5, 0.1].into_iter().zip(albedos) {
            for walk in [Walk::Camera, Walk::Light] {
                let estimate = stratified_albedo(&model, direction(cosine, 0.3), walk, 1);
                assert_relative_eq!(estimate.mean(), albedo, max_relative = 2e-3);
                assert!(estimate.z_score(albedo).abs() < 4.0, "α = {alpha}, μ = {cosine}: {estimate:?}");
                assert!(estimate.standard_error() < 1e-3 * albedo, "{}", estimate.standard_error() / albedo);
            }
        }
    }
}

/// Albedo from independent replications of a stratified grid, which makes the standard error small and honest.
fn stratified_albedo(bsdf: &impl Bsdf, fixed: DVec3, walk: Walk, seed: u64) -> Estimate {
    let mut sampler = Independent::new(seed);
    let n = 64;
    let replication = |sampler: &mut Independent| {
        let mut sum = 0.0;
        for i in 0..n * n {
            let corner = DVec2::new(f64::from(i % n), f64::from(i / n));
            let u2 = (corner + sampler.next_2d()) / f64::from(n);
            sum += bsdf.sample(fixed, walk, sampler.next_1d(), u2).map_or(0.0, |sample| {
                let squared = sample.relative_ior * sample.relative_ior;
                sample.weight.g() * if walk == Walk::Camera { squared } else { 1.0 }
            });
        }
        sum / f64::from(n * n)
    };
    (0..32).map(|_| replication(&mut sampler)).collect()
}

#[test]
fn rough_glass_loses_no_more_than_multiple_scattering() {
    for (alpha, loss) in [((0.05, 0.05), 0.01), ((0.3, 0.3), 0.2), ((0.1, 0.5), 0.25)] {
        for relative_ior in [1.5, 1.0 / 1.5] {
            for side in [1.0, -1.0] {
                for walk in [Walk::Camera, Walk::Light] {
                    let fixed = direction(0.7, 0.2) * DVec3::new(1.0, 1.0, side);
                    let [red, ..] = directional_albedo(&rough_glass(relative_ior, alpha), fixed, walk, &mut Independent::new(3), 20_000);
                    assert!(red.mean() <= 1.0 && red.mean() > 1.0 - loss, "α {alpha:?}, n {relative_ior}: {}", red.mean());
                }
            }
        }
    }
}

/// The albedo is the same on both sides of the threshold below which rough models are Dirac ones.
#[test]
fn roughness_threshold_is_continuous() {
    let (below, above) = (ggx::LEAST_ALPHA * (1.0 - 1e-9), ggx::LEAST_ALPHA * (1.0 + 1e-9));
    for cosine in [1.0, 0.5, 0.1, 0.01] {
        for walk in [Walk::Camera, Walk::Light] {
            for model in [|a: f64| rough_conductor((a, a)), |a: f64| rough_glass(1.5, (a, a))] {
                let (dirac, finite) = (model(below), model(above));
                assert!(!dirac.lobes().intersects(Lobes::FINITE) && !finite.lobes().intersects(Lobes::DIRAC));
                let fixed = direction(cosine, 0.7);
                let (a, b) = (stratified_albedo(&dirac, fixed, walk, 5), stratified_albedo(&finite, fixed, walk, 5));
                let error = (a.standard_error().powi(2) + b.standard_error().powi(2)).sqrt();
                assert!((a.mean() - b.mean()).abs() < 1e-3 * a.mean() + 4.0 * error, "μ = {cosine}: {} {}", a.mean(), b.mean());
                // the mirror limit: directions deviate by about α
                let (u1, u2) = (0.9, DVec2::new(0.3, 0.5));
                let (x, y) = (dirac.sample(fixed, walk, u1, u2).unwrap(), finite.sample(fixed, walk, u1, u2).unwrap());
                assert!((x.next - y.next).length() < 10.0 * above, "{x:?} {y:?}");
                assert_relative_eq!(x.weight.r(), y.weight.r(), max_relative = 2e-3 / cosine.sqrt());
            }
        }
    }
}

/// A sum with a mirror in both components is that mirror once, with the whole probability.
#[test]
fn coinciding_dirac_lobes_are_one() {
    let mirror: SimpleModel = Mirror::new(Rgb::splat(0.5)).unwrap().into();
    let mixture = Mixture::with_probabilities([mirror, mirror, lambert()], [0.4, 0.2, 0.4], [1.0, 2.0, 1.0]).unwrap();
    let fixed = direction(0.6, 0.1);
    for u1 in [0.1, 0.3, 0.7] {
        let sample = mixture.sample(fixed, Walk::Camera, u1, DVec2::splat(0.5)).unwrap();
        assert!(sample.dirac);
        assert_relative_eq!(sample.pdf.value(), 0.75, max_relative = 1e-14);
        assert_relative_eq!(sample.weight.r(), 0.3 / 0.75, max_relative = 1e-14);
    }
    // pdf and eval leave the Dirac lobes out, and keep the probability of the finite one
    assert_relative_eq!(mixture.pdf(fixed, fixed, Walk::Camera).value(), 0.25 / std::f64::consts::PI, max_relative = 1e-14);
    assert!(mixture.lobes().intersects(Lobes::DIRAC) && mixture.lobes().intersects(Lobes::FINITE));
}

#[test]
fn extreme_input_gives_finite_numbers() {
    let mut models = smooth_models();
    models.extend(rough_models());
    for alpha in [(1e-4, 1e-4), (1e-8, 1.0), (1e-4, 10.0), (1e-3, 1e-3)] {
        models.push((format!("rough conductor {alpha:?}"), rough_conductor(alpha).into()));
        for relative_ior in [1e-3, 1.0 - 1e-5, 1.0 + 1e-5, 100.0] {
            models.push((format!("rough glass {relative_ior} {alpha:?}"), rough_glass(relative_ior, alpha).into()));
        }
    }
    let one = 1.0f64.next_down();
    let cosines = [0.0, -0.0, 1e-300, 1e-16, 1e-12, 1e-8, 1e-3, 0.5, 1.0 - 1e-15, 1.0];
    let mut directions: Vec<DVec3> = cosines.iter().flat_map(|&c| [direction(c, 0.0), direction(c, 2.0)]).collect();
    directions.extend(directions.clone().iter().map(|&w| -w));
    for (name, model) in &models {
        for &fixed in &directions {
            for walk in [Walk::Camera, Walk::Light] {
                for &next in &directions {
                    let pdf = model.pdf(fixed, next, walk).value();
                    let value = model.eval(fixed, next);
                    let dirac = model.eval_dirac(fixed, next);
                    assert!(pdf.is_finite() && pdf >= 0.0, "{name} {fixed} {next}: pdf {pdf}");
                    assert!(value.is_finite() && dirac.value.is_finite(), "{name} {fixed} {next}: {value:?} {dirac:?}");
                }
                for u in [0.0, 1e-300, 0.5, one] {
                    for (x, y) in [(0.0, 0.0), (0.0, one), (one, 0.0), (one, one), (0.3, 0.7), (0.5, 0.5), (0.2, 1e-300)] {
                        let Some(sample) = model.sample(fixed, walk, u, DVec2::new(x, y)) else { continue };
                        let (pdf, reverse) = (sample.pdf.value(), sample.pdf_reverse.value());
                        assert!(sample.weight.is_finite() && pdf.is_finite() && reverse.is_finite(), "{name} {fixed}: {sample:?}");
                        assert!(pdf > 0.0 && sample.next.z != 0.0 && sample.next.is_normalized(), "{name} {fixed}: {sample:?}");
                        if !sample.dirac {
                            assert_relative_eq!(model.pdf(fixed, sample.next, walk).value(), pdf, max_relative = 1e-10);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn constructors_refuse_bad_parameters() {
    for bad in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(Lambert::new(Rgb::new(0.5, bad, 0.5)), Err(BsdfError::Reflectance(_))));
        assert!(matches!(Mirror::new(Rgb::splat(bad)), Err(BsdfError::Reflectance(_))));
    }
    for bad in [0.0, -1.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(Dielectric::new(bad), Err(BsdfError::RelativeIor(_))));
        assert!(RoughDielectric::new(bad, Ggx::isotropic(0.1).unwrap()).is_err());
    }
    assert!(matches!(Conductor::new(Rgb::WHITE, Rgb::splat(-1.0)), Err(BsdfError::ComplexIor(..))));
    for bad in [-0.1, 10.5, f64::NAN] {
        assert!(matches!(Ggx::new(0.1, bad), Err(BsdfError::Roughness(..))));
    }
    let pair = [lambert(), lambert()];
    assert!(Mixture::new(pair, [0.0, 0.0]).is_err());
    assert!(Mixture::new(pair, [0.5, -0.1]).is_err());
    assert!(Mixture::new(pair, [0.5, f64::NAN]).is_err());
    assert!(Mixture::with_probabilities(pair, [0.5, 0.5], [1.0, 0.0]).is_err());
    assert!(Mixture::with_probabilities(pair, [0.5, 0.0], [0.0, 0.0]).is_err());
    assert!(Mixture::<SimpleModel, 0>::new([], []).is_err());
    assert_eq!(Dielectric::new(0.0).unwrap_err().to_string(), "relative index of refraction must be in [1e-6, 1e6], but is 0");
}

#[test]
fn report_of_an_absorber_is_empty() {
    let report: Report = check(&Model::BLACK, DVec3::Z, Walk::Camera, &mut Independent::new(1), 100);
    assert_eq!((report.pdf_integral, report.finite_share.mean(), report.verdict(0.01, 1)), (0.0, 0.0, Ok(())));
}
