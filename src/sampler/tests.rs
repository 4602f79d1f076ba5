use super::*;

const SEED: u64 = 7;

/// Film offset, then three scattering vertices: the numbers that a short path takes.
fn numbers<S: SampleSource>(source: &S, pixel: u32, pass: u32) -> Vec<f64> {
    let mut sampler = source.sampler(pixel, pass);
    let mut out = Vec::new();
    sampler.stream(Stream::Film);
    for _ in 0..2 {
        let u = sampler.next_2d();
        out.extend([u.x, u.y]);
    }
    for vertex in 1..4 {
        sampler.stream(Stream::CameraVertex(vertex));
        out.push(sampler.next_1d());
        let u = sampler.next_2d();
        out.extend([u.x, u.y, sampler.next_1d()]);
    }
    out
}

fn all() -> Vec<AnySource> {
    vec![
        SamplerKind::Independent.source(SEED, 16),
        SamplerKind::Stratified.source(SEED, 16),
        SamplerKind::Stratified.source(SEED, 7),
        SamplerKind::Sobol.source(SEED, 16),
    ]
}

#[test]
fn the_index_alone_decides_and_numbers_are_in_the_half_open_interval() {
    for source in all() {
        for (pixel, pass) in
            [(0, 0), (1, 0), (0, 1), (u32::MAX, u32::MAX), (5, 65_535), (5, 65_536)]
        {
            let a = numbers(&source, pixel, pass);
            assert_eq!(a, numbers(&source, pixel, pass));
            assert!(a.iter().all(|u| (0.0..1.0).contains(u)), "{source:?} {a:?}");
            assert_ne!(a, numbers(&source, pixel ^ 1, pass));
            assert_ne!(a, numbers(&source, pixel, pass ^ 1));
        }
    }
}

/// Each dimension, over pixels at one pass: moments and a chi-square test of 64 bins. With n = 40
/// 000 the standard error of the mean is 0.2887/√n = 0.00144, that of the variance 0.0745/√n =
/// 0.00037; the bounds are 5 standard errors.
#[test]
fn every_dimension_is_uniform_over_pixels() {
    let n = 40_000u32;
    for source in all() {
        for pass in [0, 3, 70_000] {
            let samples: Vec<Vec<f64>> =
                (0..n).map(|pixel| numbers(&source, pixel, pass)).collect();
            for d in 0..samples[0].len() {
                let (mut mean, mut square, mut bins) = (0.0, 0.0, [0.0f64; 64]);
                for s in &samples {
                    mean += s[d] / f64::from(n);
                    square += (s[d] - 0.5).powi(2) / f64::from(n);
                    bins[(s[d] * 64.0) as usize] += 1.0;
                }
                assert!((mean - 0.5).abs() < 0.0073, "{source:?} dimension {d}: mean {mean}");
                assert!(
                    (square - 1.0 / 12.0).abs() < 0.0019,
                    "{source:?} dimension {d}: variance {square}"
                );
                let expected = f64::from(n) / 64.0;
                let chi2: f64 = bins.iter().map(|b| (b - expected).powi(2) / expected).sum();
                assert!(
                    chi2 < 63.0 + 5.5 * 126.0f64.sqrt(),
                    "{source:?} dimension {d}: chi-square {chi2}"
                );
            }
        }
    }
}

/// Correlation between neighbouring pixels, between passes (independent sampler only) and between
/// dimensions: standard error 1/√n = 0.005, bound 5 standard errors.
#[test]
fn neighbours_are_uncorrelated() {
    let n = 40_000u32;
    let correlation = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        12.0 * pairs.map(|(a, b)| (a - 0.5) * (b - 0.5)).sum::<f64>() / f64::from(n)
    };
    for source in all() {
        let samples: Vec<Vec<f64>> = (0..=n).map(|pixel| numbers(&source, pixel, 2)).collect();
        for d in 0..samples[0].len() {
            let r = correlation(&mut samples.windows(2).map(|w| (w[0][d], w[1][d])));
            assert!(r.abs() < 0.025, "{source:?} dimension {d}, pixels: {r}");
            for e in 0..d {
                let r = correlation(&mut samples[1..].iter().map(|s| (s[d], s[e])));
                assert!(r.abs() < 0.025, "{source:?} dimensions {d} {e}: {r}");
            }
        }
    }
    let source = Independent { seed: SEED };
    let passes: Vec<Vec<f64>> = (0..=n).map(|pass| numbers(&source, 9, pass)).collect();
    let seeds: Vec<Vec<f64>> =
        (0..=n).map(|seed| numbers(&Independent { seed: seed.into() }, 9, 0)).collect();
    for samples in [passes, seeds] {
        for d in 0..samples[0].len() {
            let r = correlation(&mut samples.windows(2).map(|w| (w[0][d], w[1][d])));
            assert!(r.abs() < 0.025, "dimension {d}, passes or seeds: {r}");
        }
    }
}

