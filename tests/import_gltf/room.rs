//! A box with blocks, from a file and built by hand: the same image, and all integrators agree on
//! it.

use crate::compare::{Comparison, assert_agree};
use crate::files::{SQUARE, load, render, seen, single};
use crate::materials::surface;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec2};
use pathspace::endpoint::{Camera, PinholeCamera};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::render::Render;
use pathspace::scene::{Emission, Mesh, World, WorldBuilder};

fn square() -> Mesh {
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        uvs: Some(vec![
            DVec2::new(0.0, 1.0),
            DVec2::new(1.0, 1.0),
            DVec2::new(1.0, 0.0),
            DVec2::new(0.0, 0.0),
        ]),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn cube() -> Mesh {
    let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|k| DVec3::new(sign(k & 4), sign(k & 2), sign(k & 1))).collect();
    let faces =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let indices = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, indices, ..Mesh::default() }
}

fn placed(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> DAffine3 {
    let rotation = DQuat::from_array(rotation.map(single)).normalize();
    DAffine3::from_scale_rotation_translation(
        DVec3::from(scale),
        rotation,
        DVec3::from(translation),
    )
}

fn box_by_hand() -> (World, PinholeCamera) {
    let mut builder = WorldBuilder::new();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (one, none) = ([1.0; 3], [0.0, 0.0, 0.0, 1.0]);
    let right = DAffine3 {
        matrix3: DMat3::from_cols(DVec3::Z, DVec3::Y, -DVec3::X),
        translation: DVec3::X,
    };
    let objects = [
        ("back", square(), surface([0.75; 3], 0.0, 1.0, 1.5), placed([0.0, 0.0, -1.0], none, one)),
        (
            "floor",
            square(),
            surface([0.75; 3], 0.0, 1.0, 1.5),
            placed([0.0, -1.0, 0.0], [-half, 0.0, 0.0, half], one),
        ),
        (
            "ceiling",
            square(),
            surface([0.75; 3], 0.0, 1.0, 1.5),
            placed([0.0, 1.0, 0.0], [half, 0.0, 0.0, half], one),
        ),
        (
            "left",
            square(),
            surface([0.625, 0.0625, 0.0625], 0.0, 1.0, 1.5),
            placed([-1.0, 0.0, 0.0], [0.0, half, 0.0, half], one),
        ),
        ("right", square(), surface([0.125, 0.5, 0.125], 0.0, 1.0, 1.5), right),
        (
            "lamp",
            square(),
            surface([0.0; 3], 0.0, 1.0, 1.5),
            placed([0.0, 0.9375, 0.0], [half, 0.0, 0.0, half], [0.25; 3]),
        ),
        (
            "metal block",
            cube(),
            surface([0.875, 0.625, 0.25], 1.0, 0.5, 1.5),
            placed(
                [-0.375, -0.5, -0.25],
                [0.0, 0.25, 0.0, 0.968_245_836_551_854_2],
                [0.25, 0.5, 0.25],
            ),
        ),
        (
            "plastic block",
            cube(),
            surface([0.125, 0.25, 0.75], 0.25, 0.375, 1.75),
            placed([0.375, -0.75, 0.125], none, [-0.25, 0.25, 0.25]),
        ),
    ];
    for (name, mesh, material, transform) in objects {
        let material = builder.add_material(name, material.culled()).expect("valid");
        let id = builder.add_mesh(name, &mesh, transform, material).expect("valid");
        if name == "lamp" {
            builder
                .set_emission(
                    id,
                    Emission { radiance: Rgb::new(16.0, 12.0, 8.0), two_sided: false },
                )
                .expect("valid");
        }
    }
    let fov = single(0.75).to_degrees();
    let camera = PinholeCamera::new(
        DVec3::new(0.0, 0.0, 3.5),
        DVec3::new(0.0, 0.0, 2.5),
        DVec3::Y,
        fov,
        UVec2::new(24, 16),
    );
    (builder.build().expect("valid"), camera.expect("valid"))
}

#[test]
fn a_file_gives_the_image_of_the_scene_built_by_hand_to_the_bit() {
    let (world, camera) = box_by_hand();
    let expected = render(&world, &camera, &PathTracer::default(), 16);
    for name in ["box.gltf", "box.glb"] {
        let import = load(name, UVec2::splat(24));
        assert_eq!(import.views.len(), 1);
        assert_eq!(
            (import.views[0].name.as_str(), import.views[0].camera.film()),
            ("eye", camera.film())
        );
        assert_eq!(
            render(&import.world, &*import.views[0].camera, &PathTracer::default(), 16),
            expected,
            "{name}"
        );
    }
    assert!(expected.mean().luminance() > 0.1);
}

/// The front of a mirrored block is its outside.
#[test]
fn mirrored_nodes_keep_their_front_outside() {
    let world = load("box.gltf", SQUARE).world;
    let x = seen(&world, DVec3::new(0.375, -0.75, 3.0), -DVec3::Z);
    assert_eq!((world.surface_name(&x), x.geometric_normal), (Some("plastic block"), DVec3::Z));
}

#[test]
fn integrators_agree_on_a_file() {
    let import = load("box.gltf", UVec2::splat(12));
    let depth = Depth { max_bounces: Some(3), ..Depth::default() };
    let path = PathTracer { depth, ..PathTracer::default() };
    let light = LightTracer { depth, ..LightTracer::default() };
    let both = Bidirectional { depth, ..Bidirectional::default() };
    let integrators: [(&str, &dyn Render<World>); 3] =
        [("path", &path), ("light", &light), ("bidirectional", &both)];
    assert_agree(
        "box.gltf",
        &import.world,
        &*import.views[0].camera,
        &integrators,
        &Comparison::default(),
    );
}
