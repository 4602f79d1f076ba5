//! Paths that advance together, from vertex to vertex, so that a scene gets many rays at a time (Laine, Karras and Aila 2013).

use super::{Counters, RandomWalk, Vertex};
use crate::film::{BatchSink, Contribution};
use crate::geometry::SurfacePoint;
use crate::math::PerProjected;
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

// Written by hand: a derive would ask for bounds on `S`.
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
