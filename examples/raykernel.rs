//! The speed of the ray kernel alone on meshes and rays from files, in million rays per second of processor time, for comparison with other
//! ray tracers on the same files.
//!
//! ```sh
//! cargo run --release --example raykernel -- DIRECTORY SCENES PASSES [STEP]
//! ```
//!
//! reads `SCENE.mesh` and `SCENE_SET.rays`, little endian: "MSH1", the numbers of vertices and triangles, three f32 per vertex, three u32 per
//! triangle; "RAY1", the number of rays, and for each origin, 0, direction, length. STEP takes every so many-th ray only. A set whose name
//! starts with "shadow" is asked whether anything is hit, any other what is hit first; `_` beside it is the time of [`Scene::intersect`], with
//! the surface point. If `hits/SCENE_SET.hits` exists ("HIT1", the number of rays, for each the primitive or all ones, or for a shadow ray
//! whether it is blocked, then for each that is not one the distance as f32), what differs is counted.
#![allow(clippy::print_stdout, reason = "a program")]

use cpu_time::ThreadTime;
use pathspace::geometry::SurfacePoint;
use pathspace::glam::{DAffine3, DVec3};
use pathspace::scene::{Material, Mesh, Scene, World, WorldBuilder};
use std::error::Error;
use std::hint::black_box;
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SETS: [&str; 6] = ["primary", "bounce1", "bounce3", "uniform", "shadow1", "shadow3"];

struct Ray {
    origin: DVec3,
    direction: DVec3,
    length: f64,
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, scenes, passes, step @ ..] = &arguments[..] else {
        return Err("usage: raykernel DIRECTORY SCENES PASSES [STEP]".into());
    };
    let (directory, passes) = (Path::new(directory), passes.parse::<u32>()?);
    let step = step.first().map_or(Ok(1), |step| step.parse::<usize>())?;
    for scene in scenes.split(',') {
        let world = world(&directory.join(format!("{scene}.mesh")))?;
        let tree = world.tree_statistics();
        let share = tree.bytes as f64 / world.primitive_count() as f64;
        let (build, set) = (tree.build_time.as_secs_f64(), tree.instruction_set);
        print!("{scene:6} build {build:.2} s, {share:.0} bytes per triangle, {set} |");
        let mut differences = String::new();
        for set in SETS {
            let rays = rays(&directory.join(format!("{scene}_{set}.rays")))?;
            let rays: Vec<&Ray> = rays.iter().step_by(step).collect();
            let rate = |seconds: f64| rays.len() as f64 / seconds / 1e6;
            let blocked = |r: &Ray| !world.is_clear(r.origin, r.direction, r.length);
            let first = |r: &Ray| world.first_hit(r.origin, r.direction);
            if set.starts_with("shadow") {
                print!(" {:6.2}", rate(best(passes, &rays, blocked)));
            } else {
                let point = |r: &Ray| world.intersect(&SurfacePoint::dirac(r.origin), r.direction);
                print!(" {:6.2} _{:.2}", rate(best(passes, &rays, first)), rate(best(passes, &rays, point)));
            }
            if let Ok(hits) = words(&directory.join(format!("hits/{scene}_{set}.hits"))) {
                let others = hits[2..].iter().step_by(step);
                let different = rays.iter().zip(others).filter(|&(ray, &other)| match set.starts_with("shadow") {
                    true => u32::from(blocked(ray)) != other,
                    false => first(ray).map_or(u32::MAX, |(primitive, _)| primitive) != other,
                });
                differences += &format!(" {set} {} of {},", different.count(), rays.len());
            }
        }
        println!("\n       differ:{differences}");
    }
    Ok(())
}

/// The shortest time, in seconds of this thread, that one of some passes over all rays took.
fn best<T>(passes: u32, rays: &[&Ray], query: impl Fn(&Ray) -> T) -> f64 {
    let pass = |_| {
        let start = ThreadTime::now();
        for ray in rays {
            black_box(query(ray));
        }
        start.elapsed().as_secs_f64()
    };
    (0..passes).map(pass).fold(f64::INFINITY, f64::min)
}

fn words(path: &Path) -> Result<Vec<u32>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(bytes.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect())
}

/// Three consecutive numbers.
fn vector(words: &[u32]) -> DVec3 {
    DVec3::from_slice(&[0, 1, 2].map(|axis| f64::from(f32::from_bits(words[axis]))))
}

fn world(path: &Path) -> Result<World> {
    let words = words(path)?;
    let (positions, indices) = words[3..].split_at(3 * words[1] as usize);
    let positions = positions.chunks_exact(3).map(vector).collect();
    let mesh = Mesh { positions, indices: indices.as_chunks().0.to_vec(), ..Mesh::default() };
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black)?;
    builder.add_mesh("mesh", &mesh, DAffine3::IDENTITY, black)?;
    Ok(builder.build()?)
}

fn rays(path: &Path) -> Result<Vec<Ray>> {
    let ray = |r: &[u32]| Ray { origin: vector(r), direction: vector(&r[4..]).normalize(), length: f64::from(f32::from_bits(r[7])) };
    Ok(words(path)?[2..].chunks_exact(8).map(ray).collect())
}
