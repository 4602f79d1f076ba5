//! The ray kernel alone: closest and any hit, coherent and incoherent rays, on 327 680 triangles.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pathspace::geometry::SurfacePoint;
use pathspace::glam::{DAffine3, DVec2, DVec3};
use pathspace::math::warp::square_to_sphere;
use pathspace::scene::{Material, Mesh, Scene, SurfaceArea, World, WorldBuilder};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::collections::HashMap;
use std::hint::black_box;

const RAYS: usize = 10_000;

/// An octahedron divided seven times has 131 072 triangles; five balls of different size have 655 360.
fn octasphere(levels: u32) -> Mesh {
    let mut positions = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut indices = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        indices = indices
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { positions, indices, ..Mesh::default() }
}
