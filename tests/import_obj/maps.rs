//! Images of materials, and their options.

use crate::files::{Directory, below, tga};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::{Bsdf, MetallicRoughness, TransportMode};
use pathspace::endpoint::Endpoint;
use pathspace::film::linear_from_srgb;
use pathspace::math::Rgb;
use pathspace::scene::{Material, Scene, World};

/// The centres of the four pixels of an image that covers the square: upper left, upper right,
/// lower left, lower right.
const CENTRES: [(f64, f64); 4] = [(0.25, 0.75), (0.75, 0.75), (0.25, 0.25), (0.75, 0.25)];
const PIXELS: [[u8; 4]; 4] =
    [[255, 0, 0, 255], [0, 255, 0, 51], [0, 0, 255, 102], [51, 102, 153, 0]];

fn linear([r, g, b, _]: [u8; 4]) -> Rgb {
    Rgb([r, g, b].map(|code| linear_from_srgb(f64::from(code) / 255.0)))
}

fn albedo(world: &World, (x, y): (f64, f64)) -> Rgb {
    let (wi, wo) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, 0.8));
    world.bsdf(&below(world, x, y)).eval(wi, wo) * std::f64::consts::PI
}

fn directory(name: &str) -> Directory {
    let directory = Directory::new(name);
    directory.write("two by two.tga", tga(2, &PIXELS));
    directory.write("grey.tga", tga(1, &[[102, 102, 102, 255]]));
    directory.write("opaque.tga", tga(2, &PIXELS.map(|[r, g, b, _]| [r, g, b, 255])));
    directory
}

fn close(a: Rgb, b: Rgb) {
    for channel in 0..3 {
        assert_relative_eq!(a[channel], b[channel], epsilon = 1e-7, max_relative = 1e-6);
    }
}

#[test]
fn images_lie_as_they_are_seen() {
    let directory = directory("kd");
    for (statements, shown, factor) in [
        ("map_Kd two by two.tga", [0, 1, 2, 3], 1.0),
        ("Kd 0.5\nmap_Kd two by two.tga", [0, 1, 2, 3], 0.5),
        ("Kd 0.5\nmap_Kd -blendu on -texres 4 -mm 0 1 -boost 2 two by two.tga", [0, 1, 2, 3], 0.5),
        // One pixel to the left, where it repeats; and one up.
        ("map_Kd -o 0.5 0 0 two by two.tga", [1, 0, 3, 2], 1.0),
        ("map_Kd -o 0.5 two by two.tga", [1, 0, 3, 2], 1.0),
        ("map_Kd -o 0 0.5 two by two.tga", [2, 3, 0, 1], 1.0),
        // Twice as small: each quarter of the square shows the whole.
        ("map_Kd -s 3 1 1 two by two.tga", [1, 0, 3, 2], 1.0),
        ("map_Kd -clamp on -o 0 0.5 0 two by two.tga", [0, 1, 0, 1], 1.0),
    ] {
        let (world, warnings) = directory.square(statements);
        assert!(warnings.is_empty(), "{warnings:?}");
        for (centre, pixel) in CENTRES.into_iter().zip(shown) {
            close(albedo(&world, centre), linear(PIXELS[pixel]) * factor);
        }
    }
}

#[test]
fn emission_and_highlights_have_images() {
    let directory = directory("ke");
    for (statements, factor) in
        [("Kd 0\nmap_Ke two by two.tga", 1.0), ("Kd 0\nKe 20\nmap_Ke two by two.tga", 20.0)]
    {
        let (world, warnings) = directory.square(statements);
        assert!(warnings.is_empty(), "{warnings:?}");
        for (centre, pixel) in CENTRES.into_iter().zip(PIXELS) {
            let x = below(&world, centre.0, centre.1);
            let light = world.light(world.light_at(&x).expect("it emits"));
            close(light.emit(&x, DVec3::Z), linear(pixel) * factor);
        }
    }
    let (world, warnings) = directory.square("Kd 0\nKs 0.5\nmap_Ks two by two.tga\nillum 3");
    assert!(warnings.is_empty(), "{warnings:?}");
    for ((x, y), pixel) in CENTRES.into_iter().zip(PIXELS) {
        let bsdf = world.bsdf(&below(&world, x, y));
        let sample =
            bsdf.sample(DVec3::new(0.6, 0.0, 0.8), TransportMode::Radiance, 0.5, DVec2::splat(0.5));
        close(sample.expect("a direction").weight, linear(pixel) * 0.5);
    }
}

