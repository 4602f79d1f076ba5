//! The needs that scenes state, and the reasons that are given.

use super::{rooms, sparing_scenes};
use glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::endpoint::{
    ConstantEnvironment, DirectionSample, Endpoint, Light, PointLight, PointSample,
};
use pathspace::film::Technique;
use pathspace::gallery;
use pathspace::geometry::{Place, Sphere, SurfacePoint};
use pathspace::material::Texture;
use pathspace::math::{PerArea, PerProjected, Rgb};
use pathspace::path::{Excluded, Family, Reason, TechniqueSet};
use pathspace::scene::{Material, Mesh, Needs, Scene};
use rooms::{Room, lambert, v};

#[test]
fn what_scenes_need() {
    let needs: Vec<(&str, Needs)> =
        sparing_scenes().iter().map(|(name, world, ..)| (*name, world.needs())).collect();
    let of = |name: &str| needs.iter().find(|(other, _)| *other == name).expect("known").1;
    let has = |name: &str, need| of(name).contains(need);
    assert!(
        !has("point light alone", Needs::HITTABLE_LIGHTS)
            && has("point light alone", Needs::DIRAC_LIGHTS | Needs::INTERREFLECTION)
    );
    assert!(!has("mirror", Needs::FINITE_LOBES) && !has("mirror", Needs::DIRAC_LIGHTS));
    assert_eq!(
        ["ball under a sky", "one disk", "lamp that shines away"]
            .map(|name| of(name).most_bounces()),
        [Some(1), Some(1), Some(0)]
    );
    assert!(
        !(of("black light").contains(Needs::HITTABLE_LIGHTS)
            || of("black light").contains(Needs::DIRAC_LIGHTS))
    );
    // With light inside it a ball has an inside; of two, one lights the other; and glass lets light
    // in.
    let ball = |second: bool, lamp: bool, material: Material| {
        let mut room = Room::default();
        room.sphere(Sphere::new(DVec3::ZERO, 1.0), material);
        if second {
            room.disk(v(0.0, 0.0, 3.0), DVec3::Z, 1.0, lambert(0.5, 0.5, 0.5));
        }
        if lamp {
            room.light(PointLight::new(DVec3::ZERO, Rgb::WHITE).expect("valid"));
        }
        room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        room.build().needs().most_bounces()
    };
    let clay = || lambert(0.5, 0.5, 0.5);
    assert_eq!(ball(false, false, clay()), Some(1));
    assert_eq!(
        [ball(true, false, clay()), ball(false, true, clay()), ball(false, false, Material::Null)],
        [None; 3]
    );
    for (name, light, scattering) in [("cornell-box", true, None), ("smooth-mesh", true, None)] {
        let world = gallery::build(name, UVec2::ONE).expect("a scene").world;
        assert_eq!(
            (world.needs().contains(Needs::HITTABLE_LIGHTS), world.needs().most_bounces()),
            (light, scattering)
        );
    }
}

#[test]
fn reasons_are_given() {
    for (name, world, ..) in sparing_scenes() {
        let left_out = TechniqueSet::BIDIRECTIONAL.left_out(&world.needs());
        let set = TechniqueSet::BIDIRECTIONAL.pruned(&world.needs());
        let reason =
            |family| left_out.families().find(|(f, _)| *f == family).map(|(_, reason)| reason);
        match name {
            "point light alone" => {
                assert_eq!(reason(Family::BsdfSampling), Some(Reason::NoHittableLight))
            }
            "mirror" => {
                assert_eq!(reason(Family::Connections), Some(Reason::NoFiniteLobe));
                assert_eq!(reason(Family::LensSampling), Some(Reason::Redundant));
                assert_eq!(set, TechniqueSet { bsdf_sampling: true, ..TechniqueSet::NONE });
            }
            "lamp that shines away" => {
                assert_eq!(reason(Family::NextEventEstimation), Some(Reason::NoIllumination))
            }
            "black light" => assert_eq!(
                (set, reason(Family::LensSampling)),
                (TechniqueSet::NONE, Some(Reason::NoLight))
            ),
            _ => assert_eq!(left_out.most_bounces(), Some(1), "{name}"),
        }
        assert!(!left_out.is_empty() && !left_out.to_string().is_empty());
    }
}

