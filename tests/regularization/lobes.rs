//! Mollified lobes by themselves: chi-square, reciprocity, what they scatter, extreme directions.

use crate::models::smooth_models;
use crate::quadrature::over_disc;
use glam::{DMat2, DVec2, DVec3};
use pathspace::bsdf::check::{Report, check};
use pathspace::bsdf::{
    Bsdf, BsdfSample, Conductor, Dielectric, Lobes, Mirror, Null, TransportMode,
};
use pathspace::math::Rgb;
use pathspace::math::statistics::{chi_square, sidak};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::RegularizedBsdf;
use std::f64::consts::TAU;

const MODES: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

fn direction(z: f64, phi: f64) -> DVec3 {
    let sine = ((1.0 - z) * (1.0 + z)).sqrt();
    DVec3::new(sine * phi.cos(), sine * phi.sin(), z)
}

fn regularized<B: Bsdf>(bsdf: B, epsilon: f64) -> RegularizedBsdf<B> {
    RegularizedBsdf::new(bsdf, epsilon).expect("a valid radius")
}

fn mirror() -> Mirror {
    Mirror::new(Rgb::WHITE).expect("valid")
}

fn glass() -> Dielectric {
    Dielectric::new(1.5).expect("valid")
}

fn images(bsdf: &(impl Bsdf + ?Sized), fixed: DVec3, mode: TransportMode) -> Vec<BsdfSample> {
    let mut images = Vec::new();
    bsdf.dirac_images(fixed, mode, &mut |image| images.push(image));
    images
}

/// A walk from a fixed direction, on both sides of a surface.
fn cases(cosines: &[f64]) -> Vec<(DVec3, TransportMode)> {
    let sides = cosines.iter().flat_map(|&z| [direction(z, 0.4), direction(-z, 2.5)]);
    sides.flat_map(|fixed| MODES.map(|mode| (fixed, mode))).collect()
}

/// Slopes by the law of refraction: around an image, on the side of the smaller index.
struct Slopes {
    /// The index on the image's side over the smaller one.
    index: f64,
    side: f64,
}

impl Slopes {
    fn around(image: &BsdfSample) -> Self {
        Self { index: image.relative_ior.max(1.0), side: image.next.z.signum() }
    }

    fn of(&self, direction: DVec3) -> Option<DVec2> {
        let bent = direction.truncate() * self.index;
        let cosine = (1.0 - bent.length_squared()).sqrt();
        (direction.z * self.side > 0.0 && cosine > 0.0).then(|| bent / cosine)
    }

    fn direction(&self, slope: DVec2) -> DVec3 {
        let tangential = slope.extend(1.0).normalize().truncate() / self.index;
        tangential.extend(self.side * (1.0 - tangential.length_squared()).sqrt())
    }

    /// dσ⊥ per area of slopes.
    fn jacobian(&self, slope: DVec2) -> f64 {
        let h = 1e-5 * (1.0 + slope.length());
        let along = |axis: DVec2| {
            let at = |sign: f64| self.direction(slope + axis * (sign * h)).truncate();
            (at(1.0) - at(-1.0)) / (2.0 * h)
        };
        DMat2::from_cols(along(DVec2::X), along(DVec2::Y)).determinant().abs()
    }
}

const RINGS: usize = 3;
const TURNS: usize = 6;

/// The cell of a place in the unit disc, all of the same area.
fn cell(place: DVec2) -> Option<usize> {
    let ring = (place.length_squared() * RINGS as f64) as usize;
    let turn = (place.y.atan2(place.x).rem_euclid(TAU) / TAU * TURNS as f64) as usize;
    (ring < RINGS).then_some(ring * TURNS + turn.min(TURNS - 1))
}

