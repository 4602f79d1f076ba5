//! One pass over the window: chunks in parallel, merged in order.

use super::settings::Threads;
use crate::endpoint::Camera;
use crate::film::{ChunkFilm, Film, FilmRegion, FilmSample, Kernel};
use crate::integrator::Integrator;
use crate::path::{Counters, Scratch};
use crate::sampler::SampleSource;
use crate::scene::Scene;
use std::ops::Range;
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

/// What one chunk did.
struct Slot {
    film: ChunkFilm,
    counters: Counters,
    time: Duration,
}

/// The partition of a pass and the memory of the chunks that are under way at the same time.
pub(super) struct Chunks {
    pixels: u32,
    /// Pixels per chunk: a function of the window alone, because the grouping of sums depends on it.
    length: u32,
    slots: Vec<Slot>,
}

impl Chunks {
    /// Enough chunks at a time that threads rarely wait for the last one, few enough that the memory of recorded contributions stays small.
    const PER_THREAD: usize = 16;

    pub fn new(region: FilmRegion, threads: usize) -> Self {
        let pixels = region.pixels();
        // Small windows are cut finer so that they keep all threads busy.
        let length = pixels.div_ceil(64).clamp(16, 256);
        let count = (threads.saturating_mul(Self::PER_THREAD)).min(1024).min(pixels.div_ceil(length) as usize);
        let slot = || Slot { film: ChunkFilm::new(region), counters: Counters::default(), time: Duration::ZERO };
        Self { pixels, length, slots: std::iter::repeat_with(slot).take(count).collect() }
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
        let mut time = Duration::ZERO;
        let mut start = 0;
        while start < self.pixels {
            let remaining = (self.pixels - start).div_ceil(self.length) as usize;
            let group = self.slots.len().min(remaining);
            let slots = &mut self.slots[..group];
            for_each_slot(threads, slots, |scratch, i, slot| {
                let first = start + i as u32 * self.length;
                // Written this way round, the end cannot overflow.
                job.render_chunk(first..first + self.length.min(self.pixels - first), pass, scratch, slot);
            });
            for slot in slots {
                film.merge(&slot.film);
                *counters += slot.counters;
                time += slot.time;
            }
            let done = group as u64 * u64::from(self.length);
            start = (u64::from(start) + done).min(u64::from(self.pixels)) as u32;
        }
        time
    }
}

impl<'a, N: SampleSource, S: Scene + ?Sized, C: Camera + ?Sized, I: Integrator<S> + ?Sized> Job<'a, N, S, C, I> {
    fn render_chunk(&self, pixels: Range<u32>, pass: u32, scratch: &mut Scratch<'a, S>, slot: &mut Slot) {
        let start = Instant::now();
        slot.film.clear();
        for pixel in pixels {
            let mut sampler = self.source.sampler(pixel, pass);
            let film = FilmSample::draw(&self.region, pixel, &self.kernel, &mut sampler);
            slot.film.begin_sample(pixel, pass);
            self.integrator.sample(self.scene, self.camera, film, &mut sampler, &mut slot.film, scratch);
        }
        slot.film.finish();
        slot.counters = std::mem::take(&mut scratch.counters);
        slot.counters.non_finite += slot.film.non_finite().count();
        slot.time = start.elapsed();
    }
}

/// Calls `work` for every slot and its number, on the given threads. Scratch memory is shared between successive slots.
fn for_each_slot<'s, S: Scene + ?Sized + 's>(
    threads: &Threads,
    slots: &mut [Slot],
    work: impl Fn(&mut Scratch<'s, S>, usize, &mut Slot) + Sync,
) {
    match threads {
        Threads::Caller => {
            let mut scratch = Scratch::default();
            slots.iter_mut().enumerate().for_each(|(i, slot)| work(&mut scratch, i, slot));
        }
        #[cfg(feature = "parallel")]
        Threads::Current => for_each_slot_in_parallel(slots, work),
        #[cfg(feature = "parallel")]
        Threads::Own(pool) => pool.install(|| for_each_slot_in_parallel(slots, &work)),
    }
}

#[cfg(feature = "parallel")]
fn for_each_slot_in_parallel<'s, S: Scene + ?Sized + 's>(slots: &mut [Slot], work: impl Fn(&mut Scratch<'s, S>, usize, &mut Slot) + Sync) {
    use rayon::prelude::*;
    slots.par_iter_mut().enumerate().for_each_init(Scratch::default, |scratch, (i, slot)| work(scratch, i, slot));
}
