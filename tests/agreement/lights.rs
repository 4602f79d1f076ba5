//! Each kind of light.

use crate::compare::{self, Comparison, assert_agree, measure};
use crate::rooms::{Room, camera, lambert, lens_camera, v};
use crate::team::{THREE, Team, apart, black, grey, metal, sky};
use glam::{DAffine3, DMat3};
use pathspace::endpoint::{
    ConstantEnvironment, DirectionalLight, EnvironmentMap, Lookup, PointLight, SpotLight,
};
use pathspace::geometry::Sphere;
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::scene::Mesh;

#[test]
fn quad_light() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.4, 8.0);
    Team::with_light(THREE).balance().general().next_event_only().agree("quad light", room);
}

/// A light large enough to be hit by chance, for the techniques that know nothing of it.
#[test]
fn large_quad_light() {
    let mut room = Room::open(grey());
    room.lamp(0.95, 2.0);
    Team::with_light(Depth::up_to(2)).emission_only().agree("large quad light", room);
}

/// Uniform-area sampling of a large light. Its variance is infinite where surfaces touch; here none
/// do.
#[test]
fn large_quad_light_by_uniform_area_sampling() {
    let world = apart(grey());
    let team = Team::new(Depth::up_to(2)).path().uniform();
    assert_agree(
        "large quad light, uniform area",
        &world,
        &camera(),
        &team.named(),
        &Comparison { target: 0.0015, ..Comparison::default() },
    );
}

#[test]
fn mesh_light() {
    let mut room = Room::closed_above(grey());
    let transform = DAffine3::from_scale_rotation_translation(
        v(0.25, 0.2, 0.1),
        glam::DQuat::from_rotation_y(0.5),
        v(0.1, 0.2, 1.6),
    );
    let mesh = room.mesh(&Mesh::icosphere(0), transform, grey());
    room.emit(mesh, Rgb::new(4.0, 5.0, 6.0), false);
    Team::with_light(THREE).agree("mesh light", room);
}

#[test]
fn disk_light() {
    let mut room = Room::closed_above(grey());
    let disk = room.disk(v(0.0, -0.2, 1.9), v(0.1, 0.3, -1.0), 0.4, grey());
    room.emit(disk, Rgb::new(6.0, 5.0, 4.0), false);
    Team::with_light(THREE).agree("disk light", room);
}

#[test]
fn whole_sphere_light() {
    let mut room = Room::closed_above(grey());
    let sphere = room.sphere(Sphere::new(v(0.3, -0.1, 1.5), 0.2), grey());
    room.emit(sphere, Rgb::new(6.0, 5.0, 4.0), false);
    Team::with_light(THREE).agree("sphere light", room);
}

/// The upper half of a sphere that shines inwards, like a dome lamp.
#[test]
fn inward_zone_light() {
    let mut room = Room::open(grey());
    let zone = Sphere {
        axis: v(0.0, 0.1, 1.0),
        cos_min: 0.2,
        cos_max: 0.95,
        inward: true,
        ..Sphere::new(v(0.0, 0.0, 1.2), 0.9)
    };
    let zone = room.sphere(zone, grey());
    room.emit(zone, Rgb::new(1.0, 2.0, 3.0), false);
    Team::with_light(Depth::up_to(2)).agree("inward zone", room);
}

#[test]
fn two_sided_quad_light() {
    let mut room = Room::closed_above(grey());
    let quad = room.quad(v(0.3, -0.6, 1.0), v(0.2, 0.0, 0.6), v(0.0, 0.7, 0.1), grey());
    room.emit(quad, Rgb::new(3.0, 4.0, 5.0), true);
    Team::with_light(THREE).agree("two-sided quad", room);
}

#[test]
fn point_light() {
    let mut room = Room::closed_above(grey());
    room.light(PointLight::new(v(0.2, -0.3, 1.4), Rgb::new(2.0, 1.5, 1.0)).expect("valid"));
    Team::with_light(THREE).next_event_only().general().agree("point light", room);
}

#[test]
fn spot_light() {
    let mut room = Room::closed_above(grey());
    room.light(
        SpotLight::new(v(0.6, -0.6, 1.7), v(-0.5, 0.5, -1.0), Rgb::new(4.0, 3.0, 2.0), 15.0, 40.0)
            .expect("valid"),
    );
    Team::with_light(THREE).next_event_only().agree("spot light", room);
}

#[test]
fn directional_light() {
    let mut room = Room::open(grey());
    room.light(DirectionalLight::new(v(0.3, 0.5, -1.0), Rgb::new(1.0, 2.0, 3.0)).expect("valid"));
    Team::with_light(THREE).balance().next_event_only().agree("directional light", room);
}

#[test]
fn constant_environment() {
    let mut room = Room::open(grey());
    room.environment(ConstantEnvironment::new(Rgb::new(0.5, 0.7, 1.0)).expect("valid"));
    Team::with_light(THREE).emission_only().agree("constant environment", room);
}

/// An environment in view, with the blocker in front of it: s = 0 and (1, 1) draw the paths of one
/// edge. It is bright where the camera looks, so that light walks from it find the lens.
#[test]
fn environment_seen_directly() {
    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), grey());
    room.sphere(Sphere::new(v(0.2, 0.0, 0.8), 0.3), lambert(0.7, 0.5, 0.3));
    // The image's left edge is straight ahead.
    let pixel = |i: u32| match (i % 16, i / 16) {
        (x @ (0..2 | 14..16), y @ 2..6) => {
            Rgb::new(0.2 + 0.05 * f64::from(x), 0.5, 0.1 * f64::from(y))
        }
        _ => Rgb::splat(0.02),
    };
    room.environment(
        EnvironmentMap::new(16, 8, (0..128).map(pixel).collect(), EnvironmentMap::Z_UP)
            .expect("valid"),
    );
    let (world, team) = (room.build(), Team::with_light(Depth::up_to(1)));
    assert_agree(
        "environment in view, pinhole",
        &world,
        &camera(),
        &team.named(),
        &Comparison::default(),
    );
    assert_agree(
        "environment in view, thin lens",
        &world,
        &lens_camera(),
        &team.named(),
        &Comparison::default(),
    );
}