/// The middle of a cell.
fn middle(cell: usize) -> DVec2 {
    let radius = (((cell / TURNS) as f64 + 0.5) / RINGS as f64).sqrt();
    DVec2::from_angle(((cell % TURNS) as f64 + 0.5) * TAU / TURNS as f64) * radius
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// A sample's own figures, against the model's answers.
fn assert_consistent(model: &impl Bsdf, fixed: DVec3, mode: TransportMode, sample: &BsdfSample) {
    let (to_light, to_camera) = mode.label(fixed, sample.next);
    let value = model.eval(to_light, to_camera);
    let pdf = model.pdf(fixed, sample.next, mode).value();
    let reverse = model.pdf(sample.next, fixed, mode.reversed()).value();
    assert!(!sample.dirac && (sample.next.length() - 1.0).abs() < 1e-15);
    let errors = [relative(sample.pdf.value(), pdf), relative(sample.pdf_reverse.value(), reverse)];
    for c in 0..3 {
        let weight = relative(sample.weight[c] * sample.pdf.value(), value[c]);
        assert!(errors.into_iter().fold(weight, f64::max) < 1e-12, "{fixed} {sample:?} {value:?}");
    }
}

/// Around every image, the density is the image's probability over the disc, and samples fall there
/// by it. The cells of the test are those of equal shares but for finite lobes.
#[test]
fn samples_follow_the_density_at_every_radius() {
    const SAMPLES: u32 = 4000;
    let (models, cases) = (smooth_models(), cases(&[1.0, 0.7, 0.02]));
    let radii = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
    let level = sidak(0.01, models.len() * cases.len() * radii.len());
    for (name, inner) in &models {
        for (&epsilon, &(fixed, mode)) in
            radii.iter().flat_map(|e| cases.iter().map(move |c| (e, c)))
        {
            let what = || format!("{name} at {fixed} on a {mode:?} walk, radius {epsilon:e}");
            let (inner, model) = (&**inner, regularized(&**inner, epsilon));
            let images = images(inner, fixed, mode);
            let found = |next: DVec3| {
                images.iter().enumerate().find_map(|(number, image)| {
                    let slopes = Slopes::around(image);
                    let place = (slopes.of(next)? - slopes.of(image.next)?) / epsilon;
                    cell(place).map(|cell| number * RINGS * TURNS + cell)
                })
            };
            let cells = images.len() * RINGS * TURNS;
            let (mut observed, mut expected) = (vec![0.0; cells + 1], vec![0.0; cells + 1]);
            for (number, image) in images.iter().enumerate() {
                let slopes = Slopes::around(image);
                let center = slopes.of(image.next).expect("a slope");
                let mut mollified = 0.0;
                for cell in 0..RINGS * TURNS {
                    let z = center + middle(cell) * epsilon;
                    let (next, area) = (slopes.direction(z), TAU / 2.0 * epsilon * epsilon);
                    let measure = slopes.jacobian(z) * area / (RINGS * TURNS) as f64;
                    let [whole, rest] =
                        [model.pdf(fixed, next, mode), inner.pdf(fixed, next, mode)]
                            .map(|pdf| pdf.value() * measure);
                    expected[number * RINGS * TURNS + cell] = whole * f64::from(SAMPLES);
                    mollified += whole - rest;
                }
                let probability = image.dirac_probability(mode);
                assert!(relative(mollified, probability) < 1e-5, "{}: {mollified}", what());
            }
            let mut sampler = Independent { seed: 7 }.sampler(0, 0);
            for _ in 0..SAMPLES {
                let sample = model.sample(fixed, mode, sampler.next_1d(), sampler.next_2d());
                observed[sample.and_then(|sample| found(sample.next)).unwrap_or(cells)] += 1.0;
                sample.iter().for_each(|sample| assert_consistent(&model, fixed, mode, sample));
            }
            let inside: f64 = expected.iter().sum();
            let rest = f64::from(SAMPLES) - inside;
            expected[cells] = if rest > 1e-4 * f64::from(SAMPLES) { rest } else { 0.0 };
            let test = chi_square(&observed, &expected, 5.0);
            assert!(test.p_value > level, "{}: {test:?}", what());
        }
    }
}

/// The integrals of `check` have no more than two digits where a density jumps, and f is reciprocal
/// for mirrors alone.
#[test]
fn every_smooth_model_passes_the_checks_of_a_bsdf() {
    for (number, (name, model)) in smooth_models().iter().enumerate() {
        let model = regularized(&**model, 0.3);
        assert!(!model.lobes().intersects(Lobes::DIRAC), "{name}");
        for (fixed, mode) in cases(&[0.7]) {
            let mut sampler = Independent { seed: number as u64 }.sampler(0, 0);
            let report = check(&model, fixed, mode, &mut sampler, 5000);
            let Report { asymmetry, albedo, .. } = report;
            let what = format!("{name} at {fixed} on a {mode:?} walk: {report:?}");
            let exact = [
                report.weight_error,
                report.pdf_error,
                report.pdf_reverse_error,
                report.image_error,
            ];
            assert!(report.invalid == 0 && exact.into_iter().all(|e| e < 1e-12), "{what}");
            assert!((report.pdf_integral - report.finite_share.mean()).abs() < 0.03, "{what}");
            assert!(name != "mirror" || asymmetry < 1e-12, "{what}");
            // ε²/16 is the most that a disc may add.
            let most = 1.0 + 0.3 * 0.3 / 16.0;
            let is_camera = mode == TransportMode::Radiance;
            assert!(
                !is_camera || albedo.iter().all(|a| a.mean() < most + 4.0 * a.standard_error()),
                "{what}"
            );
        }
    }
}

/// The light that a perfect mirror scatters, `(1 + z²)/ε² · [asinh((t + 1 - z²)/2z)]` from t = 0 to ε² with
/// the slope z: 1 + O(ε²) at all angles.
#[test]
fn a_white_mirror_is_white_up_to_the_square_of_the_radius() {
    for epsilon in [1.0, 0.3, 0.1, 0.01, 1e-3] {
        let model = regularized(mirror(), epsilon);
        for cosine in [1.0, 0.9, 0.7, 0.5, 0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-6] {
            let fixed = direction(cosine, 1.0);
            let z: f64 = fixed.truncate().length() / cosine;
            let [image] = images(&mirror(), fixed, TransportMode::Radiance)[..] else { panic!() };
            let slopes = Slopes::around(&image);
            let center = -fixed.truncate() / cosine;
            let kappa = 1.0 / (TAU / 2.0 * epsilon * epsilon);
            let albedo = over_disc(epsilon, |offset| {
                let next = slopes.direction(center + offset);
                let next = next.with_z(1.0 / (1.0 + (center + offset).length_squared()).sqrt());
                model.eval(next, fixed).g() * next.z.powi(4) / kappa
            });
            let change = 0.5 * epsilon * epsilon * (z * z - 1.0) / (1.0 + z * z).powi(2);
            assert!((albedo - 1.0).abs() <= 0.5 * epsilon * epsilon, "{epsilon} {cosine} {albedo}");
            assert!(
                (albedo - 1.0 - change).abs() <= 0.4 * epsilon.powi(4) + 1e-9,
                "{epsilon} {cosine} {albedo} {change}"
            );
            if epsilon >= 0.1 && (0.1..1.0).contains(&cosine) {
                let at = |t: f64| ((t + 1.0 - z * z) / (2.0 * z)).asinh();
                let exact = (1.0 + z * z) / (epsilon * epsilon) * (at(epsilon * epsilon) - at(0.0));
                assert!(relative(albedo, exact) < 1e-6, "{epsilon} {cosine} {albedo} {exact}");
            }
        }
    }
}

/// The mean weight with refraction's n² taken out, by a grid over both random numbers of the disc.
fn albedo(model: &impl Bsdf, fixed: DVec3, mode: TransportMode) -> f64 {
    const SIDE: u32 = 48;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let mut sum = 0.0;
    // Which lobe is taken needs many steps where one is rare.
    for lobe in 0..SIDE {
        let mut sampler = Independent { seed: u64::from(lobe) }.sampler(0, 0);
        for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
            let u1 = (f64::from(lobe) + sampler.next_1d()) / f64::from(SIDE);
            let Some(sample) = model.sample(fixed, mode, u1, DVec2::new(at(i), at(j))) else {
                continue;
            };
            let squared =
                if mode == TransportMode::Radiance { sample.relative_ior.powi(2) } else { 1.0 };
            sum += sample.weight.g() * squared;
        }
    }
    sum / f64::from(SIDE * SIDE * SIDE)
}

