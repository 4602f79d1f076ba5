//! The speed of the ray kernel alone on meshes and rays from files, for comparison with other ray tracers on the same files.
//!
//! ```sh
//! cargo run --release --example raykernel -- DIRECTORY small,large,room 5
//! ```
use pathspace::geometry::SurfacePoint;
use pathspace::glam::{DAffine3, DVec3};
use pathspace::scene::{Material, Mesh, Scene, World, WorldBuilder};
use std::error::Error;
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn words(path: &Path) -> Result<Vec<u32>> {
    let bytes = std::fs::read(path)?;
    Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}
fn float(w: u32) -> f64 {
    f64::from(f32::from_bits(w))
}
fn world(path: &Path) -> Result<World> {
    let w = words(path)?;
    let (nv, _nt) = (w[1] as usize, w[2] as usize);
    let positions = w[3..3 + 3 * nv].chunks_exact(3).map(|p| DVec3::new(float(p[0]), float(p[1]), float(p[2]))).collect();
    let indices = w[3 + 3 * nv..].chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black)?;
    builder.add_mesh("mesh", &Mesh { positions, indices, ..Mesh::default() }, DAffine3::IDENTITY, black)?;
    Ok(builder.build()?)
}
#[derive(Clone)] struct Ray { o: DVec3, d: DVec3, t: f64 }
fn rays(path: &Path) -> Result<Vec<Ray>> {
    let w = words(path)?;
    Ok(w[2..].chunks_exact(8).map(|r| Ray { o: DVec3::new(float(r[0]), float(r[1]), float(r[2])), d: DVec3::new(float(r[4]), float(r[5]), float(r[6])).normalize(), t: float(r[7]) }).collect())
}
fn main() -> Result<()> {
    let a: Vec<String> = std::env::args().collect();
    let dir = Path::new(&a[1]);
    let reps: usize = a[3].parse()?;
    for scene in a[2].split(',') {
        let t0 = cpu_time::ThreadTime::now();
        let world = world(&dir.join(format!("{scene}.mesh")))?;
        print!("{scene:6} ours build {:8.3} |", t0.elapsed().as_secs_f64());
        let full = a.len() > 4;
        let sets = std::env::var("SETS").unwrap_or("primary,bounce1,bounce3,uniform,shadow1,shadow3".into());
        for set in sets.split(',') {
        #[cfg(any())]
        for set in ["primary", "bounce1", "bounce3", "uniform", "shadow1", "shadow3"] {}
            let mut rays = rays(&dir.join(format!("{scene}_{set}.rays")))?;
            if let Ok(l) = std::env::var("LIMIT") { let l: usize = l.parse()?; let k = (rays.len() / l).max(1); rays = rays.into_iter().step_by(k).collect(); }
            let mut best = f64::INFINITY;
            let mut n = 0usize;
            for _ in 0..reps {
                n = 0;
                let t = cpu_time::ThreadTime::now();
                if set.starts_with("shadow") {
                    for r in &rays { n += usize::from(!world.is_clear(r.o, r.d, r.t)); }
                } else if full {
                    for r in &rays { n += usize::from(world.intersect(&SurfacePoint::dirac(r.o), r.d).is_some()); }
                } else {
                    for r in &rays { n += usize::from(world.first_hit(r.o, r.d).is_some()); }
                }
                best = best.min(t.elapsed().as_secs_f64());
            }
            print!(" {:5.2}", rays.len() as f64 / best / 1e6);
            if std::env::var("HITS").is_ok() { print!("({n})"); }
        }
        println!();
    }
    Ok(())
}
