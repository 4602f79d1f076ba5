//! Materials that vary, by the checker and by values.

use super::*;
use crate::bsdf::check::check;
use crate::bsdf::{Bsdf, Lambert, LaneForm, Model, TransportMode};
use crate::sampler::{Independent, SampleSource, Sampler};
use glam::{DAffine2, DVec3, DVec4};
use std::f64::consts::PI;

fn lambert(albedo: f64) -> Material {
    Material::Lambert { albedo: Rgb::splat(albedo) }
}

fn board() -> Texture {
    Texture::checkerboard(Rgb::new(0.2, 0.5, 0.8), Rgb::new(0.9, 0.1, 0.3))
}

/// Texture coordinates at which the board has its first and its second colour.
const PLACES: [DVec2; 2] = [DVec2::splat(0.25), DVec2::new(0.75, 0.25)];

#[test]
fn textured_and_sided_materials_agree_with_themselves() {
    let plastic = Material::Plastic {
        albedo: board(),
        specular: Rgb::WHITE,
        relative_ior: 1.5,
        colour_shift: true,
    };
    let rough_plastic = Material::RoughPlastic {
        albedo: board(),
        specular: Rgb::WHITE,
        relative_ior: 1.5,
        colour_shift: false,
        alpha: 0.3,
    };
    let rough = Material::RoughMirror { reflectance: Rgb::splat(0.9), alpha: DVec2::new(0.3, 0.4) };
    let beckmann = Material::Beckmann { rough: Box::new(rough.clone()) };
    let varying = |rough: &Material| Material::VaryingRoughness {
        rough: Box::new(rough.clone()),
        alpha: Box::new([board(), Rgb::splat(0.4).into()]),
    };
    let glass = Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::ZERO };
    let materials = [
        varying(&glass).stained(board()),
        Material::Dielectric { relative_ior: 1.5 }.stained(board()),
        Material::ThinDielectric { relative_ior: 1.5 }.stained(board()),
        varying(&beckmann),
        varying(&glass),
        Material::Beckmann {
            rough: Box::new(Material::IndependentMasking { rough: Box::new(rough.clone()) }),
        },
        rough_plastic.clone(),
        Material::Beckmann { rough: Box::new(rough_plastic) },
        lambert(0.7).tinted(board()),
        lambert(0.7).one_sided(),
        Material::Sided { front: Box::new(lambert(0.3)), back: Box::new(rough.tinted(board())) },
        Material::Blend {
            components: Box::new([Material::Null, lambert(0.6).tinted(board()).one_sided()]),
            amount: board(),
        },
        Material::Blend {
            components: Box::new([
                Material::Dielectric { relative_ior: 1.5 },
                beckmann.one_sided(),
            ]),
            amount: board(),
        },
        plastic.one_sided(),
    ];
    let directions = [DVec3::new(0.48, 0.36, 0.8), DVec3::new(0.48, 0.36, -0.8)];
    let cases = materials.len() * PLACES.len() * directions.len() * 2;
    for (index, material) in materials.iter().enumerate() {
        let finish = material.finish().expect("valid");
        for uv in PLACES {
            for (fixed, walk) in directions
                .iter()
                .flat_map(|w| [(*w, TransportMode::Radiance), (*w, TransportMode::Importance)])
            {
                let mut sampler = Independent { seed: index as u64 }.sampler(7, 0);
                let report = check(
                    &SurfaceBsdf::new(&finish, uv, || None),
                    fixed,
                    walk,
                    &mut sampler,
                    10_000,
                );
                assert_eq!(
                    report.verdict(0.01, cases),
                    Ok(()),
                    "{material:?} at {uv} seen from {fixed} on a {walk:?} walk: {report:?}"
                );
            }
        }
    }
}

