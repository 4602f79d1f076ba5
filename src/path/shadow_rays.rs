//! Contributions that wait for their shadow rays, so that a scene gets many rays at a time.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::Subpaths;
use crate::bsdf::TransportMode;
use crate::film::{Contribution, Sink};
use crate::geometry::SurfacePoint;
use crate::lanes::Rows;
use crate::scene::Scene;
use crate::tree::{Ends, Segment};

/// An end of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The vertex of the sample's camera subpath with this index.
    Camera(u32),
    /// The vertex of the sample's light subpath with this index.
    Light(u32),
    /// A point that was handed to [`Out::keep`].
    Point(u32),
}

/// The way out for what a sample finds.
pub struct Out<'v> {
    pub(super) sample: usize,
    pub(super) sink: &'v mut dyn Sink,
    pub(super) connections: &'v mut Connections,
}

impl Out<'_> {
    /// The number of the sample among those that are drawn together.
    #[inline]
    #[must_use]
    pub fn sample(&self) -> usize {
        self.sample
    }
}

impl End {
    #[inline]
    pub(super) fn of(mode: TransportMode, index: u32) -> Self {
        match mode {
            TransportMode::Radiance => Self::Camera(index),
            TransportMode::Importance => Self::Light(index),
        }
    }
}

impl Out<'_> {
    /// Adds a contribution.
    #[inline]
    pub fn add(&mut self, contribution: &Contribution) {
        self.sink.add(self.sample, contribution);
    }

    /// Adds a contribution if the ends of a shadow ray see each other, which is tested later. The
    /// vertices that it ends at must stay in their places until then.
    #[inline]
    pub fn connect(&mut self, ends: [End; 2], contribution: Contribution) {
        self.connections.rays.push((self.sample, ends));
        self.connections.list.push(Connection {
            sample: self.sample,
            in_columns: false,
            contribution,
        });
    }

    /// Adds a contribution if a segment of a scene with [flat surfaces](Scene::flat_surfaces) is
    /// free, which is tested later.
    #[inline(always)]
    pub(super) fn connect_by(&mut self, segment: &Segment, contribution: Contribution) {
        let Segment { origin, direction, length, ends } = *segment;
        self.connections.segments.push([origin, direction], [length]);
        self.connections.ends.push(ends);
        self.connections.list.push(Connection {
            sample: self.sample,
            in_columns: true,
            contribution,
        });
    }

    /// Keeps a point that is no vertex as an end of shadow rays.
    #[inline]
    pub fn keep(&mut self, point: &SurfacePoint) -> End {
        // Not pushed, which would copy it twice.
        self.connections.points.extend_from_slice(std::slice::from_ref(point));
        End::Point(self.connections.points.len() as u32 - 1)
    }
}

struct Connection {
    sample: usize,
    /// True if its shadow ray is a segment in columns.
    in_columns: bool,
    contribution: Contribution,
}

/// The shadow rays that are yet to be tested. Those between vertices refer to them instead of
/// copying them, which would cost more than the test in small scenes.
#[derive(Default)]
pub(super) struct Connections {
    list: Vec<Connection>,
    /// The rays of those that are not in columns, with the number of the sample.
    rays: Vec<(usize, [End; 2])>,
    points: Vec<SurfacePoint>,
    visible: Vec<bool>,
    /// Origins, directions and lengths of the others.
    segments: Rows<7>,
    ends: Vec<Ends>,
    free: Vec<bool>,
}

impl Connections {
    /// Tests the shadow rays and gives what is visible to the sink.
    #[inline]
    pub(super) fn test<S: Scene + ?Sized>(
        &mut self,
        scene: &S,
        subpaths: &[Subpaths<'_, S>],
        sink: &mut dyn Sink,
    ) {
        let Self { list, rays, points, visible, segments, ends, free } = self;
        let point = |sample: usize, end: End| match end {
            End::Camera(i) => &subpaths[sample].camera[i as usize].point,
            End::Light(i) => &subpaths[sample].light[i as usize].point,
            End::Point(i) => &points[i as usize],
        };
        visible.clear();
        visible.resize(rays.len(), false);
        let between = rays.iter().map(|(sample, [a, b])| (point(*sample, *a), point(*sample, *b)));
        scene.visible_many(between, |i, answer| visible[i] = answer);
        free.clear();
        if let Some(flats) = scene.flat_surfaces() {
            flats.forest().are_free_in_columns(segments, ends, free);
        }
        let (mut visible, mut free) = (visible.iter(), free.iter());
        // In their own order and not in that of the answers, which depends on the instruction set.
        for Connection { sample, in_columns, contribution } in &*list {
            let answer = if *in_columns { free.next() } else { visible.next() };
            if answer == Some(&true) {
                sink.add(*sample, contribution);
            }
        }
        list.clear();
        rays.clear();
        points.clear();
        segments.clear();
        ends.clear();
    }
}
