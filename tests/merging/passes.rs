//! Statistics over passes, each of which has light walks of its own.

use crate::common::Moments;
use pathspace::film::{Contribution, FilmSample, Sample};
use pathspace::integrator::{Caller, Run};
use pathspace::path::Scratch;
use pathspace::sampler::Sampler;
use pathspace::scene::Scene;

/// Moments over passes of the mean of what `measure` makes of a sample's contributions.
pub fn over_passes<'a, S: Scene + 'a, R: Run<'a, S>, P: Sampler>(
    run: &mut R,
    passes: u32,
    samples: u32,
    sampler: &mut P,
    film: impl Fn(&mut P) -> FilmSample,
    mut measure: impl FnMut(&[Contribution]) -> f64,
) -> Moments {
    let (mut scratch, mut moments) = (Scratch::default(), Moments::default());
    let mut found: Vec<Contribution> = Vec::new();
    for pass in 0..passes {
        run.begin_pass(pass, &Caller).expect("memory");
        let mut sum = 0.0;
        for _ in 0..samples {
            found.clear();
            let film = film(sampler);
            let sample = &mut [Sample { film, sampler: &mut *sampler }];
            run.draw(sample, &mut found, &mut Default::default(), &mut scratch);
            sum += measure(&found);
        }
        moments.add(sum / f64::from(samples));
    }
    assert_eq!(scratch.counters.non_finite, 0);
    moments
}

/// Asserts that the mean is within 4 standard errors of what is expected, and that these are small
/// enough to see a bias of 1 %.
#[track_caller]
pub fn assert_mean(name: &str, moments: Moments, expected: f64) {
    let (mean, error) = (moments.mean(), moments.standard_error());
    println!("{name}: {mean} ± {error}, expected {expected}");
    assert!(
        (mean - expected).abs() <= 4.0 * error + 1e-12 * expected,
        "{name}: {mean} ± {error}, expected {expected}"
    );
    assert!(error <= 0.0025 * expected, "{name}: the standard error {error} is too large");
}
