//! Exact answers: coefficients of smooth glass and of coinciding mirrors, albedos, and the limit of
//! small roughness.

use crate::models::{lambert, rough_conductor, rough_glass};
use crate::{Independent, direction};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::check::directional_albedo;
use pathspace::bsdf::fresnel::Reflectance;
use pathspace::bsdf::*;
use pathspace::math::statistics::Estimate;
use pathspace::math::{PerProjected, Rgb};
use pathspace::sampler::Sampler;

/// Dirac coefficients of a refraction, against the definition of `DiracValue`.
#[test]
fn refraction_of_smooth_glass() {
    let glass = Dielectric::new(1.5).unwrap();
    let outside = direction(0.6, 1.1);
    for (fixed, mode) in [(outside, TransportMode::Radiance), (outside, TransportMode::Importance)]
    {
        let sample = glass.sample(fixed, mode, 1.0f64.next_down(), DVec2::ZERO).unwrap();
        let transmittance = fresnel::dielectric(0.6, 0.8, 1.5).transmittance;
        assert_relative_eq!(sample.next.truncate().length(), 0.8 / 1.5, max_relative = 1e-14);
        assert_eq!(sample.relative_ior, 1.5);
        let squeeze = if mode == TransportMode::Radiance { 1.0 / 2.25 } else { 2.25 };
        let weight = if mode == TransportMode::Radiance { squeeze } else { 1.0 };
        assert_relative_eq!(sample.weight.r(), weight, max_relative = 1e-14);
        let (pdf, reverse) =
            if mode == TransportMode::Radiance { (1.0, squeeze) } else { (squeeze, 1.0) };
        assert_relative_eq!(sample.pdf.value(), transmittance * pdf, max_relative = 1e-14);
        assert_relative_eq!(
            sample.pdf_reverse.value(),
            transmittance * reverse,
            max_relative = 1e-14
        );
    }
    // n = 1 passes straight through, whatever the roughness
    for model in [Model::from(glass_of(1.0)), rough_glass(1.0, (0.5, 0.5))] {
        let sample =
            model.sample(outside, TransportMode::Radiance, 0.0, DVec2::splat(0.5)).unwrap();
        assert_eq!((sample.next, sample.weight, sample.dirac), (-outside, Rgb::WHITE, true));
        assert_eq!(model.lobes(), Lobes::DIRAC_TRANSMISSION);
    }
    // total reflection 1e-7 beyond the critical angle
    let angle = (1.0f64 / 1.5).asin() + 1e-7;
    let inside = DVec3::new(angle.sin(), 0.0, -angle.cos());
    let sample =
        glass.sample(inside, TransportMode::Radiance, 1.0f64.next_down(), DVec2::ZERO).unwrap();
    assert_eq!(
        (sample.pdf, sample.next),
        (PerProjected(1.0), DVec3::new(-inside.x, 0.0, inside.z))
    );
}

fn glass_of(relative_ior: f64) -> Dielectric {
    Dielectric::new(relative_ior).unwrap()
}

/// Single-scattering albedo of height-correlated GGX with R = 1, within 4 standard errors and 0.1
/// %.
#[test]
fn white_furnace_of_ggx() {
    let expected = [
        (0.1, [0.988_304_056_520_612, 0.969_204_984_411_689_5, 0.883_455_001_867_146_2]),
        (0.3, [0.877_358_415_788_612_7, 0.821_711_003_150_766_1, 0.888_803_659_233_124_8]),
        (0.5, [0.687_848_515_110_236_4, 0.698_250_696_927_548_4, 0.860_105_072_667_923]),
        (1.0, [0.306_852_819_440_054_7, 0.450_693_855_665_945_2, 0.760_210_472_720_163]),
    ];
    for (alpha, albedos) in expected {
        let model = RoughConductor::new(
            Reflectance::constant(Rgb::WHITE).unwrap(),
            Ggx::isotropic(alpha).unwrap(),
        );
        for (cosine, albedo) in [1.0, 0.5, 0.1].into_iter().zip(albedos) {
            for mode in [TransportMode::Radiance, TransportMode::Importance] {
                let estimate = stratified_albedo(&model, direction(cosine, 0.3), mode, 1);
                assert_relative_eq!(estimate.mean(), albedo, max_relative = 2e-3);
                assert!(
                    estimate.z_score(albedo).abs() < 4.0,
                    "α = {alpha}, μ = {cosine}: {estimate:?}"
                );
                assert!(
                    estimate.standard_error() < 1e-3 * albedo,
                    "{}",
                    estimate.standard_error() / albedo
                );
            }
        }
    }
}

