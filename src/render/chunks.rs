//! The passes over the window: threads take chunks as they come, and what was recorded is merged in
//! the order of their numbers.
//!
//! The calling thread merges, and renders like the others while there is nothing to merge. At the
//! end of a pass threads go on with the next one instead of waiting for each other; a slow chunk
//! costs memory for those behind it, but no time.

use super::RenderError;
use super::queue::{Queue, Turn};
use super::settings::Threads;
use super::state::State;
use crate::film::{ChunkFilm, Film, FilmRegion, FilmSample, Kernel, Sample};
use crate::integrator::{AnyRun, Crew};
use crate::path::{Counters, Scratch};
use crate::sampler::SampleSource;
use crate::scene::Scene;
use std::ops::{ControlFlow, Range};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// Everything that the samples of a rendering share.
pub(super) struct Job<'j, N> {
    pub source: &'j N,
    pub kernel: Kernel,
    pub region: FilmRegion,
    pub threads: &'j Threads,
}

/// Samples that an integrator gets at a time: enough rays for the scene, and their paths stay in
/// the nearest memory.
const BATCH: usize = 256;

/// Chunks per thread that may be begun beyond the pass under way.
const AHEAD: u64 = 4;

/// The partition of a pass into chunks.
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

/// The results of a chunk.
struct Record {
    film: ChunkFilm,
    counters: Counters,
    time: Duration,
}

/// The working memory of a thread.
struct Workbench<'a, P, S: Scene + ?Sized> {
    samples: Vec<Sample<P>>,
    scratch: Scratch<'a, S>,
}

impl<N: SampleSource> Job<'_, N> {
    /// Renders the passes of one sample per pixel that follow those of the state, up to `end`.
    /// `after_pass` gets to know what there is after each, and says whether another one follows.
    pub fn render<'a, S: Scene + ?Sized + 'a>(
        &self,
        run: &mut dyn AnyRun<'a, S, N::Sampler>,
        end: u32,
        state: &mut State,
        crew: &dyn Crew,
        mut after_pass: impl FnMut(&mut State) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        let first = state.passes.end;
        if !run.prepares() {
            let run = &*run;
            let draw = |samples: &mut [_], film: &mut ChunkFilm, scratch: &mut _, chunk| {
                run.draw(samples, film, chunk, scratch);
            };
            self.passes(first..end, &draw, state, after_pass);
            return Ok(());
        }
        run.keep_chunks(Partition::new(self.region).chunks() as usize);
        // The passes that a run has to learn from although their sums are there already.
        let known = if run.learns() { 0..first } else { first..first };
        let unused = (!known.is_empty()).then(|| Film::new(self.region)).transpose()?;
        let mut unused = unused.map(|film| State::before(0, film));
        for pass in known.start..end {
            run.begin_pass(pass, crew)?;
            let state = match &mut unused {
                Some(unused) if pass < first => unused,
                _ => &mut *state,
            };
            state.counters.add(&Counters { samples: 0, ..run.take_preparation() });
            let drawing = &*run;
            let draw = |samples: &mut [_], film: &mut ChunkFilm, scratch: &mut _, chunk| {
                drawing.draw(samples, film, chunk, scratch);
            };
            self.passes(pass..pass + 1, &draw, state, |_| ControlFlow::Continue(()));
            run.collect();
            if pass >= first && after_pass(state).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Draws a range of passes, which threads need not end together. `draw` gets samples, where
    /// they go, and the number of their chunk in the pass.
    fn passes<'a, S: Scene + ?Sized + 'a>(
        &self,
        passes: Range<u32>,
        draw: &(impl Fn(&mut [Sample<N::Sampler>], &mut ChunkFilm, &mut Scratch<'a, S>, usize) + Sync),
        state: &mut State,
        mut after_pass: impl FnMut(&mut State) -> ControlFlow<()>,
    ) {
        let partition = Partition::new(self.region);
        let (chunks, threads) = (partition.chunks(), self.threads);
        let (ahead, last) = (AHEAD * threads.count() as u64, u64::from(passes.end) * chunks);
        let queue = Queue::new(u64::from(passes.start) * chunks);
        // Records are used again for their memory.
        let merged = Mutex::new(Vec::new());
        let merged = || merged.lock().unwrap_or_else(PoisonError::into_inner);
        let render = |number, bench: &mut _| {
            let record = merged().pop();
            let chunk = (number % chunks) as usize;
            let draw = |samples: &mut _, film: &mut _, scratch: &mut _| {
                draw(samples, film, scratch, chunk)
            };
            queue.finish(number, self.chunk(partition.samples(number), bench, record, draw));
        };
        let worker = || {
            let mut bench = Workbench::new();
            queue.work(|number| render(number, &mut bench));
        };
        threads.with_workers(&worker, |start_worker| {
            let mut bench = Workbench::new();
            let mut next = u64::from(passes.start) * chunks;
            for pass in passes {
                let end = (u64::from(pass) + 1) * chunks;
                let missing = queue.open((end + ahead).min(last), threads.count() - 1);
                (0..missing).for_each(|_| start_worker());
                while next < end {
                    match queue.turn(next..end) {
                        Turn::Take(records) => {
                            next += records.len() as u64;
                            for Record { film, counters, time } in &records {
                                state.add(film, counters, *time);
                            }
                            merged().extend(records);
                        }
                        Turn::Render(number) => render(number, &mut bench),
                        Turn::End => return,
                    }
                }
                state.passes.end = pass + 1;
                if after_pass(state).is_break() {
                    break;
                }
            }
            queue.close();
        });
    }

    fn chunk<'a, S: Scene + ?Sized + 'a>(
        &self,
        (pixels, pass): (Range<u32>, u32),
        Workbench { samples, scratch }: &mut Workbench<'a, N::Sampler, S>,
        record: Option<Record>,
        draw: impl Fn(&mut [Sample<N::Sampler>], &mut ChunkFilm, &mut Scratch<'a, S>),
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
                let film = FilmSample::draw(&self.region, pixel, &self.kernel, &mut sampler);
                Sample { film, sampler }
            }));
            draw(samples, &mut film, scratch);
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
