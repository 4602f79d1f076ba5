//! Lights and their units.

use crate::files::{Directory, FLOOR, PROBE, emitted, intensity, render};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::film::{Image, ImageFile};
use pathspace::import::Import;
use pathspace::math::Rgb;
use std::f64::consts::{PI, TAU};

/// The largest radiance of what is around, in a direction.
fn from_sky(import: &Import, towards: DVec3) -> Rgb {
    emitted(&import.world, DVec3::ZERO, towards)
}

fn near(found: Rgb, expected: [f64; 3], tolerance: f64) {
    (0..3).for_each(|i| assert_relative_eq!(found[i], expected[i], max_relative = tolerance));
}

#[test]
fn points_have_their_intensity_and_power() {
    let directory = Directory::new("points");
    let light = |parameters: &str| {
        let text = format!("{PROBE}Translate 0 1 0\nLightSource \"point\" {parameters}\n{FLOOR}");
        intensity(&directory.load(&text).world, DVec3::new(1.0, 2.0, 3.0))
    };
    let at = "\"point3 from\" [1 0 2]";
    assert_eq!(light(at), (DVec3::new(1.0, 1.0, 2.0), Rgb::WHITE));
    assert_eq!(light("\"rgb I\" [1 2 3] \"float scale\" 2").1, Rgb::new(2.0, 4.0, 6.0));
    near(light("\"float power\" 50").1, [50.0 / (4.0 * PI); 3], 1e-12);
    // Version 3.
    assert_eq!(light("\"color I\" [1 2 3] \"color scale\" [2 1 0]").1, Rgb::new(2.0, 2.0, 0.0));
}

/// Of all spectra but RGB the luminance is 1, whatever their magnitude.
#[test]
fn spectra_of_lights_have_luminance_1() {
    let directory = Directory::new("spectra");
    directory.write("parts/rise.spd", "# rises\n400 0.1\n700 0.4 # steadily\n");
    let colour = |value: &str| {
        let text = format!("{PROBE}LightSource \"point\" {value}\n{FLOOR}");
        intensity(&directory.load(&text).world, DVec3::Z).1
    };
    for value in [
        "\"blackbody I\" 3000",
        "\"blackbody I\" [6500]",
        "\"spectrum I\" [300 5 900 5]",
        "\"spectrum I\" [300 2 500 7 900 5]",
        "\"spectrum I\" \"stdillum-A\"",
        "\"spectrum I\" \"stdillum-F11\"",
        "\"spectrum I\" \"parts/rise.spd\"",
    ] {
        assert_relative_eq!(colour(value).luminance(), 1.0, max_relative = 2e-3);
    }
    assert_relative_eq!(colour("\"blackbody I\" [3000 2.5]").luminance(), 2.5, max_relative = 2e-3);
    // Daylight is white, the same energy at all wavelengths a little reddish (both by the
    // chromaticities of the standard), and illuminant A is a black body of 2856 K.
    near(colour("\"spectrum I\" \"stdillum-D65\""), [1.0; 3], 1e-9);
    near(colour("\"spectrum I\" [300 5 900 5]"), [1.2048, 0.9483, 0.9089], 2e-3);
    let lamp = colour("\"blackbody I\" 2856");
    near(colour("\"spectrum I\" \"stdillum-A\""), lamp.0, 5e-3);
}

#[test]
fn spots_have_their_cone_and_power() {
    let directory = Directory::new("spots");
    let towards = |parameters: &str, degrees: f64| {
        let text = format!("{PROBE}LightSource \"spot\" {parameters}\n{FLOOR}");
        let (sin, cos) = degrees.to_radians().sin_cos();
        intensity(&directory.load(&text).world, DVec3::new(cos, 0.0, sin)).1.r()
    };
    let along_x = "\"point3 to\" [1 0 0]";
    assert_relative_eq!(towards(along_x, 24.0), 1.0);
    assert_relative_eq!(towards(along_x, 30.5), 0.0);
    // Smooth in the cosine between 25 and 30 degrees.
    let cone = "\"point3 to\" [1 0 0] \"float coneangle\" 60 \"float conedeltaangle\" 60";
    let middle = 0.75f64.acos().to_degrees();
    assert_relative_eq!(towards(cone, middle), 0.5, max_relative = 1e-9);
    // 2π times the integral of 1 up to 20 degrees and of a half beyond.
    let power = "\"point3 to\" [1 0 0] \"float coneangle\" 40 \"float conedeltaangle\" 20 \"float power\" 30";
    let [inner, outer] = [20f64, 40.0].map(|angle| angle.to_radians().cos());
    let expected = 30.0 / (TAU * (1.0 - 0.5 * (inner + outer)));
    assert_relative_eq!(towards(power, 10.0), expected, max_relative = 1e-9);
}

