//! The speed of the ray kernel alone on meshes and rays from files, in million rays per second of
//! processor time, for comparison with other ray tracers on the same files.
//!
//! ```sh
//! cargo run --release --example raykernel -- DIRECTORY --scenes small,room
//! ```
//!
//! reads `SCENE.mesh` and `SCENE_SET.rays`, little endian: "MSH1", the numbers of vertices and
//! triangles, three f32 per vertex, three u32 per triangle; "RAY1", the number of rays, and for
//! each origin, 0, direction, length. A set whose name starts with "shadow" is asked whether
//! anything is hit, any other what is hit first: one ray after the other, `:` all rays at once, `_`
//! and `_:` the same by [`Scene::intersect`] and [`Scene::intersect_many`], with the surface point.
//! Rays of which the answer at once is another one are counted. If `hits/SCENE_SET.hits` exists
//! ("HIT1", the number of rays, for each the primitive or all ones, or for a shadow ray whether it
//! is blocked, then for each that is not one the distance as f32), what differs is counted.

#[macro_use]
mod common;

use clap::Parser;
use common::{End, MANY, exit_code};
use cpu_time::ThreadTime;
use pathspace::geometry::SurfacePoint;
use pathspace::glam::{DAffine3, DVec3};
use pathspace::scene::{Material, Mesh, Scene, World, WorldBuilder};
use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Measures the ray kernel on meshes and rays from files, in million rays per second of processor
/// time.
///
/// cargo run --release --example raykernel -- DIRECTORY --scenes small,room
#[derive(Parser, Debug)]
struct Options {
    /// Directory of the files
    directory: PathBuf,
    /// Names of meshes, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "small,large,room")]
    scenes: Vec<String>,
    /// Names of sets of rays, separated by commas
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "primary,bounce1,bounce3,uniform,shadow1,shadow3"
    )]
    sets: Vec<String>,
    /// Passes over all rays, of which the fastest counts
    #[arg(long, default_value_t = 3, value_parser = common::parse_count::<u32, 1, MANY>)]
    passes: u32,
    /// Take every so many-th ray only
    #[arg(long, default_value_t = 1, value_parser = common::parse_count::<u32, 1, MANY>)]
    step: u32,
}

struct Ray {
    origin: DVec3,
    direction: DVec3,
    length: f64,
}

fn main() -> ExitCode {
    exit_code(run(&common::options()))
}

fn run(options: &Options) -> Result<End> {
    let (directory, passes, step) = (&options.directory, options.passes, options.step as usize);
    for scene in &options.scenes {
        let world = world(&directory.join(format!("{scene}.mesh")))?;
        let tree = world.tree_statistics();
        let share = tree.bytes as f64 / world.primitive_count() as f64;
        let (build, set) = (tree.build_time.as_secs_f64(), tree.instruction_set);
        let mut line =
            format!("{scene:6} build {build:.2} s, {share:.0} bytes per triangle, {set} |");
        let mut differences = String::new();
        let mut different = 0;
        for set in &options.sets {
            let rays = rays(&directory.join(format!("{scene}_{set}.rays")), step)?;
            let rate = |seconds: f64| rays.len() as f64 / seconds / 1e6;
            let blocked = |r: &Ray| !world.is_clear(r.origin, r.direction, r.length);
            let first = |r: &Ray| world.first_hit(r.origin, r.direction);
            if set.starts_with("shadow") {
                let mut clear = vec![false; rays.len()];
                let many = best_of_all(passes, || {
                    world.are_clear(
                        rays.iter().map(|r| (r.origin, r.direction, r.length)),
                        |i, c| clear[i] = c,
                    );
                });
                different +=
                    rays.iter().zip(&clear).filter(|&(r, &clear)| blocked(r) == clear).count();
                line += &format!(" {:6.2} :{:.2}", rate(best(passes, &rays, blocked)), rate(many));
            } else {
                let point = |r: &Ray| world.intersect(&SurfacePoint::dirac(r.origin), r.direction);
                let mut hits = vec![None; rays.len()];
                let many = best_of_all(passes, || {
                    world.first_hits(rays.iter().map(|r| (r.origin, r.direction)), |i, hit| {
                        hits[i] = hit
                    });
                });
                different += rays.iter().zip(&hits).filter(|&(r, &hit)| first(r) != hit).count();
                line += &format!(" {:6.2} :{:.2}", rate(best(passes, &rays, first)), rate(many));
                let froms: Vec<SurfacePoint> =
                    rays.iter().map(|r| SurfacePoint::dirac(r.origin)).collect();
                let many = best_of_all(passes, || {
                    world.intersect_many(
                        froms.iter().zip(&rays).map(|(from, r)| (from, r.direction)),
                        |_, x| {
                            black_box(x);
                        },
                    );
                });
                line += &format!(" _{:.2} _:{:.2}", rate(best(passes, &rays, point)), rate(many));
            }
            if let Ok(hits) =
                words(&directory.join(format!("hits/{scene}_{set}.hits")), b"HIT1", [1])
            {
                let others = hits[2..].iter().step_by(step);
                let different = rays.iter().zip(others).filter(|&(ray, &other)| {
                    match set.starts_with("shadow") {
                        true => u32::from(blocked(ray)) != other,
                        false => first(ray).map_or(u32::MAX, |(primitive, _)| primitive) != other,
                    }
                });
                differences += &format!(" {set} {} of {},", different.count(), rays.len());
            }
        }
        say!("{line}\n       differ: at once {different};{differences}");
    }
    Ok(End::Done)
}

