//! The pilot of [`Adaptive`](super::Adaptive): one run of bidirectional path tracing tells what
//! every set of techniques would have cost and how noisy it would have been (efficiency-aware
//! multiple importance sampling: Grittmann, Yazici, Georgiev and Slusallek 2022).
//!
//! Each sample has one camera walk and two light walks; [`super::findings`] says what is made of
//! them.

use super::findings::{Factors, Findings, Seen, Tally, share_index};
use crate::endpoint::Camera;
use crate::film::{BatchSample, FilmSample, Technique};
use crate::integrator::bidirectional::Kernel;
use crate::integrator::{Bidirectional, Pilot};
use crate::path::{Counters, Family, LightWalks, Path, PathDensities, Scratch, TechniqueSet};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::Scene;
use std::sync::OnceLock;

/// Samples of each pixel that the pilot looks at: enough for a variance.
pub(super) const PASSES: u32 = 4;
/// Light walks per sample.
pub(super) const WALKS: usize = 2;
/// Pixels per task.
const TASK: u64 = 4;
/// Independent parts of the pilot, which tell how certain it is.
pub(super) const GROUPS: usize = 8;

/// Runs the pilot for a number of pixels; returns its findings in a few independent groups.
pub(super) fn run<S: Scene + ?Sized, C: Camera + ?Sized>(
    integrator: &Bidirectional,
    candidates: &[TechniqueSet],
    scene: &S,
    camera: &C,
    pilot: &Pilot<'_>,
    pixels: u64,
) -> [Findings; GROUPS] {
    let walks = LightWalks::power_of_two(1).unwrap_or_default();
    let proxy = Bidirectional {
        techniques: TechniqueSet { light_walks: walks, ..integrator.techniques },
        ..*integrator
    };
    let factors: Vec<Factors> =
        candidates.iter().map(|set| Factors::new(proxy.heuristic, set)).collect();
    let parts = in_parallel(pilot, pixels, |range, scratch| {
        let mut tally = Tally::new(&factors);
        for site in range {
            for_each_sample(camera, pilot, site, pixels, 0, |film, sampler| {
                sample(
                    &mut tally,
                    &Kernel::new(&proxy, scene, camera),
                    &proxy,
                    &mut BatchSample { film, sampler },
                    scratch,
                );
            });
            tally.end_pixel();
        }
        tally.findings
    });
    let mut groups = std::array::from_fn(|_| Findings::new(candidates.len()));
    // Neighbours in different groups: each group sees all of the image.
    parts.iter().zip((0..GROUPS).cycle()).for_each(|(part, group)| groups[group].merge(part));
    groups
}