/// The radiance E/π of a white floor.
#[test]
fn distant_lights_have_their_irradiance() {
    let directory = Directory::new("distant");
    let floor = format!("Material \"diffuse\" \"rgb reflectance\" [1 1 1]\n{FLOOR}");
    let radiance = |light: &str| {
        let text = format!("{PROBE}{light}\nIdentity\n{floor}");
        render(&directory.load(&text), 1).mean() * PI
    };
    let down = "\"point3 from\" [0 0 1] \"point3 to\" [0 0 0]";
    near(
        radiance(&format!("LightSource \"distant\" {down} \"rgb L\" [1 2 3]")),
        [1.0, 2.0, 3.0],
        1e-6,
    );
    near(
        radiance(&format!("LightSource \"distant\" {down} \"float illuminance\" 7")),
        [7.0; 3],
        1e-6,
    );
    // From x over z, 60 degrees from above.
    let turned = format!("Rotate 60 0 1 0\nLightSource \"distant\" {down} \"float scale\" 4");
    near(radiance(&turned), [2.0; 3], 1e-6);
    // From below there is nothing.
    assert_eq!(radiance("LightSource \"distant\""), Rgb::BLACK);
}

#[test]
fn area_lights_have_their_power() {
    let directory = Directory::new("area");
    let radiance = |light: &str, shape: &str| {
        let text = format!("{PROBE}AreaLightSource \"diffuse\" {light}\n{shape}");
        emitted(&directory.load(&text).world, DVec3::new(0.2, 0.1, 5.0), DVec3::NEG_Z)
    };
    let disk = "Shape \"disk\" \"float radius\" 2";
    assert_eq!(radiance("", disk), Rgb::WHITE);
    near(radiance("\"float power\" 100", disk), [100.0 / (PI * 4.0 * PI); 3], 1e-12);
    let both = "\"float power\" 100 \"bool twosided\" true \"float scale\" 3 \"rgb L\" [1 0.5 2]";
    let expected = 300.0 / (2.0 * PI * 4.0 * PI);
    near(radiance(both, disk), [expected, 0.5 * expected, 2.0 * expected], 1e-12);
    let sphere = "Scale 2 2 2 Shape \"sphere\"";
    near(radiance("\"float power\" 10", sphere), [10.0 / (PI * 16.0 * PI); 3], 1e-12);
    let square = "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]";
    near(radiance("\"float power\" 10", square), [10.0 / (PI * 4.0); 3], 1e-12);
    // Each triangle has it.
    let two = "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] \"integer indices\" [0 1 2 0 2 3]";
    near(radiance("\"float power\" 10", two), [20.0 / (PI * 4.0); 3], 1e-12);
    // An image, its lower left corner black; the luminance of all four is a half.
    let pixels = [Rgb::WHITE, Rgb::WHITE, Rgb::BLACK, Rgb::BLACK];
    let image = Image::new(2, 2, pixels.to_vec()).expect("four pixels");
    ImageFile::from(image).save(directory.0.join("parts/half.png")).expect("saved");
    let light = "\"string filename\" \"parts/half.png\"";
    assert_eq!(radiance(light, &format!("Translate 0 -0.5 0 {square}")), Rgb::WHITE);
    assert_eq!(radiance(light, &format!("Translate 0 1 0 {square}")), Rgb::BLACK);
    let upper = format!("Translate 0 -0.5 0 {square}");
    near(radiance(&format!("{light} \"float power\" 10"), &upper), [20.0 / (PI * 4.0); 3], 1e-12);
}

