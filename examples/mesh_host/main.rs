//! A host whose scenes are triangle meshes of f32 numbers over the trees of obvhs: how it says what
//! its positions are worth, and where its shadow rays begin and end ([`scene`]).
//!
//! ```sh
//! cargo run --release --example mesh_host
//! ```

mod scene;

use pathspace::bsdf::Lambert;
use pathspace::endpoint::{IrradianceMeter, PinholeCamera};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::Bidirectional;
use pathspace::math::Rgb;
use pathspace::render::{Settings, measure, render};
use scene::MeshScene;
use std::error::Error;
use std::f32::consts::TAU;

/// Segments around the ring, and around its tube.
const SEGMENTS: [u32; 2] = [96, 48];

fn main() -> Result<(), Box<dyn Error>> {
    let scene = ring_under_a_lamp()?;
    let (eye, target, film) = (DVec3::new(0.0, 5.0, 7.0), DVec3::Y * 0.6, UVec2::new(480, 360));
    let camera = PinholeCamera::new(eye, target, DVec3::Y, 35.0, film)?;
    let (integrator, settings) = (Bidirectional::up_to(6), Settings::default());
    let rendering = render(&scene, &camera, &integrator, &settings)?;
    rendering.to_file().save("target/mesh_host.png")?;
    println!("wrote target/mesh_host.png: {:.1} s", rendering.wall.as_secs_f64());

    let meter = IrradianceMeter::new(DVec3::Y * 0.01, DVec3::Y)?;
    let light = measure(&scene, &meter, &integrator, &settings)?;
    let [mean, error] = [light.mean().g(), light.half_width(0.95).g()];
    println!("irradiance in the middle of the ring: {mean:.4} ± {error:.4} W/m² (95 %)");
    Ok(())
}

/// A ring on a floor, under a square lamp.
fn ring_under_a_lamp() -> Result<MeshScene, Box<dyn Error>> {
    let [around, tube] = SEGMENTS;
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..tube {
            let (a, b) = (TAU * i as f32 / around as f32, TAU * j as f32 / tube as f32);
            let radius = 1.6 + 0.6 * b.cos();
            vertices.push([radius * a.cos(), 0.6 + 0.6 * b.sin(), radius * a.sin()]);
            let at = |i: u32, j: u32| i % around * tube + j % tube;
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend(halves(corners));
        }
    }
    for (half, height) in [(6.0, 0.0), (0.8, 4.0)] {
        let first = vertices.len() as u32;
        vertices.extend(
            [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
                .map(|[x, z]: [f32; 2]| [x * half, height, z * half]),
        );
        // The floor faces upwards, the lamp downwards.
        let mut corners = [first, first + 1, first + 2, first + 3];
        if height > 0.0 {
            corners.reverse();
        }
        triangles.extend(halves(corners));
    }
    let lamp = (triangles.len() as u32 - 2, Rgb::new(30.0, 26.0, 20.0));
    let clay = Lambert::new(Rgb::new(0.7, 0.6, 0.5))?;
    Ok(MeshScene::new(vertices, triangles, clay, lamp)?)
}

fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}