/// Splits the pixels into tasks and returns what each of them gave, in order.
pub(super) fn in_parallel<'s, S: Scene + ?Sized + 's, T: Send + Sync>(
    pilot: &Pilot<'_>,
    pixels: u64,
    task: impl Fn(std::ops::Range<u64>, &mut Scratch<'s, S>) -> T + Sync,
) -> Vec<T> {
    let slots: Vec<OnceLock<T>> = (0..pixels.div_ceil(TASK)).map(|_| OnceLock::new()).collect();
    (pilot.parallel)(slots.len(), &|i| {
        let first = i as u64 * TASK;
        slots[i].get_or_init(|| task(first..(first + TASK).min(pixels), &mut Scratch::default()));
    });
    slots.into_iter().filter_map(OnceLock::into_inner).collect()
}

/// The samples of one of the pixels that are spread over the window. Pass numbers run down from the
/// largest, which no rendering reaches: so the samples are independent of the rendering's.
pub(super) fn for_each_sample<C: Camera + ?Sized>(
    camera: &C,
    pilot: &Pilot<'_>,
    site: u64,
    sites: u64,
    round: u64,
    mut visit: impl FnMut(FilmSample, &mut <Independent as SampleSource>::Sampler),
) {
    let region = camera.film();
    let source = Independent { seed: pilot.seed };
    let first = (site + round * sites) * u64::from(PASSES);
    let pass = |i: u64| u32::MAX - ((first + i) % (1 << 31)) as u32;
    // One site in each part of the window, at random in it.
    let position = (site as f64 + source.sampler(0, pass(0)).next_1d()) / sites as f64;
    let pixel = ((position * f64::from(region.pixels())) as u32).min(region.pixels() - 1);
    for i in 0..u64::from(PASSES) {
        let mut sampler = source.sampler(pixel, pass(i));
        let film = FilmSample::draw(&region, pixel, pilot.kernel, &mut sampler);
        visit(film, &mut sampler);
    }
}

/// Index of a family among sums.
fn column(technique: Technique) -> usize {
    match Family::of(technique) {
        Family::EmitterSampling => 1,
        Family::Connections => 2,
        Family::LensSampling => 3,
        Family::EmitterHits | Family::UniformArea => 0,
    }
}

/// Draws one sample.
fn sample<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
    tally: &mut Tally<'_>,
    kernel: &Kernel<'_, 's, S, C>,
    proxy: &Bidirectional,
    draw: &mut BatchSample<P>,
    scratch: &mut Scratch<'s, S>,
) {
    scratch.counters = Counters { samples: 1, ..Counters::default() };
    kernel.walk_from_camera(draw, scratch);
    let counters = std::mem::take(&mut scratch.counters);
    tally.findings.camera_walks += counters;
    let goes_on = scratch.camera.get(1).is_some_and(|first| first.dirac);
    tally.findings.rest_walks += if goes_on {
        counters
    } else {
        Counters { closest_rays: 1, scattered: counters.scattered.min(1), ..counters }
    };
    for t in 2..=scratch.camera.len() {
        for s in 0..2 {
            let counters = join(tally, kernel, proxy, (s, t), 0, draw, scratch);
            tally.findings.emitter_sampling += counters;
            if goes_on {
                tally.findings.rest_sampling += counters;
            }
        }
    }
    for walk in 0..kernel.draw_light_walks(&mut draw.sampler) as usize {
        kernel.walk_from_light(&mut draw.sampler, &mut scratch.light, &mut scratch.counters);
        tally.findings.light_walks += std::mem::take(&mut scratch.counters);
        for t in 1..=scratch.camera.len().max(1) {
            for s in if t == 1 { 1 } else { 2 }..=scratch.light.len() {
                let counters = join(tally, kernel, proxy, (s, t), walk, draw, scratch);
                let findings = &mut tally.findings;
                *if t == 1 { &mut findings.lens } else { &mut findings.connections } += counters;
            }
        }
    }
    tally.end_sample();
}

/// Draws with one technique and returns what that took; hitting a light takes nothing.
fn join<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
    tally: &mut Tally<'_>,
    kernel: &Kernel<'_, 's, S, C>,
    proxy: &Bidirectional,
    (s, t): (usize, usize),
    walk: usize,
    draw: &mut BatchSample<P>,
    scratch: &mut Scratch<'s, S>,
) -> Counters {
    let Scratch { counters, camera, light, .. } = scratch;
    kernel.join((s, t), draw, [camera, light], counters, &mut |path, _, _, counters| {
        if path.is_visible(counters) {
            see(tally, proxy, &path, walk);
        }
    });
    let counters = std::mem::take(counters);
    let technique = Technique { s: s as u16, t: t as u16 };
    if let Some(index) = share_index(technique) {
        tally.findings.shares[index].cost += counters.cost() / proxy.techniques.count(technique);
    }
    counters
}

/// Takes down a path that contributes.
fn see<S: Scene + ?Sized, C: Camera + ?Sized>(
    tally: &mut Tally<'_>,
    proxy: &Bidirectional,
    path: &Path<'_, '_, S, C>,
    walk: usize,
) {
    let (technique, heuristic) = (path.technique(), proxy.heuristic);
    let (family, value) = (column(technique), path.value().luminance());
    let (mut p, mut q) = ([0.0; 4], [0.0; 4]);
    (p[family], q[family]) = (1.0, 1.0);
    let densities = path.densities();
    densities.sweep(usize::from(technique.t), |t, ratio| {
        let other = densities.technique(t);
        if ratio > 0.0 && proxy.techniques.contains(other) {
            let raised = heuristic.raise(ratio);
            p[column(other)] += raised;
            q[column(other)] += raised * (raised / ratio);
        }
    });
    let count = proxy.techniques.count(technique);
    let proxy_walks = heuristic.raise(proxy.techniques.light_walks.count());
    let proxy_total = p[0] + p[1] + proxy_walks * (p[2] + p[3]);
    // The weight in the pilot, over the number of samples: what an average over all samples of all
    // techniques takes.
    let in_proxy = heuristic.raise(count) / proxy_total / count;
    if !(value.is_finite() && in_proxy.is_finite() && q.iter().all(|q| q.is_finite())) {
        return;
    }
    let plain = value / p.iter().sum::<f64>();
    if let Some(share) = share_index(technique).map(|index| &mut tally.findings.shares[index]) {
        share.energy += plain / count;
        share.square += plain * plain / count;
    }
    tally.see(&Seen { family, walk, count, value, moment: in_proxy * value * value, p, q });
}
