//! Materials of libraries against those built by hand.

use crate::files::{CORNERS, Directory, below};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::{Bsdf, TransportMode};
use pathspace::endpoint::Endpoint;
use pathspace::math::Rgb;
use pathspace::scene::{Material, Scene, World};

fn grey(albedo: f64) -> Material {
    Material::Lambert { albedo: Rgb::splat(albedo) }
}

fn rough_mirror(reflectance: Rgb, alpha: f64) -> Material {
    Material::RoughMirror { reflectance, alpha: DVec2::splat(alpha) }
}

fn metallic(base_color: f64, roughness: f64, metalness: f64, relative_ior: f64) -> Material {
    Material::MetallicRoughness {
        base_color: Rgb::splat(base_color).into(),
        metallic_roughness: Rgb::new(0.0, roughness, metalness).into(),
        relative_ior,
    }
}

fn phong(diffuse: Material, lobe: Material, weights: [f64; 2]) -> Material {
    Material::Mixture { components: Box::new([diffuse, lobe]), weights }
}

fn veil(material: Material, opacity: f64) -> Material {
    let amount = Rgb::splat(opacity).into();
    Material::Blend { components: Box::new([Material::Null, material]), amount }
}

fn assert_is(world: &World, expected: &Material, statements: &str) {
    let bsdf = world.bsdf(&below(world, 0.5, 0.25));
    let expected = expected.mixture().expect("valid");
    assert!(expected.is_some());
    assert_eq!(bsdf.mixture(true), expected, "{statements}");
    assert_eq!(bsdf.mixture(false), expected, "{statements}");
}

#[test]
fn materials_are_those_built_by_hand() {
    let directory = Directory::new("materials");
    let red = Rgb::new(0.5, 0.25, 0.125);
    let colour = Rgb::new(1.0, 0.5, 0.25);
    let glass = Material::Dielectric { relative_ior: 1.25 };
    let half = 0.5f64.sqrt();
    // α = √(2/(Ns + 2)) is 1/2 at 6 and 1/4 at 30, and its root is 1/√2 at 6.
    for (statements, expected) in [
        ("", grey(0.6)),
        ("Kd 0.5", grey(0.5)),
        ("Kd 0.5 0.25 0.125 # red", Material::Lambert { albedo: red }),
        (
            "Ka 1 1 1\nmap_Ka a.png\nTf 1 1 1\nPs 0\nKd 0.5 0.25 0.125",
            Material::Lambert { albedo: red },
        ),
        ("Kd 0.5\nKs 0 0 0\nNs 6\nillum 2", grey(0.5)),
        ("Kd 0.5\nKs 0.5\nNs 6\nillum 1", grey(0.5)),
        ("Kd 0.5\nKs 0.5\nNs 6\nillum 0", grey(0.5)),
        ("Kd 0\nKs 0.5 0.25 0.125\nNs 6", rough_mirror(red, 0.5)),
        ("Kd 0\nKs 0.5 0.25 0.125\nNs 30\nillum 3", rough_mirror(red, 0.25)),
        ("Kd 0\nKs 0.5 0.25 0.125", rough_mirror(red, 1.0)),
        ("Kd 0\nKs 0.5 0.25 0.125\nNs -3", rough_mirror(red, 1.0)),
        ("Kd 0\nKs 0.5 0.25 0.125\nillum 5", Material::Mirror { reflectance: red }),
        ("Kd 0\nKs 0.5 0.25 0.125\nNs 1024\nillum 8", Material::Mirror { reflectance: red }),
        ("Kd 0.25\nKs 0.5\nNs 6", phong(grey(1.0), rough_mirror(Rgb::WHITE, 0.5), [0.25, 0.5])),
        // Colours that exclude each other may be brighter together than 1.
        (
            "Kd 0.75 0 0\nKs 0 0 0.75\nNs 6",
            phong(
                Material::Lambert { albedo: Rgb::new(1.0, 0.0, 0.0) },
                rough_mirror(Rgb::new(0.0, 0.0, 1.0), 0.5),
                [0.75, 0.75],
            ),
        ),
        ("illum 7\nNi 1.25\nd 0.01\nKd 0.5", glass.clone()),
        ("illum 6\nNi 1.25\nPr 0", glass),
        (
            "illum 7\nPr 0.5",
            Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.25) },
        ),
        // What some programs write for all that is opaque.
        ("illum 4\nKd 0.5\nTf 1.00 1.00 1.00\nNi 1.00", grey(0.5)),
        ("Kd 0.5\nd 0.25", veil(grey(0.5), 0.25)),
        ("Kd 0.5\nd 0.25\nTr 0.5", veil(grey(0.5), 0.25)),
        ("Kd 0.5\nTr 0.5\nd 0.25", veil(grey(0.5), 0.25)),
        ("Kd 0.5\nTr 0.75\nillum 9", veil(grey(0.5), 0.25)),
        ("Kd 0\nKs 1 0.5 0.25\nNs 6\nd 0.25", veil(rough_mirror(colour, 0.5), 0.25)),
        ("Kd 0.5\nd 1", grey(0.5)),
        ("Kd 0.5\nd 0", Material::Null),
        ("Kd 0.5\nPr 0.25", metallic(0.5, 0.25, 0.0, 1.5)),
        ("Kd 0.5\nPr 0.25\nPm 0.75\nNi 2\nKs 1", metallic(0.5, 0.25, 0.75, 2.0)),
        ("Kd 0.5\nPm 1", metallic(0.5, 0.5, 1.0, 1.5)),
        ("Kd 0.5\nPm 1\nNs 6", metallic(0.5, half, 1.0, 1.5)),
        ("Kd 0.5\nPm 1\nNs -6", metallic(0.5, 1.0, 1.0, 1.5)),
    ] {
        let (world, warnings) = directory.square(statements);
        assert!(warnings.is_empty(), "{statements}: {warnings:?}");
        assert_is(&world, &expected, statements);
    }
}

