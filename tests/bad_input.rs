//! Every bad scene is refused with an error that names the object, and nothing makes the builder
//! panic.

use pathspace::geometry::{Disk, Quad, Sphere, SurfacePoint};
use pathspace::glam::{DAffine3, DMat3, DVec2, DVec3, DVec4};
use pathspace::math::Rgb;
use pathspace::scene::{
    Emission, Material, MaterialId, Mesh, Scene, SceneError, SurfaceArea, SurfaceId, Warning,
    WorldBuilder,
};
use proptest::prelude::*;

fn builder() -> (WorldBuilder, MaterialId) {
    let mut builder = WorldBuilder::new();
    let grey =
        builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).expect("valid");
    (builder, grey)
}

fn triangle() -> Mesh {
    Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    }
}

/// The error of adding a mesh called "thing".
fn refused(mesh: &Mesh, transform: DAffine3) -> SceneError {
    let (mut builder, grey) = builder();
    let error = builder.add_mesh("thing", mesh, transform, grey).expect_err("must be refused");
    assert!(error.to_string().contains("\"thing\""), "{error}");
    error
}

#[test]
fn vertices_must_be_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let mut mesh = triangle();
        mesh.positions[1].y = bad;
        assert!(matches!(
            refused(&mesh, DAffine3::IDENTITY),
            SceneError::Vertex { attribute: "position", vertex: 1, .. }
        ));
    }
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        let mesh = Mesh { normals: Some(vec![DVec3::Z, DVec3::Z, bad]), ..triangle() };
        assert!(matches!(
            refused(&mesh, DAffine3::IDENTITY),
            SceneError::Vertex { attribute: "normal", vertex: 2, .. }
        ));
    }
    let mesh = Mesh { uvs: Some(vec![DVec2::ZERO, DVec2::NAN, DVec2::ONE]), ..triangle() };
    assert!(matches!(refused(&mesh, DAffine3::IDENTITY), SceneError::Vertex { vertex: 1, .. }));
}

#[test]
fn meshes_must_be_consistent() {
    let mesh = Mesh { indices: vec![[0, 1, 2], [0, 1, 3]], ..triangle() };
    assert!(matches!(
        refused(&mesh, DAffine3::IDENTITY),
        SceneError::IndexOutOfRange { triangle: 1, index: 3, vertices: 3, .. }
    ));
    let mesh = Mesh { normals: Some(vec![DVec3::Z; 2]), ..triangle() };
    assert!(matches!(
        refused(&mesh, DAffine3::IDENTITY),
        SceneError::AttributeCount { found: 2, expected: 3, .. }
    ));
    let mesh = Mesh { uvs: Some(vec![DVec2::ZERO; 4]), ..triangle() };
    assert!(matches!(
        refused(&mesh, DAffine3::IDENTITY),
        SceneError::AttributeCount { found: 4, expected: 3, .. }
    ));
}

#[test]
fn transforms_must_be_invertible() {
    for matrix in [DMat3::ZERO, DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)), DMat3::NAN] {
        assert!(matches!(
            refused(&triangle(), DAffine3::from_mat3(matrix)),
            SceneError::SingularTransform { .. }
        ));
    }
    let infinite = DAffine3::from_translation(DVec3::INFINITY);
    assert!(matches!(refused(&triangle(), infinite), SceneError::SingularTransform { .. }));
    let (mut builder, grey) = builder();
    for (name, scale) in [("tiny", 1e-30), ("huge", 1e30)] {
        let transform = DAffine3::from_scale(DVec3::splat(scale));
        assert!(
            builder.add_mesh(name, &triangle(), transform, grey).is_ok(),
            "small and large are not singular"
        );
    }
    assert_eq!(builder.build().expect("valid").dropped_triangles(), 0);
}