/// Albedo from independent replications of a stratified grid, which makes the standard error small
/// and honest.
fn stratified_albedo(bsdf: &impl Bsdf, fixed: DVec3, mode: TransportMode, seed: u64) -> Estimate {
    let mut sampler = Independent::new(seed);
    let n = 64;
    let replication = |sampler: &mut Independent| {
        let mut sum = 0.0;
        for i in 0..n * n {
            let corner = DVec2::new(f64::from(i % n), f64::from(i / n));
            let u2 = (corner + sampler.next_2d()) / f64::from(n);
            sum += bsdf.sample(fixed, mode, sampler.next_1d(), u2).map_or(0.0, |sample| {
                let squared = sample.relative_ior * sample.relative_ior;
                sample.weight.g() * if mode == TransportMode::Radiance { squared } else { 1.0 }
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
                for mode in [TransportMode::Radiance, TransportMode::Importance] {
                    let fixed = direction(0.7, 0.2) * DVec3::new(1.0, 1.0, side);
                    let [red, ..] = directional_albedo(
                        &rough_glass(relative_ior, alpha),
                        fixed,
                        mode,
                        &mut Independent::new(3),
                        20_000,
                    );
                    assert!(
                        red.mean() <= 1.0 && red.mean() > 1.0 - loss,
                        "α {alpha:?}, n {relative_ior}: {}",
                        red.mean()
                    );
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
        for mode in [TransportMode::Radiance, TransportMode::Importance] {
            for model in [|a: f64| rough_conductor((a, a)), |a: f64| rough_glass(1.5, (a, a))] {
                let (dirac, finite) = (model(below), model(above));
                assert!(
                    !dirac.lobes().intersects(Lobes::FINITE)
                        && !finite.lobes().intersects(Lobes::DIRAC)
                );
                let fixed = direction(cosine, 0.7);
                let (a, b) = (
                    stratified_albedo(&dirac, fixed, mode, 5),
                    stratified_albedo(&finite, fixed, mode, 5),
                );
                let error = (a.standard_error().powi(2) + b.standard_error().powi(2)).sqrt();
                assert!(
                    (a.mean() - b.mean()).abs() < 1e-3 * a.mean() + 4.0 * error,
                    "μ = {cosine}: {} {}",
                    a.mean(),
                    b.mean()
                );
                // the mirror limit: directions deviate by about α
                let (u1, u2) = (0.9, DVec2::new(0.3, 0.5));
                let (x, y) = (
                    dirac.sample(fixed, mode, u1, u2).unwrap(),
                    finite.sample(fixed, mode, u1, u2).unwrap(),
                );
                assert!((x.next - y.next).length() < 10.0 * above, "{x:?} {y:?}");
                assert_relative_eq!(
                    x.weight.r(),
                    y.weight.r(),
                    max_relative = 2e-3 / cosine.sqrt()
                );
            }
        }
    }
}

/// A sum with a mirror in both components is that mirror once, with the whole probability.
#[test]
fn coinciding_dirac_lobes_are_one() {
    let mirror: Model = Mirror::new(Rgb::splat(0.5)).unwrap().into();
    let mixture =
        Mixture::with_probabilities([mirror, mirror, lambert()], [0.4, 0.2, 0.4], [1.0, 2.0, 1.0])
            .unwrap();
    let fixed = direction(0.6, 0.1);
    for u1 in [0.1, 0.3, 0.7] {
        let sample = mixture.sample(fixed, TransportMode::Radiance, u1, DVec2::splat(0.5)).unwrap();
        assert!(sample.dirac);
        assert_relative_eq!(sample.pdf.value(), 0.75, max_relative = 1e-14);
        assert_relative_eq!(sample.weight.r(), 0.3 / 0.75, max_relative = 1e-14);
    }
    // pdf and eval leave the Dirac lobes out, and keep the probability of the finite one
    assert_relative_eq!(
        mixture.pdf(fixed, fixed, TransportMode::Radiance).value(),
        0.25 / std::f64::consts::PI,
        max_relative = 1e-14
    );
    assert!(mixture.lobes().intersects(Lobes::DIRAC) && mixture.lobes().intersects(Lobes::FINITE));
}

/// The albedos that the documentation of the principled BSDF names, within 0.3 %.
#[test]
fn principled_surfaces_reflect_what_is_said() {
    let albedo = |base: f64, roughness: f64, cosine: f64| {
        let lobes = PrincipledLobes::default();
        let model = Principled::new(Rgb::splat(base), 0.0, roughness, lobes).unwrap();
        stratified_albedo(&model, direction(cosine, 0.3), TransportMode::Radiance, 1).mean()
    };
    let mut grazing: f64 = 0.0;
    for roughness in [0.1, 0.3, 0.5, 0.8, 1.0] {
        let normal = albedo(1.0, roughness, 1.0);
        assert!((1.018..1.052).contains(&normal), "{roughness}: {normal}");
        grazing = grazing.max(albedo(1.0, roughness, 0.05));
        for cosine in [0.3, 0.5, 0.7, 1.0] {
            let grey = albedo(0.8, roughness, cosine);
            assert!(grey < 1.0, "{roughness} {cosine}: {grey}");
        }
    }
    assert!((1.49..1.52).contains(&grazing), "{grazing}");
}
