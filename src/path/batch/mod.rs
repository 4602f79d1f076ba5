//! Walks that advance together, from vertex to vertex, so that a scene gets many rays at a time and
//! arithmetic goes in lanes (Laine, Karras and Aila 2013).

mod lens;
mod next_event;
mod rooms;
mod scattering;

pub(super) use rooms::Rooms;

use super::columns::{Columns, Shared};
use super::scratch::Advancing;
use super::steps::Drawn;
use super::{DiffuseSteps, End, Out, Plan, Scratch, Site, Steps, Vertex, Visit};
use crate::bsdf::TransportMode;
use crate::film::{Sample, Sink};
use crate::geometry::SurfacePoint;
use crate::sampler::Sampler;
use crate::scene::{FlatSurfaces, Scene};
use std::ops::ControlFlow;

/// Draws one walk for each sample and lets all of them advance together until the steps end them or
/// no ray meets anything. Contributions go to the sink with the numbers of their samples.
#[inline]
pub fn advance<'s, S: Scene + ?Sized, W: Steps<'s, S>, P: Sampler>(
    plan: &Plan<'s, S>,
    steps: &W,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    scratch: &mut Scratch<'s, S>,
) {
    let diffuse = diffuse_steps(plan, steps);
    let mut batch = Batch { plan, samples, sink, scratch };
    batch.scratch.make_room(batch.samples.len());
    if !diffuse.is_some_and(|diffuse| batch.in_columns(&diffuse, Columns::begin)) {
        begin(plan, steps, batch.samples, batch.sink, batch.scratch);
    }
    while !(batch.scratch.walks.is_empty() && batch.scratch.columns.is_empty()) {
        batch.trace(W::KEEPS, diffuse.map(|(_, flats)| flats));
        if !batch.scratch.walks.is_empty() {
            batch.arrive(steps);
            batch.leave(steps);
        }
        if let Some(diffuse) = &diffuse {
            batch.in_columns(diffuse, Columns::visit);
        }
        batch.test_shadow_rays();
        batch.scatter(steps);
    }
}

/// The steps at diffuse vertices, and the surfaces that have such, if they can be taken in columns.
fn diffuse_steps<'s, S: Scene + ?Sized, W: Steps<'s, S>>(
    plan: &Plan<'s, S>,
    steps: &W,
) -> Option<(DiffuseSteps, FlatSurfaces<'s>)> {
    let steps = steps.at_diffuse(plan).filter(|_| !W::KEEPS)?;
    let Plan { stage, techniques, .. } = plan;
    let flats = stage.scene.flat_surfaces()?;
    let fits = (!techniques.lens_sampling || stage.camera.as_pinhole().is_some())
        && (!techniques.next_event || flats.has_flat_lights())
        && steps.heuristic.is_in_lanes()
        && steps.roulette.constant.is_black();
    fits.then_some((steps, flats))
}

/// Shows `visit` each sample with its subpaths, and tests the shadow rays of all of them.
#[inline]
pub fn join<'s, S: Scene + ?Sized, P: Sampler>(
    plan: &Plan<'s, S>,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    scratch: &mut Scratch<'s, S>,
    mut visit: impl FnMut(&mut Site<'_, 's, S, P>),
) {
    scratch.make_room(samples.len());
    let Scratch { counters, subpaths, connections, pairs, level, .. } = scratch;
    for (number, (sample, subpaths)) in samples.iter_mut().zip(&mut *subpaths).enumerate() {
        let out = Out { sample: number, sink: &mut *sink, connections };
        pairs.clear();
        let level = *level;
        visit(&mut Site { plan, sample, subpaths, out, counters, pairs, level });
    }
    connections.test(plan.stage.scene, subpaths, sink);
}

/// Begins the walk of each sample.
#[inline]
fn begin<'s, S: Scene + ?Sized, W: Steps<'s, S>, P: Sampler>(
    plan: &Plan<'s, S>,
    steps: &W,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    scratch: &mut Scratch<'s, S>,
) {
    let mut walks = std::mem::take(&mut scratch.walks);
    walks.clear();
    let mut sample = 0;
    join(plan, samples, sink, scratch, |site| {
        if let Some(walk) = steps.begin(site) {
            let next = if W::KEEPS { site.subpaths.of(walk.mode()).len() as u32 } else { 0 };
            walks.push(Advancing { sample, walk, next });
        }
        sample += 1;
    });
    scratch.walks = walks;
}