#[test]
fn empty_scenes_are_refused_and_degenerate_triangles_dropped() {
    assert_eq!(WorldBuilder::new().build().expect_err("empty"), SceneError::Empty);
    let (mut builder, grey) = builder();
    let slivers = Mesh { indices: vec![[0, 0, 1], [1, 1, 1], [0, 1, 2], [2, 1, 2]], ..triangle() };
    builder
        .add_mesh("slivers", &slivers, DAffine3::IDENTITY, grey)
        .expect("degenerate triangles are no error");
    let world = builder.build().expect("valid");
    assert_eq!((world.dropped_triangles(), world.primitive_count()), (3, 1));
    assert!((world.total_area() - 0.5).abs() < 1e-15);
}

/// The warnings of building a scene.
fn warnings(add: impl FnOnce(&mut WorldBuilder, MaterialId)) -> Vec<Warning> {
    let (mut builder, grey) = builder();
    add(&mut builder, grey);
    let world = builder.build().expect("valid");
    world.warnings().iter().for_each(|warning| assert!(!warning.to_string().is_empty()));
    world.warnings().to_vec()
}

#[test]
fn triangles_without_area_are_warned_of() {
    let mesh = Mesh { indices: vec![[0, 0, 1], [0, 1, 2]], ..triangle() };
    let found = warnings(|builder, grey| {
        _ = builder.add_mesh("slivers", &mesh, DAffine3::IDENTITY, grey).expect("valid")
    });
    assert_eq!(
        found,
        [Warning::DroppedTriangles { object: "slivers".into(), dropped: 1, triangles: 2 }]
    );
    assert_eq!(
        found[0].to_string(),
        "\"slivers\": 1 of 2 triangles have no area and were left out"
    );
}

#[test]
fn scenes_of_parts_of_too_different_sizes_are_warned_of() {
    let stretched = |offset: f64| {
        warnings(|builder, grey| {
            let ball = Mesh::icosphere(2);
            builder.add_mesh("ball", &ball, DAffine3::IDENTITY, grey).expect("valid");
            let wall = Quad {
                origin: DVec3::X * offset,
                edge_u: DVec3::Y * 1e-2 * offset,
                edge_v: DVec3::Z * 1e-2 * offset,
            };
            builder.add_quad("far wall", wall, grey).expect("valid");
        })
    };
    assert_eq!((stretched(2.0), stretched(1e9)), (vec![], vec![]));
    let found = stretched(1e11);
    assert!(
        matches!(&found[..], [Warning::Stretched { objects, .. }] if *objects == ["far wall"]),
        "{found:?}"
    );
    assert!(found[0].to_string().contains("because of \"far wall\": "));
}

/// Six digits are left at 9e9 sizes from the origin.
#[test]
fn lost_digits_are_warned_of() {
    let far = |distance: f64, origin: bool| {
        warnings(|builder, grey| {
            builder.add_sphere("ball", Sphere::new(DVec3::X * distance, 0.5), grey).expect("valid");
            if origin {
                builder.add_sphere("home", Sphere::new(DVec3::ZERO, 0.5), grey).expect("valid");
            }
        })
    };
    assert_eq!((far(8e9, false), far(8e9, true)), (vec![], vec![]));
    assert!(matches!(&far(1e10, false)[..], [Warning::FewDigits { object: None, .. }]));
    let found = far(1e10, true);
    assert!(
        matches!(&found[..], [Warning::FewDigits { object: Some(object), .. }] if object == "ball"),
        "{found:?}"
    );
    let text = found[0].to_string();
    assert_eq!(
        text,
        "\"ball\" is 1.0e0 large at coordinates of 1.0e10: 6.0 digits are left; move it closer to the origin"
    );
    // Smaller than one step of f64 at its place.
    assert!(far(1e30, true)[0].to_string().contains(": 0."));
}