/// Number of strata of `n` that hold exactly one of the values.
fn filled(values: impl Iterator<Item = f64>, n: usize) -> usize {
    let mut counts = vec![0; n];
    values.for_each(|v| counts[(v * n as f64) as usize] += 1);
    counts.iter().filter(|&&c| c == 1).count()
}

#[test]
fn stratified_fills_every_stratum_once() {
    for n in [1u32, 2, 7, 12, 16, 64, 100] {
        let source = Stratified { seed: SEED, samples_per_pixel: n };
        for (pixel, first) in [(0, 0), (3, n), (4, 5 * n)] {
            let samples: Vec<Vec<f64>> =
                (first..first + n).map(|pass| numbers(&source, pixel, pass)).collect();
            for d in 0..samples[0].len() {
                assert_eq!(
                    filled(samples.iter().map(|s| s[d]), n as usize),
                    n as usize,
                    "n {n} dimension {d}"
                );
            }
            // Points of the square: one per cell of the coarse grid.
            let columns = (1..=n.isqrt()).rev().find(|&d| n.is_multiple_of(d)).unwrap_or(1);
            let cell = |x: f64, y: f64| {
                (((x * f64::from(columns)).floor()
                    + f64::from(columns) * (y * f64::from(n / columns)).floor())
                    + 0.5)
                    / f64::from(n)
            };
            for d in [0, 2, 5] {
                assert_eq!(
                    filled(samples.iter().map(|s| cell(s[d], s[d + 1])), n as usize),
                    n as usize,
                    "n {n} point {d}"
                );
            }
        }
    }
    assert_eq!(numbers(&Stratified { seed: 1, samples_per_pixel: 0 }, 0, 3).len(), 16);
}

#[test]
fn sobol_is_a_net_in_each_set_and_across_the_end_of_its_sequence() {
    let source = Sobol { seed: SEED };
    for first in [0u32, 256, 65_536 - 256, 65_536, 3 * 65_536] {
        let samples: Vec<Vec<f64>> =
            (first..first + 256).map(|pass| numbers(&source, 11, pass)).collect();
        for d in 0..samples[0].len() {
            assert_eq!(filled(samples.iter().map(|s| s[d]), 256), 256, "{first} dimension {d}");
        }
        // The first two dimensions of a set are a (0, 2)-sequence: one point in every 16 × 16 cell.
        let cells = samples
            .iter()
            .map(|s| ((s[0] * 16.0).floor() * 16.0 + (s[1] * 16.0).floor() + 0.5) / 256.0);
        assert_eq!(filled(cells, 256), 256, "{first}");
    }
}

/// Root mean square error of the mean of f over `n` samples, over 64 pixels.
fn error<S: SampleSource>(source: &S, first: u32, n: u32) -> f64 {
    let f = |u: &[f64]| (u[0] - 0.5) * (u[1] + 0.3) + (u[5] - u[6] * u[6]).exp();
    // A sum over sets of dimensions: what padding can integrate. ∫(x - ½)(y + 0.3) = 0; ∫∫ e^(a -
    // b²) = (e - 1) · √π/2 · erf(1).
    let exact = (1f64.exp() - 1.0) * 0.746_824_132_812_427;
    let total: f64 = (0..64u32)
        .map(|pixel| {
            ((first..first + n).map(|pass| f(&numbers(source, pixel, pass))).sum::<f64>()
                / f64::from(n)
                - exact)
                .powi(2)
        })
        .sum();
    (total / 64.0).sqrt()
}

#[test]
fn structured_samplers_beat_random_ones_on_a_smooth_integrand() {
    let random = error(&Independent { seed: SEED }, 0, 1024);
    let stratified = error(&Stratified { seed: SEED, samples_per_pixel: 1024 }, 0, 1024);
    let sobol = error(&Sobol { seed: SEED }, 0, 1024);
    // Across the boundary two independent sequences meet: 512 points of each.
    let boundary = error(&Sobol { seed: SEED }, 65_536 - 512, 1024);
    println!(
        "rms error at 1024 samples: random {random:.2e}, stratified {stratified:.2e}, Sobol' {sobol:.2e}, at the boundary {boundary:.2e}"
    );
    assert!(stratified < 0.1 * random && sobol < 0.05 * random && boundary < 0.05 * random);
    // The random error is what its variance predicts, so the comparison means something: sd of f
    // about 0.5.
    assert!((0.008..0.03).contains(&random), "{random}");
}

