//! Renders a scene with several integrators and independent seeds, and holds every integrator
//! against the others.
//!
//! Each integrator renders `SEEDS` images. Their variance over the seeds gives the standard error
//! of everything that is compared: the mean of the image, and the means of 4 × 4 blocks, per
//! channel. An integrator is held against the mean of all others, weighted by inverse variance of
//! the whole image (weights that do not depend on the compared block).
//!
//! * whole image: |difference| ≤ 4 standard errors, where the standard error of each integrator is
//!   at most 0.25 %, so that a bias of 1.5 % fails nearly always and one of 1 % more often than
//!   not; noisier tests state their target;
//! * blocks: the p-value of Welch's t test is at least Šidák's level for a significance of 1e-4
//!   over all blocks and channels.
//!
//! Within an image, samples are Sobol' points, which need fewer of them; images of different seeds
//! are independent, which is what the errors rest on. The number of samples is found in earlier
//! rounds with seeds of their own, so it does not depend on the compared images.

use pathspace::endpoint::Camera;
use pathspace::film::{Filter, Image};
use pathspace::math::statistics::sidak;
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::{Scene, World};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Independent images per integrator.
const SEEDS: u64 = 24;
/// The mean of a block, beside that of the image, below which an integrator may have met none of
/// its light: in the tail of a narrow lobe one sample in 10⁷ or fewer meets any, and connections
/// evaluate the tail in each.
const UNMET: f64 = 1e-7;
/// Samples per pixel of the first images; they only decide how many are needed.
const PILOT_SAMPLES: u32 = 16;

/// An integrator with the name that messages call it by.
pub type Named<'a, S = World> = (&'a str, &'a dyn Render<S>);

/// Settings of a comparison.
#[derive(Clone, Copy)]
pub struct Comparison {
    pub filter: Filter,
    /// Errors of heavy-tailed estimates are only known from independent samples: Sobol' points
    /// leave the tail alone, and little else, to chance.
    pub sampler: SamplerKind,
    /// Relative standard error of the mean that each integrator is to reach.
    pub target: f64,
    /// Most samples per pixel of one image.
    pub most: u32,
    /// True if blocks are compared, too. Where an integrator finds a part of the light so rarely
    /// that most images of a block miss it, the block has too small a mean and too small a variance
    /// at once, and only the whole image can be tested.
    pub blocks: bool,
}

impl Default for Comparison {
    fn default() -> Self {
        Self {
            filter: Filter::Box,
            sampler: SamplerKind::Sobol,
            target: 0.0025,
            most: 4096,
            blocks: true,
        }
    }
}

/// Mean, variance of the mean, and degrees of freedom of that variance.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    pub value: f64,
    pub variance: f64,
    pub freedom: f64,
}

impl Mean {
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
        Self { value, variance: squares / (n - 1.0) / n, freedom: n - 1.0 }
    }

    /// Σ w_i m_i (Welch 1947, Satterthwaite 1946).
    fn combine(terms: impl Iterator<Item = (f64, Mean)> + Clone) -> Self {
        let value = terms.clone().map(|(w, m)| w * m.value).sum();
        let variance: f64 = terms.clone().map(|(w, m)| w * w * m.variance).sum();
        let spread: f64 = terms.map(|(w, m)| (w * w * m.variance).powi(2) / m.freedom).sum();
        Self {
            value,
            variance,
            freedom: if spread > 0.0 { variance * variance / spread } else { 1.0 },
        }
    }

    /// Difference in standard errors; differences within rounding are none.
    fn z(&self, scale: f64) -> f64 {
        if self.value.abs() <= 1e-9 * scale.abs() { 0.0 } else { self.value / self.variance.sqrt() }
    }

    fn p_value(&self, scale: f64) -> f64 {
        let z = self.z(scale).abs();
        if z == 0.0 {
            return 1.0;
        }
        if z.is_infinite() {
            return 0.0;
        }
        let t = StudentsT::new(0.0, 1.0, self.freedom).expect("positive degrees of freedom");
        2.0 * t.sf(z)
    }

    pub fn standard_error(&self) -> f64 {
        self.variance.sqrt()
    }
}

