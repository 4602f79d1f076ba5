//! Thin, touching and coincident surfaces.

use super::{CONNECTED, Case, FROM_CAMERA, ONE, decades, lit_floor, sky};
use crate::scenes::{
    Stage, camera, cube, cube_mesh, footprint, furnace_box, lambert, polygon_irradiance,
};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DAffine3, DVec3};
use pathspace::integrator::Depth;
use pathspace::path::Roulette;
use pathspace::scene::{Material, Mesh};
use std::f64::consts::PI;

pub(super) fn geometry(cases: &mut Vec<Case>) {
    let eye = || camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 80.0);
    // A mirrored instance emits on the image of its front side.
    for x in [1.0, -1.0] {
        let mut stage = Stage::default();
        let walls =
            stage.mesh(&cube_mesh(), DAffine3::from_scale(DVec3::new(x, 1.0, 1.0)), lambert(0.5));
        stage.glow(walls, 1.0);
        let eye = camera(DVec3::new(0.5 * x, 0.5, 0.5), DVec3::new(x, 0.7, 0.4), 80.0);
        cases.push(Case::new("S11", "mirrored instance", x, 2.0, stage.build(), eye));
    }
    for width in decades(&[-15, -12, -9, -6, -3]) {
        let mut stage = Stage::default();
        for (i, face) in cube(DVec3::ZERO, 1.0).into_iter().enumerate() {
            if i != 1 {
                let face = stage.face(face, lambert(0.5));
                stage.glow(face, 1.0);
            }
        }
        // The wall that the camera looks at has strips ever thinner towards the point that it looks
        // at.
        let mut cuts = vec![0.0, 1.0];
        let mut w = width;
        while w < 0.25 {
            cuts.extend([0.7 - w, 0.7 + w]);
            w *= 10.0;
        }
        cuts.sort_by(f64::total_cmp);
        let positions =
            cuts.iter().flat_map(|&y| [DVec3::new(1.0, y, 0.0), DVec3::new(1.0, y, 1.0)]).collect();
        let indices = (0..cuts.len() as u32 - 1)
            .map(|i| 2 * i)
            .flat_map(|i| [[i, i + 1, i + 2], [i + 1, i + 3, i + 2]])
            .collect();
        let strips = stage.mesh(
            &Mesh { positions, indices, ..Mesh::default() },
            DAffine3::IDENTITY,
            lambert(0.5),
        );
        stage.glow(strips, 1.0);
        let narrow = camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 60.0);
        cases.push(Case::new("S13", "width of slivers", width, 2.0, stage.build(), narrow));
    }
    for gap in decades(&[-12, -9, -6, -3]) {
        let mut stage = Stage::default();
        let inner = stage.sphere(Sphere::new(DVec3::ZERO, 1.0), lambert(0.5));
        let outer = stage
            .sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0 + gap) }, lambert(0.5));
        stage.glow(inner, 1.0);
        stage.glow(outer, 1.0);
        let eye = DVec3::Z * (1.0 + 0.5 * gap);
        let eye = camera(eye, eye + DVec3::new(1.0, 0.5, 0.1), 60.0);
        cases.push(
            Case::new("S16", "gap between spheres", gap, 2.0, stage.build(), eye).by(FROM_CAMERA),
        );
    }
    for gap in decades(&[-12, -9, -6, -3]) {
        // A faint screen just before the floor, or just before a lamp a million times as strong,
        // none of whose light may pass.
        for (family, height) in
            [("gap between floor and screen", gap), ("gap between screen and lamp", 2.0 - gap)]
        {
            let mut stage = Stage::default();
            stage.square(0.0, 1.0, true, lambert(0.5));
            for (z, radiance) in [(height, 1.0), (2.0, 1e6)] {
                let square = stage.square(z, 1.0, false, Material::Black);
                stage.glow(square, radiance);
            }
            let screen = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[x, y]| DVec3::new(x, y, height));
            let expected = 0.5 / PI * polygon_irradiance(DVec3::ZERO, DVec3::Z, &screen);
            let eye = footprint(DVec3::ZERO, 0.5 * height, 1e-2 * gap);
            let case = Case::new("S16", family, gap, expected, stage.build(), eye)
                .by(FROM_CAMERA)
                .depth(ONE);
            // What passes the screen at its sides is rarer than any sample.
            cases.push(Case { tolerance: 2.0 * gap * gap + 1e-9, ..case });
        }
    }
    for gap in decades(&[-12, -9, -6, -3]) {
        // Walls just behind the floor and just behind the lamp are in nobody's way.
        let mut stage = Stage::default();
        stage.square(0.0, 1.0, true, lambert(0.5));
        let lamp = stage.square(2.0, 1.0, false, Material::Black);
        stage.glow(lamp, 1.0);
        stage.square(-gap, 2.0, true, Material::Black);
        stage.square(2.0 + gap, 2.0, false, Material::Black);
        let eye = footprint(DVec3::ZERO, 1.0, 1e-4);
        cases.push(
            Case::new("S16", "gap behind floor and lamp", gap, lit_floor(), stage.build(), eye)
                .by(FROM_CAMERA)
                .depth(ONE),
        );
    }
    for distance in decades(&[-9, -6, -3, 0]) {
        let mut stage = Stage::default();
        let (corner, along) = (DVec3::new(0.0, -1e4, 0.0), DVec3::Y * 2e4);
        stage.face(Quad { origin: corner, edge_u: DVec3::X * 1e4, edge_v: along }, lambert(0.6));
        stage.face(Quad { origin: corner, edge_u: along, edge_v: DVec3::Z * 1e4 }, lambert(0.6));
        stage.environment(sky());
        let eye = camera(DVec3::new(distance, 0.0, 0.5 * distance), DVec3::X * distance, 1e-3);
        cases.push(
            Case::new("S17", "distance from a corner", distance, 3.0 / 7.0, stage.build(), eye)
                .by(FROM_CAMERA),
        );
    }
    for copies in [1.0, 2.0] {
        // A wall that is there twice scatters once.
        let mut stage = Stage::default();
        for (i, face) in cube(DVec3::ZERO, 1.0).into_iter().enumerate() {
            for _ in 0..if i == 4 { copies as u32 } else { 1 } {
                let id = stage.face(face, if i == 4 { lambert(0.5) } else { Material::Black });
                if i == 5 {
                    stage.glow(id, PI);
                }
            }
        }
        let expected = 0.5 * 0.752_274_688_454_107_5;
        let eye = footprint(DVec3::new(0.5, 0.5, 0.0), 0.5, 1e-4);
        cases.push(
            Case::new("S15", "copies of a wall", copies, expected, stage.build(), eye)
                .by(FROM_CAMERA)
                .depth(ONE),
        );
    }
    for bounces in [5, 18] {
        // Without weights the corners' 1/r² would have no variance to speak of.
        let expected = 2.0 * (1.0 - 0.5f64.powi(bounces + 1));
        let world = furnace_box(DVec3::ZERO, 1.0, &lambert(0.5), 1.0);
        let case = Case::new(
            "S18",
            "bounces of weighted paths",
            f64::from(bounces),
            expected,
            world,
            eye(),
        );
        cases.push(Case {
            roulette: Roulette::NEVER,
            ..case.by(CONNECTED).depth(Depth::up_to(bounces as u32))
        });
    }
}
