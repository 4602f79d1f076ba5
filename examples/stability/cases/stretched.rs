//! Scenes with parts of very different sizes.

use super::{Case, FROM_CAMERA, decades};
use crate::scenes::{Stage, camera, cube, cube_mesh, lambert};
use pathspace::geometry::Sphere;
use pathspace::glam::{DAffine3, DMat3, DVec3};
use pathspace::scene::Mesh;

/// A stage of furnaces: all of it reflects one half and emits 1, and so has radiance 2.
struct Furnace(Stage);

impl Furnace {
    fn mesh(&mut self, mesh: &Mesh, center: DVec3, scale: f64) {
        let matrix3 = DMat3::from_diagonal(DVec3::splat(scale));
        let mesh = self.0.mesh(mesh, DAffine3 { matrix3, translation: center }, lambert(0.5));
        self.0.glow(mesh, 1.0);
    }
}

pub(super) fn stretched(cases: &mut Vec<Case>) {
    let teapot = Mesh::icosphere(3);
    let eye = || camera(DVec3::new(2.5, 1.0, 1.5), DVec3::new(0.0, 0.3, 0.6), 60.0);
    for size in decades(&[1, 3, 5, 7, 9]) {
        let mut furnace = Furnace(Stage::default());
        for wall in cube(DVec3::new(-0.4 * size, -0.7 * size, 0.0), size) {
            let wall = furnace.0.face(wall, lambert(0.5));
            furnace.0.glow(wall, 1.0);
        }
        furnace.mesh(&teapot, DVec3::Z, 1.0);
        cases.push(
            Case::new("S84", "size of a stadium", size, 2.0, furnace.0.build(), eye())
                .by(FROM_CAMERA),
        );
    }
    // Seen from outside.
    let mut block = cube_mesh();
    block.indices.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    for size in decades(&[1, 3, 5, 7, 9]) {
        let mut furnace = Furnace(Stage::default());
        furnace.mesh(&teapot, DVec3::Z, 1.0);
        let stadium = 1e4;
        furnace.mesh(&block, DVec3::new(-0.5, -0.5, -1.0) * stadium, stadium);
        for i in 0..12 {
            let (y, x) = (std::f64::consts::PI / 6.0 * f64::from(i)).sin_cos();
            furnace.mesh(&teapot, DVec3::new(x, y, 0.0) * (0.4 * stadium), 0.05 * stadium);
        }
        let system = size * stadium;
        for (center, radius) in [([0.3, -0.2, 0.5], 0.1), ([-0.5, 0.4, 0.1], 0.2)] {
            furnace.mesh(&teapot, DVec3::from(center) * system, radius * system);
        }
        let sky = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, system) };
        let sky = furnace.0.sphere(sky, lambert(0.5));
        furnace.0.glow(sky, 1.0);
        cases.push(
            Case::new("S85", "size of a solar system", size, 2.0, furnace.0.build(), eye())
                .by(FROM_CAMERA),
        );
    }
}
