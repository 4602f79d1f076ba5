//! Paths that advance together, from vertex to vertex, so that a scene gets many rays at a time
//! (Laine, Karras and Aila 2013).

use super::{Counters, RandomWalk, Roulette, Scattered, Scratch, Vertex};
use crate::bsdf::Walk;
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

/// The walks of a sample.
pub(crate) struct Walks<'s, S: Scene + ?Sized + 's> {
    /// Vertices of the camera walk, from the lens.
    pub camera: Vec<Vertex<S::Bsdf<'s>>>,
    /// Vertices of the light walk under way, from the light.
    pub light: Vec<Vertex<S::Bsdf<'s>>>,
    /// The number of light walks.
    pub light_walks: u32,
}

/// An end of a segment.
#[derive(Clone, Copy)]
pub(crate) enum End {
    /// Where the path in this place has arrived.
    Arrival(u32),
    /// A vertex of the sample's camera walk.
    Camera(u32),
    /// A vertex of the sample's light walk.
    Light(u32),
    /// One of the points that were sampled for segments.
    Sampled(u32),
}

/// What a sample contributes if two points see each other.
pub(crate) struct Segment {
    pub sample: usize,
    pub ends: [End; 2],
    pub contribution: Contribution,
}

/// What is yet to be tested for visibility.
#[derive(Default)]
pub(crate) struct Segments {
    list: Vec<Segment>,
    sampled: Vec<SurfacePoint>,
    visible: Vec<bool>,
}

impl Segments {
    #[inline]
    pub fn push(&mut self, sample: usize, ends: [End; 2], contribution: Contribution) {
        self.list.push(Segment { sample, ends, contribution });
    }

    /// Keeps a point until the segments have been tested.
    #[inline]
    pub fn keep(&mut self, point: &SurfacePoint) -> End {
        self.sampled.push(*point);
        End::Sampled(self.sampled.len() as u32 - 1)
    }
}

/// The paths of a batch that are under way.
pub(crate) struct Wavefront<'s, S: Scene + ?Sized + 's> {
    pub paths: Vec<GrowingPath<'s, S>>,
    /// Where each path has arrived.
    vertices: Vec<Option<Vertex<S::Bsdf<'s>>>>,
    pub segments: Segments,
}

impl<'s, S: Scene + ?Sized + 's> Walks<'s, S> {
    #[inline]
    fn vertices(&mut self, walk: &RandomWalk<'s, S>) -> &mut Vec<Vertex<S::Bsdf<'s>>> {
        match walk.kind() {
            Walk::Camera => &mut self.camera,
            Walk::Light => &mut self.light,
        }
    }
}

// Written by hand: derives would ask for bounds on `S`.
impl<'s, S: Scene + ?Sized + 's> Default for Walks<'s, S> {
    fn default() -> Self {
        Self { camera: Vec::new(), light: Vec::new(), light_walks: 0 }
    }
}

impl<'s, S: Scene + ?Sized + 's> Default for Wavefront<'s, S> {
    fn default() -> Self {
        Self { paths: Vec::new(), vertices: Vec::new(), segments: Segments::default() }
    }
}