/// The shortest time, in seconds of this thread, that one of some passes over all rays took, one
/// ray after the other.
fn best<T>(passes: u32, rays: &[Ray], query: impl Fn(&Ray) -> T) -> f64 {
    best_of_all(passes, || {
        for ray in rays {
            black_box(query(ray));
        }
    })
}

/// The same for a query of all rays at once.
fn best_of_all(passes: u32, mut query: impl FnMut()) -> f64 {
    let pass = |_| {
        let start = ThreadTime::now();
        query();
        start.elapsed().as_secs_f64()
    };
    (0..passes).map(pass).fold(f64::INFINITY, f64::min)
}

/// The numbers of a file after its head: a name, and counts of things that have so many numbers
/// each.
fn words<const N: usize>(path: &Path, name: &[u8; 4], sizes: [usize; N]) -> Result<Vec<u32>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let words: Vec<u32> =
        bytes.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect();
    let counts = words.get(1..=N).unwrap_or_default();
    let least: usize = counts.iter().zip(sizes).map(|(&count, size)| count as usize * size).sum();
    if !bytes.starts_with(name) || counts.len() < N || words.len() - 1 - N < least {
        return Err(format!(
            "{}: no {} file, or not all of it",
            path.display(),
            name.escape_ascii()
        )
        .into());
    }
    Ok(words)
}

/// Three consecutive numbers.
fn vector(words: &[u32]) -> DVec3 {
    DVec3::from_slice(&[0, 1, 2].map(|axis| f64::from(f32::from_bits(words[axis]))))
}

fn world(path: &Path) -> Result<World> {
    let words = words(path, b"MSH1", [3, 3])?;
    let (positions, indices) = words[3..].split_at(3 * words[1] as usize);
    let positions = positions.chunks_exact(3).map(vector).collect();
    let mesh = Mesh { positions, indices: indices.as_chunks().0.to_vec(), ..Mesh::default() };
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black)?;
    builder.add_mesh(path.display().to_string(), &mesh, DAffine3::IDENTITY, black)?;
    Ok(builder.build()?)
}

fn rays(path: &Path, step: usize) -> Result<Vec<Ray>> {
    let ray = |r: &[u32]| Ray {
        origin: vector(r),
        direction: vector(&r[4..]).normalize(),
        length: f64::from(f32::from_bits(r[7])),
    };
    Ok(words(path, b"RAY1", [8])?[2..].chunks_exact(8).step_by(step).map(ray).collect())
}