#[test]
fn roughness_that_is_not_rendered_is_warned_of() {
    let found = |material: Material| {
        warnings(|builder, _| {
            builder.add_material("glass", material).expect("valid");
            builder
                .add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), MaterialId(1))
                .expect("valid");
        })
    };
    let glass = |relative_ior: f64, x: f64, y: f64| Material::RoughDielectric {
        relative_ior,
        alpha: DVec2::new(x, y),
    };
    for silent in [
        glass(1.5, 1e-4, 1e-4),
        glass(1.5, 0.0, 0.0),
        glass(1.0, 0.1, 0.1),
        glass(1.0 + 2e-6, 0.1, 0.1),
        Material::Null,
    ] {
        assert_eq!(found(silent), []);
    }
    for (x, y, what) in
        [(9.9e-5, 0.0, "a smooth surface"), (9.9e-5, 0.1, "1e-4"), (0.1, 1e-300, "1e-4")]
    {
        let mirror = Material::RoughMirror { reflectance: Rgb::WHITE, alpha: DVec2::new(x, y) };
        let mixture = Material::Mixture {
            components: Box::new([mirror, Material::Black]),
            weights: [0.5, 0.5],
        };
        for material in [glass(1.5, x, y), mixture] {
            let found = found(material);
            assert!(
                matches!(&found[..], [Warning::Roughness { .. }])
                    && found[0].to_string().ends_with(what),
                "{found:?}"
            );
        }
    }
    assert!(matches!(found(glass(1.0 + 1e-7, 0.1, 0.1))[..], [Warning::IndexMatched { .. }]));
}

#[test]
fn radiance_without_a_variance_is_warned_of() {
    for (radiance, warned) in
        [(1e150, false), (2e150, true), (1e-150, false), (9e-151, true), (0.0, false)]
    {
        let found = warnings(|builder, grey| {
            let ball =
                builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), grey).expect("valid");
            builder
                .set_emission(
                    ball,
                    Emission { radiance: Rgb::new(0.0, radiance, 0.0), two_sided: false },
                )
                .expect("valid");
        });
        assert_eq!(
            matches!(found[..], [Warning::Radiance { .. }]),
            warned,
            "{radiance:e} {found:?}"
        );
        assert_eq!(found.is_empty(), !warned);
    }
}

#[test]
fn coincident_emitters_are_warned_of() {
    let mirrored = Mesh { indices: vec![[2, 1, 0]], ..triangle() };
    let lamp_and = |other: Mesh, bright: [bool; 2]| {
        warnings(|builder, grey| {
            for ((name, mesh), bright) in
                [("lamp", triangle()), ("wall", other)].into_iter().zip(bright)
            {
                let id = builder.add_mesh(name, &mesh, DAffine3::IDENTITY, grey).expect("valid");
                let radiance = if bright { Rgb::WHITE } else { Rgb::BLACK };
                builder.set_emission(id, Emission { radiance, two_sided: false }).expect("valid");
            }
        })
    };
    for bright in [[true, false], [false, true], [true, true]] {
        let found = lamp_and(mirrored.clone(), bright);
        let expected = if bright[0] { ("lamp", "wall") } else { ("wall", "lamp") };
        assert_eq!(
            found,
            [Warning::CoincidentEmitter { object: expected.0.into(), other: expected.1.into() }]
        );
    }
    assert_eq!(lamp_and(mirrored, [false, false]), []);
    let mut above = triangle();
    above.positions[0].z = 1e-12;
    assert_eq!(lamp_and(above, [true, true]), []);
}

#[test]
fn lights_need_area_and_radiance() {
    let (mut builder, grey) = builder();
    let flat = Mesh { indices: vec![[0, 0, 1]], ..triangle() };
    let flat = builder
        .add_mesh("flat", &flat, DAffine3::IDENTITY, grey)
        .expect("valid as long as it is dark");
    let emission = Emission { radiance: Rgb::WHITE, two_sided: false };
    assert_eq!(
        builder.set_emission(flat, emission),
        Err(SceneError::LightWithoutArea { object: "flat".into() })
    );
    let lamp = builder.add_mesh("lamp", &triangle(), DAffine3::IDENTITY, grey).expect("valid");
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let emission = Emission { radiance: Rgb::new(1.0, bad, 1.0), two_sided: false };
        assert!(matches!(
            builder.set_emission(lamp, emission),
            Err(SceneError::Parameter { parameter: "radiance", .. })
        ));
    }
    assert!(matches!(
        builder.set_emission(SurfaceId(9), emission),
        Err(SceneError::Missing { kind: "surface", .. })
    ));
    builder.set_emission(lamp, emission).expect("valid");
    let world = builder.build().expect("valid");
    let id = world.light_by_name("lamp").expect("named after its surface");
    assert_eq!(world.light_name(id), Some("lamp"));
    assert_eq!(world.pick_light(0.3), Some((id, 1.0)));
}