/// Points that keep apart leave less variance at an edge: a disk is met by 0.069 of that of random
/// points (simulated with random permutations), by 0.18 if rows and columns of the grid are
/// permuted each for itself. Means of 4000 pixels: a standard error of 2 %.
#[test]
fn stratified_points_keep_apart() {
    let (pixels, strata) = (4000, 64);
    let source = Stratified { seed: SEED, samples_per_pixel: strata };
    let is_inside = |u: DVec2| f64::from((u - 0.5).length_squared() < 0.1);
    let mean = |pixel| {
        (0..strata).map(|pass| is_inside(source.sampler(pixel, pass).next_2d())).sum::<f64>()
            / f64::from(strata)
    };
    let area = 0.1 * std::f64::consts::PI;
    let errors: Vec<f64> = (0..pixels).map(|pixel| mean(pixel) - area).collect();
    let of_random = area * (1.0 - area) / f64::from(strata);
    let ratio = errors.iter().map(|e| e * e).sum::<f64>() / f64::from(pixels) / of_random;
    let bias = errors.iter().sum::<f64>() / f64::from(pixels);
    let standard_error = (ratio * of_random / f64::from(pixels)).sqrt();
    println!("variance / random {ratio:.4}, bias {bias:.2e} ± {standard_error:.2e}");
    assert!((ratio - 0.069).abs() < 0.006 && bias.abs() < 4.0 * standard_error);
}

#[test]
fn a_stream_announced_twice_does_not_repeat_its_numbers() {
    for source in all() {
        for stream in [Stream::Film, Stream::CameraVertex(2), Stream::LensSampling(500)] {
            let mut sampler = source.sampler(0, 0);
            let mut seen = Vec::new();
            for _ in 0..4 {
                sampler.stream(stream);
                seen.push(sampler.next_1d());
            }
            assert!(
                (1..4).all(|i| !seen[..i].contains(&seen[i])),
                "{source:?} {stream:?} {seen:?}"
            );
        }
    }
}

#[test]
fn structured_dimensions_do_not_depend_on_what_other_streams_took() {
    for source in [SamplerKind::Stratified.source(SEED, 16), SamplerKind::Sobol.source(SEED, 16)] {
        let (mut a, mut b) = (source.sampler(2, 3), source.sampler(2, 3));
        a.stream(Stream::CameraVertex(1));
        for _ in 0..9 {
            let _ = a.next_1d();
        }
        a.stream(Stream::CameraVertex(2));
        b.stream(Stream::CameraVertex(2));
        assert_eq!(a.next_2d(), b.next_2d());
    }
}

#[test]
fn replay_gives_the_recorded_numbers() {
    let mut recorder = Recorder::new(Sobol { seed: SEED }.sampler(1, 2));
    recorder.stream(Stream::Film);
    let (a, b) = (recorder.next_2d(), recorder.next_1d());
    assert_eq!(recorder.numbers(), [a.x, a.y, b]);
    let mut replay = recorder.into_replay();
    for _ in 0..2 {
        assert_eq!((replay.next_2d(), replay.next_1d()), (a, b));
        assert!(!replay.overran());
        assert_eq!(replay.next_1d(), 0.0);
        assert!(replay.overran());
        replay.rewind();
    }
    let mut invalid = Replay::new(vec![f64::NAN, -1.0, 1.0, f64::INFINITY]);
    assert!((0..4).all(|_| (0.0..1.0).contains(&invalid.next_1d())));
}

/// Numbers passed over leave those after them as they would have been.
#[test]
fn skipping_is_drawing_without_looking() {
    for source in all() {
        for pattern in 0..64u32 {
            let (mut skipping, mut drawing) = (source.sampler(3, 5), source.sampler(3, 5));
            for sampler in [&mut skipping, &mut drawing] {
                sampler.stream(Stream::Lens);
            }
            // Any sequence of six numbers and points, skipped or drawn.
            for i in 0..6 {
                if pattern >> i & 1 == 1 {
                    skipping.skip_1d();
                    drawing.next_1d();
                } else {
                    skipping.skip_2d();
                    drawing.next_2d();
                }
                assert_eq!(
                    skipping.clone().next_1d(),
                    drawing.clone().next_1d(),
                    "{source:?} {pattern:b}"
                );
                assert_eq!(
                    skipping.clone().next_2d(),
                    drawing.clone().next_2d(),
                    "{source:?} {pattern:b}"
                );
            }
        }
    }
}
