//! Textures.

use crate::files::{Directory, PROBE, seen};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::Bsdf;
use pathspace::film::{Image, ImageFile, linear_from_srgb};
use pathspace::import::Import;
use pathspace::math::Rgb;
use pathspace::scene::Scene;

/// A square whose texture coordinates are x and y.
const SQUARE: &str = "Material \"diffuse\" \"texture reflectance\" \"t\"\n\
    Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0]";

fn albedo(import: &Import, uv: DVec2) -> Rgb {
    let hit = seen(&import.world, uv.extend(1.0), DVec3::NEG_Z);
    import.world.bsdf(&hit).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI
}

fn near(found: Rgb, expected: [f64; 3], what: &str) {
    (0..3).for_each(|i| assert!((found[i] - expected[i]).abs() < 1e-6, "{what}: {found:?}"));
}

/// Pixels of 0.25, 0.5, 0.75 and 1 (as codes of PNG: 64, 128, 191 and 255), the lower row first.
fn save_grey(directory: &Directory) {
    let code = |code: u8| Rgb::splat(linear_from_srgb(f64::from(code) / 255.0));
    let pixels = vec![code(191), code(255), code(64), code(128)];
    let image = Image::new(2, 2, pixels).expect("four pixels");
    ImageFile::from(image.clone()).save(directory.0.join("parts/grey.png")).expect("saved");
}

#[test]
fn images_are_mapped_and_decoded() {
    let directory = Directory::new("images");
    save_grey(&directory);
    let at = |parameters: &str, u: f64, v: f64| {
        let texture = format!(
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"parts/grey.png\" {parameters}\n"
        );
        albedo(&directory.load(&format!("{PROBE}{texture}{SQUARE}")), DVec2::new(u, v)).r()
    };
    let linear = |code: u8| f64::from(code) / 255.0;
    let srgb = |code: u8| linear_from_srgb(linear(code));
    let point = "\"string filter\" \"point\"";
    for (u, v, code) in [(0.2, 0.3, 64), (0.7, 0.1, 128), (0.2, 0.8, 191), (0.9, 0.6, 255)] {
        assert_relative_eq!(at(point, u, v), srgb(code), epsilon = 1e-7);
        let encoding = format!("{point} \"string encoding\" \"linear\"");
        assert_relative_eq!(at(&encoding, u, v), linear(code), epsilon = 1e-7);
        let encoding = format!("{point} \"string encoding\" \"gamma 2\"");
        assert_relative_eq!(at(&encoding, u, v), linear(code).powi(2), epsilon = 1e-6);
        let inverted = format!("{point} \"float scale\" 0.5 \"bool invert\" true");
        assert_relative_eq!(at(&inverted, u, v), 1.0 - 0.5 * srgb(code), epsilon = 1e-7);
    }
    // Between the centres of pixels it is linear, and beyond them as the wrap mode says.
    let mean = 0.25 * [64, 128, 191, 255].map(srgb).iter().sum::<f64>();
    assert_relative_eq!(at("", 0.5, 0.5), mean, epsilon = 1e-7);
    assert_relative_eq!(at("\"string wrap\" \"clamp\"", 0.1, 0.2), srgb(64), epsilon = 1e-7);
    let moved = format!(
        "{point} \"float uscale\" 2 \"float vscale\" 0.5 \"float udelta\" 1.25 \"float vdelta\" 0.25"
    );
    // (0.2, 0.3) becomes (1.65, 0.4).
    assert_relative_eq!(at(&moved, 0.2, 0.3), srgb(128), epsilon = 1e-7);
    let clamped = format!("{moved} \"string wrap\" \"clamp\"");
    assert_relative_eq!(at(&clamped, 0.2, 0.3), srgb(128), epsilon = 1e-7);
}