/// White glass from both sides, to the horizon and around the critical angle, for walks from the
/// camera; those from a light meet other reflectances there.
#[test]
fn white_glass_is_white_up_to_the_square_of_the_radius() {
    let critical = (1.0f64 - 1.0 / 2.25).sqrt();
    let cosines = [
        1.0,
        0.6,
        0.1,
        1e-2,
        1e-4,
        critical + 1e-2,
        critical + 1e-4,
        critical + 1e-7,
        critical - 1e-4,
    ];
    for epsilon in [0.2, 0.1, 0.05] {
        let model = regularized(glass(), epsilon);
        for (fixed, mode) in cases(&cosines).into_iter().filter(|c| c.1 == MODES[0]) {
            let off = (albedo(&model, fixed, mode) - 1.0).abs();
            println!("{epsilon} {fixed} {mode:?} {off:e}");
            assert!(off <= 0.8 * epsilon * epsilon, "{epsilon} {fixed} {mode:?}: {off:e}");
        }
    }
}

/// The radius of 1e-9, at the horizon and at the critical angle: finite samples, which agree with
/// the model's answers as far as the direction has digits for the disc.
#[test]
fn extreme_directions_and_radii_give_finite_numbers() {
    let critical = (1.0f64 - 1.0 / 2.25).sqrt();
    let cosines =
        [1.0, 1e-3, 1e-6, 1e-12, 1e-30, 1e-100, critical, critical + 1e-15, critical + 1e-9];
    let conductor = Conductor::new(Rgb::splat(0.2), Rgb::splat(3.0)).expect("valid");
    let models: [&dyn Bsdf; 4] = [&mirror(), &glass(), &conductor, &Null];
    for (model, epsilon) in models.iter().flat_map(|m| [1.0, 1e-3, 1e-7, 1e-9].map(|e| (m, e))) {
        let model = regularized(*model, epsilon);
        for (fixed, mode) in cases(&cosines) {
            let mut sampler = Independent { seed: 3 }.sampler(0, 0);
            let mut found = 0;
            for _ in 0..200 {
                let u = sampler.next_2d();
                let Some(sample) = model.sample(fixed, mode, sampler.next_1d(), u) else {
                    continue;
                };
                let numbers = [sample.pdf.value(), sample.pdf_reverse.value(), sample.weight.g()];
                assert!(numbers.into_iter().all(f64::is_finite), "{epsilon:e} {fixed} {sample:?}");
                // Where light from below all comes back, a light walk may have taken R of the normal.
                let most = if mode == TransportMode::Radiance { 5.0 } else { 30.0 };
                assert!(sample.weight.g() < most, "{epsilon:e} {fixed} {sample:?}");
                found += 1;
            }
            if fixed.z.abs() > 1e-5 && epsilon > 1e-8 {
                assert!(found > 195, "{epsilon:e} {fixed} {mode:?} {found}");
            }
        }
    }
}