/// Whatever the factors, rounding does not take a product of them out of its range.
#[test]
fn highlights_of_images_conserve_energy() {
    let directory = directory("rounding");
    directory.write("dim.tga", tga(1, &[[179, 143, 17, 255]]));
    for k in 1..60 {
        let factor = f64::from(k) / 60.0;
        let (world, warnings) =
            directory.square(&format!("Kd {factor}\nmap_Kd dim.tga\nKs {factor}\nmap_Ks dim.tga"));
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(world.primitive_count(), 2);
    }
}

/// The alpha channel if there is one, else the luminance, or the channel that is asked for.
#[test]
fn opacity_has_an_image() {
    let directory = directory("d");
    let luminance =
        PIXELS.map(|[r, g, b, _]| Rgb([r, g, b].map(|code| f64::from(code) / 255.0)).luminance());
    for (statements, expected) in [
        ("Kd 0.5\nmap_d two by two.tga", [1.0, 0.2, 0.4, 0.0]),
        ("Kd 0.5\nd 0.5\nmap_d -imfchan m two by two.tga", [0.5, 0.1, 0.2, 0.0]),
        ("Kd 0.5\nmap_d -imfchan l two by two.tga", luminance),
        ("Kd 0.5\nmap_d -imfchan r two by two.tga", [1.0, 0.0, 0.0, 0.2]),
        ("Kd 0.5\nmap_d -imfchan g two by two.tga", [0.0, 1.0, 0.0, 0.4]),
        ("Kd 0.5\nmap_d -imfchan b two by two.tga", [0.0, 0.0, 1.0, 0.6]),
    ] {
        let (world, warnings) = directory.square(statements);
        assert!(warnings.is_empty(), "{warnings:?}");
        for (centre, opacity) in CENTRES.into_iter().zip(expected) {
            close(albedo(&world, centre), Rgb::splat(0.5 * opacity));
        }
    }
}

#[test]
fn roughness_and_metalness_have_images() {
    let directory = directory("pr");
    directory.write("wide.tga", tga(4, &[[0; 4], [51; 4], [102; 4], [255; 4]]));
    let eval = |material: MetallicRoughness| {
        let (wi, wo) = (DVec3::new(0.28, 0.0, 0.96), DVec3::new(0.0, 0.28, 0.96));
        material.eval(wi, wo)
    };
    let blue = [0.0, 0.0, 1.0, 0.6];
    for (statements, expected) in [
        ("map_Pr -imfchan b two by two.tga\nPm 0.5", blue.map(|rough| [rough, 0.5])),
        ("Pr 0.5\nmap_Pr -imfchan b two by two.tga", blue.map(|rough| [0.5 * rough, 0.0])),
        ("Pr 0.5\nmap_Pm -imfchan b two by two.tga", blue.map(|metal| [0.5, metal])),
        (
            "map_Pr grey.tga\nPm 0.5\nmap_Pm -imfchan b two by two.tga",
            blue.map(|metal| [0.4, 0.5 * metal]),
        ),
    ] {
        let (world, warnings) = directory.square(&format!("Kd 0.5\n{statements}"));
        assert!(warnings.is_empty(), "{warnings:?}");
        for ((x, y), [roughness, metalness]) in CENTRES.into_iter().zip(expected) {
            let (wi, wo) = (DVec3::new(0.28, 0.0, 0.96), DVec3::new(0.0, 0.28, 0.96));
            let found = world.bsdf(&below(&world, x, y)).eval(wi, wo);
            let model = MetallicRoughness::new(Rgb::splat(0.5), metalness, roughness, 1.5);
            close(found, eval(model.expect("valid")));
        }
    }
    let (world, warnings) =
        directory.square("Kd 0.5\nmap_Pr wide.tga\nmap_Pm -o 0.5 two by two.tga");
    assert!(warnings.len() == 1 && warnings[0].contains("the options of two by two.tga are those"));
    assert_eq!(world.primitive_count(), 2);
    let (wi, wo) = (DVec3::new(0.28, 0.0, 0.96), DVec3::new(0.0, 0.28, 0.96));
    // An exponent of 15 · 0.4 has α = 1/2, a roughness of 0.75 · 0.4 has 0.09.
    let lobe = Material::RoughMirror { reflectance: Rgb::splat(0.5), alpha: DVec2::splat(0.5) };
    let (world, warnings) = directory.square("Kd 0\nKs 0.5\nNs 15\nmap_Ns grey.tga");
    assert!(warnings.is_empty(), "{warnings:?}");
    let expected = lobe.mixture().expect("valid").expect("a model").eval(wi, wo);
    close(world.bsdf(&below(&world, 0.5, 0.25)).eval(wi, wo), expected);
    let relative_ior = 1.5;
    let frosted = Material::RoughDielectric { relative_ior, alpha: DVec2::splat(0.09) };
    let (world, warnings) = directory.square("illum 7\nPr 0.75\nmap_Pr grey.tga");
    assert!(warnings.is_empty(), "{warnings:?}");
    let wi = DVec3::new(0.28, 0.0, -0.96);
    let expected = frosted.mixture().expect("valid").expect("a model").eval(wi, wo);
    close(world.bsdf(&below(&world, 0.5, 0.25)).eval(wi, wo), expected);
}

