//! Wavefront OBJ files with their materials (MTL).
//!
//! Read are positions, normals, Kd (diffuse albedo), Ke (emission), and for the illumination models
//! with refraction (4, 6, 7 and 9) Ni (index of refraction). Emission is two-sided, since files do
//! not agree about the order of vertices. The camera frames the whole model from the front (+z), a
//! little from the right and above; a file without Ke is lit by a white environment.

use super::scenes::{AnyCamera, NamedScene};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera};
use pathspace::film::Filter;
use pathspace::geometry::Bounds;
use pathspace::glam::{DAffine3, DVec3, UVec2};
use pathspace::math::Rgb;
use pathspace::scene::{Emission, Material, Mesh, WorldBuilder};
use std::cell::RefCell;
use std::error::Error;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Albedo of what has no Kd.
const DEFAULT_ALBEDO: f64 = 0.6;
/// Index of refraction of glass without Ni.
const DEFAULT_IOR: f64 = 1.5;
const FIELD_OF_VIEW: f64 = 40.0;

/// The look of a surface, made from a material of the file.
struct Look {
    material: Material,
    emission: Option<Rgb>,
}

/// Loads a file; errors name it.
pub fn load(path: &Path, resolution: UVec2) -> Result<NamedScene, Box<dyn Error>> {
    load_file(path, resolution).map_err(|error| format!("{}: {error}", path.display()).into())
}

fn load_file(path: &Path, resolution: UVec2) -> Result<NamedScene, Box<dyn Error>> {
    let (models, materials) = parse(path)?;
    let mut builder = WorldBuilder::new();
    let looks = materials.iter().map(look).collect::<Vec<_>>();
    let fallback = builder.add_material(
        "without material",
        Material::Lambert { albedo: Rgb::splat(DEFAULT_ALBEDO) },
    )?;
    let mut ids = Vec::new();
    for (index, (material, look)) in materials.iter().zip(&looks).enumerate() {
        // Names may occur twice in a file.
        ids.push(
            builder.add_material(format!("{index} {}", material.name), look.material.clone())?,
        );
    }

    let (mut triangles, mut emits) = (0, false);
    for (index, model) in models.iter().enumerate() {
        let mesh = to_mesh(&model.mesh);
        if mesh.indices.is_empty() {
            continue;
        }
        triangles += mesh.indices.len();
        let material = model.mesh.material_id.filter(|&id| id < ids.len());
        let id = material.map_or(fallback, |id| ids[id]);
        let surface =
            builder.add_mesh(format!("{index} {}", model.name), &mesh, DAffine3::IDENTITY, id)?;
        let Some(look) = material.map(|id| &looks[id]) else { continue };
        if let Some(radiance) = look.emission {
            builder.set_emission(surface, Emission { radiance, two_sided: true })?;
            emits = true;
        }
    }
    if triangles == 0 {
        return Err("no triangles".into());
    }
    if !emits {
        builder.set_environment("environment", ConstantEnvironment::new(Rgb::WHITE)?)?;
    }
    let world = builder.build()?;
    let camera = AnyCamera(Box::new(framing(world.bounds(), resolution)?));
    let name = path
        .file_stem()
        .map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let light = if emits { "its own lights" } else { "a white environment" };
    Ok(NamedScene {
        name,
        description: format!("{} with {triangles} triangles under {light}.", path.display()),
        world,
        camera,
        max_bounces: None,
        claims: None,
        filter: Filter::Box,
    })
}

/// Reads the file and its material libraries, which are looked for beside it.
fn parse(path: &Path) -> Result<(Vec<tobj::Model>, Vec<tobj::Material>), Box<dyn Error>> {
    let options =
        tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let mut reader = BufReader::new(File::open(path)?);
    // The parser's errors do not say which library they are about.
    let library = RefCell::new(PathBuf::new());
    let (models, materials) = tobj::load_obj_buf(&mut reader, &options, |name| {
        let beside = path.with_file_name(name);
        library.replace(beside.clone());
        tobj::load_mtl(beside)
    })?;
    let materials = materials
        .map_err(|error| format!("material library {}: {error}", library.borrow().display()))?;
    Ok((models, materials))
}

fn look(material: &tobj::Material) -> Look {
    let is_glass = matches!(material.illumination_model, Some(4 | 6 | 7 | 9));
    let kind = if is_glass {
        Material::Dielectric {
            relative_ior: material.optical_density.map_or(DEFAULT_IOR, f64::from),
        }
    } else {
        Material::Lambert {
            albedo: material
                .diffuse
                .map_or(Rgb::splat(DEFAULT_ALBEDO), |kd| Rgb(kd.map(f64::from))),
        }
    };
    let emission = material.emissive.map(|ke| Rgb(ke.map(f64::from))).filter(|ke| !ke.is_black());
    Look { material: kind, emission }
}

fn to_mesh(mesh: &tobj::Mesh) -> Mesh {
    let vectors = |values: &[f32]| {
        values
            .as_chunks::<3>()
            .0
            .iter()
            .map(|v| DVec3::from_array(v.map(f64::from)))
            .collect::<Vec<_>>()
    };
    let positions = vectors(&mesh.positions);
    let normals = vectors(&mesh.normals);
    // Files with a missing or zero normal are common: better flat than refused.
    let usable =
        normals.len() == positions.len() && normals.iter().all(|n| n.try_normalize().is_some());
    Mesh {
        positions,
        normals: usable.then_some(normals),
        indices: mesh.indices.as_chunks().0.to_vec(),
        ..Mesh::default()
    }
}

/// A camera that sees the sphere around the model.
fn framing(bounds: Bounds, resolution: UVec2) -> Result<PinholeCamera, Box<dyn Error>> {
    let aspect = f64::from(resolution.x) / f64::from(resolution.y);
    let half_height = (0.5 * FIELD_OF_VIEW.to_radians()).tan();
    let half_angle = (half_height * aspect.min(1.0)).atan();
    let distance = bounds.radius().max(f64::MIN_POSITIVE) / half_angle.sin();
    let position = bounds.center() + DVec3::new(0.35, 0.3, 1.0).normalize() * distance;
    Ok(PinholeCamera::new(position, bounds.center(), DVec3::Y, FIELD_OF_VIEW, resolution)?)
}