#[test]
fn colours_are_those_of_the_place_and_the_side() {
    let f = |material: &Material, uv: DVec2, z: f64| {
        let finish = material.finish().expect("valid");
        SurfaceBsdf::new(&finish, uv, || None).eval(DVec3::Z * z, DVec3::Z * z) * PI
    };
    let near = |a: Rgb, b: Rgb| {
        (0..3).for_each(|c| approx::assert_relative_eq!(a[c], b[c], max_relative = 1e-14))
    };
    let tinted = lambert(0.5).tinted(board());
    near(f(&tinted, PLACES[0], 1.0), Rgb::new(0.1, 0.25, 0.4));
    near(f(&tinted, PLACES[1], -1.0), Rgb::new(0.45, 0.05, 0.15));
    let sided = Material::Sided { front: Box::new(lambert(0.3)), back: Box::new(lambert(0.6)) };
    near(f(&sided, PLACES[0], 1.0), Rgb::splat(0.3));
    near(f(&sided, PLACES[0], -1.0), Rgb::splat(0.6));
    assert_eq!(f(&lambert(0.6).one_sided(), PLACES[0], -1.0), Rgb::BLACK);
    let half = Texture::from(Rgb::splat(0.25));
    let blend =
        Material::Blend { components: Box::new([lambert(0.2), lambert(0.6)]), amount: half };
    near(f(&blend, PLACES[0], 1.0), Rgb::splat(0.75 * 0.2 + 0.25 * 0.6));
    assert!(
        matches!(blend.finish(), Ok(Finish::Mixtures { .. }))
            && matches!(tinted.finish(), Ok(Finish::Tinted { .. }))
    );
}

#[test]
fn what_cannot_be_is_refused() {
    use crate::bsdf::BsdfError;
    let glass = Material::Dielectric { relative_ior: 1.5 };
    assert_eq!(glass.clone().one_sided().finish(), Err(BsdfError::SidedTransmission));
    let blend = |a: Material, b: Material| Material::Blend {
        components: Box::new([a, b]),
        amount: board(),
    };
    assert_eq!(
        blend(blend(lambert(0.1), lambert(0.2)), glass.clone()).finish(),
        Err(BsdfError::NestedMixture)
    );
    assert_eq!(Material::Beckmann { rough: Box::new(glass) }.finish(), Err(BsdfError::NotRough));
    assert!(matches!(
        lambert(0.5).tinted(Rgb::splat(1.5)).finish(),
        Err(BsdfError::Reflectance(_))
    ));
    let custom = Material::custom(crate::bsdf::Null);
    assert!(matches!(custom.finish(), Ok(Finish::Custom(_))) && custom.mixture() == Ok(None));
    let sided = Material::Sided { front: Box::new(lambert(0.5)), back: Box::new(custom.clone()) };
    let mixture = Material::Mixture {
        components: Box::new([lambert(0.5), custom.clone()]),
        weights: [0.5, 0.5],
    };
    for nested in [
        custom.clone().tinted(board()),
        custom.clone().one_sided(),
        sided,
        blend(custom.clone(), lambert(0.5)),
        mixture,
    ] {
        let refused = nested.finish();
        assert!(matches!(refused, Err(BsdfError::NestedCustom)), "{nested:?}: {refused:?}");
    }
    let rough = Material::Beckmann { rough: Box::new(custom) };
    assert_eq!(rough.finish(), Err(BsdfError::NotRough));
}

#[test]
fn custom_materials_are_equal_to_their_clones_alone() {
    let (one, other) = (Material::custom(crate::bsdf::Null), Material::custom(crate::bsdf::Null));
    assert!(one == one.clone() && one != other);
    assert_eq!(format!("{one:?}"), "Custom(CustomBsdf(Lobes(32)))");
}

