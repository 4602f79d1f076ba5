//! The Dirac lobes that a model lists are those that it samples, and it lists them alike from both
//! ends.

use crate::direction;
use crate::models::smooth_models;
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::*;
use pathspace::math::Rgb;

const WALKS: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

/// Directions on both sides, one of them beyond the critical angle of glass.
fn directions() -> impl Iterator<Item = DVec3> {
    let sides = |cosine| [direction(cosine, 0.4), -direction(cosine, 0.4)];
    [1.0, 0.8, 0.2, 0.01].into_iter().flat_map(sides)
}

fn images(bsdf: &dyn Bsdf, fixed: DVec3, mode: TransportMode) -> Vec<BsdfSample> {
    let mut images = Vec::new();
    bsdf.dirac_images(fixed, mode, &mut |image| images.push(image));
    images
}

/// The share of the power that a Dirac sample scatters, refraction's n² taken out.
fn power(image: &BsdfSample, mode: TransportMode) -> Rgb {
    let n_squared = image.relative_ior * image.relative_ior;
    image.weight * if mode == TransportMode::Radiance { n_squared } else { 1.0 }
}

/// Over equidistant u1 the share of an image among the samples is its probability up to the two
/// ends of each interval that chooses it; no mixture here has more than four of them.
#[test]
fn samples_are_the_images_with_their_probabilities() {
    const N: u32 = 20_000;
    for (name, model) in smooth_models() {
        for (fixed, mode) in directions().flat_map(|fixed| WALKS.map(|mode| (fixed, mode))) {
            let images = images(&*model, fixed, mode);
            let kinds = model.lobes();
            assert!(images.len() <= 3, "{name}");
            assert!(images.is_empty() || kinds.intersects(Lobes::DIRAC), "{name}");
            let mut counts = vec![0u32; images.len()];
            for i in 0..N {
                let u1 = (f64::from(i) + 0.5) / f64::from(N);
                let sample = model.sample(fixed, mode, u1, DVec2::new(0.3, 0.6));
                let Some(sample) = sample.filter(|sample| sample.dirac) else { continue };
                let found = images.iter().position(|image| image.next == sample.next);
                let found = found.unwrap_or_else(|| panic!("{name}: {sample:?} in {images:?}"));
                counts[found] += 1;
                let image = images[found];
                assert_eq!(image.relative_ior, sample.relative_ior, "{name}");
                let pairs = [
                    (image.pdf.value(), sample.pdf.value()),
                    (image.pdf_reverse.value(), sample.pdf_reverse.value()),
                    (image.weight[0], sample.weight[0]),
                    (image.weight[1], sample.weight[1]),
                    (image.weight[2], sample.weight[2]),
                ];
                for (a, b) in pairs {
                    assert_relative_eq!(a, b, max_relative = 1e-13);
                }
            }
            for (image, count) in images.iter().zip(counts) {
                let probability = image.dirac_probability(mode);
                assert!(probability > 0.0 && image.dirac && image.next.is_normalized(), "{name}");
                let share = f64::from(count) / f64::from(N);
                assert!(
                    (share - probability).abs() <= 4.0 / f64::from(N),
                    "{name} from {fixed} on a {mode:?} mode: {share} of {image:?}"
                );
            }
        }
    }
}

/// Models that absorb nothing and have no other lobes.
#[test]
fn images_of_clear_models_sum_to_one() {
    let clear = ["glass 1.5", "glass 1/1.33", "glass 1", "null", "pane"];
    let mut seen = 0;
    for (_, model) in smooth_models().into_iter().filter(|(n, _)| clear.contains(&&**n)) {
        for (fixed, mode) in directions().flat_map(|fixed| WALKS.map(|mode| (fixed, mode))) {
            let images = images(&*model, fixed, mode);
            let probability: f64 = images.iter().map(|image| image.dirac_probability(mode)).sum();
            let albedo: Rgb =
                images.iter().map(|i| power(i, mode) * i.dirac_probability(mode)).sum();
            assert_relative_eq!(probability, 1.0, max_relative = 1e-12);
            assert_relative_eq!(albedo.mean(), 1.0, max_relative = 1e-12);
        }
        seen += 1;
    }
    assert_eq!(seen, clear.len());
}

