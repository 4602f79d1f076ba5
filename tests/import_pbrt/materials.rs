//! Materials, held against the crate's own ones.

use crate::files::{Directory, PROBE, render, seen};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::{Bsdf, TransportMode};
use pathspace::film::{Image, ImageFile};
use pathspace::geometry::Sphere;
use pathspace::math::Rgb;
use pathspace::scene::{Material, Scene, World, WorldBuilder};

fn rough_plastic(albedo: f64, alpha: f64) -> Material {
    Material::RoughPlastic {
        albedo: Rgb::splat(albedo).into(),
        specular: Rgb::WHITE,
        relative_ior: 1.5,
        colour_shift: true,
        alpha,
    }
}

/// What a surface makes of light: values of smooth parts, and the images of Dirac lobes.
fn scattered(world: &World) -> Vec<Rgb> {
    let hit = seen(world, DVec3::new(0.1, 0.2, 9.0), DVec3::NEG_Z);
    let bsdf = world.bsdf(&hit);
    let directions = [
        DVec3::new(0.1, 0.2, 0.9),
        DVec3::new(-0.3, 0.1, 0.5),
        DVec3::new(0.6, -0.6, 0.2),
        DVec3::new(-0.15, -0.2, 0.9),
        DVec3::new(0.3, -0.1, -0.8),
    ]
    .map(DVec3::normalize);
    let mut values = Vec::new();
    for a in directions {
        values.extend(directions.map(|b| bsdf.eval(a, b)));
        bsdf.dirac_images(a, TransportMode::Radiance, &mut |image| {
            values.push(image.weight * image.pdf.value());
        });
    }
    values
}

fn expected(material: Material) -> Vec<Rgb> {
    let mut builder = WorldBuilder::new();
    let id = builder.add_material("m", material).expect("valid");
    builder.add_sphere("s", Sphere::new(DVec3::ZERO, 1.0), id).expect("valid");
    scattered(&builder.build().expect("valid"))
}

fn assert_same(found: &[Rgb], expected: &[Rgb], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (a, b) in found.iter().zip(expected) {
        (0..3).for_each(|i| {
            assert!((a[i] - b[i]).abs() <= 1e-9 * (1.0 + b[i]), "{what}: {a:?} {b:?}")
        });
    }
    assert!(expected.iter().any(|value| !value.is_black()), "{what}");
}

const SPHERE: &str = "Shape \"sphere\"";

fn metallic(colour: Rgb, roughness: f64, metalness: f64) -> Material {
    Material::MetallicRoughness {
        base_color: colour.into(),
        metallic_roughness: Rgb::new(1.0, roughness, metalness).into(),
        relative_ior: 1.5,
    }
}

