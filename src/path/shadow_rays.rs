//! Contributions that wait for their shadow rays, so that a scene gets many rays at a time.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::Subpaths;
use crate::bsdf::TransportMode;
use crate::film::{Contribution, Sink};
use crate::geometry::SurfacePoint;
use crate::scene::Scene;

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
        self.connections.list.push(Connection { sample: self.sample, ends, contribution });
    }

    /// Keeps a point that is no vertex as an end of shadow rays.
    #[inline]
    pub fn keep(&mut self, point: &SurfacePoint) -> End {
        self.connections.points.push(*point);
        End::Point(self.connections.points.len() as u32 - 1)
    }
}

struct Connection {
    sample: usize,
    ends: [End; 2],
    contribution: Contribution,
}

/// The shadow rays that are yet to be tested. They refer to vertices instead of copying them, which
/// would cost more than the test in small scenes.
#[derive(Default)]
pub(super) struct Connections {
    list: Vec<Connection>,
    points: Vec<SurfacePoint>,
    visible: Vec<bool>,
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
        let Self { list, points, visible } = self;
        let point = |sample: usize, end: End| match end {
            End::Camera(i) => &subpaths[sample].camera[i as usize].point,
            End::Light(i) => &subpaths[sample].light[i as usize].point,
            End::Point(i) => &points[i as usize],
        };
        visible.clear();
        visible.resize(list.len(), false);
        let rays = list.iter().map(|Connection { sample, ends: [a, b], .. }| {
            (point(*sample, *a), point(*sample, *b))
        });
        scene.visible_many(rays, |i, answer| visible[i] = answer);
        // In their own order and not in that of the answers, which depends on the instruction set.
        for (connection, _) in list.iter().zip(visible).filter(|(_, visible)| **visible) {
            sink.add(connection.sample, &connection.contribution);
        }
        list.clear();
        points.clear();
    }
}