#[test]
fn normals_and_heights_have_images() {
    let directory = directory("relief");
    // Heights that grow by 0.2 from pixel to pixel, of which there are four across the square.
    directory.write("ramp.tga", tga(4, &[[0; 4], [51; 4], [102; 4], [153; 4]]));
    directory.write("steps.tga", tga(1, &[[153; 4], [102; 4], [51; 4], [0; 4]]));
    directory.write("normal.tga", tga(1, &[[204, 102, 255, 255]]));
    let mapped = DVec3::new(0.6, -0.2, 1.0).normalize();
    for (statements, normal, warned) in [
        ("bump ramp.tga", DVec3::new(-0.8, 0.0, 1.0), false),
        ("map_Bump -bm 0.5 ramp.tga", DVec3::new(-0.4, 0.0, 1.0), false),
        ("map_bump -s 0.5 1 1 ramp.tga", DVec3::new(-0.4, 0.0, 1.0), false),
        ("bump steps.tga", DVec3::new(0.0, -0.8, 1.0), false),
        ("norm normal.tga", mapped, false),
        ("bump ramp.tga\nnorm normal.tga", mapped, false),
        ("bump -bm 3 normal.tga", mapped, true),
    ] {
        let (world, warnings) = directory.square(statements);
        assert_eq!(warnings.len(), usize::from(warned), "{warnings:?}");
        assert_relative_eq!(
            below(&world, 0.5, 0.55).shading_normal,
            normal.normalize(),
            epsilon = 1e-7
        );
    }
}

#[test]
fn images_that_cannot_be_read_leave_the_factor() {
    let directory = directory("unreadable");
    directory.write("broken.png", b"\x89PNG\r\n\x1a\nno chunks");
    directory.write("text.txt", "text");
    let grey = Material::Lambert { albedo: Rgb::splat(0.5) };
    for (map, warning) in [
        ("none.png", "scene.mtl:3: material \"a\": there is no file none.png; the factor holds"),
        ("broken.png", "broken.png: "),
        ("text.txt", "text.txt: "),
        ("../up.png", "may lie outside"),
        ("C:\\images\\wood.png", "there is no file C:/images/wood.png"),
        ("/etc/hostname", "may lie outside"),
        ("", "map_Kd names no file"),
        ("-clamp on", "map_Kd names no file"),
        (".", "is not a file"),
    ] {
        let (world, warnings) = directory.square(&format!("Kd 0.5\nmap_Kd {map}"));
        assert!(warnings.len() == 1 && warnings[0].contains(warning), "{map}: {warnings:?}");
        let bsdf = world.bsdf(&below(&world, 0.5, 0.25));
        assert_eq!(bsdf.mixture(true), grey.mixture().expect("valid"), "{map}");
    }
    for option in ["-mm 0.5 2", "-t 1 1 1", "-imfchan z", "-cc on"] {
        let (world, warnings) = directory.square(&format!("map_Kd {option} grey.tga"));
        assert!(
            warnings.len() == 1 && warnings[0].contains("is left out"),
            "{option}: {warnings:?}"
        );
        close(albedo(&world, (0.5, 0.25)), linear([102; 4]));
    }
}

/// A library in a directory refers to images beside it, or to those beside the scene.
#[test]
fn images_are_looked_for_beside_their_library() {
    let directory = directory("beside");
    directory.write("below/grey.tga", tga(1, &[[51, 51, 51, 255]]));
    directory.write("below/a.mtl", "newmtl a\nmap_Kd grey.tga\nnewmtl b\nmap_Kd opaque.tga\n");
    let text = |name: &str| {
        format!("mtllib below/a.mtl\n{}usemtl {name}\nf 1/1 2/2 3/3 4/4\n", crate::files::CORNERS)
    };
    close(albedo(&directory.world(&text("a")), (0.5, 0.25)), linear([51; 4]));
    close(albedo(&directory.world(&text("b")), CENTRES[2]), linear(PIXELS[2]));
}

#[test]
fn missing_texture_coordinates_are_said() {
    let directory = directory("coordinates");
    directory.write("scene.mtl", "newmtl a\nmap_Kd two by two.tga\n");
    let text = format!("mtllib scene.mtl\n{}usemtl a\nf 1 2 3 4\n", crate::files::CORNERS);
    let (_, warnings) = directory.load(&text);
    assert!(warnings.len() == 1 && warnings[0].contains("4 of its vertices lack texture"));
}