/// A beam: Dirac in position and direction.
pub struct Beam;

impl Endpoint for Beam {
    fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
        Some(PointSample { point: SurfacePoint::dirac(DVec3::Z), pdf: PerArea(1.0) })
    }
    fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }
    fn sample_direction(&self, point: &SurfacePoint, _: DVec2) -> Option<DirectionSample> {
        Some(DirectionSample {
            from: *point,
            direction: -DVec3::Z,
            pdf: PerProjected(1.0),
            weight: Rgb::WHITE,
        })
    }
    fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
        PerProjected::ZERO
    }
    fn emit(&self, _: &SurfacePoint, _: DVec3) -> Rgb {
        Rgb::BLACK
    }
}

impl Light for Beam {
    fn power(&self) -> Rgb {
        Rgb::WHITE
    }
    fn can_be_hit(&self) -> bool {
        false
    }
    fn can_be_connected(&self) -> bool {
        false
    }
}

/// Each feature alone, in a room that needs nothing but diffuse reflection and a lamp.
#[test]
fn every_feature_is_needed_where_it_is_and_nowhere_else() {
    let plain = Needs::HITTABLE_LIGHTS
        | Needs::CONNECTIBLE_LIGHTS
        | Needs::FINITE_LOBES
        | Needs::ILLUMINATION
        | Needs::INTERREFLECTION;
    let room = |add: &dyn Fn(&mut Room)| {
        let mut room = Room::open(lambert(0.5, 0.5, 0.5));
        room.lamp(0.5, 4.0);
        add(&mut room);
        room.build().needs()
    };
    let ball = |material: Material| {
        room(&|room| {
            room.sphere(Sphere::new(v(0.0, 0.0, 0.5), 0.2), material.clone());
        })
    };
    let rough = || Material::RoughMirror { reflectance: Rgb::WHITE, alpha: DVec2::splat(0.3) };
    assert_eq!(room(&|_| ()), plain);
    assert_eq!(ball(Material::Mirror { reflectance: Rgb::WHITE }), plain | Needs::DIRAC_LOBES);
    assert_eq!(ball(rough()), plain | Needs::GLOSSY_LOBES);
    assert_eq!(ball(Material::Dielectric { relative_ior: 1.5 }), plain | Needs::DIRAC_LOBES);
    assert_eq!(ball(Material::Null), plain | Needs::DIRAC_LOBES);
    let frosted = Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.3) };
    assert_eq!(ball(frosted), plain | Needs::GLOSSY_LOBES);
    let board = Texture::checkerboard(Rgb::BLACK, Rgb::WHITE);
    assert_eq!(ball(lambert(0.5, 0.5, 0.5).tinted(board)), plain);
    let sky = room(&|room| room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid")));
    assert_eq!(sky, plain | Needs::ENVIRONMENT);
    let point =
        room(&|room| room.light(PointLight::new(v(0.0, 0.0, 1.0), Rgb::WHITE).expect("valid")));
    assert_eq!(point, plain | Needs::DIRAC_LIGHTS);
    assert_eq!(
        room(&|room| room.light(Beam)),
        plain | Needs::DIRAC_LIGHTS | Needs::UNCONNECTIBLE_LIGHTS
    );

    let mut beam = Room::open(lambert(0.5, 0.5, 0.5));
    beam.light(Beam);
    let unconnectible = Needs::DIRAC_LIGHTS
        | Needs::UNCONNECTIBLE_LIGHTS
        | Needs::FINITE_LOBES
        | Needs::ILLUMINATION;
    assert_eq!(beam.build().needs(), unconnectible | Needs::INTERREFLECTION);

    // Without diffuse reflection, glossy lobes are what can be connected to.
    let lone = |material: Material, inward: bool, two_sided: Option<bool>| {
        let mut room = Room::default();
        let sphere = room.sphere(Sphere { inward, ..Sphere::new(DVec3::ZERO, 1.0) }, material);
        if let Some(two_sided) = two_sided {
            room.emit(sphere, Rgb::WHITE, two_sided);
        }
        room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        room.build().needs()
    };
    assert!(lone(rough(), false, None).contains(Needs::FINITE_LOBES | Needs::GLOSSY_LOBES));
    assert!(!lone(Material::Black, false, None).contains(Needs::FINITE_LOBES));
    // Seen from inside, or emitting into itself, a ball lights itself.
    let interreflection = |inward, two_sided| {
        lone(lambert(0.5, 0.5, 0.5), inward, two_sided).contains(Needs::INTERREFLECTION)
    };
    assert_eq!(
        [(false, None), (false, Some(false)), (false, Some(true)), (true, None)]
            .map(|(a, b)| interreflection(a, b)),
        [false, false, true, true]
    );
}