/// The albedo of what has Dirac lobes alone is the sum over its images, against known reflectances.
#[test]
fn images_carry_the_reflectance() {
    let mirror = Mirror::new(Rgb::new(0.3, 0.6, 1.0)).unwrap();
    let (eta, k) = (Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6));
    let conductor = Conductor::new(eta, k).unwrap();
    for fixed in directions() {
        let (cosine, sine) = (fixed.z.abs(), fixed.truncate().length());
        let metal: [f64; 3] =
            std::array::from_fn(|c| fresnel::conductor(cosine, sine, eta[c], k[c]));
        let cases: [(&dyn Bsdf, Rgb); 2] =
            [(&mirror, Rgb::new(0.3, 0.6, 1.0)), (&conductor, Rgb(metal))];
        for ((bsdf, expected), mode) in cases.into_iter().flat_map(|case| WALKS.map(|w| (case, w)))
        {
            let [image] = images(bsdf, fixed, mode)[..] else { panic!("one image") };
            assert_eq!(image.next, DVec3::new(-fixed.x, -fixed.y, fixed.z));
            (0..3).for_each(|c| {
                assert_relative_eq!(
                    (image.weight * image.dirac_probability(mode))[c],
                    expected[c],
                    max_relative = 1e-12
                );
            });
        }
    }
}

/// Listed from its image, a direction is an image with the same coefficients; and a pair that was
/// rounded has them, too.
#[test]
fn images_are_reversible() {
    let mut refractions = 0;
    for (name, model) in smooth_models() {
        for (fixed, mode) in directions().flat_map(|fixed| WALKS.map(|mode| (fixed, mode))) {
            for image in images(&*model, fixed, mode) {
                let there = image.dirac_value(mode);
                let back = images(&*model, image.next, mode.reversed());
                let back = back
                    .iter()
                    .find(|back| back.next.distance(fixed) < 1e-12)
                    .unwrap_or_else(|| panic!("{name} from {fixed}: {image:?}, {back:?}"));
                assert_relative_eq!(
                    back.relative_ior,
                    1.0 / image.relative_ior,
                    max_relative = 1e-14
                );
                refractions += usize::from(image.relative_ior != 1.0);
                let rounded = (image.next + DVec3::new(1e-9, -1e-9, 0.0)).normalize();
                let (to_light, to_camera) = mode.label(fixed, rounded);
                let close = model.eval_dirac(to_light, to_camera);
                for (value, tolerance) in
                    [(back.dirac_value(mode.reversed()), 1e-10), (close, 1e-5)]
                {
                    let close_to = |a: f64, b: f64| {
                        assert!(
                            (a - b).abs() <= tolerance * a.abs().max(b.abs()),
                            "{name} from {fixed} on a {mode:?} mode: {there:?}, {value:?}"
                        );
                    };
                    (0..3).for_each(|c| close_to(there.value[c], value.value[c]));
                    close_to(there.pdf_to_light.value(), value.pdf_to_light.value());
                    close_to(there.pdf_to_camera.value(), value.pdf_to_camera.value());
                }
            }
        }
    }
    assert!(refractions > 50, "{refractions}");
}

/// A shading normal changes densities and weights of an image as it does those of a sample.
#[test]
fn images_at_a_surface_point_are_its_samples() {
    use pathspace::bsdf::shading::ShadedBsdf;
    use pathspace::geometry::SurfacePoint;
    let flat = SurfacePoint::on_surface(DVec3::ZERO, 0.0, DVec3::new(0.1, -0.2, 1.0).normalize());
    let point = SurfacePoint { shading_normal: DVec3::new(0.3, 0.1, 1.0).normalize(), ..flat };
    let mut refused = 0;
    for (name, model) in smooth_models() {
        let bsdf = ShadedBsdf::new(&*model, &point);
        for (fixed, mode) in directions().flat_map(|fixed| WALKS.map(|mode| (fixed, mode))) {
            let mut images = Vec::new();
            bsdf.dirac_images(fixed, mode, &mut |image| images.push(image));
            for i in 0..200 {
                let u1 = (f64::from(i) + 0.5) / 200.0;
                let sample = bsdf.sample(fixed, mode, u1, DVec2::new(0.3, 0.6));
                refused += u32::from(sample.is_none());
                let Some(sample) = sample.filter(|sample| sample.dirac) else { continue };
                let same = |image: &&BsdfSample| {
                    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs().max(b.abs());
                    image.next == sample.next
                        && near(image.pdf.value(), sample.pdf.value())
                        && near(image.pdf_reverse.value(), sample.pdf_reverse.value())
                        && (0..3).all(|c| near(image.weight[c], sample.weight[c]))
                };
                assert!(images.iter().find(same).is_some(), "{name}: {sample:?} in {images:?}");
            }
        }
    }
    assert!(refused > 0, "some directions are on different sides of the normals");
}
