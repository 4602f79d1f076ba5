//! Light walks of a pass that all pixels share, and the steps of a light walk that keeps its
//! vertices.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use crate::film::{Contribution, FilmSample, Sample};
use crate::integrator::{Crew, IntegratorError};
use crate::path::{
    Counters, Plan, RandomWalk, Roulette, Scratch, Site, Steps, Vertex, Visit, advance, join,
};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::{Needs, Scene};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

/// Walks from the light that keep their vertices, for the samples that have more than `number` of
/// them.
#[derive(Clone, Copy, Debug)]
pub struct LightWalks<'r> {
    /// Termination.
    pub roulette: &'r Roulette,
    /// The number of light walks that the samples had before this one.
    pub number: u32,
    /// Scattering events of the shortest path that the first surface of a walk is part of, so that
    /// no walk scatters for paths that are too long to count.
    pub shortest: u32,
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for LightWalks<'_> {
    const KEEPS: bool = true;

    #[inline]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let Site { plan: Plan { stage, depth, .. }, sample, subpaths, counters, .. } = site;
        subpaths.light.clear();
        if self.number >= subpaths.light_subpaths {
            return None;
        }
        let (walk, start) = RandomWalk::from_light(stage, &mut sample.sampler, counters)?;
        subpaths.light.push(start);
        let has_use = stage.needs.contains(Needs::FINITE_LOBES) && depth.limit() >= self.shortest;
        walk?.if_useful(has_use, counters)
    }

    #[inline]
    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.limit(visit.plan.depth.limit().saturating_sub(self.shortest))
    }

    #[inline]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.scatter(self.roulette).flow()
    }
}

/// The light walks of a pass, which all its samples share.
pub struct SharedWalks<'r, 'a, S: Scene + ?Sized> {
    /// The stage, and the path lengths that count.
    pub plan: &'r Plan<'a, S>,
    /// Termination.
    pub roulette: &'r Roulette,
    /// Number of walks.
    pub count: u32,
    /// Scattering events of the shortest path that the first surface of a walk is part of.
    pub shortest: u32,
}

/// Walks that a thread draws at a time.
const CHUNK: u32 = 256;

impl<'a, S: Scene + ?Sized + 'a> SharedWalks<'_, 'a, S> {
    /// Draws the walks of a pass and collects what `read` takes from the vertices of each, in the
    /// order of the walks; with counts of what was done.
    ///
    /// Their random numbers follow from the rendering's seed, and are none of those that samples
    /// take: a walk made of the numbers of the sample that it contributes to would be a bias.
    ///
    /// # Errors
    /// If there is no memory for what is collected.
    pub fn draw<T: Send + Sync>(
        &self,
        pass: u32,
        crew: &dyn Crew,
        integrator: &'static str,
        read: impl Fn(&mut Vec<Vertex<S::Bsdf<'a>>>, &mut Vec<T>) + Sync,
    ) -> Result<(Vec<T>, Counters), IntegratorError> {
        let reserved = |count: usize| {
            let mut room = Vec::<T>::new();
            room.try_reserve_exact(count).map(|()| room).map_err(|_| {
                let walks = self.count;
                let reason = format!("no memory for {count} vertices of {walks} light walks");
                IntegratorError { integrator, reason }
            })
        };
        // A walk leaves about one or more: what has no room is refused before hours of walks.
        drop(reserved(self.count as usize)?);
        let source = Independent { seed: self.plan.stage.seed ^ OWN_NUMBERS };
        let steps = LightWalks { roulette: self.roulette, number: 0, shortest: self.shortest };
        let (nowhere, benches) = (|_: usize, _: &Contribution| {}, Mutex::new(Vec::new()));
        let benches = || benches.lock().unwrap_or_else(PoisonError::into_inner);
        let chunks = crew.collect(self.count.div_ceil(CHUNK) as usize, |chunk| {
            let mut scratch: Scratch<'a, S> = benches().pop().unwrap_or_default();
            let first = chunk as u32 * CHUNK;
            let walks = first..first + CHUNK.min(self.count - first);
            let film = FilmSample::default();
            let sample = |walk| Sample { film, sampler: source.sampler(walk, pass) };
            let mut samples: Vec<_> = walks.map(sample).collect();
            let (mut taken, nowhere) = (Vec::new(), &mut { nowhere });
            join(self.plan, &mut samples, nowhere, &mut scratch, |site| {
                site.subpaths.light_subpaths = 1;
            });
            advance(self.plan, &steps, &mut samples, nowhere, &mut scratch);
            join(self.plan, &mut samples, nowhere, &mut scratch, |site| {
                read(&mut site.subpaths.light, &mut taken);
            });
            let counters = std::mem::take(&mut scratch.counters);
            benches().push(scratch);
            (taken, counters)
        });
        let mut all = reserved(chunks.iter().map(|(taken, _)| taken.len()).sum())?;
        let mut counters = Counters::default();
        for (taken, done) in chunks {
            all.extend(taken);
            counters += done;
        }
        Ok((all, counters))
    }
}

/// Tells the numbers of shared walks from those of samples.
const OWN_NUMBERS: u64 = 0x6c69_6768_7420_7761;