#[test]
fn textures_are_made_of_others() {
    let directory = Directory::new("textures");
    save_grey(&directory);
    let at = |text: &str, u: f64, v: f64| {
        albedo(&directory.load(&format!("{PROBE}{text}\n{SQUARE}")), DVec2::new(u, v))
    };
    near(
        at("Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0.1 0.2 0.3]", 0.3, 0.3),
        [0.1, 0.2, 0.3],
        "constant",
    );
    let board = "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 2 \"float vscale\" 4 \
        \"rgb tex1\" [0.1 0.2 0.3] \"rgb tex2\" [0.9 0.9 0.9]";
    // The first where ⌊2 u⌋ + ⌊4 v⌋ is even.
    for (u, v, is_first) in
        [(0.2, 0.1, true), (0.7, 0.1, false), (0.2, 0.3, false), (0.7, 0.3, true), (0.7, 0.8, true)]
    {
        let expected = if is_first { [0.1, 0.2, 0.3] } else { [0.9; 3] };
        near(at(board, u, v), expected, &format!("{u} {v}"));
    }
    let scale = format!(
        "{}\nTexture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"b\" \"float scale\" 0.5",
        board.replace("\"t\"", "\"b\"")
    );
    near(at(&scale, 0.2, 0.1), [0.05, 0.1, 0.15], "scale");
    let old = scale
        .replace("texture tex\"", "texture tex1\"")
        .replace("float scale\" 0.5", "rgb tex2\" [1 0 0.5]");
    near(at(&old, 0.2, 0.1), [0.1, 0.0, 0.15], "scale of version 3");
    let mix = "Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0.2 0.4 0.6] \"rgb tex2\" [1 0 1] \"float amount\" 0.25";
    near(at(mix, 0.2, 0.1), [0.4, 0.3, 0.7], "mix");
    let constants = "Texture \"a\" \"float\" \"constant\" \"float value\" 0.5\n\
        Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0.2 0.4 0.6] \"rgb tex2\" [1 0 1] \"texture amount\" \"a\"";
    near(at(constants, 0.2, 0.1), [0.6, 0.2, 0.8], "mix by a texture");
    // An image mixes constants, and is mixed with one.
    let image = |sort: &str| {
        format!(
            "Texture \"i\" \"{sort}\" \"imagemap\" \"string filename\" \"parts/grey.png\" \
             \"string encoding\" \"linear\"\n"
        )
    };
    // Half way between four pixels, and in the middle of one.
    for (u, v, value) in
        [(0.5, 0.5, (64 + 128 + 191 + 255) as f64 / 1020.0), (0.25, 0.25, 64.0 / 255.0)]
    {
        let by = format!(
            "{}Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0.2 0.4 0.6] \"rgb tex2\" [1 0 1] \
             \"texture amount\" \"i\"",
            image("float")
        );
        near(at(&by, u, v), [0.2 + 0.8 * value, 0.4 - 0.4 * value, 0.6 + 0.4 * value], "mixed by");
        for (parts, share) in [
            ("\"texture tex1\" \"i\" \"rgb tex2\" [0.2 0.4 0.6]", 0.75),
            ("\"texture tex2\" \"i\" \"rgb tex1\" [0.2 0.4 0.6]", 0.25),
        ] {
            let with = format!(
                "{}Texture \"t\" \"spectrum\" \"mix\" {parts} \"float amount\" 0.25",
                image("spectrum")
            );
            let expected = [0.2, 0.4, 0.6].map(|c| value * share + c * (1.0 - share));
            near(at(&with, u, v), expected, parts);
        }
    }
    // The reflectance of a spectrum is seen under daylight, so that it is grey if it is constant.
    let grey = "Texture \"t\" \"spectrum\" \"constant\" \"spectrum value\" [300 0.3 900 0.3]";
    (0..3).for_each(|i| {
        assert_relative_eq!(at(grey, 0.5, 0.5)[i], 0.3, max_relative = 1e-3);
    });
}