/// Each side of a point answers to the bit as the mixture that it shows, and as the form in which
/// lanes shade it.
#[test]
fn sides_answer_as_what_they_show() {
    let white = || lambert(1.0).tinted(board());
    let rough = Material::RoughMirror { reflectance: Rgb::splat(0.9), alpha: DVec2::new(0.3, 0.4) };
    let sided = |front: &Material, back: &Material| Material::Sided {
        front: Box::new(front.clone()),
        back: Box::new(back.clone()),
    };
    let blend =
        Material::Blend { components: Box::new([lambert(0.2), rough.clone()]), amount: board() };
    let two = lambert(1.0)
        .tinted(board())
        .tinted(Texture::checkerboard(Rgb::new(0.7, 0.1, 0.6), Rgb::splat(0.3)));
    // The sides that lanes can shade.
    let materials = [
        (Material::Black, [true; 2]),
        (lambert(0.7), [true; 2]),
        (lambert(0.7).one_sided(), [true; 2]),
        (sided(&lambert(0.7), &lambert(0.2)), [true; 2]),
        (white(), [true; 2]),
        (sided(&Material::Black, &white()), [true; 2]),
        (two, [true; 2]),
        (sided(&lambert(0.7), &rough), [true, false]),
        (sided(&white(), &lambert(0.7)), [false; 2]),
        (lambert(0.7).tinted(board()), [false; 2]),
        (rough.clone().tinted(board()), [false; 2]),
        (rough.clone().tinted(Rgb::splat(0.3)).one_sided(), [false, true]),
        (sided(&rough.clone().tinted(board()), &lambert(0.3).tinted(board())), [false; 2]),
        (blend, [false; 2]),
    ];
    let mut sampler = Independent { seed: 3 }.sampler(0, 0);
    for ((material, lanes), uv) in materials.iter().flat_map(|m| PLACES.map(|uv| (m, uv))) {
        let finish = material.finish().expect("valid");
        let bsdf = SurfaceBsdf::new(&finish, uv, || None);
        for (front, has_lanes) in [(true, lanes[0]), (false, lanes[1])] {
            let form = bsdf.lane_form(front).map(|form| match form {
                LaneForm::Black => Model::Black,
                LaneForm::Lambert(lambert) => lambert.into(),
            });
            assert_eq!(form.is_some(), has_lanes, "{material:?}");
            let mixture = bsdf.mixture(front).expect("no custom one");
            let mut same = |shown: &dyn Bsdf| {
                let mut direction =
                    || crate::math::warp::square_to_sphere(sampler.next_2d()).normalize();
                let (fixed, next) = (direction(), direction());
                let fixed = fixed.with_z(if front { fixed.z.abs() } else { -fixed.z.abs() });
                let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
                let mode = TransportMode::Radiance;
                assert_eq!(bsdf.eval(next, fixed), shown.eval(next, fixed), "{material:?}");
                assert_eq!(bsdf.pdf(fixed, next, mode), shown.pdf(fixed, next, mode));
                let sample = bsdf.sample(fixed, mode, u1, u2);
                assert_eq!(sample, shown.sample(fixed, mode, u1, u2), "{material:?}");
            };
            for _ in 0..100 {
                same(&mixture);
                form.iter().for_each(|form| same(form));
            }
        }
    }
    // The albedo is that by which a white reflector would be multiplied.
    let finish = white().finish().expect("valid");
    for uv in PLACES {
        let albedo = Lambert::new(board().at(uv)).expect("valid");
        let form = SurfaceBsdf::new(&finish, uv, || None).lane_form(true);
        assert_eq!(form, Some(LaneForm::Lambert(albedo)));
    }
}

/// Nothing is lost of a weight that stands beside nothing.
#[test]
fn a_material_mixed_with_black_keeps_its_weight() {
    let mixture = |weights| Material::Mixture {
        components: Box::new([lambert(0.8), Material::Black]),
        weights,
    };
    assert!(matches!(mixture([1.0, 0.0]).finish(), Ok(Finish::Lambert { .. })));
    for (weights, albedo) in [([0.5, 0.0], 0.4), ([0.5, 0.5], 0.4), ([1.0, 0.0], 0.8)] {
        let finish = mixture(weights).finish().expect("valid");
        let value = SurfaceBsdf::new(&finish, DVec2::ZERO, || None).eval(DVec3::Z, DVec3::Z) * PI;
        approx::assert_relative_eq!(value.mean(), albedo, max_relative = 1e-14);
    }
}

