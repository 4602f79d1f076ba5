//! Classes of paths that a set of techniques cannot draw: against every path signature, and against
//! what is drawn.

use super::common::Random;
use super::needs::Beam;
use super::rooms::{self, Room, lambert, v};
use super::worlds;
use pathspace::endpoint::{
    Camera, ConstantEnvironment, DirectionalLight, Light, LightId, LightKind, PointLight,
};
use pathspace::film::{Sample, Technique};
use pathspace::geometry::{Place, Sphere};
use pathspace::integrator::{Bidirectional, Depth, Stage};
use pathspace::math::Rgb;
use pathspace::path::{DrawnBy, Excluded, PathClass, Scratch, TechniqueSet};
use pathspace::scene::{Material, Needs, Scene, World};
use std::collections::{BTreeMap, BTreeSet};

const LENSES: [Place; 3] = [Place::Area, Place::Dirac, Place::Infinite];

/// True if the definition of a technique lets it draw a path: `lobes` tells from the light on which
/// vertices take Dirac lobes.
fn can_draw(technique: Technique, light: LightKind, lens: Place, lobes: &[bool]) -> bool {
    let (s, t) = (usize::from(technique.s), usize::from(technique.t));
    let is_finite = |from_light: usize| !lobes[from_light - 1];
    let from_lens = |i: usize| lobes.len() + 1 - i;
    if technique.merged {
        // Both subpaths have found the vertex.
        assert_eq!(s - 1, from_lens(t - 1));
        return is_finite(s - 1);
    }
    if s == 0 {
        return light.hittable;
    }
    if lobes.is_empty() {
        // The film sees a Dirac distribution unless a random point of lens or light decides where.
        let has_image = lens == Place::Area || light.hittable;
        let emits_that_way = light.hittable || light.connectible;
        let has_line = (lens, light.place) != (Place::Infinite, Place::Infinite);
        return has_image && emits_that_way && has_line;
    }
    let light_end = if s == 1 { light.connectible } else { is_finite(s - 1) };
    let lens_end = t == 1 || is_finite(from_lens(t - 1));
    light_end && lens_end
}

/// The same of a set.
fn draws(set: &TechniqueSet, light: LightKind, lens: Place, lobes: &[bool]) -> bool {
    let bounces = lobes.len() as u16;
    let connected = (0..=bounces + 1).map(|s| Technique::new(s, bounces + 2 - s));
    let merged = (2..=bounces + 1).map(|s| Technique::merge(s, bounces + 3 - s));
    let uniform = light.hittable
        && lobes.iter().all(|dirac| !dirac)
        && (light.place == Place::Area || lobes.is_empty());
    (set.uniform_area && uniform)
        || connected
            .chain(merged)
            .any(|technique| set.contains(technique) && can_draw(technique, light, lens, lobes))
}

fn drawn_by(light: LightKind, lens: Place, lobes: &[bool]) -> DrawnBy {
    let merging = TechniqueSet { merges: 1, ..TechniqueSet::BIDIRECTIONAL };
    if draws(&TechniqueSet::BIDIRECTIONAL, light, lens, lobes) {
        DrawnBy::Connections
    } else if draws(&merging, light, lens, lobes) {
        DrawnBy::Merges
    } else {
        DrawnBy::Nothing
    }
}

fn class(lobes: &[bool]) -> PathClass {
    let any = |dirac: bool| lobes.contains(&dirac);
    match (lobes.first(), lobes.last()) {
        (None, _) | (_, None) => PathClass::Direct,
        _ if !any(false) => PathClass::SpecularlySeen,
        _ if !any(true) => PathClass::Scattered,
        (Some(true), Some(false)) => PathClass::Caustic,
        (Some(false), Some(true)) => PathClass::SpecularView,
        (Some(true), Some(true)) => PathClass::SpecularViewOfCaustic,
        (Some(false), Some(false)) => PathClass::Between,
    }
}

fn notation(lobes: &[bool]) -> String {
    let vertices: String = lobes.iter().map(|dirac| if *dirac { "S " } else { "D " }).collect();
    format!("L {vertices}E")
}

/// All lobes of paths with so many scattering events, among those that a scene has.
fn chains(bounces: u32, dirac: bool, finite: bool) -> impl Iterator<Item = Vec<bool>> {
    (0..1u32 << bounces)
        .map(move |bits| (0..bounces).map(|i| bits >> i & 1 == 1).collect::<Vec<bool>>())
        .filter(move |lobes| lobes.iter().all(|is_dirac| if *is_dirac { dirac } else { finite }))
}