/// But for what the images of both ends have as values, f/n² is symmetric.
#[test]
fn the_shape_of_a_lobe_is_reciprocal() {
    let (inner, mut sampler) = (glass(), Independent { seed: 5 }.sampler(0, 0));
    for epsilon in [0.3, 1e-2, 1e-5] {
        let model = regularized(inner, epsilon);
        let mut pairs = 0;
        for (to_camera, mode) in
            cases(&[0.9, 0.8, 0.3, 0.05]).into_iter().filter(|c| c.1 == MODES[0])
        {
            for _ in 0..50 {
                let u = sampler.next_2d();
                let Some(sample) = model.sample(to_camera, mode, sampler.next_1d(), u) else {
                    continue;
                };
                let to_light = sample.next;
                let is_reflected = to_light.z * to_camera.z > 0.0;
                // R or T, the same from both sides.
                let share = |fixed: DVec3| {
                    let is_same =
                        |image: &BsdfSample| (image.next.z * fixed.z > 0.0) == is_reflected;
                    let image = images(&inner, fixed, mode).into_iter().find(is_same);
                    image.map(|image| image.dirac_probability(mode))
                };
                let [Some(there), Some(back)] = [to_camera, to_light].map(share) else { continue };
                let squeeze = sample.relative_ior.powi(2);
                let forwards = model.eval(to_light, to_camera).g() / there;
                let backwards = model.eval(to_camera, to_light).g() / back;
                assert!(relative(forwards * squeeze, backwards) < 1e-9, "{epsilon} {sample:?}");
                pairs += 1;
            }
        }
        assert!(pairs > 350, "{pairs}");
    }
}

#[test]
fn radii_out_of_range_are_refused() {
    for epsilon in [0.0, -1.0, 1.5, f64::NAN, f64::INFINITY] {
        let error = RegularizedBsdf::new(mirror(), epsilon).expect_err("an invalid radius");
        assert!(error.to_string().contains("(0, 1]"), "{error}");
    }
}