#[test]
fn materials_are_what_they_say() {
    let directory = Directory::new("materials");
    let grey = |albedo: f64| Material::Lambert { albedo: Rgb::splat(albedo) };
    let red = Rgb::new(0.8, 0.2, 0.1);
    let glass = Material::Dielectric { relative_ior: 1.5 };
    let plastic = |albedo: Rgb, relative_ior: f64| Material::Plastic {
        albedo: albedo.into(),
        specular: Rgb::WHITE,
        relative_ior,
        colour_shift: true,
    };
    let conductor = |eta: [f64; 3], k: [f64; 3]| Material::Conductor { eta: Rgb(eta), k: Rgb(k) };
    let rough = |material: &str| format!("Material \"{material}\" \"float eta\" 1.3");
    let both = |a: Material, b: Material, amount: f64| Material::Blend {
        components: Box::new([a, b]),
        amount: Rgb::splat(amount).into(),
    };
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.1 0.1 0.1]\n\
        MakeNamedMaterial \"b\" \"string type\" \"dielectric\"\n";
    let half_k = 2.0 * (0.5f64 / 0.5).sqrt();
    let cases = [
        (String::new(), grey(0.5)),
        ("Material \"diffuse\"".to_owned(), grey(0.5)),
        ("Material \"diffuse\" \"rgb reflectance\" [0.8 0.2 0.1]".to_owned(), Material::Lambert { albedo: red }),
        ("Material \"diffuse\" \"rgb reflectance\" [1.8 0.2 -1]".to_owned(), Material::Lambert { albedo: Rgb::new(1.0, 0.2, 0.0) }),
        ("Material \"coateddiffuse\" \"rgb reflectance\" [0.8 0.2 0.1]".to_owned(), plastic(red, 1.5)),
        (format!("{} \"rgb reflectance\" [0.8 0.2 0.1] \"float thickness\" 0.1", rough("coateddiffuse")), plastic(red, 1.3)),
        ("Material \"coateddiffuse\" \"float roughness\" 0.25".to_owned(), rough_plastic(0.5, 0.5)),
        ("Material \"dielectric\"".to_owned(), glass.clone()),
        ("Material \"dielectric\" \"float eta\" 1.3".to_owned(), Material::Dielectric { relative_ior: 1.3 }),
        // α is the root of the roughness.
        ("Material \"dielectric\" \"float roughness\" 0.09".to_owned(), Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.3) }),
        ("Material \"dielectric\" \"float roughness\" 0.3 \"bool remaproughness\" false".to_owned(), Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.3) }),
        ("Material \"thindielectric\" \"float eta\" 1.4".to_owned(), Material::ThinDielectric { relative_ior: 1.4 }),
        ("Material \"conductor\"".to_owned(), conductor([0.2093, 0.97792, 1.2046], [4.15, 2.6237, 2.3604])),
        ("Material \"conductor\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\"".to_owned(), conductor([0.12849, 0.12353, 0.15088], [4.1011, 3.3265, 2.4071])),
        ("Material \"conductor\" \"rgb eta\" [1 2 3] \"rgb k\" [3 2 1]".to_owned(), conductor([1.0, 2.0, 3.0], [3.0, 2.0, 1.0])),
        ("Material \"conductor\" \"rgb reflectance\" [0.5 0.5 0.5]".to_owned(), conductor([1.0; 3], [half_k; 3])),
        ("Material \"conductor\" \"rgb eta\" [1 2 3] \"rgb k\" [3 2 1] \"float uroughness\" 0.04 \"float vroughness\" 0.16".to_owned(),
            Material::RoughConductor { eta: Rgb::new(1.0, 2.0, 3.0), k: Rgb::new(3.0, 2.0, 1.0), alpha: DVec2::new(0.2, 0.4) }),
        ("Material \"interface\"".to_owned(), Material::Null),
        ("Material \"\"".to_owned(), Material::Null),
        (format!("{named}NamedMaterial \"b\""), glass.clone()),
        (format!("{named}Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.25"), both(grey(0.1), glass, 0.25)),
    ];
    for (text, material) in cases {
        // Orthographic rays meet the sphere where its normal is nearly along z.
        let world = directory.load(&format!("{PROBE}{text}\n{SPHERE}")).world;
        assert_same(&scattered(&world), &expected(material), &text);
    }
}