/// What can be hit has an extent, on a surface or at infinity; Dirac lights have none.
fn kinds() -> Vec<LightKind> {
    let lights = [
        (Place::Area, true),
        (Place::Infinite, true),
        (Place::Dirac, false),
        (Place::Infinite, false),
    ];
    let kind = |(place, hittable)| {
        [true, false].map(|connectible| LightKind { place, hittable, connectible })
    };
    lights.into_iter().flat_map(kind).collect()
}

fn needs_of(light: LightKind, dirac: bool, finite: bool) -> Needs {
    let when = |condition: bool, need| if condition { need } else { Needs::NONE };
    Needs::ILLUMINATION
        | Needs::INTERREFLECTION
        | when(light.hittable, Needs::HITTABLE_LIGHTS)
        | when(!light.hittable, Needs::DIRAC_LIGHTS)
        | when(light.connectible, Needs::CONNECTIBLE_LIGHTS)
        | when(!light.connectible, Needs::UNCONNECTIBLE_LIGHTS)
        | when(light.hittable && light.place == Place::Infinite, Needs::ENVIRONMENT)
        | when(dirac, Needs::DIRAC_LOBES)
        | when(finite, Needs::FINITE_LOBES)
}

/// All unions of families, and some with single techniques left out.
fn sets() -> Vec<TechniqueSet> {
    let mut sets: Vec<TechniqueSet> = (0..64u32)
        .map(|bits| TechniqueSet {
            bsdf_sampling: bits & 1 != 0,
            next_event: bits & 2 != 0,
            connections: bits & 4 != 0,
            lens_sampling: bits & 8 != 0,
            uniform_area: bits & 16 != 0,
            merges: bits >> 5,
            ..TechniqueSet::NONE
        })
        .collect();
    let exclude = |techniques: &[Technique]| {
        let all = techniques.iter().try_fold(Excluded::NONE, |set, one| set.with(*one));
        TechniqueSet { excluded: all.expect("short paths"), ..TechniqueSet::BIDIRECTIONAL }
    };
    sets.extend(Technique::up_to(3).map(|technique| exclude(&[technique])));
    sets.push(exclude(&[Technique::new(0, 2), Technique::new(1, 1)]));
    sets.push(exclude(&Technique::up_to(1).filter(|t| t.s > 0).collect::<Vec<_>>()));
    sets.extend(Technique::up_to(2).filter_map(TechniqueSet::only));
    sets.extend(Technique::merges_up_to(2).filter_map(TechniqueSet::only));
    let merges: Vec<_> = Technique::merges_up_to(2).collect();
    sets.extend([TechniqueSet::NONE, TechniqueSet::BIDIRECTIONAL].into_iter().flat_map(|set| {
        let excluded = [&merges[..1], &merges].map(|merges| exclude(merges).excluded);
        excluded.map(|excluded| TechniqueSet { excluded, merges: 1, ..set })
    }));
    sets
}

/// Every kind of light and of lens, every set, every path: a class is missing if and only if one of
/// its paths is, and the path that is told is a shortest one.
#[test]
fn a_class_is_missing_if_a_path_of_it_is() {
    let (mut complete, mut incomplete) = (0, 0);
    let mut check = |light: LightKind, lens, dirac, finite, set: TechniqueSet| {
        let needs = needs_of(light, dirac, finite);
        let what = format!("{set}, {light:?}, {lens:?}, {needs}");
        let paths = |most: u32| (0..=most).flat_map(|n| chains(n, dirac, finite));
        for most in [0, 1, 2, 3, 6] {
            let mut undrawn = BTreeMap::<String, Vec<String>>::new();
            for lobes in paths(most).filter(|lobes| !draws(&set, light, lens, lobes)) {
                let key = format!("{:?} {:?}", class(&lobes), drawn_by(light, lens, &lobes));
                undrawn.entry(key).or_default().push(notation(&lobes));
            }
            let missing = set.missing(&needs, lens, Depth::up_to(most));
            let missing: Vec<_> = missing.iter().filter(|paths| paths.kind == light).collect();
            for paths in &missing {
                let key = format!("{:?} {:?}", paths.class, paths.drawn_by);
                let of_class = &undrawn[&key];
                assert!(of_class.contains(&paths.shortest), "{what}: {paths:?}");
                assert!(of_class.iter().all(|path| path.len() >= paths.shortest.len()));
            }
            assert_eq!(missing.len(), undrawn.len(), "{what}: {missing:?}, {undrawn:?}");
        }
        let lights: Vec<_> = kinds().into_iter().filter(|kind| may_have(&needs, *kind)).collect();
        let is_complete = paths(6).all(|lobes| {
            lights.iter().all(|light| {
                draws(&set, *light, lens, &lobes)
                    || !draws(&TechniqueSet::BIDIRECTIONAL, *light, lens, &lobes)
            })
        });
        assert_eq!(set.is_complete(&needs, lens), is_complete, "{what}");
        *(if is_complete { &mut complete } else { &mut incomplete }) += 1;
    };
    for light in kinds() {
        for lens in LENSES {
            for (dirac, finite) in [(false, false), (true, false), (false, true), (true, true)] {
                sets().into_iter().for_each(|set| check(light, lens, dirac, finite, set));
            }
        }
    }
    println!("{complete} complete, {incomplete} not");
    assert!(complete > 1000 && incomplete > 1000);
}