#[test]
fn names_are_unique_and_materials_exist() {
    let (mut builder, grey) = builder();
    let sphere = Sphere::new(DVec3::ZERO, 1.0);
    let duplicate = |name: &str| SceneError::DuplicateName { name: name.into() };
    assert_eq!(builder.add_material("grey", Material::Black), Err(duplicate("grey")));
    builder.add_sphere("ball", sphere, grey).expect("valid");
    assert_eq!(builder.add_sphere("ball", sphere, grey), Err(duplicate("ball")));
    assert_eq!(
        builder.add_mesh("ball", &triangle(), DAffine3::IDENTITY, grey),
        Err(duplicate("ball"))
    );
    assert!(matches!(
        builder.add_sphere("other", sphere, MaterialId(7)),
        Err(SceneError::Missing { kind: "material", .. })
    ));
    assert_eq!(builder.material("grey"), Ok(grey));
    assert!(matches!(builder.material("gray"), Err(SceneError::Missing { kind: "material", .. })));
}

#[test]
fn materials_are_checked() {
    let (mut builder, _) = builder();
    let glass = |relative_ior: f64, alpha: f64| Material::RoughDielectric {
        relative_ior,
        alpha: DVec2::splat(alpha),
    };
    let mixture = |weights| Material::Mixture {
        components: Box::new([Material::Black, Material::Null]),
        weights,
    };
    let mut refused = vec![
        glass(0.0, 0.1),
        glass(f64::NAN, 0.1),
        glass(1.5, -0.1),
        glass(1.5, f64::INFINITY),
        mixture([-1.0, 1.0]),
    ];
    refused.push(Material::Mixture {
        components: Box::new([mixture([0.5, 0.5]), Material::Black]),
        weights: [0.5, 0.5],
    });
    for bad in [-0.1, 1.1, f64::NAN] {
        refused.push(Material::Lambert { albedo: Rgb::new(0.2, 0.3, bad) });
        refused.push(Material::Mirror { reflectance: Rgb::new(bad, 0.2, 0.3) });
        refused.push(Material::RoughMirror {
            reflectance: Rgb::new(0.2, bad, 0.3),
            alpha: DVec2::ONE,
        });
    }
    refused.push(Material::Conductor { eta: Rgb::splat(-1.0), k: Rgb::WHITE });
    refused.push(Material::RoughConductor {
        eta: Rgb::WHITE,
        k: Rgb::splat(f64::NAN),
        alpha: DVec2::ONE,
    });
    for material in refused {
        let error = builder
            .add_material("bad", material.clone())
            .expect_err("a parameter outside its range");
        assert!(matches!(error, SceneError::Material { .. }), "{material:?}: {error}");
        assert!(error.to_string().starts_with("material \"bad\": "), "{error}");
    }
    assert!(builder.material("bad").is_err(), "a refused material leaves no name behind");
}