impl<'s, S: Scene + ?Sized + 's> Wavefront<'s, S> {
    /// Traces one ray for each path and shows `visit` those that arrive somewhere, with the vertex
    /// there as it is and as the end of segments. It says whether the path may go on.
    #[inline]
    pub fn arrive(
        &mut self,
        scene: &S,
        counters: &mut Counters,
        mut visit: impl FnMut(
            &GrowingPath<'s, S>,
            &Vertex<S::Bsdf<'s>>,
            End,
            &mut Segments,
            &mut Counters,
        ) -> bool,
    ) {
        let Self { paths, vertices, segments } = self;
        counters.closest_rays += paths.len() as u64;
        vertices.clear();
        vertices.resize_with(paths.len(), || None);
        scene.intersect_many(paths.iter().map(|path| path.walk.ray()), |i, point| {
            vertices[i] = paths[i].walk.vertex_at(point)
        });
        for (i, (path, vertex)) in paths.iter_mut().zip(vertices).enumerate() {
            path.walk.count_vertex(vertex.as_ref(), counters);
            if vertex.as_ref().is_some_and(|vertex| {
                !visit(path, vertex, End::Arrival(i as u32), segments, counters)
            }) {
                *vertex = None;
            }
        }
    }

    /// Keeps the paths that may go on and of which `scatter` says that they do.
    #[inline]
    pub fn scatter(
        &mut self,
        mut scatter: impl FnMut(&mut GrowingPath<'s, S>, &mut Vertex<S::Bsdf<'s>>) -> bool,
    ) {
        let Self { paths, vertices, .. } = self;
        for i in (0..paths.len()).rev() {
            if !vertices[i].as_mut().is_some_and(|vertex| scatter(&mut paths[i], vertex)) {
                paths.swap_remove(i);
            }
        }
    }

    /// Tests the segments and gives what is visible to the sink.
    #[inline]
    pub fn test(&mut self, scene: &S, walks: &[Walks<'s, S>], sink: &mut impl BatchSink) {
        let Self { vertices, segments: Segments { list, sampled, visible }, .. } = self;
        let point = |sample: usize, end: End| match end {
            End::Arrival(i) => vertices[i as usize].as_ref().map(|vertex| &vertex.point),
            End::Camera(i) => walks[sample].camera.get(i as usize).map(|vertex| &vertex.point),
            End::Light(i) => walks[sample].light.get(i as usize).map(|vertex| &vertex.point),
            End::Sampled(i) => sampled.get(i as usize),
        };
        // None is missing: what segments end at stays until they are tested.
        let ends = list.iter().filter_map(|Segment { sample, ends: [a, b], .. }| {
            point(*sample, *a).zip(point(*sample, *b))
        });
        visible.clear();
        visible.resize(list.len(), false);
        scene.visible_many(ends, |i, answer| visible[i] = answer);
        // In their own order and not in that of the answers, which depends on the instruction set.
        for (Segment { sample, contribution, .. }, _) in
            list.iter().zip(visible).filter(|(_, visible)| **visible)
        {
            sink.add(*sample, contribution);
        }
        list.clear();
        sampled.clear();
    }
}

impl<'s, S: Scene + ?Sized + 's> Scratch<'s, S> {
    /// Lets the paths of the wavefront walk until absorption, escape, roulette or `max_bounces`
    /// scattering events, and appends the vertices to the walks of their samples. At the first
    /// surface `goes_on` decides, too.
    #[inline]
    pub(crate) fn record<P: Sampler>(
        &mut self,
        scene: &S,
        max_bounces: u32,
        roulette: &Roulette,
        samples: &mut [BatchSample<P>],
        goes_on: impl Fn(&Vertex<S::Bsdf<'s>>) -> bool,
    ) {
        let Self { counters, walks, wavefront: Wavefront { paths, .. }, .. } = self;
        while !paths.is_empty() {
            counters.closest_rays += paths.len() as u64;
            scene.intersect_many(paths.iter().map(|path| path.walk.ray()), |i, point| {
                let GrowingPath { sample, walk, .. } = &paths[i];
                walks[*sample].vertices(walk).extend(walk.vertex_at(point));
            });
            for i in (0..paths.len()).rev() {
                let GrowingPath { sample, walk, .. } = &mut paths[i];
                // Behind the walk's start and all surfaces met before.
                let vertex = walks[*sample].vertices(walk).get_mut(walk.vertices() as usize + 1);
                walk.count_vertex(vertex.as_deref(), counters);
                let has_gone_on = vertex.is_some_and(|vertex| {
                    if walk.vertices() > max_bounces {
                        walk.truncate(counters);
                        return false;
                    }
                    let scattered =
                        walk.scatter(vertex, roulette, &mut samples[*sample].sampler, counters);
                    matches!(scattered, Scattered::On { .. })
                        && (walk.vertices() > 1 || goes_on(vertex))
                });
                if !has_gone_on {
                    paths.swap_remove(i);
                }
            }
        }
    }
}
