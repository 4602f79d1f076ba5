//! Edges of a scene, to be seen from the side.

use glam::DVec3;
use pathspace::geometry::{Frame, Shape};
use pathspace::scene::World;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Segments of a circle.
const CIRCLE: u32 = 32;
/// Of larger scenes, as many primitives are shown.
const MOST: usize = 20_000;
/// Cosine of the angle from which on two faces are seen to bend.
const FLAT: f64 = 0.999;

/// The faces at an edge.
struct Edge {
    ends: [DVec3; 2],
    normal: DVec3,
    /// True if there is one, or two of them bend.
    is_shown: bool,
}

/// The edges of flat surfaces where they end or bend, and circles around disks and spheres: segments
/// of six numbers each.
pub(crate) fn of(world: &World) -> Vec<f32> {
    let mut circles = Vec::new();
    let mut edges = BTreeMap::new();
    let count = world.primitive_count();
    for i in (0..count).step_by(count.div_ceil(MOST).max(1)) {
        match world.shape(i as u32) {
            Some(Shape::Triangle(triangle)) => {
                add_face(&mut edges, &triangle.vertices, triangle.cross());
            }
            Some(Shape::Quad(quad)) => add_face(&mut edges, &quad.corners(), quad.cross()),
            Some(Shape::Disk(disk)) => {
                add_circle(&mut circles, disk.center, disk.normal, disk.radius);
            }
            Some(Shape::Sphere(sphere)) => {
                for axis in DVec3::AXES {
                    add_circle(&mut circles, sphere.center, axis, sphere.radius);
                }
            }
            None => {}
        }
    }
    let shown = edges.into_values().filter(|edge| edge.is_shown).map(|edge| edge.ends);
    shown.chain(circles).flatten().flat_map(|x| x.as_vec3().to_array()).collect()
}

/// Edges by their ends.
type Edges = BTreeMap<[[u64; 3]; 2], Edge>;

fn add_face(edges: &mut Edges, corners: &[DVec3], cross: DVec3) {
    let normal = cross.normalize_or_zero();
    for (i, a) in corners.iter().enumerate() {
        let ends = [*a, corners[(i + 1) % corners.len()]];
        let mut key = ends.map(|x| x.to_array().map(f64::to_bits));
        key.sort_unstable();
        edges
            .entry(key)
            .and_modify(|edge| edge.is_shown = edge.normal.dot(normal).abs() < FLAT)
            .or_insert(Edge { ends, normal, is_shown: true });
    }
}

fn add_circle(circles: &mut Vec<[DVec3; 2]>, center: DVec3, axis: DVec3, radius: f64) {
    let frame = Frame::from_normal(axis);
    let point = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(CIRCLE)).sin_cos();
        center + radius * (frame.x * cos + frame.y * sin)
    };
    circles.extend((0..CIRCLE).map(|i| [point(i), point(i + 1)]));
}
