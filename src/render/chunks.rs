//! One pass over the window: threads take chunks as they come, and what was recorded is merged in the order of their numbers.

use super::settings::Threads;
use crate::endpoint::Camera;
use crate::film::{BatchSample, ChunkFilm, Film, FilmRegion, FilmSample, Kernel};
use crate::integrator::Integrator;
use crate::path::{Counters, Scratch};
use crate::sampler::SampleSource;
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Everything that the samples of a rendering share.
pub(super) struct Job<'a, N, S: ?Sized, C: ?Sized, I: ?Sized> {
    pub source: &'a N,
    pub scene: &'a S,
    pub camera: &'a C,
    pub integrator: &'a I,
    pub kernel: Kernel,
    pub region: FilmRegion,
}

/// Samples that an integrator gets at a time: enough rays for the scene, and their paths stay in the nearest memory.
const BATCH: usize = 128;

/// What one chunk did.
struct Slot {
    film: ChunkFilm,
    counters: Counters,
    time: Duration,
}

/// The partition of a pass, and the memory of chunks, which is used again.
pub(super) struct Chunks {
    pixels: u32,
    /// Pixels per chunk: a function of the window alone, because the grouping of sums depends on it.
    length: u32,
    free: Vec<Slot>,
}

/// What all threads of a pass share: chunks that are done wait until it is their turn. No thread waits for another, so that a slow chunk costs
/// memory for those behind it, but no time.
struct Merge<'m> {
    free: &'m mut Vec<Slot>,
    /// Done before their turn, by their numbers.
    early: BTreeMap<u32, Slot>,
    /// The number of the next chunk to merge.
    turn: u32,
    film: &'m mut Film,
    counters: &'m mut Counters,
    time: Duration,
}

impl Merge<'_> {
    /// Takes what a chunk recorded, and merges all whose turn has come.
    fn take(&mut self, number: u32, slot: Slot) {
        self.early.insert(number, slot);
        while let Some(slot) = self.early.remove(&self.turn) {
            self.film.merge(&slot.film);
            *self.counters += slot.counters;
            self.time += slot.time;
            self.free.push(slot);
            self.turn += 1;
        }
    }
}

impl Chunks {
    pub fn new(region: FilmRegion) -> Self {
        let pixels = region.pixels();
        // Small windows are cut finer so that they keep all threads busy.
        Self { pixels, length: pixels.div_ceil(64).clamp(16, 256), free: Vec::new() }
    }

    /// Renders one sample per pixel; returns the time that all threads together spent on it.
    pub fn render_pass<N: SampleSource, S: Scene + ?Sized, C: Camera + ?Sized, I: Integrator<S> + ?Sized>(
        &mut self,
        job: &Job<'_, N, S, C, I>,
        pass: u32,
        threads: &Threads,
        film: &mut Film,
        counters: &mut Counters,
    ) -> Duration {
        let Self { pixels, length, free } = self;
        let (pixels, length, next) = (*pixels, *length, AtomicU32::new(0));
        let merge = Mutex::new(Merge { free, early: BTreeMap::new(), turn: 0, film, counters, time: Duration::ZERO });
        threads.for_each(threads.count(), &|_| {
            let (mut samples, mut scratch) = (Vec::new(), Scratch::default());
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= pixels.div_ceil(length) {
                    break;
                }
                let free = lock(&merge).free.pop();
                let mut slot =
                    free.unwrap_or_else(|| Slot { film: ChunkFilm::new(job.region), counters: Counters::default(), time: Duration::ZERO });
                let first = number * length;
                // Written this way round, the end cannot overflow.
                job.render_chunk(first..first + length.min(pixels - first), pass, &mut samples, &mut scratch, &mut slot);
                lock(&merge).take(number, slot);
            }
        });
        lock(&merge).time
    }
}

/// A thread that panicked ends the rendering anyway.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a, N: SampleSource, S: Scene + ?Sized, C: Camera + ?Sized, I: Integrator<S> + ?Sized> Job<'a, N, S, C, I> {
    fn render_chunk(
        &self,
        pixels: Range<u32>,
        pass: u32,
        samples: &mut Vec<BatchSample<N::Sampler>>,
        scratch: &mut Scratch<'a, S>,
        slot: &mut Slot,
    ) {
        let start = Instant::now();
        slot.film.clear();
        for first in pixels.clone().step_by(BATCH) {
            let pixels = first..pixels.end.min(first + BATCH as u32);
            slot.film.begin_samples(pixels.clone(), pass);
            samples.clear();
            samples.extend(pixels.map(|pixel| {
                let mut sampler = self.source.sampler(pixel, pass);
                BatchSample { film: FilmSample::draw(&self.region, pixel, &self.kernel, &mut sampler), sampler }
            }));
            self.integrator.sample_batch(self.scene, self.camera, samples, &mut slot.film, scratch);
        }
        slot.film.finish();
        slot.counters = std::mem::take(&mut scratch.counters);
        slot.counters.non_finite += slot.film.non_finite().count();
        slot.time = start.elapsed();
    }
}
