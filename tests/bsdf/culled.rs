//! Surfaces without a back: the model in front, nothing behind, and one value for both walks.

use crate::models::{lambert, smooth_models};
use crate::{Independent, direction};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::bsdf::check::check;
use pathspace::bsdf::{Bsdf, BsdfSample, Culled, Mixture, Model, Null, TransportMode};
use pathspace::math::Rgb;
use pathspace::math::statistics::{sidak, two_sided_p_value};

fn images(bsdf: &dyn Bsdf, fixed: DVec3, mode: TransportMode) -> Vec<BsdfSample> {
    let mut images = Vec::new();
    bsdf.dirac_images(fixed, mode, &mut |image| images.push(image));
    images
}

#[test]
fn samples_are_those_of_the_densities() {
    let mut models = smooth_models();
    let veil = Mixture::new([lambert(), Model::Null(Null)], [0.75, 0.25]).expect("valid");
    models.push(("veil".to_owned(), Box::new(veil)));
    let cosines = [0.9, 0.1, -0.1, -0.9];
    let level = sidak(0.01, 4 * models.len() * cosines.len());
    for (index, (name, model)) in models.into_iter().enumerate() {
        let culled = Culled(&*model);
        for cosine in cosines {
            let fixed = direction(cosine, 0.4);
            for walk in [TransportMode::Radiance, TransportMode::Importance] {
                let mut sampler = Independent::new(index as u64 + 1);
                let report = check(&culled, fixed, walk, &mut sampler, 20_000);
                let errors = [
                    report.weight_error,
                    report.pdf_error,
                    report.pdf_reverse_error,
                    report.image_error,
                ];
                assert!(errors.iter().all(|e| *e < 1e-10), "{name} {cosine} {walk:?}: {report:?}");
                assert_eq!(report.invalid, 0, "{name} {cosine} {walk:?}");
                assert!(report.chi_square.p_value >= level, "{name} {cosine} {walk:?}: {report:?}");
                let z = report.normalization_z_score();
                assert!(two_sided_p_value(z) >= level, "{name} {cosine} {walk:?}: {report:?}");
            }
        }
    }
}

/// Whoever looks at the back sees what is before the surface; whoever looks at the front sees the
/// model alone; and both walks have the same coefficients.
#[test]
fn the_front_shows_the_model_and_the_back_nothing() {
    let model = lambert();
    let culled = Culled(model);
    let (front, other) = (direction(0.8, 0.4), direction(0.3, 2.0));
    assert_eq!(culled.eval(front, other), model.eval(front, other));
    for (to_light, to_camera) in [(front, -other), (-front, other), (-front, -other)] {
        assert_eq!(culled.eval(to_light, to_camera), Rgb::BLACK);
    }
    assert!(images(&culled, front, TransportMode::Radiance).is_empty());
    assert!(images(&culled, -front, TransportMode::Importance).is_empty());
    let [seen] = images(&culled, -front, TransportMode::Radiance)[..] else { panic!("one image") };
    let [sent] = images(&culled, front, TransportMode::Importance)[..] else { panic!("one image") };
    let value = seen.dirac_value(TransportMode::Radiance);
    assert_eq!((seen.next, sent.next), (front, -front));
    assert_eq!((value.value, value.pdf_to_light.value()), (Rgb::WHITE, 1.0));
    assert_eq!(value, sent.dirac_value(TransportMode::Importance));
    assert_eq!(value, culled.eval_dirac(front, -front));
    assert_eq!(culled.eval_dirac(-front, front).value, Rgb::BLACK);
    // Of a light walk that arrives in front, as much is scattered as without culling.
    let mut sampler = Independent::new(3);
    let report = check(&culled, front, TransportMode::Importance, &mut sampler, 100_000);
    let albedo = check(&model, front, TransportMode::Importance, &mut sampler, 10).albedo;
    for (with, without) in report.albedo.iter().zip(albedo) {
        assert_relative_eq!(
            with.mean(),
            1.0 + without.mean(),
            epsilon = 4.0 * with.standard_error()
        );
    }
}
