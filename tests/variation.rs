//! Scenes in which lamps or roughness are varied, and nothing else.

use glam::{DVec2, DVec3, UVec2};
use pathspace::bsdf::{Bsdf, Lobes};
use pathspace::endpoint::Light;
use pathspace::gallery::{self, GalleryError};
use pathspace::geometry::{Disk, Quad, Sphere, SurfacePoint};
use pathspace::import::{Options, gltf};
use pathspace::material::Texture;
use pathspace::math::Rgb;
use pathspace::scene::{
    Emission, Material, Mesh, Scene, SceneError, SurfaceArea, Variation, Warning, World,
    WorldBuilder,
};

const SIZE: UVec2 = UVec2::new(8, 8);

fn smaller(light_size: f64) -> Variation {
    Variation { light_size, ..Variation::default() }
}

fn rougher(alpha: f64) -> Variation {
    Variation { roughness: Some(alpha), ..Variation::default() }
}

#[test]
fn nothing_is_varied_by_default() {
    for name in gallery::NAMES {
        let plain = gallery::build(name, SIZE).expect("a scene of the gallery");
        let same = gallery::build_varied(name, SIZE, Variation::default()).expect("the same");
        assert_eq!(plain.world.fingerprint(), same.world.fingerprint(), "{name}");
        let other = gallery::build_varied(name, SIZE, smaller(0.5)).expect("valid").world;
        let warned = other.warnings().iter().any(|w| matches!(w, Warning::Unvaried { .. }));
        let changed = plain.world.fingerprint() != other.fingerprint();
        // Its lamp is a zone of the sphere, and glossy plates have more than one lamp.
        assert_eq!(warned, name == "sphere-cap", "{name}");
        assert_eq!(changed, name != "sphere-cap" && name != "smooth-mesh", "{name}");
    }
}

/// Lamps of every shape, one of them.
fn lamp(shape: usize, variation: Variation) -> Result<World, SceneError> {
    let mut builder = WorldBuilder::varied(variation);
    let black = builder.add_material("black", Material::Black)?;
    let center = DVec3::new(1.0, 2.0, 3.0);
    let id = match shape {
        0 => builder.add_sphere("lamp", Sphere::new(center, 0.5), black)?,
        1 => builder.add_disk("lamp", Disk { center, normal: DVec3::Z, radius: 0.5 }, black)?,
        2 => {
            let (edge_u, edge_v) = (DVec3::X, DVec3::Y * 2.0);
            let origin = center - 0.5 * (edge_u + edge_v);
            builder.add_quad("lamp", Quad { origin, edge_u, edge_v }, black)?
        }
        _ => {
            let mesh = Mesh {
                positions: [[0.0, 1.0], [2.0, 1.0], [2.0, 3.0], [0.0, 3.0]]
                    .map(|[x, y]| DVec3::new(x, y, 3.0))
                    .to_vec(),
                indices: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            };
            builder.add_mesh("lamp", &mesh, glam::DAffine3::IDENTITY, black)?
        }
    };
    builder.set_emission(id, Emission { radiance: Rgb::new(1.0, 2.0, 3.0), two_sided: false })?;
    builder.build()
}

#[test]
fn lamps_keep_their_power_and_their_centre() {
    for shape in 0..4 {
        let plain = lamp(shape, Variation::default()).expect("valid");
        for factor in [0.1, 3.0] {
            let scaled = lamp(shape, smaller(factor)).expect("valid");
            let [a, b] = [&plain, &scaled].map(|world| {
                let id = world.light_by_name("lamp").expect("there is one");
                (world.light(id).power().luminance(), world.bounds(), world.total_area())
            });
            assert!((a.0 / b.0 - 1.0).abs() < 1e-14, "{shape}: {} {}", a.0, b.0);
            assert!((a.1.center() - b.1.center()).length() < 1e-14, "{shape}");
            assert!((b.2 / a.2 / (factor * factor) - 1.0).abs() < 1e-14, "{shape}");
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-4] {
            let error = lamp(shape, smaller(bad)).expect_err("out of range");
            assert!(matches!(error, SceneError::Parameter { parameter: "light_size", .. }));
        }
    }
}

