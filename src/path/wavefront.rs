//! Paths that advance together, from vertex to vertex, so that a scene gets many rays at a time (Laine, Karras and Aila 2013).

use super::{Counters, RandomWalk, Roulette, Scattered, Vertex};
use crate::film::{BatchSample, BatchSink, Contribution};
use crate::geometry::SurfacePoint;
use crate::math::PerProjected;
use crate::sampler::Sampler;
use crate::scene::Scene;

/// A path that grows.
pub(crate) struct GrowingPath<'s, S: Scene + ?Sized + 's> {
    /// The number of its sample.
    pub sample: usize,
    pub walk: RandomWalk<'s, S>,
    /// Density of the walk's direction at the vertex before.
    pub pdf_next: PerProjected,
    /// Whether a connection could have drawn the path from there.
    pub competes: bool,
}

impl<'s, S: Scene + ?Sized + 's> GrowingPath<'s, S> {
    #[inline]
    pub fn new(sample: usize, walk: RandomWalk<'s, S>) -> Self {
        Self { sample, walk, pdf_next: PerProjected::ZERO, competes: false }
    }
}

/// Segments that make up for the start and the end of a query.
const MANY: usize = 64;

/// The walks of a sample.
pub(crate) struct Walks<'s, S: Scene + ?Sized + 's> {
    /// Vertices of the camera walk, from the lens.
    pub camera: Vec<Vertex<S::Bsdf<'s>>>,
    /// Vertices of the light walk under way, from the light.
    pub light: Vec<Vertex<S::Bsdf<'s>>>,
    /// The number of light walks.
    pub light_walks: u32,
}

/// What a sample contributes if two points see each other.
pub(crate) struct Segment {
    pub sample: usize,
    pub ends: [SurfacePoint; 2],
    pub contribution: Contribution,
}

/// The paths of a batch that are under way.
pub(crate) struct Wavefront<'s, S: Scene + ?Sized + 's> {
    pub paths: Vec<GrowingPath<'s, S>>,
    /// Where each path has arrived.
    vertices: Vec<Option<Vertex<S::Bsdf<'s>>>>,
    /// What is yet to be tested for visibility.
    pub segments: Vec<Segment>,
}

// Written by hand: derives would ask for bounds on `S`.
impl<'s, S: Scene + ?Sized + 's> Default for Walks<'s, S> {
    fn default() -> Self {
        Self { camera: Vec::new(), light: Vec::new(), light_walks: 0 }
    }
}

impl<'s, S: Scene + ?Sized + 's> Default for Wavefront<'s, S> {
    fn default() -> Self {
        Self { paths: Vec::new(), vertices: Vec::new(), segments: Vec::new() }
    }
}

impl<'s, S: Scene + ?Sized + 's> Wavefront<'s, S> {
    /// Traces one ray for each path, and shows each path with the vertex where it has arrived, or `None`.
    #[inline]
    pub fn arrive(
        &mut self,
        scene: &S,
        counters: &mut Counters,
        mut visit: impl FnMut(&mut GrowingPath<'s, S>, &mut Vertex<S::Bsdf<'s>>, &mut Vec<Segment>, &mut Counters) -> bool,
    ) {
        let Self { paths, vertices, segments } = self;
        counters.closest_rays += paths.len() as u64;
        vertices.clear();
        vertices.resize_with(paths.len(), || None);
        scene.intersect_many(paths.iter().map(|path| path.walk.ray()), |i, point| vertices[i] = paths[i].walk.vertex_at(point));
        for (path, vertex) in paths.iter_mut().zip(vertices) {
            path.walk.count_vertex(vertex.as_ref(), counters);
            if vertex.as_mut().is_some_and(|vertex| !visit(path, vertex, segments, counters)) {
                *vertex = None;
            }
        }
    }

    /// Keeps the paths of which `scatter` says that they go on.
    #[inline]
    pub fn scatter(&mut self, mut scatter: impl FnMut(&mut GrowingPath<'s, S>, &mut Vertex<S::Bsdf<'s>>) -> bool) {
        let Self { paths, vertices, .. } = self;
        for i in (0..paths.len()).rev() {
            if !vertices[i].as_mut().is_some_and(|vertex| scatter(&mut paths[i], vertex)) {
                paths.swap_remove(i);
            }
        }
    }

    /// Lets the paths walk until absorption, escape, roulette or `max_bounces` scattering events, and hands each vertex to `keep` with the number
    /// of the sample, which says of the first surface whether to go on.
    #[inline]
    pub fn record<P: Sampler>(
        &mut self,
        scene: &S,
        max_bounces: u32,
        roulette: &Roulette,
        samples: &mut [BatchSample<P>],
        counters: &mut Counters,
        mut keep: impl FnMut(usize, Vertex<S::Bsdf<'s>>) -> bool,
    ) {
        while !self.paths.is_empty() {
            self.arrive(scene, counters, |_, _, _, _| true);
            for i in (0..self.paths.len()).rev() {
                let GrowingPath { sample, walk, .. } = &mut self.paths[i];
                let mut goes_on = false;
                if let Some(mut vertex) = self.vertices[i].take() {
                    if walk.vertices() > max_bounces {
                        walk.truncate(counters);
                    } else {
                        let scattered = walk.scatter(&mut vertex, roulette, &mut samples[*sample].sampler, counters);
                        goes_on = matches!(scattered, Scattered::On { .. });
                    }
                    goes_on = (keep(*sample, vertex) || walk.vertices() > 1) && goes_on;
                }
                if !goes_on {
                    self.paths.swap_remove(i);
                }
            }
        }
    }

    /// Tests the segments if there are enough of them.
    #[inline]
    pub fn test_many(&mut self, scene: &S, sink: &mut impl BatchSink) {
        if self.segments.len() >= MANY {
            self.test(scene, sink);
        }
    }

    /// Tests the segments and gives what is visible to the sink.
    #[inline]
    pub fn test(&mut self, scene: &S, sink: &mut impl BatchSink) {
        let segments = &self.segments;
        scene.visible_many(segments.iter().map(|Segment { ends: [a, b], .. }| (a, b)), |i, visible| {
            if visible {
                sink.add(segments[i].sample, &segments[i].contribution);
            }
        });
        self.segments.clear();
    }
}