#[test]
fn environments_have_their_radiance() {
    let directory = Directory::new("environments");
    let load = |text: &str| {
        directory.load(&format!(
            "{PROBE}{text}\nTranslate 0 0 -90\nShape \"sphere\" \"float radius\" 1e-3"
        ))
    };
    let up = DVec3::new(0.1, 0.2, 1.0);
    let sky = |text: &str| from_sky(&load(text), up);
    assert_eq!(sky("LightSource \"infinite\""), Rgb::WHITE);
    assert_eq!(
        sky("LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2"),
        Rgb::new(2.0, 4.0, 6.0)
    );
    near(sky("LightSource \"infinite\" \"float illuminance\" 10"), [10.0 / PI; 3], 1e-12);
    let two =
        "LightSource \"infinite\" \"rgb L\" [1 2 3] LightSource \"infinite\" \"rgb L\" [1 0 1]";
    assert_eq!(sky(two), Rgb::new(2.0, 2.0, 4.0));
    // Latitude and longitude of version 3: z up, and the azimuth from x to y.
    let save = |name: &str, width: u32, height: u32, pixels: Vec<Rgb>| {
        let image = Image::new(width, height, pixels).expect("as many pixels");
        ImageFile::from(image).save(directory.0.join("parts").join(name)).expect("saved");
    };
    let grey = |value: u32| Rgb::splat(f64::from(value));
    save("sky.exr", 4, 2, (1..=8).map(grey).collect());
    let old =
        load("LightSource \"infinite\" \"string mapname\" \"parts/sky.exr\" \"float scale\" 2");
    for (azimuth, height, pixel) in
        [(45, 1, 1), (135, 1, 2), (225, 1, 3), (315, 1, 4), (45, -1, 5), (315, -1, 8)]
    {
        let (sin, cos) = f64::from(azimuth).to_radians().sin_cos();
        let found = from_sky(&old, DVec3::new(cos, sin, f64::from(height)));
        assert_eq!(found, grey(2 * pixel), "{azimuth} {height}");
    }
    let turned =
        load("Rotate 90 0 0 1\nLightSource \"infinite\" \"string mapname\" \"parts/sky.exr\"");
    assert_eq!(from_sky(&turned, DVec3::new(-1.0, 1.0, 1.0)), grey(1));
    let mirrored =
        load("Scale -1 1 1\nLightSource \"infinite\" \"string mapname\" \"parts/sky.exr\"");
    assert_eq!(from_sky(&mirrored, DVec3::new(-1.0, 1.0, 1.0)), grey(1));
    // The equal-area map: its middle is up, its corners are down, its edges' middles around. Of
    // the quarters of a square of 2 × 2 each has its part of up and down.
    save("square.exr", 2, 2, (1..=4).map(grey).collect());
    let square = "LightSource \"infinite\" \"string filename\" \"parts/square.exr\"";
    for (x, y, pixel) in [(-1.0, -1.0, 1), (1.0, -1.0, 2), (-1.0, 1.0, 3), (1.0, 1.0, 4)] {
        for z in [2.0, 0.1, -0.1, -2.0] {
            let found = from_sky(&load(square), DVec3::new(x, y, z));
            near(found, [f64::from(pixel); 3], 1e-12);
        }
    }
    // The middle of the square is the upper part of all that is above.
    let is_inside = |i: u32| (8..24).contains(&i);
    let inside = |i: u32| Rgb::splat(f64::from(u8::from(is_inside(i % 32) && is_inside(i / 32))));
    save("cap.exr", 32, 32, (0..32 * 32).map(inside).collect());
    let cap = load("LightSource \"infinite\" \"string filename\" \"parts/cap.exr\"");
    assert_eq!(from_sky(&cap, DVec3::new(0.1, 0.2, 1.0)), Rgb::WHITE);
    assert_eq!(from_sky(&cap, DVec3::new(1.0, 1.0, -0.1)), Rgb::BLACK);
    // A constant beside an image is added to it.
    let both = load(&format!("{square}\nLightSource \"infinite\" \"rgb L\" [1 0 0]"));
    near(from_sky(&both, DVec3::new(1.0, 1.0, 2.0)), [5.0, 4.0, 4.0], 1e-12);
    // pbrt's illuminance is that of the upper half, with half of its solid angle.
    save("white.exr", 64, 64, vec![Rgb::WHITE; 64 * 64]);
    let white = load(
        "LightSource \"infinite\" \"string filename\" \"parts/white.exr\" \"float illuminance\" 3",
    );
    near(from_sky(&white, up), [3.0 / (0.5 * PI); 3], 0.02);
}

#[test]
fn other_lights_are_approximated() {
    let directory = Directory::new("other-lights");
    let pixels = [Rgb::splat(1.0), Rgb::splat(3.0)];
    let image = Image::new(2, 1, pixels.to_vec()).expect("two pixels");
    ImageFile::from(image).save(directory.0.join("parts/two.exr")).expect("saved");
    let light = |text: &str, expected: &str| {
        let text = format!("{PROBE}LightSource {text}\n{FLOOR}");
        intensity(&directory.left_out(&text, expected).world, DVec3::Z).1
    };
    let image = "\"string filename\" \"parts/two.exr\"";
    assert_eq!(
        light(&format!("\"goniometric\" {image} \"rgb I\" [1 2 3]"), "mean"),
        Rgb::new(2.0, 4.0, 6.0)
    );
    let power = light(&format!("\"goniometric\" {image} \"float power\" 5"), "mean");
    near(power, [5.0 / (4.0 * PI); 3], 1e-12);
    assert_eq!(
        light(&format!("\"projection\" {image} \"float scale\" 3"), "mean"),
        Rgb::splat(6.0)
    );
    let text = format!("{PROBE}LightSource \"infinite\" {image}\n{FLOOR}");
    directory.left_out(&text, "not square");
    let text = format!("{PROBE}LightSource \"infinite\" \"string filename\" \"none.exr\"\n{FLOOR}");
    assert_eq!(directory.left_out(&text, "there is no file").world.light_count(), 0);
}