/// The lobes of a material on a disk.
fn lobes(material: Material, variation: Variation) -> (Lobes, Vec<Warning>) {
    let mut builder = WorldBuilder::varied(variation);
    let id = builder.add_material("material", material).expect("valid");
    let disk = Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 1.0 };
    builder.add_disk("disk", disk, id).expect("valid");
    let world = builder.build().expect("valid");
    let eye = SurfacePoint::dirac(DVec3::new(0.1, 0.1, 1.0));
    let x = world.intersect(&eye, -DVec3::Z).expect("it is in front");
    (world.bsdf(&x).lobes(), world.warnings().to_vec())
}

#[test]
fn all_that_mirrors_gets_the_roughness() {
    let white = || Texture::from(Rgb::splat(0.9));
    let smooth = [
        Material::Mirror { reflectance: Rgb::splat(0.9) },
        Material::Conductor { eta: Rgb::splat(0.2), k: Rgb::splat(3.0) },
        Material::Dielectric { relative_ior: 1.5 },
        Material::Plastic {
            albedo: white(),
            specular: Rgb::WHITE,
            relative_ior: 1.5,
            colour_shift: false,
        },
        Material::Mirror { reflectance: Rgb::splat(0.9) }.one_sided(),
        Material::Mirror { reflectance: Rgb::WHITE }.tinted(white()),
        Material::Dielectric { relative_ior: 1.5 }.stained(white()),
        Material::Mixture {
            components: Box::new([
                Material::Mirror { reflectance: Rgb::splat(0.9) },
                Material::Dielectric { relative_ior: 1.5 },
            ]),
            weights: [0.5, 0.5],
        },
        Material::RoughMirror { reflectance: Rgb::splat(0.9), alpha: DVec2::splat(0.3) },
    ];
    for material in smooth {
        let name = format!("{material:?}");
        let (rough, _) = lobes(material.clone(), rougher(0.2));
        assert!(!rough.intersects(Lobes::DIRAC), "{name}: {rough:?}");
        let (smooth, _) = lobes(material, rougher(0.0));
        assert!(smooth.intersects(Lobes::DIRAC), "{name}: {smooth:?}");
    }
    let diffuse = Material::Lambert { albedo: Rgb::splat(0.5) };
    assert_eq!(lobes(diffuse.clone(), rougher(0.2)), lobes(diffuse, Variation::default()));
}

#[test]
fn what_cannot_be_varied_is_said() {
    let product =
        Texture::from(Rgb::splat(0.5)).times(Texture::checkerboard(Rgb::BLACK, Rgb::WHITE));
    let material = Material::MetallicRoughness {
        base_color: Rgb::splat(0.5).into(),
        metallic_roughness: product,
        relative_ior: 1.5,
    };
    let (_, warnings) = lobes(material, rougher(0.2));
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.to_string().starts_with("\"material\" is not varied: "), "{warning}");
    // A roughness out of range is no roughness at all.
    let bad = gallery::build_varied("caustic", SIZE, rougher(-1.0));
    assert!(matches!(bad, Err(GalleryError::Scene(SceneError::Material { .. }))), "{bad:?}");
}

#[test]
fn files_are_varied_as_they_are_read() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/gltf/box.glb");
    let bytes = std::fs::read(path).expect("it is there");
    let options = Options::default();
    let of_file = gltf::load(path, SIZE, &options).expect("valid");
    let of_bytes = gltf::from_slice("box.glb", &bytes, SIZE, &options).expect("valid");
    assert_eq!(of_file.world.fingerprint(), of_bytes.world.fingerprint());
    let options = Options { variation: rougher(0.5), ..options };
    let varied = gltf::from_slice("box.glb", &bytes, SIZE, &options).expect("valid");
    assert_ne!(of_file.world.fingerprint(), varied.world.fingerprint());
    let text = std::fs::read(path.replace("box.glb", "textures.gltf")).expect("it is there");
    let error = gltf::from_slice("textures.gltf", &text, SIZE, &options).expect_err("other files");
    assert!(error.to_string().contains("textures.bin is another file"), "{error}");
}