/// Light that arrives from another surface, or from another part of the same one.
#[test]
fn illumination_and_interreflection_are_claimed_unless_impossible() {
    // A lamp above everything that shines up, and one that shines both ways.
    let lamp = |two_sided| {
        let mut room = Room::closed_above(lambert(0.5, 0.5, 0.5));
        let lamp =
            room.quad(v(-0.5, -0.5, 2.5), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), Material::Black);
        room.emit(lamp, Rgb::WHITE, two_sided);
        room.build().needs().contains(Needs::ILLUMINATION)
    };
    assert_eq!([false, true].map(lamp), [false, true]);
    let sky = || ConstantEnvironment::new(Rgb::WHITE).expect("valid");
    let cap = |cos_max| {
        let mut room = Room::default();
        room.sphere(Sphere { cos_max, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(0.5, 0.5, 0.5));
        room.environment(sky());
        room.build().needs().contains(Needs::INTERREFLECTION)
    };
    assert_eq!([1.0, 0.5].map(cap), [false, true]);
    let mesh = |triangles: usize| {
        let (positions, indices) =
            (vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2], [0, 2, 3]]);
        let mesh = Mesh { positions, indices: indices[..triangles].to_vec(), ..Mesh::default() };
        let mut room = Room::default();
        room.mesh(&mesh, DAffine3::IDENTITY, lambert(0.5, 0.5, 0.5));
        room.environment(sky());
        room.build().needs().contains(Needs::INTERREFLECTION)
    };
    assert_eq!([1, 2].map(mesh), [false, true]);
}

/// A set that asks for a technique by name keeps it; and what a beam lights is not drawn by path
/// tracing.
#[test]
fn nothing_is_redundant_or_complete_that_is_asked_for_or_missing() {
    let mirrors = Needs::HITTABLE_LIGHTS
        | Needs::CONNECTIBLE_LIGHTS
        | Needs::DIRAC_LOBES
        | Needs::ILLUMINATION
        | Needs::INTERREFLECTION;
    let all = TechniqueSet::BIDIRECTIONAL;
    assert!(!all.pruned(&mirrors).lens_sampling);
    let only = TechniqueSet::only(Technique::new(1, 1)).expect("a short path");
    assert!(only.pruned(&mirrors).lens_sampling);
    let excluded = Excluded::NONE.with(Technique::new(0, 2)).expect("a short path");
    assert!(TechniqueSet { excluded, ..all }.pruned(&mirrors).lens_sampling);
    let paths = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    let point = Needs::DIRAC_LIGHTS
        | Needs::CONNECTIBLE_LIGHTS
        | Needs::FINITE_LOBES
        | Needs::ILLUMINATION
        | Needs::INTERREFLECTION;
    assert!(paths.is_complete(&point, Place::Dirac));
    assert!(!paths.is_complete(&(point | Needs::UNCONNECTIBLE_LIGHTS), Place::Dirac));
}