#[test]
fn environment_map() {
    let mut room = Room::open(grey());
    room.environment(sky(Lookup::PiecewiseConstant));
    Team::with_light(THREE).balance().agree("environment map", room);
}

#[test]
fn bilinear_environment_map() {
    let mut room = Room::open(grey());
    room.environment(sky(Lookup::Bilinear));
    Team::with_light(THREE).agree("bilinear environment map", room);
}

/// Powers about 1 : 10⁴ : 1, and a light at infinity among finite ones.
#[test]
fn several_lights() {
    let mut room = Room::open(grey());
    room.lamp(0.3, 1e-3);
    let sphere = room.sphere(Sphere::new(v(-0.4, 0.3, 1.3), 0.15), grey());
    room.emit(sphere, Rgb::new(20.0, 15.0, 10.0), false);
    room.environment(ConstantEnvironment::new(Rgb::new(0.0, 0.0, 1e-4)).expect("valid"));
    Team::with_light(THREE).agree("several lights", room);
}

/// Each light is chosen half of the time: hits and connections must both know it.
#[test]
fn lights_of_equal_power() {
    let mut room = Room::open(metal(0.3, 0.3));
    for x in [-1.0, 0.0] {
        let lamp = room.quad(v(x, -0.9, 1.95), v(0.0, 1.8, 0.0), v(0.95, 0.0, 0.0), black());
        room.emit(lamp, Rgb::new(3.0, 2.0, 1.0), false);
    }
    Team::with_light(Depth::up_to(2)).emission_only().agree("equal lights", room);
}

/// The faint light is the only one that the camera's half of the scene sees, so that no other hides
/// an error in its probability.
#[test]
fn faint_light_alone_behind_a_wall() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 0.3);
    let hidden = room.quad(v(-1.0, 3.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0), black());
    room.emit(hidden, Rgb::splat(1.0), false);
    // Shines towards -y, onto the black back of the wall: strong, and of no use.
    let depth = Depth::up_to(2);
    let team = Team::new(depth).path().bidirectional().light();
    team.agree_within(0.005, "faint light", room);
}

/// A mirrored instance emits on the side of its front, as a mesh whose vertices are mirrored and
/// whose winding is reversed does.
#[test]
fn mirrored_instance() {
    let tetrahedron = |sign: f64, reverse: bool| {
        let positions = [v(0.0, 0.0, 0.0), v(0.5, 0.0, 0.1), v(0.1, 0.6, 0.0), v(0.1, 0.1, 0.4)]
            .map(|p| v(sign * p.x, p.y, p.z))
            .to_vec();
        let indices = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
            .map(|[a, b, c]| if reverse { [a, c, b] } else { [a, b, c] })
            .to_vec();
        Mesh { positions, indices, ..Mesh::default() }
    };
    let world = |mesh: Mesh, x: f64| {
        let mut room = Room::closed_above(grey());
        let transform = DAffine3 {
            matrix3: DMat3::from_diagonal(v(x, 1.0, 1.0)),
            translation: v(0.2, -0.2, 1.2),
        };
        let mesh = room.mesh(&mesh, transform, grey());
        room.emit(mesh, Rgb::new(3.0, 4.0, 5.0), false);
        room.build()
    };
    let team = Team::new(Depth::up_to(2)).path().light().bidirectional();
    let comparison = Comparison::default();
    let worlds = [
        ("instance", world(tetrahedron(1.0, false), -1.0)),
        ("vertices", world(tetrahedron(-1.0, true), 1.0)),
    ];
    let mut measured = Vec::new();
    for (label, world) in &worlds {
        for (name, integrator) in team.named() {
            measured.push(measure(
                world,
                &camera(),
                (&format!("{name}, {label}"), integrator),
                &comparison,
            ));
        }
    }
    compare::assert_measurements_agree("mirrored instance", &measured, &comparison);
}

/// A speck far away makes the disk that rays from infinity start on several times as wide: more
/// variance, the same mean.
#[test]
fn a_larger_scene_changes_no_light_at_infinity() {
    let world = |directional: bool, speck: bool| {
        let mut room = Room::open(grey());
        if directional {
            room.light(
                DirectionalLight::new(v(0.3, 0.5, -1.0), Rgb::new(1.0, 2.0, 3.0)).expect("valid"),
            );
        } else {
            room.environment(sky(Lookup::PiecewiseConstant));
        }
        if speck {
            room.quad(v(3.0, 4.0, 4.0), v(1e-6, 0.0, 0.0), v(0.0, 1e-6, 0.0), black());
        }
        room.build()
    };
    let team = Team::new(Depth::up_to(2)).bidirectional().light();
    // The light tracer hits the room with few rays.
    let comparison = Comparison { target: 0.004, ..Comparison::default() };
    for directional in [true, false] {
        let mut measured = Vec::new();
        for speck in [false, true] {
            for (name, integrator) in team.named() {
                let name = format!("{name}{}", if speck { ", speck" } else { "" });
                measured.push(measure(
                    &world(directional, speck),
                    &camera(),
                    (&name, integrator),
                    &comparison,
                ));
            }
        }
        compare::assert_measurements_agree("larger scene", &measured, &comparison);
    }
}
