//! Clear coats: the formula, the base alone without a coat, the coat alone over black, and the
//! white furnace.

use crate::models::{rough_models, smooth_models};
use crate::{Independent, direction};
use approx::assert_relative_eq;
use glam::DVec2;
use pathspace::bsdf::check::check;
use pathspace::bsdf::{Bsdf, BsdfSample, Coated, Ggx, Lambert, Mirror, Model, TransportMode};
use pathspace::math::Rgb;

fn coated<B: Bsdf>(base: B, share: f64, roughness: f64) -> Coated<B> {
    Coated::new(base, share, roughness).expect("valid")
}

fn images(bsdf: &dyn Bsdf, cosine: f64) -> Vec<BsdfSample> {
    let mut images = Vec::new();
    bsdf.dirac_images(direction(cosine, 0.4), TransportMode::Radiance, &mut |image| {
        images.push(image);
    });
    images
}

/// F of the index 1.5.
fn fresnel(cosine: f64) -> f64 {
    0.04 + 0.96 * (1.0 - cosine).powi(5)
}

/// The factor of the base: that of the lower direction.
fn passing(share: f64, lower: f64) -> f64 {
    1.0 - share * (1.0 - 0.997 * (1.0 - fresnel(lower)))
}

#[test]
fn values_are_those_of_the_formula() {
    let (o, i) = (direction(0.8, 0.6), direction(0.3, 3.0));
    let h = (o + i).normalize();
    let ggx = Ggx::isotropic(0.36).expect("valid");
    let glossy = fresnel(o.dot(h)) * ggx.density(h) * ggx.correlation(o, i) / 2.0;
    let base = Lambert::new(Rgb::new(0.2, 0.5, 0.9)).expect("valid");
    for share in [0.4, 1.0] {
        let value = coated(base, share, 0.6).eval(i, o);
        let bare = coated(Model::Black, share, 0.6).eval(i, o);
        for c in 0..3 {
            let under = base.eval(i, o)[c] * passing(share, 0.3);
            assert_relative_eq!(value[c], share * glossy + under, max_relative = 1e-12);
            assert_relative_eq!(bare[c], share * glossy, max_relative = 1e-12);
        }
        let smooth = coated(base, share, 0.0);
        assert_relative_eq!(
            smooth.eval(i, o)[0],
            base.eval(i, o)[0] * passing(share, 0.3),
            max_relative = 1e-12
        );
        let [image] = images(&smooth, 0.3)[..] else { panic!("one image") };
        let value = image.dirac_value(TransportMode::Radiance).value;
        assert_relative_eq!(value[0], share * fresnel(0.3), max_relative = 1e-12);
        // Two mirrors in one direction.
        let mirror = Mirror::new(Rgb::splat(0.5)).expect("valid");
        let [image] = images(&coated(mirror, share, 0.0), 0.3)[..] else { panic!("one image") };
        let value = image.dirac_value(TransportMode::Radiance).value;
        let both = share * fresnel(0.3) + 0.5 * passing(share, 0.3);
        assert_relative_eq!(value[0], both, max_relative = 1e-12);
        assert_relative_eq!(image.pdf.value(), 1.0, max_relative = 1e-12);
    }
}

#[test]
fn without_a_coat_the_base_is_left_to_the_bit() {
    let mut models = smooth_models();
    models.extend(rough_models());
    for (name, model) in models {
        let bare = coated(&*model, 0.0, 0.3);
        assert_eq!(bare.lobes(), model.lobes(), "{name}");
        for (fixed, next) in [(0.8, 0.3), (0.2, -0.7), (-0.5, -0.1)] {
            let (fixed, next) = (direction(fixed, 0.4), direction(next, 2.0));
            assert_eq!(bare.eval(next, fixed), model.eval(next, fixed), "{name}");
            assert_eq!(bare.eval_and_pdf(next, fixed), model.eval_and_pdf(next, fixed), "{name}");
            for walk in [TransportMode::Radiance, TransportMode::Importance] {
                assert_eq!(bare.pdf(fixed, next, walk), model.pdf(fixed, next, walk), "{name}");
                for u in [0.1, 0.6, 0.9] {
                    let u2 = DVec2::new(u, 0.3);
                    let samples =
                        [&bare as &dyn Bsdf, &*model].map(|b| b.sample(fixed, walk, u, u2));
                    assert_eq!(samples[0], samples[1], "{name}");
                }
            }
        }
    }
}