/// The images that an integrator made.
pub struct Measured {
    pub name: String,
    pub images: Vec<Image>,
    pub samples_per_pixel: u32,
}

fn render<S: Scene>(
    scene: &S,
    camera: &dyn Camera,
    (name, integrator): Named<'_, S>,
    comparison: &Comparison,
    seeds: std::ops::Range<u64>,
    samples: u32,
) -> Vec<Image> {
    let Comparison { filter, sampler, .. } = *comparison;
    let one = |seed| {
        let settings = Settings {
            budget: Budget::Samples(samples),
            seed,
            threads: Some(1),
            filter,
            sampler,
            ..Settings::default()
        };
        let rendering = integrator.render(scene, camera, &settings).expect("valid settings");
        assert_eq!(
            rendering.counters.non_finite,
            0,
            "{name}: {:?}",
            rendering.non_finite().first()
        );
        rendering.image
    };
    seeds.map(one).collect()
}

/// Images that differ in their seeds only. Rounds with fresh seeds and more samples follow each
/// other until the target is met; only the last is kept, and whether another follows depends on
/// standard errors only.
pub fn measure<S: Scene>(
    scene: &S,
    camera: &dyn Camera,
    integrator: Named<'_, S>,
    comparison: &Comparison,
) -> Measured {
    // Streams of different integrators must not be correlated.
    let base =
        integrator.0.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| {
            (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)
        }) << 16;
    let mut samples = PILOT_SAMPLES;
    for round in 0.. {
        let start = base + round * SEEDS;
        let images = render(scene, camera, integrator, comparison, start..start + SEEDS, samples);
        let measured =
            Measured { name: integrator.0.to_owned(), images, samples_per_pixel: samples };
        let excess = measured.relative_error() / comparison.target;
        if excess <= 1.0 || samples == comparison.most || round == 4 {
            return measured;
        }
        // The error of a standard error from 24 images is 15 %.
        samples = round_up((1.25 * excess * excess * f64::from(samples)).ceil() as u32)
            .min(comparison.most);
    }
    unreachable!("the last round returns")
}

/// The next number with three binary digits: Sobol' points of that many are about as good as of a
/// power of two, and it is nearer.
fn round_up(samples: u32) -> u32 {
    samples.next_multiple_of((samples.next_power_of_two() / 8).max(1))
}

impl Measured {
    /// The largest relative standard error of a channel's mean.
    pub fn relative_error(&self) -> f64 {
        let channels = (0..3).map(|c| self.channel(c)).filter(|mean| mean.value != 0.0);
        channels.map(|mean| mean.standard_error() / mean.value.abs()).fold(0.0, f64::max)
    }

    pub fn channel(&self, c: usize) -> Mean {
        Mean::of(&self.images.iter().map(|image| image.mean().0[c]).collect::<Vec<_>>())
    }

    fn block(&self, c: usize, x: u32, y: u32, size: u32) -> Mean {
        let mean = |image: &Image| {
            let max = [(x + size).min(image.width()), (y + size).min(image.height())];
            image.crop([x, y], max).expect("inside").mean().0[c]
        };
        Mean::of(&self.images.iter().map(mean).collect::<Vec<_>>())
    }

    /// Asserts |mean - expected| ≤ 4 standard errors, for standard errors of at most `resolution`
    /// relatively; exact images pass by rounding.
    pub fn assert_mean(&self, expected: [f64; 3], resolution: f64) {
        for (c, expected) in expected.into_iter().enumerate() {
            let mean = self.channel(c);
            let (error, difference) = (mean.standard_error(), mean.value - expected);
            println!(
                "{:24} {:10.6} expected {expected:10.6}, z = {:5.2}, error {:.3} %",
                self.name,
                mean.value,
                difference / error,
                100.0 * error / expected
            );
            assert!(
                difference.abs() <= 4.0 * error + 1e-9 * expected.abs(),
                "{}: {} ± {error}, not {expected}",
                self.name,
                mean.value
            );
            assert!(
                error <= resolution * expected.abs(),
                "{}: error {error} of {expected} sees no bias",
                self.name
            );
        }
    }