#[test]
fn shapes_are_checked() {
    let (mut builder, grey) = builder();
    let sphere = Sphere::new(DVec3::ZERO, 1.0);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
        assert!(matches!(
            builder.add_sphere("s", Sphere { radius, ..sphere }, grey),
            Err(SceneError::Parameter { parameter: "radius", .. })
        ));
        let disk = Disk { center: DVec3::ZERO, normal: DVec3::Z, radius };
        assert!(matches!(
            builder.add_disk("d", disk, grey),
            Err(SceneError::Parameter { parameter: "radius", .. })
        ));
    }
    for (cos_min, cos_max) in
        [(0.5, 0.5), (0.6, 0.2), (-1.5, 1.0), (f64::NAN, 1.0), (-1.0, f64::NAN), (0.0, 1.5)]
    {
        assert!(matches!(
            builder.add_sphere("s", Sphere { cos_min, cos_max, ..sphere }, grey),
            Err(SceneError::Parameter { parameter: "cos_min" | "cos_max", .. })
        ));
    }
    assert!(builder.add_sphere("s", Sphere { axis: DVec3::ZERO, ..sphere }, grey).is_err());
    assert!(builder.add_sphere("s", Sphere { center: DVec3::NAN, ..sphere }, grey).is_err());
    assert!(
        builder
            .add_disk("d", Disk { center: DVec3::ZERO, normal: DVec3::ZERO, radius: 1.0 }, grey)
            .is_err()
    );
    let quad = Quad { origin: DVec3::ZERO, edge_u: DVec3::X, edge_v: DVec3::X * 2.0 };
    assert_eq!(
        builder.add_quad("q", quad, grey),
        Err(SceneError::Degenerate { object: "q".into() })
    );
    // What was refused leaves nothing behind.
    assert!(builder.add_sphere("s", sphere, grey).is_ok());
    assert_eq!(builder.build().expect("valid").surface_count(), 1);
}

/// Products of lengths lose digits before they vanish.
#[test]
fn surfaces_are_refused_or_sound_at_every_size() {
    let mut refused = 0;
    for (tilted, exponent) in (-320..=50).flat_map(|e| [(false, e), (true, e)]) {
        let small = 10f64.powi(exponent);
        let (u, v) = if tilted {
            (DVec3::new(0.3, -0.7, 0.1), DVec3::new(0.2, 0.5, -0.9) * small)
        } else {
            (DVec3::Z * 0.058, DVec3::Y * small)
        };
        let mesh =
            Mesh { positions: vec![DVec3::ZERO, u, v], indices: vec![[0, 1, 2]], ..triangle() };
        let (mut builder, grey) = builder();
        let added = [
            builder.add_quad("q", Quad { origin: DVec3::ZERO, edge_u: u, edge_v: v }, grey),
            builder.add_mesh("m", &mesh, DAffine3::IDENTITY, grey),
            builder.add_sphere("s", Sphere { axis: v, ..Sphere::new(DVec3::ZERO, small) }, grey),
            builder.add_disk("d", Disk { center: DVec3::ZERO, normal: v, radius: small }, grey),
            builder.add_disk("n", Disk { center: DVec3::ZERO, normal: v, radius: 1.0 }, grey),
        ];
        refused += added.iter().filter(|result| result.is_err()).count();
        let world = match builder.build() {
            Ok(world) => world,
            Err(SceneError::Empty) => continue,
            Err(error) => panic!("{exponent}: {error}"),
        };
        for i in 0..world.primitive_count() {
            let u = (f64::from(i as u32) + 0.5) / f64::from(world.primitive_count() as u32);
            let x = world.sample_surface(u, DVec2::new(0.3, 0.6));
            let is_sound = x.position.is_finite()
                && x.geometric_normal.is_normalized()
                && x.shading_normal.is_normalized();
            assert!(is_sound, "{exponent}: {x:?}");
        }
    }
    assert!(refused > 0);
}

#[test]
fn mirrored_meshes_keep_their_front_side() {
    let (mut builder, grey) = builder();
    let mesh = Mesh { normals: Some(vec![DVec3::Z; 3]), ..triangle() };
    for (name, scale) in [
        ("plain", DVec3::ONE),
        ("mirrored", DVec3::new(-1.0, 1.0, 1.0)),
        ("turned", DVec3::new(1.0, -2.0, -3.0)),
    ] {
        builder.add_mesh(name, &mesh, DAffine3::from_scale(scale), grey).expect("valid");
    }
    let world = builder.build().expect("valid");
    for (x, y, expected) in [(0.2, 0.2, DVec3::Z), (-0.2, 0.2, DVec3::Z), (0.2, -0.2, -DVec3::Z)] {
        let hit = world
            .intersect(&SurfacePoint::dirac(DVec3::new(x, y, 5.0)), -DVec3::Z)
            .expect("aimed at it");
        assert_eq!(hit.geometric_normal, expected);
        assert_eq!(hit.shading_normal, expected);
    }
}