/// True if a scene with these needs may have a light of this kind.
fn may_have(needs: &Needs, kind: LightKind) -> bool {
    let everywhere = Needs::ILLUMINATION | Needs::INTERREFLECTION;
    needs.contains(needs_of(kind, false, false).without(everywhere))
}

/// Floor and ball in diffuse white, floor and ball as mirrors, and one light.
fn world(light: &str) -> World {
    let mut room = Room::default();
    let mirror = || Material::Mirror { reflectance: Rgb::splat(0.9) };
    for (x, material) in [(-1.0, lambert(0.8, 0.8, 0.8)), (0.0, mirror())] {
        room.quad(v(x, -1.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 2.0, 0.0), material);
    }
    room.sphere(Sphere::new(v(-0.4, 0.0, 0.4), 0.35), lambert(0.8, 0.8, 0.8));
    room.sphere(Sphere::new(v(0.4, 0.0, 0.4), 0.35), mirror());
    match light {
        "area" => {
            let lamp = room.sphere(Sphere::new(v(0.0, -0.2, 1.3), 0.3), Material::Black);
            room.emit(lamp, Rgb::WHITE, false);
        }
        "sky" => room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid")),
        "point" => room.light(PointLight::new(v(0.0, -0.2, 1.0), Rgb::WHITE).expect("valid")),
        "sun" => room.light(DirectionalLight::new(v(0.0, -1.0, -0.02), Rgb::WHITE).expect("valid")),
        _ => room.light(Beam),
    }
    room.build()
}

/// What integrators contribute is what the rule says that they can draw: nothing else, and all of
/// it.
#[test]
fn what_is_drawn_is_what_can_be_drawn() {
    const DEPTH: Depth = Depth::up_to(2);
    let cameras: [(&dyn Camera, Place); 3] = [
        (&rooms::lens_camera(), Place::Area),
        (&rooms::camera(), Place::Dirac),
        (&rooms::parallel_camera(), Place::Infinite),
    ];
    let none = TechniqueSet::NONE;
    let sets = [
        TechniqueSet { bsdf_sampling: true, ..none },
        TechniqueSet { next_event: true, ..none },
        TechniqueSet { connections: true, ..none },
        TechniqueSet { lens_sampling: true, ..none },
        TechniqueSet::BIDIRECTIONAL,
    ];
    for (name, kind) in [
        ("area", LightKind { place: Place::Area, hittable: true, connectible: true }),
        ("sky", LightKind { place: Place::Infinite, hittable: true, connectible: true }),
        ("point", LightKind { place: Place::Dirac, hittable: false, connectible: true }),
        ("sun", LightKind { place: Place::Infinite, hittable: false, connectible: true }),
        ("beam", LightKind { place: Place::Dirac, hittable: false, connectible: false }),
    ] {
        let world = world(name);
        assert_eq!(world.light(LightId(0)).kind(), kind, "{name}");
        assert!(may_have(&world.needs(), kind));
        for (camera, lens) in cameras {
            assert_eq!(camera.place(), lens);
            for techniques in sets {
                let integrator =
                    Bidirectional { techniques, depth: DEPTH, ..Bidirectional::default() };
                let (mut sampler, mut scratch) = (Random::new(5), Scratch::default());
                let mut drawn = BTreeSet::new();
                for _ in 0..20_000 {
                    let film = worlds::film_sample(camera, &mut sampler);
                    let sample = Sample { film, sampler: &mut sampler };
                    let stage = Stage::new(&world, camera);
                    integrator.for_each_path(stage, sample, &mut scratch, |path, _| {
                        let vertices = (1..path.edges()).rev().map(|i| path.vertex(i).dirac);
                        drawn.insert(vertices.collect::<Vec<_>>());
                    });
                }
                let can = (0..=2)
                    .flat_map(|n| chains(n, true, true))
                    .filter(|lobes| draws(&techniques, kind, lens, lobes))
                    // The beam falls on the diffuse floor.
                    .filter(|lobes| name != "beam" || lobes.first() == Some(&false))
                    .collect::<BTreeSet<_>>();
                assert_eq!(drawn, can, "{name}, {lens:?}, {techniques}");
            }
        }
    }
}