/// Kd + Ks above 1 would create light: with a scale that makes it 1, a white wall is white.
#[test]
fn highlights_conserve_energy() {
    let directory = Directory::new("energy");
    let (world, warnings) = directory.square("Kd 0.75\nKs 0.5\nNs 6");
    assert!(
        warnings.len() == 1
            && warnings[0].contains("scene.mtl:1: material \"a\": Kd + Ks reflect 1.250")
    );
    let expected = phong(grey(1.0), rough_mirror(Rgb::WHITE, 0.5), [0.6, 0.4]);
    assert_is(&world, &expected, "scaled");
    // A mirror loses nothing, so that the sum is exactly 1.
    let (world, _) = directory.square("Kd 0.75\nKs 0.5\nillum 3");
    let bsdf = world.bsdf(&below(&world, 0.5, 0.25));
    for u in [0.1, 0.9] {
        let sample =
            bsdf.sample(DVec3::new(0.6, 0.0, 0.8), TransportMode::Radiance, u, DVec2::splat(0.3));
        assert_relative_eq!(sample.expect("a direction").weight.g(), 1.0, max_relative = 1e-14);
    }
}

#[test]
fn values_outside_of_their_range_are_the_nearest_ones() {
    let directory = Directory::new("ranges");
    for (statements, expected, warning) in [
        (
            "Kd 1.5 0.5 -1",
            Material::Lambert { albedo: Rgb::new(1.0, 0.5, 0.0) },
            "Kd is not in [0, 1]",
        ),
        ("Kd nan 0 0", grey(0.6), "scene.mtl:2: Kd is not one finite number"),
        ("Kd 0.5 0.5", grey(0.6), "Kd is not one finite number"),
        ("Kd", grey(0.6), "Kd is not one finite number"),
        ("Kd spectral a.rfl 1", grey(0.6), "Kd is not one finite number"),
        ("Kd 0.5\nd -1", Material::Null, "d is -1, and not in [0, 1]"),
        ("Kd 0.5\nd inf", grey(0.5), "d is not a finite number"),
        ("Kd 0.5\nd -halo 0.5", grey(0.5), "d -halo"),
        ("Kd 0.5\nPr 2", metallic(0.5, 1.0, 0.0, 1.5), "Pr is 2"),
        ("Kd 0.5\nPm -0.5\nPr 0.5", metallic(0.5, 0.5, 0.0, 1.5), "Pm is -0.5"),
        (
            "illum 7\nNi 0.5",
            Material::Dielectric { relative_ior: 1.5 },
            "the index of refraction 0.5",
        ),
        (
            "Kd 0.5\nKs 0.5\nd 0.5",
            veil(grey(0.5), 0.5),
            "Ks is left out of a material that is seen through",
        ),
        ("Kd 0.5\nPs 0.5", grey(0.5), "Ps is not supported"),
        ("Kd 0.5\nTf 0.5 1 1", grey(0.5), "Tf is not supported"),
        (
            "Kd 0.5\nbump -bm 2 b.png",
            grey(0.5),
            "no file b.png; the surface is as smooth as its shape",
        ),
        ("Kd 0.5\nmap_Bump b.png", grey(0.5), "no file b.png; the surface"),
        ("Kd 0.5\nnorm b.png", grey(0.5), "no file b.png; the surface"),
        ("Kd 0.5\ndisp b.png", grey(0.5), "disp is not supported"),
        ("Kd 0.5\nrefl -type sphere b.png", grey(0.5), "refl is not supported"),
        ("Kd 0.5\nKe -1 0 0", grey(0.5), "Ke is negative"),
    ] {
        let (world, warnings) = directory.square(statements);
        assert!(warnings.len() == 1 && warnings[0].contains(warning), "{statements}: {warnings:?}");
        assert_is(&world, &expected, statements);
    }
}