fn number() -> impl Strategy<Value = f64> {
    let special = vec![
        0.0,
        -0.0,
        1.0,
        1e-320,
        1e-160,
        1e-30,
        1e30,
        1e50,
        1e160,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ];
    prop_oneof![
        6 => -2.0..2.0f64,
        1 => prop::sample::select(special),
        1 => (-320.0..60.0f64).prop_map(|exponent| 10f64.powf(exponent)),
    ]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from)
}

fn mesh() -> impl Strategy<Value = Mesh> {
    let attributes = (
        prop::option::weighted(0.3, prop::collection::vec(vector(), 1..8)),
        prop::option::weighted(0.3, 1..8usize),
    );
    let indices = prop::collection::vec([0..9u32, 0..9u32, 0..9u32], 0..12);
    (prop::collection::vec(vector(), 0..9), attributes, indices).prop_map(
        |(positions, (normals, uvs), indices)| Mesh {
            positions,
            normals,
            uvs: uvs.map(|n| vec![DVec2::splat(n as f64); n]),
            other_uvs: uvs.map(|n| vec![DVec2::splat(0.1 * n as f64); n]),
            colors: uvs.map(|n| vec![DVec4::splat(n as f64); n]),
            tangents: uvs.map(|n| vec![DVec4::splat(0.0); n]),
            indices,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn the_builder_never_panics(
        meshes in prop::collection::vec(
            (mesh(), [vector(), vector(), vector(), vector()], "[a-c]?"),
            0..3,
        ),
        (center, radius, cos) in (vector(), number(), number()),
        (origin, edge_u, edge_v) in (vector(), vector(), vector()),
        (albedo, radiance) in (number(), number()),
        (from, to) in (vector(), vector()),
    ) {
        let (mut builder, grey) = builder();
        let _ = builder.add_material("other", Material::Lambert { albedo: Rgb::splat(albedo) });
        let emission = Emission { radiance: Rgb::splat(radiance), two_sided: radiance > 1.0 };
        for (mesh, [x, y, z, offset], name) in meshes {
            let transform = DAffine3::from_cols(x, y, z, offset);
            if let Ok(id) = builder.add_mesh(name.clone() + "1", &mesh, transform, grey) {
                let _ = builder.set_emission(id, emission);
            }
            let _ = builder.add_mesh(name, &mesh, DAffine3::IDENTITY, grey);
        }
        let sphere = Sphere { axis: edge_u, cos_min: cos, ..Sphere::new(center, radius) };
        let _ = builder.add_sphere("sphere", sphere, grey);
        let _ = builder.add_disk("disk", Disk { center, normal: edge_v, radius }, grey);
        if let Ok(id) = builder.add_quad("quad", Quad { origin, edge_u, edge_v }, grey) {
            let _ = builder.set_emission(id, emission);
        }
        if let Ok(world) = builder.build() {
            let (a, b) = (SurfacePoint::dirac(from), SurfacePoint::dirac(to));
            prop_assert_eq!(world.visible(&a, &b), world.visible(&b, &a));
            let x = world.intersect(&a, to);
            let is_sound = x.is_none_or(|x| {
                x.position.is_finite() && x.shading_normal.is_normalized() && x.error.is_finite()
            });
            prop_assert!(is_sound);
            if world.primitive_count() > 0 {
                let x = world.sample_surface(0.5, DVec2::splat(0.3));
                prop_assert!(x.position.is_finite() && x.geometric_normal.is_normalized());
                let _ = (world.bsdf(&x), world.light_at(&x));
                let _ = (world.visible(&x, &a), world.intersect(&x, to));
            }
        }
    }
}