/// The albedo of a coat alone, by the midpoint rule over what it samples.
fn albedo_of_coat(roughness: f64, cosine: f64) -> f64 {
    const N: u32 = 96;
    let coat = coated(Model::Black, 1.0, roughness);
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(N);
    let weight = |k: u32| {
        let u = DVec2::new(at(k / N), at(k % N));
        coat.sample(direction(cosine, 0.4), TransportMode::Radiance, 0.5, u)
    };
    let sum: f64 = (0..N * N).filter_map(weight).map(|sample| sample.weight.mean()).sum();
    sum / f64::from(N * N)
}

/// A white mirror under a coat reflects everything but for what κ leaves, and never more; nothing
/// can have more left of it, because it reflects into the same angle.
#[test]
fn white_bases_reflect_almost_everything_and_never_more() {
    let mirror = Mirror::new(Rgb::WHITE).expect("valid");
    let mut greatest: f64 = 0.0;
    for roughness in [0.0, 0.02, 0.1, 0.2, 0.3, 0.36, 0.387, 0.41, 0.5, 0.7, 1.0] {
        for k in 1..=25 {
            let cosine = f64::from(k) / 25.0;
            let coat = albedo_of_coat(roughness, cosine);
            for share in [0.3, 1.0] {
                let coat_of_share = if roughness < 0.01 { 0.0 } else { share * coat };
                let images = images(&coated(mirror, share, roughness), cosine);
                let mirrored = images[0].dirac_value(TransportMode::Radiance).value.mean();
                let albedo = coat_of_share + mirrored;
                greatest = greatest.max(albedo);
                assert!(albedo <= 1.0, "{share} {roughness} {cosine}: {albedo}");
            }
        }
    }
    assert!(greatest > 0.9985, "{greatest}");
}

/// A white diffuse base, whose albedo no quadrature of one direction gives.
#[test]
fn white_furnaces_gain_nothing() {
    let white = Lambert::new(Rgb::WHITE).expect("valid");
    for (roughness, cosine) in [(0.0, 0.9), (0.0, 0.1), (0.3, 0.9), (0.3, 0.1), (1.0, 0.5)] {
        for walk in [TransportMode::Radiance, TransportMode::Importance] {
            let coat = coated(white, 1.0, roughness);
            let report =
                check(&coat, direction(cosine, 0.4), walk, &mut Independent::new(7), 50_000);
            let albedo = report.albedo[0];
            let (mean, error) = (albedo.mean(), albedo.standard_error());
            // ∫ 2 μ T(min(μ, μ_o)) dμ, by the midpoint rule.
            let at = |k: u32| (f64::from(k) + 0.5) / 1e4;
            let lower = |k: u32| passing(1.0, cosine.min(at(k)));
            let under = (0..10_000).map(|k| 2.0 * at(k) * lower(k) / 1e4).sum::<f64>();
            let coat =
                if roughness == 0.0 { fresnel(cosine) } else { albedo_of_coat(roughness, cosine) };
            let expected = under + coat;
            assert!(expected <= 1.0, "{roughness} {cosine}: {expected}");
            assert!(error < 0.0025, "{roughness} {cosine}: {error}");
            assert!(
                (mean - expected).abs() < 4.0 * error,
                "{roughness} {cosine}: {mean} {expected}"
            );
        }
    }
}

#[test]
fn parameters_outside_of_their_range_are_refused() {
    for (share, roughness) in [(-0.1, 0.5), (1.1, 0.5), (0.5, 1.1), (f64::NAN, 0.5)] {
        assert!(Coated::new(Model::Black, share, roughness).is_err(), "{share} {roughness}");
    }
}