/// Emission is seen from both sides; without any, the sky is white.
#[test]
fn light_is_that_of_the_file_or_white() {
    let directory = Directory::new("light");
    let (world, warnings) = directory.square("Kd 0\nKe 3 2 1");
    assert!(warnings.is_empty() && world.light_count() == 1);
    let x = below(&world, 0.5, 0.25);
    let light = world.light(world.light_at(&x).expect("it emits"));
    for direction in [DVec3::Z, -DVec3::Z] {
        assert_eq!(light.emit(&x, direction), Rgb::new(3.0, 2.0, 1.0));
    }
    for dark in ["", "Ke 0 0 0"] {
        let (world, warnings) = directory.square(dark);
        assert!(warnings.is_empty() && world.light_count() == 1);
        assert_eq!(world.light_name(world.environment().expect("white")), Some("environment"));
    }
}

#[test]
fn libraries_are_found_where_they_are() {
    let directory = Directory::new("libraries");
    directory.write("two words.mtl", "Kd 0\nnewmtl a\nKd 0.25\nnewmtl a\nKd 0.75\n");
    directory.write("other.mtl", "newmtl  b b \nKd 0.5\n");
    directory.write("below/it.mtl", "newmtl c\nKd 0.125\n");
    for (libraries, name, albedo, warnings) in [
        ("mtllib two words.mtl", "a", 0.25, 1),
        ("mtllib other.mtl", "b b", 0.5, 0),
        ("mtllib below/it.mtl other.mtl", "b b", 0.5, 0),
        ("mtllib other.mtl\nmtllib below\\it.mtl", "c", 0.125, 0),
    ] {
        let text = format!("{libraries}\n{CORNERS}usemtl {name}\nf 1 2 3 4\n");
        let (world, found) = directory.load(&text);
        assert_eq!(found.len(), warnings, "{found:?}");
        assert_is(&world, &grey(albedo), libraries);
    }
}
