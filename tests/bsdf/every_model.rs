//! Every model agrees with itself, and answers extreme input with finite numbers.

use crate::models::{boxed, rough_conductor, rough_glass, rough_models, smooth_models};
use crate::{Independent, direction};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::check::check;
use pathspace::bsdf::{Bsdf, TransportMode};

const COSINES: [f64; 4] = [1.0, 0.7, 0.2, 0.01];

/// Fixed directions on both sides of the surface with a walk.
fn cases() -> impl Iterator<Item = (DVec3, TransportMode)> + Clone {
    let walks = [TransportMode::Radiance, TransportMode::Importance];
    let sides =
        |cosine| [direction(cosine, 0.4), direction(cosine, 0.4) * DVec3::new(1.0, 1.0, -1.0)];
    COSINES.into_iter().flat_map(sides).flat_map(move |fixed| walks.map(|walk| (fixed, walk)))
}

/// Runs all checks at the level 1 % for all together.
fn check_all(
    models: &[(String, Box<dyn Bsdf>)],
    cases: impl Iterator<Item = (DVec3, TransportMode)> + Clone,
    samples: u32,
) {
    let checks = models.len() * cases.clone().count();
    for (index, (name, model)) in models.iter().enumerate() {
        for (fixed, walk) in cases.clone() {
            let report =
                check(&**model, fixed, walk, &mut Independent::new(index as u64 + 1), samples);
            let verdict = report.verdict(0.01, checks);
            assert_eq!(verdict, Ok(()), "{name} at {fixed} on a {walk:?} walk: {report:?}");
            assert!(
                report.pdf_error < 1e-10 && report.pdf_reverse_error < 1e-10,
                "{name} at {fixed} {walk:?}: {report:?}"
            );
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
    let alternating = cases().enumerate().filter(|(k, (_, walk))| {
        (*walk == TransportMode::Importance) == (k / 4 % 2 == (k / 2) % 2)
    });
    check_all(&rough_models(), alternating.map(|(_, case)| case), 20_000);
}

#[test]
fn extreme_input_gives_finite_numbers() {
    let mut models = smooth_models();
    models.extend(rough_models());
    for alpha in [(1e-4, 1e-4), (1e-8, 1.0), (1e-4, 10.0), (1e-3, 1e-3)] {
        models.push((format!("rough conductor {alpha:?}"), boxed(rough_conductor(alpha))));
        for relative_ior in [1e-3, 1.0 - 1e-5, 1.0 + 1e-5, 100.0] {
            models.push((
                format!("rough glass {relative_ior} {alpha:?}"),
                boxed(rough_glass(relative_ior, alpha)),
            ));
        }
    }
    let one = 1.0f64.next_down();
    let cosines = [0.0, -0.0, 1e-300, 1e-16, 1e-12, 1e-8, 1e-3, 0.5, 1.0 - 1e-15, 1.0];
    let mut directions: Vec<DVec3> =
        cosines.iter().flat_map(|&c| [direction(c, 0.0), direction(c, 2.0)]).collect();
    directions.extend(directions.clone().iter().map(|&w| -w));
    for (name, model) in &models {
        for &fixed in &directions {
            for walk in [TransportMode::Radiance, TransportMode::Importance] {
                for &next in &directions {
                    let pdf = model.pdf(fixed, next, walk).value();
                    let value = model.eval(fixed, next);
                    let dirac = model.eval_dirac(fixed, next);
                    assert!(pdf.is_finite() && pdf >= 0.0, "{name} {fixed} {next}: pdf {pdf}");
                    assert!(
                        value.is_finite() && dirac.value.is_finite(),
                        "{name} {fixed} {next}: {value:?} {dirac:?}"
                    );
                }
                for u in [0.0, 1e-300, 0.5, one] {
                    for (x, y) in [
                        (0.0, 0.0),
                        (0.0, one),
                        (one, 0.0),
                        (one, one),
                        (0.3, 0.7),
                        (0.5, 0.5),
                        (0.2, 1e-300),
                    ] {
                        let Some(sample) = model.sample(fixed, walk, u, DVec2::new(x, y)) else {
                            continue;
                        };
                        let (pdf, reverse) = (sample.pdf.value(), sample.pdf_reverse.value());
                        assert!(
                            sample.weight.is_finite() && pdf.is_finite() && reverse.is_finite(),
                            "{name} {fixed}: {sample:?}"
                        );
                        assert!(
                            pdf > 0.0 && sample.next.z != 0.0 && sample.next.is_normalized(),
                            "{name} {fixed}: {sample:?}"
                        );
                        if !sample.dirac {
                            assert_relative_eq!(
                                model.pdf(fixed, sample.next, walk).value(),
                                pdf,
                                max_relative = 1e-10
                            );
                        }
                    }
                }
            }
        }
    }
}