/// At each place the material is that of the roughness which the texture has there.
#[test]
fn roughness_varies_with_its_texture() {
    let rough = |alpha: DVec2| Material::RoughMirror { reflectance: Rgb::WHITE, alpha };
    let u = Texture::checkerboard(Rgb::splat(0.1), Rgb::splat(0.4));
    let v = Texture::from(Rgb::splat(0.2));
    let alpha = Box::new([u, v]);
    let varying = |rough: Material| Material::VaryingRoughness {
        rough: Box::new(rough),
        alpha: alpha.clone(),
    };
    let beckmann = |rough| Material::Beckmann { rough: Box::new(rough) };
    let independent = |rough| Material::IndependentMasking { rough: Box::new(rough) };
    let (o, i) = (DVec3::new(0.48, 0.36, 0.8), DVec3::new(-0.6, 0.0, 0.8));
    let f = |material: &Material, uv: DVec2| {
        SurfaceBsdf::new(&material.finish().expect("valid"), uv, || None).eval(i, o).mean()
    };
    for (uv, alpha_u) in PLACES.into_iter().zip([0.1, 0.4]) {
        let there = rough(DVec2::new(alpha_u, 0.2));
        for (varying, constant) in [
            (varying(rough(DVec2::ZERO)), there.clone()),
            (varying(beckmann(rough(DVec2::ONE))), beckmann(there.clone())),
            (varying(independent(rough(DVec2::ONE))), independent(there.clone())),
            (varying(beckmann(independent(rough(DVec2::ONE)))), beckmann(independent(there))),
        ] {
            let (here, there) = (f(&varying, uv), f(&constant, uv));
            approx::assert_relative_eq!(here, there, max_relative = 1e-12);
        }
    }
    use crate::bsdf::BsdfError;
    assert_eq!(varying(lambert(0.5)).finish(), Err(BsdfError::NotRough));
    let alpha = Box::new([Texture::checkerboard(Rgb::WHITE, Rgb::splat(10.5)), board()]);
    let refused = Material::VaryingRoughness { rough: Box::new(rough(DVec2::ONE)), alpha }.finish();
    assert!(matches!(refused, Err(BsdfError::Roughness(..))), "{refused:?}");
}

/// Refracted light has the colour of the stain, reflected light has not.
#[test]
fn stains_colour_what_passes() {
    let (front, back) =
        (DVec3::new(0.3, 0.2, 0.8).normalize(), DVec3::new(-0.2, -0.1, -0.9).normalize());
    let rough = Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.4) };
    let smooth = Material::Dielectric { relative_ior: 1.5 };
    let pane = Material::ThinDielectric { relative_ior: 1.5 };
    for glass in [rough, smooth, pane] {
        let (clear, stained) = (glass.finish().unwrap(), glass.stained(board()).finish().unwrap());
        for uv in PLACES {
            let [clear, stained] =
                [&clear, &stained].map(|finish| SurfaceBsdf::new(finish, uv, || None));
            let stain = board().at(uv);
            let ways = [(front, front, Rgb::WHITE), (back, front, stain), (front, back, stain)];
            for (to_light, to_camera, share) in ways {
                assert_eq!(
                    stained.eval(to_light, to_camera),
                    share * clear.eval(to_light, to_camera)
                );
            }
            for mode in [TransportMode::Radiance, TransportMode::Importance] {
                let images = |bsdf: &SurfaceBsdf| {
                    let mut images = Vec::new();
                    bsdf.dirac_images(front, mode, &mut |image| images.push(image));
                    images
                };
                for (clear, stained) in images(&clear).iter().zip(images(&stained)) {
                    let share = if clear.next.z > 0.0 { Rgb::WHITE } else { stain };
                    assert_eq!(stained.weight, share * clear.weight);
                    assert_eq!((stained.pdf, stained.next), (clear.pdf, clear.next));
                }
            }
        }
    }
}

/// Products look at vertices as their factors do, and give them transforms and coordinates.
#[test]
fn products_ask_vertices() {
    let values = VertexValues {
        uvs: Some(vec![DVec2::new(0.25, 0.25); 3]),
        other_uvs: Some(vec![DVec2::new(0.75, 0.25); 3]),
        colors: Some(vec![DVec4::new(0.5, 1.0, 0.25, 1.0); 3]),
        indices: vec![[0, 1, 2]],
    };
    let site = VertexSite { values: &values, index: 0, barycentric: DVec2::splat(0.25) };
    let white = Texture::from(Rgb::WHITE);
    let coloured = white.clone().with_vertex_factor(VertexFactor::Color);
    let board = Texture::checkerboard(Rgb::splat(0.5), Rgb::splat(0.25));
    let product = coloured.times(board.clone());
    assert!(product.asks_vertices() && product.as_constant().is_none());
    assert!(!white.times(board).asks_vertices());
    let colour = Rgb::new(0.5, 1.0, 0.25);
    assert_eq!(product.on_mesh(&site), colour * 0.5);
    assert_eq!(product.clone().with_other_coordinates().on_mesh(&site), colour * 0.25);
    let half = DAffine2::from_translation(DVec2::new(0.5, 0.0));
    let moved = product.with_transform(half).expect("finite");
    assert_eq!(moved.on_mesh(&site), colour * 0.25);
    assert_eq!(moved.at(DVec2::new(0.25, 0.25)), Rgb::splat(0.25));
}