    /// The same for each pixel, with Student's t and Šidák's level over the pixels.
    pub fn assert_pixels(&self, expected: f64) {
        let (width, height) = (self.images[0].width(), self.images[0].height());
        let level = sidak(1e-4, (width * height) as usize);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let mean = self.block(1, x, y, 1);
            let difference = Mean { value: mean.value - expected, ..mean };
            let p = difference.p_value(expected);
            assert!(
                p >= level,
                "{}: pixel ({x}, {y}) is {} ± {}, not {expected}",
                self.name,
                mean.value,
                mean.standard_error()
            );
        }
    }
}

/// Measures all integrators and asserts that they agree.
pub fn assert_agree(
    case: &str,
    world: &World,
    camera: &dyn Camera,
    integrators: &[Named<'_>],
    comparison: &Comparison,
) {
    let clock = std::time::Instant::now();
    let measured: Vec<Measured> =
        integrators.iter().map(|i| measure(world, camera, *i, comparison)).collect();
    println!("{case}: {:.1} s", clock.elapsed().as_secs_f64());
    assert_measurements_agree(case, &measured, comparison);
}

/// Asserts that measurements of the same image agree.
pub fn assert_measurements_agree(case: &str, measured: &[Measured], comparison: &Comparison) {
    let (width, height) = (measured[0].images[0].width(), measured[0].images[0].height());
    let height = if comparison.blocks { height } else { 0 };
    let blocks: Vec<(u32, u32)> =
        (0..height).step_by(4).flat_map(|y| (0..width).step_by(4).map(move |x| (x, y))).collect();
    let level = sidak(1e-4, 3 * blocks.len());
    let mut failures = Vec::new();
    for (i, one) in measured.iter().enumerate() {
        let (mut worst_z, mut worst_error, mut worst_p) = (0.0f64, 0.0f64, 1.0f64);
        for c in 0..3 {
            let own = one.channel(c);
            // An integrator without noise gets a weight that does not overflow.
            let precision =
                |m: &Measured| 1.0 / m.channel(c).variance.max((1e-9 * own.value).powi(2));
            let total: f64 = measured
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, m)| precision(m))
                .sum();
            if !total.is_finite() {
                assert!(own.value == 0.0, "{case}: {} sees what nobody else does", one.name);
                continue;
            }
            let difference = |mean: &dyn Fn(&Measured) -> Mean| {
                let others: Vec<(f64, Mean)> = measured
                    .iter()
                    .enumerate()
                    .filter(|(j, _)| *j != i)
                    .map(|(_, m)| (-precision(m) / total, mean(m)))
                    .collect();
                Mean::combine(others.into_iter().chain([(1.0, mean(one))]))
            };
            let whole = difference(&|m| m.channel(c));
            let (z, error) = (whole.z(own.value), whole.standard_error() / own.value);
            (worst_z, worst_error) = (worst_z.max(z.abs()), worst_error.max(error));
            if z.abs() > 4.0 {
                failures.push(format!(
                    "{} is off by {:.2} % (z = {z:.2}) in channel {c}",
                    one.name,
                    100.0 * whole.value / own.value
                ));
            }
            for &(x, y) in &blocks {
                let block = difference(&|m| m.block(c, x, y, 4));
                let is_unmet = one.block(c, x, y, 4).value == 0.0;
                if is_unmet && block.value.abs() < UNMET * own.value {
                    continue;
                }
                let p = block.p_value(own.value);
                worst_p = worst_p.min(p);
                if p < level {
                    let relative = 100.0 * block.value / one.block(c, x, y, 4).value;
                    failures.push(format!("{}: block ({x}, {y}) is off by {relative:.1} % (p = {p:.1e}) in channel {c}", one.name));
                }
            }
        }
        let spp = one.samples_per_pixel;
        let mean = one.channel(1).value;
        println!(
            "  {:24} {mean:9.6}  z {worst_z:4.2}  error {:5.3} %  block p {worst_p:.1e} (level {level:.1e})  {spp} spp",
            one.name,
            100.0 * worst_error
        );
        if worst_error > 1.5 * comparison.target {
            failures.push(format!(
                "{}: standard error {:.3} % is too large to mean anything",
                one.name,
                100.0 * worst_error
            ));
        }
    }
    assert!(failures.is_empty(), "{case}:\n  {}", failures.join("\n  "));
}