/// The counterparts of what the crate lacks, each with a warning.
#[test]
fn other_materials_are_approximated() {
    let directory = Directory::new("approximated");
    let grey = |albedo: f64| Material::Lambert { albedo: Rgb::splat(albedo) };
    let copper = Material::Conductor {
        eta: Rgb::new(0.2093, 0.97792, 1.2046),
        k: Rgb::new(4.15, 2.6237, 2.3604),
    };
    let gold = |alpha: f64| Material::RoughConductor {
        eta: Rgb::new(0.16001, 0.40508, 1.5607),
        k: Rgb::new(4.9682, 2.3382, 1.7182),
        alpha: DVec2::splat(alpha),
    };
    let smooth = |albedo: f64| Material::Plastic {
        albedo: Rgb::splat(albedo).into(),
        specular: Rgb::WHITE,
        relative_ior: 1.5,
        colour_shift: true,
    };
    // Version 3's α of a roughness of 0.1, by its polynomial.
    let old_alpha = 0.461_760_032;
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.1 0.1 0.1]\n\
        MakeNamedMaterial \"b\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"]\n";
    let cases = [
        ("Material \"coateddiffuse\" \"float uroughness\" 0.25 \"float vroughness\" 0.09".to_owned(), "the roughness of a coat", rough_plastic(0.5, 0.4)),
        ("Material \"coatedconductor\" \"float interface.roughness\" 0.1".to_owned(), "without its coat", copper),
        ("Material \"diffusetransmission\" \"rgb reflectance\" [0.6 0.6 0.6] \"float scale\" 0.5".to_owned(), "reflects", grey(0.3)),
        ("Material \"subsurface\" \"rgb reflectance\" [0.4 0.4 0.4]".to_owned(), "coated", smooth(0.4)),
        ("Material \"measured\" \"string filename\" \"x.bsdf\"".to_owned(), "diffuse", grey(0.5)),
        ("Material \"hair\" \"rgb color\" [0.3 0.3 0.3]".to_owned(), "diffuse", grey(0.3)),
        ("Material \"matte\" \"color Kd\" [0.3 0.3 0.3]".to_owned(), "diffuse", grey(0.3)),
        ("Material \"mirror\"".to_owned(), "mirror", Material::Mirror { reflectance: Rgb::splat(0.9) }),
        ("Material \"glass\" \"float index\" 1.4".to_owned(), "dielectric", Material::Dielectric { relative_ior: 1.4 }),
        ("Material \"metal\" \"spectrum eta\" \"spds/Au.eta.spd\" \"spectrum k\" \"spds/Au.k.spd\" \"float roughness\" 0.1".to_owned(), "conductor", gold(old_alpha)),
        ("Material \"plastic\" \"color Kd\" [0.3 0.3 0.3] \"float roughness\" 0".to_owned(), "coated", smooth(0.3)),
        ("Material \"disney\" \"color color\" [0.3 0.2 0.1] \"float metallic\" 0.5 \"float roughness\" 0.4".to_owned(), "metallic", metallic(Rgb::new(0.3, 0.2, 0.1), 0.4, 0.5)),
        ("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"".to_owned(), "dispersion", Material::Dielectric { relative_ior: 1.5168 }),
        ("Material \"dielectric\" \"spectrum eta\" [500 1.4 600 1.5]".to_owned(), "dispersion", Material::Dielectric { relative_ior: 1.4876 }),
        ("Material \"dielectric\" \"texture displacement\" \"none\"".to_owned(), "there is no texture none", Material::Dielectric { relative_ior: 1.5 }),
        ("Material \"diffuse\" \"texture reflectance\" \"none\"".to_owned(), "there is no texture", grey(0.5)),
        ("Material \"velvet\"".to_owned(), "not supported", grey(0.5)),
        ("NamedMaterial \"none\"".to_owned(), "there is no material", grey(0.5)),
        (format!("{named}Material \"mix\" \"string materials\" [\"b\" \"a\"] \"float amount\" 0.7"), "has more of it", grey(0.1)),
        ("MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"]\nNamedMaterial \"a\"".to_owned(), "nested too deeply", grey(0.5)),
    ];
    for (text, warning, material) in cases {
        let world = directory.left_out(&format!("{PROBE}{text}\n{SPHERE}"), warning).world;
        assert_same(&scattered(&world), &expected(material), &text);
    }
}

/// In version 3 the amount of a mix is that of the first one.
#[test]
fn amounts_of_mixes_have_their_order() {
    let directory = Directory::new("amounts");
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.1 0.1 0.1]\n\
        MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.9 0.9 0.9]\n";
    for (mix, albedo) in [
        ("\"string materials\" [\"a\" \"b\"] \"float amount\" 0.25", 0.3),
        (
            "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"float amount\" 0.25",
            0.7,
        ),
    ] {
        let world =
            directory.load(&format!("{PROBE}{named}Material \"mix\" {mix}\n{SPHERE}")).world;
        let found = scattered(&world)[0].r() * std::f64::consts::PI;
        assert_relative_eq!(found, albedo, max_relative = 1e-9);
    }
}

