//! The passes over the window: threads take chunks as they come, and what was recorded is merged in
//! the order of their numbers.
//!
//! The calling thread merges, and renders like the others while there is nothing to merge. At the
//! end of a pass threads go on with the next one instead of waiting for each other; a slow chunk
//! costs memory for those behind it, but no time.

use super::queue::{Queue, Turn};
use super::settings::Threads;
use crate::endpoint::Camera;
use crate::film::{BatchSample, ChunkFilm, Film, FilmRegion, FilmSample, Kernel};
use crate::integrator::Integrator;
use crate::path::{Counters, Scratch};
use crate::sampler::SampleSource;
use crate::scene::Scene;
use std::ops::{ControlFlow, Range};
use std::sync::{Mutex, PoisonError};
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

/// What the samples so far amount to.
pub(super) struct Totals {
    pub film: Film,
    pub counters: Counters,
    /// Time that all threads together spent on them.
    pub thread_time: Duration,
}

/// Samples that an integrator gets at a time: enough rays for the scene, and their paths stay in
/// the nearest memory.
const BATCH: usize = 128;

/// Chunks per thread that may be begun beyond the pass under way.
const AHEAD: u64 = 4;

/// How a pass is cut into chunks.
struct Partition {
    pixels: u32,
    /// Pixels per chunk: a function of the window alone, because the grouping of sums depends on
    /// it.
    length: u32,
}

impl Partition {
    fn new(region: FilmRegion) -> Self {
        let pixels = region.pixels();
        // Small windows are cut finer so that they keep all threads busy.
        Self { pixels, length: pixels.div_ceil(64).clamp(16, 256) }
    }

    /// Chunks per pass.
    fn chunks(&self) -> u64 {
        u64::from(self.pixels.div_ceil(self.length))
    }

    /// The pixels and the pass of a chunk.
    fn samples(&self, number: u64) -> (Range<u32>, u32) {
        let first = (number % self.chunks()) as u32 * self.length;
        // Written this way round, the end cannot overflow.
        (first..first + self.length.min(self.pixels - first), (number / self.chunks()) as u32)
    }
}

/// What one chunk did.
struct Record {
    film: ChunkFilm,
    counters: Counters,
    time: Duration,
}

/// What a thread works with.
struct Workbench<'a, P, S: Scene + ?Sized> {
    samples: Vec<BatchSample<P>>,
    scratch: Scratch<'a, S>,
}

impl<'a, N: SampleSource, S: Scene + ?Sized, C: Camera + ?Sized, I: Integrator<S> + ?Sized>
    Job<'a, N, S, C, I>
{
    /// Renders at most so many passes of one sample per pixel. `after_pass` gets to know each, and
    /// what there is after it, and says whether another one follows.
    pub fn run(
        &self,
        most: u32,
        threads: &Threads,
        totals: &mut Totals,
        mut after_pass: impl FnMut(u32, &Totals) -> ControlFlow<()>,
    ) {
        let partition = Partition::new(self.region);
        let (chunks, ahead) = (partition.chunks(), AHEAD * threads.count() as u64);
        let queue = Queue::new();
        // Records are used again for their memory.
        let merged = Mutex::new(Vec::new());
        let merged = || merged.lock().unwrap_or_else(PoisonError::into_inner);
        let render = |number, bench: &mut _| {
            let record = merged().pop();
            queue.finish(number, self.render(partition.samples(number), bench, record));
        };
        let worker = || {
            let mut bench = Workbench::new();
            queue.work(|number| render(number, &mut bench));
        };
        threads.with_workers(&worker, |start_worker| {
            let mut bench = Workbench::new();
            let mut next = 0;
            for pass in 1..=most {
                let end = u64::from(pass) * chunks;
                let missing =
                    queue.open((end + ahead).min(u64::from(most) * chunks), threads.count() - 1);
                (0..missing).for_each(|_| start_worker());
                while next < end {
                    match queue.turn(next..end) {
                        Turn::Take(records) => {
                            next += records.len() as u64;
                            records.iter().for_each(|record| totals.add(record));
                            merged().extend(records);
                        }
                        Turn::Render(number) => render(number, &mut bench),
                        Turn::End => return,
                    }
                }
                if after_pass(pass, totals).is_break() {
                    break;
                }
            }
            queue.close();
        });
    }

    fn render(
        &self,
        (pixels, pass): (Range<u32>, u32),
        Workbench { samples, scratch }: &mut Workbench<'a, N::Sampler, S>,
        record: Option<Record>,
    ) -> Record {
        let start = Instant::now();
        let mut film = record.map_or_else(|| ChunkFilm::new(self.region), |record| record.film);
        film.clear();
        for first in pixels.clone().step_by(BATCH) {
            let pixels = first..pixels.end.min(first + BATCH as u32);
            film.begin_samples(pixels.clone(), pass);
            samples.clear();
            samples.extend(pixels.map(|pixel| {
                let mut sampler = self.source.sampler(pixel, pass);
                BatchSample {
                    film: FilmSample::draw(&self.region, pixel, &self.kernel, &mut sampler),
                    sampler,
                }
            }));
            self.integrator.sample_batch(self.scene, self.camera, samples, &mut film, scratch);
        }
        film.finish();
        let mut counters = std::mem::take(&mut scratch.counters);
        counters.non_finite += film.non_finite().count();
        Record { film, counters, time: start.elapsed() }
    }
}

impl<P, S: Scene + ?Sized> Workbench<'_, P, S> {
    fn new() -> Self {
        Self { samples: Vec::new(), scratch: Scratch::default() }
    }
}

impl Totals {
    fn add(&mut self, record: &Record) {
        self.film.merge(&record.film);
        self.counters += record.counters;
        self.thread_time += record.time;
    }
}