/// The walks of samples that advance together.
struct Batch<'b, 's, S: Scene + ?Sized + 's, P> {
    plan: &'b Plan<'s, S>,
    samples: &'b mut [Sample<P>],
    sink: &'b mut dyn Sink,
    scratch: &'b mut Scratch<'s, S>,
}

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Batch<'_, 's, S, P> {
    /// Traces the next ray of each walk and enters what it meets in its subpath.
    #[inline]
    fn trace(&mut self, keeps: bool, flats: Option<FlatSurfaces<'s>>) {
        let Scratch { counters, subpaths, walks, has_ended, drawn, columns, .. } =
            &mut *self.scratch;
        counters.closest_rays += walks.len() as u64;
        has_ended.clear();
        has_ended.resize(walks.len(), true);
        // Returns false if the walk ends.
        let mut meet = |path: &Advancing<'s, S>, point: Option<SurfacePoint>| {
            let Advancing { sample, walk, next } = path;
            let vertices = subpaths[*sample].of(walk.mode());
            // Written where the one before was, if only the last one is kept.
            if vertices.len() <= *next as usize {
                vertices.push(Vertex::blank());
            }
            let has_met = walk.meet(point, &mut vertices[*next as usize]);
            if keeps && !has_met {
                vertices.pop();
            }
            has_met
        };
        let scene = self.plan.stage.scene;
        scene.intersect_many(walks.iter().map(|path| path.walk.ray()), |i, point| {
            let path = &walks[i];
            if let (Some(flats), Some(point)) = (&flats, &point)
                && columns.accept(flats, path.sample, &path.walk, point)
            {
                return;
            }
            has_ended[i] = !meet(path, point);
            if has_ended[i] {
                path.walk.count_escape(counters);
            }
        });
        if let Some(flats) = &flats {
            columns.trace(&self.plan.stage, flats, counters, |sample, walk, point| {
                let path = Advancing { sample: sample as usize, walk, next: 0 };
                if meet(&path, point) {
                    walks.push(path);
                    has_ended.push(false);
                    return true;
                }
                false
            });
        }
        drawn.resize(drawn.len().max(walks.len()), Drawn::Nothing);
    }

    /// Does something with the walks in columns.
    #[inline]
    fn in_columns<R>(
        &mut self,
        &(steps, flats): &(DiffuseSteps, FlatSurfaces<'s>),
        done: impl FnOnce(&mut Columns<'s>, &mut Shared<'_, 's, S, P>) -> R,
    ) -> R {
        let Scratch { counters, columns, connections, level, .. } = &mut *self.scratch;
        let (plan, samples, sink) = (self.plan, &mut *self.samples, &mut *self.sink);
        let level = *level;
        let shared =
            &mut Shared { plan, flats, steps, samples, sink, connections, counters, level };
        done(columns, shared)
    }

    /// Visits the walks that have not ended, each with its number; a break ends it.
    #[inline(always)]
    fn visit(&mut self, mut visit: impl FnMut(usize, &mut Visit<'_, 's, S, P>) -> ControlFlow<()>) {
        let (plan, samples, sink) = (self.plan, &mut *self.samples, &mut *self.sink);
        let Scratch { counters, subpaths, walks, has_ended, drawn, connections, .. } =
            &mut *self.scratch;
        let paths = walks.iter_mut().zip(has_ended).zip(drawn).enumerate();
        for (i, ((path, has_ended), drawn)) in paths {
            if *has_ended {
                continue;
            }
            let Advancing { sample: number, walk, next } = path;
            let (mode, sample) = (walk.mode(), &mut samples[*number]);
            let vertex = &mut subpaths[*number].of(mode)[*next as usize];
            let out = Out { sample: *number, sink: &mut *sink, connections };
            let end = End::of(mode, *next);
            let visited = &mut Visit { plan, walk, vertex, end, sample, out, counters, drawn };
            *has_ended = visit(i, visited).is_break();
        }
    }

    /// Shows the steps where each walk has arrived, and samples the point that the vertex is
    /// connected to.
    #[inline]
    fn arrive<W: Steps<'s, S>>(&mut self, steps: &W) {
        let mut rooms = std::mem::take(&mut self.scratch.rooms);
        rooms.clear();
        let plan = self.plan;
        self.visit(|i, visit| {
            *visit.drawn = Drawn::Nothing;
            steps.arrive(visit)?;
            if W::CONNECTS && visit.is_connected() && steps.samples_point(visit) {
                match visit.walk.mode() {
                    TransportMode::Radiance => rooms.next_event(plan, i, visit),
                    TransportMode::Importance => rooms.lens_connection(plan, i, visit),
                }
            }
            ControlFlow::Continue(())
        });
        rooms.connect(self.scratch.level, plan.stage.camera.as_pinhole());
        self.scratch.rooms = rooms;
    }

    /// Connects the vertices to the points that were sampled, and samples where the walks go on.
    #[inline]
    fn leave<W: Steps<'s, S>>(&mut self, steps: &W) {
        let mut rooms = std::mem::take(&mut self.scratch.rooms);
        self.visit(|i, visit| {
            if W::CONNECTS {
                rooms.connection(i, visit);
                steps.connect(visit);
            }
            steps.leave(visit)?;
            rooms.direction(i, visit)
        });
        rooms.sample_directions(self.scratch.level, &mut self.scratch.drawn);
        self.scratch.rooms = rooms;
    }

    #[inline]
    fn test_shadow_rays(&mut self) {
        let Scratch { connections, subpaths, .. } = &mut *self.scratch;
        connections.test(self.plan.stage.scene, subpaths, self.sink);
    }

    /// Shows the steps where the walks go on, and keeps those that do.
    #[inline]
    fn scatter<W: Steps<'s, S>>(&mut self, steps: &W) {
        self.visit(|_, visit| steps.scatter(visit));
        let Scratch { walks, has_ended, .. } = &mut *self.scratch;
        let mut has_ended = has_ended.iter();
        walks.retain_mut(|walk| {
            walk.next += u32::from(W::KEEPS);
            has_ended.next() == Some(&false)
        });
    }
}