/// Where a shape has an opacity of 0.25, a quarter of the light is scattered and the rest goes on.
#[test]
fn opacity_lets_light_pass() {
    let directory = Directory::new("opacity");
    let disk = "Material \"diffuse\" \"rgb reflectance\" [0.8 0.8 0.8]\n";
    let blend = Material::Blend {
        components: Box::new([Material::Null, Material::Lambert { albedo: Rgb::splat(0.8) }]),
        amount: Rgb::splat(0.25).into(),
    };
    let texture = "Texture \"quarter\" \"float\" \"constant\" \"float value\" 0.25\n";
    for alpha in ["\"float alpha\" 0.25", "\"texture alpha\" \"quarter\""] {
        let text = format!("{PROBE}{texture}{disk}{SPHERE} {alpha}");
        assert_same(&scattered(&directory.load(&text).world), &expected(blend.clone()), alpha);
    }
}

/// What a medium absorbs, by the way that light has in it.
#[test]
fn media_absorb() {
    let directory = Directory::new("media");
    let seen = |interface: &str| {
        let text = format!(
            "{PROBE}MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"float scale\" 2\n\
             \"rgb sigma_a\" [0.1 0.2 0.4] \"rgb sigma_s\" [0 0 0]\n\
             LightSource \"infinite\"\nMaterial \"interface\"\n{interface}\n{SPHERE}"
        );
        render(&directory.load(&text), 4).mean()
    };
    // A way of 2 through it.
    let expected = [0.4f64, 0.8, 1.6].map(|depth| (-depth).exp());
    let found = seen("MediumInterface \"m\" \"\"");
    (0..3).for_each(|i| assert_relative_eq!(found[i], expected[i], max_relative = 1e-6));
    assert_eq!(seen("MediumInterface \"\" \"m\""), Rgb::WHITE);
    assert_eq!(seen("MediumInterface \"m\" \"m\""), Rgb::WHITE);
}

/// A shape may name a material that is described after it, as pbrt's own scenes do.
#[test]
fn materials_may_follow_shapes() {
    let directory = Directory::new("later");
    let later = "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"a\" \"b\"]\n\
        MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.2 0.2 0.2]\n\
        MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.4 0.4 0.4]";
    for shape in
        [SPHERE.to_owned(), format!("ObjectBegin \"o\" {SPHERE} ObjectEnd ObjectInstance \"o\"")]
    {
        let text =
            format!("{PROBE}AttributeBegin NamedMaterial \"m\" {shape} AttributeEnd\n{later}");
        let found = scattered(&directory.load(&text).world)[0].r() * std::f64::consts::PI;
        assert_relative_eq!(found, 0.3, max_relative = 1e-9);
    }
}

/// α of a texture is the root of what it shows.
#[test]
fn roughness_may_vary() {
    let directory = Directory::new("roughness");
    let pixel = Image::new(1, 1, vec![Rgb::splat(0.09)]).expect("a pixel");
    ImageFile::from(pixel).save(directory.0.join("parts/pixel.exr")).expect("saved");
    let texture = "Texture \"r\" \"float\" \"imagemap\" \"string filename\" \"parts/pixel.exr\"\n";
    let (eta, k) = (Rgb::new(1.0, 2.0, 3.0), Rgb::new(3.0, 2.0, 1.0));
    let (relative_ior, u) = (1.5, DVec2::new(0.3, 0.5));
    let cases = [
        (
            "\"conductor\" \"rgb eta\" [1 2 3] \"rgb k\" [3 2 1] \"texture roughness\" \"r\"",
            Material::RoughConductor { eta, k, alpha: DVec2::splat(0.3) },
        ),
        (
            "\"conductor\" \"rgb eta\" [1 2 3] \"rgb k\" [3 2 1] \"texture uroughness\" \"r\" \"float vroughness\" 0.25",
            Material::RoughConductor { eta, k, alpha: u },
        ),
        (
            "\"dielectric\" \"texture roughness\" \"r\"",
            Material::RoughDielectric { relative_ior, alpha: DVec2::splat(0.3) },
        ),
    ];
    for (text, material) in cases {
        let text = format!("{PROBE}{texture}Material {text}\n{SPHERE}");
        let found = scattered(&directory.load(&text).world);
        for (a, b) in found.iter().zip(expected(material)) {
            (0..3).for_each(|i| {
                assert!((a[i] - b[i]).abs() <= 1e-5 * (1.0 + b[i]), "{text}: {a:?} {b:?}")
            });
        }
    }
}