#[test]
fn what_is_no_texture_here_has_its_mean() {
    let directory = Directory::new("means");
    save_grey(&directory);
    let image = "\"string filename\" \"parts/grey.png\" \"string encoding\" \"linear\"";
    let mean = (64 + 128 + 191 + 255) as f64 / (4.0 * 255.0);
    let board =
        "Texture \"b\" \"spectrum\" \"checkerboard\" \"float uscale\" 8 \"float vscale\" 8\n";
    let board2 = board.replace("\"b\"", "\"c\"");
    let cases = [
        (
            format!(
                "Texture \"t\" \"spectrum\" \"imagemap\" {image} \"string mapping\" \"spherical\""
            ),
            mean,
        ),
        ("Texture \"t\" \"spectrum\" \"bilerp\" \"rgb v00\" [0.1 0.1 0.1]".to_owned(), 0.525),
        ("Texture \"t\" \"spectrum\" \"dots\" \"rgb outside\" [0.1 0.1 0.1]".to_owned(), 0.1),
        ("Texture \"t\" \"spectrum\" \"marble\"".to_owned(), 0.5),
        ("Texture \"t\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3".to_owned(), 0.5),
        (
            format!("{board}Texture \"t\" \"spectrum\" \"checkerboard\" \"texture tex1\" \"b\""),
            0.25,
        ),
        (
            format!(
                "{board}{board2}Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"b\" \"texture tex2\" \"c\""
            ),
            0.5,
        ),
        (
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"".to_owned(),
            0.5,
        ),
        ("Texture \"t\" \"spectrum\" \"imagemap\"".to_owned(), 0.5),
    ];
    for (text, expected) in cases {
        let import = directory.left_out(&format!("{PROBE}{text}\n{SQUARE}"), "");
        near(albedo(&import, DVec2::new(0.3, 0.4)), [expected; 3], &text);
    }
    // The roughness of a coat that varies has its mean.
    let rough = format!(
        "{PROBE}Texture \"r\" \"float\" \"imagemap\" {image}\nMaterial \"coateddiffuse\" \"texture roughness\" \"r\"\nShape \"sphere\""
    );
    directory.left_out(&rough, "the roughness of a coat");
    let bright = "Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"b\" \"float scale\" 4\n";
    let import = directory.left_out(&format!("{PROBE}{board}{bright}{SQUARE}"), "scaled down to 1");
    near(albedo(&import, DVec2::new(0.05, 0.05)), [1.0; 3], "scaled down");
}

/// Shading normals of a height that grows by a half along u, and of normal maps, whose green goes
/// along v on a square that is not mirrored.
#[test]
fn reliefs_turn_normals() {
    let directory = Directory::new("reliefs");
    // Between the centres of its two columns the height grows from 0 to 0.25.
    let heights = Image::new(2, 1, vec![Rgb::BLACK, Rgb::splat(0.25)]).expect("two pixels");
    ImageFile::from(heights).save(directory.0.join("parts/slope.exr")).expect("saved");
    let (red, green) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, 0.8));
    for (name, normal) in [("red", red), ("green", green)] {
        let image = Image::new(1, 1, vec![Rgb((0.5 + 0.5 * normal).to_array())]).expect("a pixel");
        ImageFile::from(image).save(directory.0.join(format!("parts/{name}.exr"))).expect("saved");
    }
    let normal = |material: &str, state: &str| {
        let text = format!(
            "{PROBE}Texture \"h\" \"float\" \"imagemap\" \"string filename\" \"parts/slope.exr\"\n\
             Material \"diffuse\" {material}\n{state} Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0]"
        );
        let world = directory.load(&text).world;
        let center = 0.5 * (world.bounds().min + world.bounds().max);
        let hit = seen(&world, center + DVec3::new(0.01, 0.02, 1.0), DVec3::NEG_Z);
        hit.shading_normal
    };
    let close = |found: DVec3, expected: DVec3| {
        assert_relative_eq!(found, expected.normalize(), epsilon = 1e-6);
    };
    let bump = "\"texture displacement\" \"h\"";
    close(normal(bump, ""), DVec3::new(-0.5, 0.0, 1.0));
    close(normal(bump, "Scale 0.5 1 1"), DVec3::new(-1.0, 0.0, 1.0));
    close(normal(bump, "Scale -1 1 1"), DVec3::new(0.5, 0.0, 1.0));
    let map = |name: &str| format!("\"string normalmap\" \"parts/{name}.exr\"");
    close(normal(&map("red"), ""), red);
    close(normal(&map("red"), "Rotate 90 0 0 1"), green);
    close(normal(&map("green"), ""), green);
}
