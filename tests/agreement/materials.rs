//! Each material, smooth normals, and hard geometry.

use crate::rooms::{Room, lambert, v};
use crate::team::{THREE, Team, black, grey, metal};
use glam::{DAffine3, DVec2, DVec3};
use pathspace::endpoint::ConstantEnvironment;
use pathspace::geometry::Sphere;
use pathspace::integrator::{Bidirectional, Depth};
use pathspace::material::Texture;
use pathspace::math::Rgb;
use pathspace::path::TechniqueSet;
use pathspace::scene::{Material, Mesh};

/// A mirror that the camera does not see lights the floor: paths light – mirror – floor – lens.
#[test]
fn mirror_beside_the_floor() {
    let mut room = Room::open(grey());
    room.lamp(0.5, 4.0);
    // Leans over the room from the front, below the camera's view, its front towards the back wall.
    room.quad(
        v(-1.0, -1.2, -0.1),
        v(2.0, 0.0, 0.0),
        v(0.0, -0.3, 0.45),
        Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) },
    );
    Team::with_light(THREE).general().agree("mirror", room);
}

/// A mirror in view: light tracing cannot see it, the others must agree all the same.
#[test]
fn mirror_in_view() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 4.0);
    room.sphere(
        Sphere::new(v(0.4, -0.2, 1.1), 0.3),
        Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) },
    );
    let general = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    Team::standard(Depth::up_to(4))
        .with(
            "general, s < 2",
            Bidirectional {
                techniques: general,
                depth: Depth::up_to(4),
                ..Bidirectional::default()
            },
        )
        .agree_within(0.004, "mirror in view", room);
}

/// A glass pane between the lamp and all the rest, not seen by the camera.
#[test]
fn glass_pane_under_the_lamp() {
    let mut room = Room::open(grey());
    room.lamp(0.8, 4.0);
    let glass = || Material::Dielectric { relative_ior: 1.5 };
    room.quad(v(-1.0, -1.0, 1.85), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), glass());
    room.quad(v(-1.0, -1.0, 1.80), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0), glass());
    Team::with_light(Depth::up_to(4)).agree_within(0.004, "glass pane", room);
}

/// One interface only: the lamp is inside glass and the room is not, so n² does not cancel.
#[test]
fn lamp_inside_glass() {
    let mut room = Room::open(grey());
    room.lamp(0.8, 4.0);
    room.quad(
        v(-2.0, -2.0, 1.85),
        v(0.0, 4.0, 0.0),
        v(4.0, 0.0, 0.0),
        Material::Dielectric { relative_ior: 1.5 },
    );
    Team::with_light(THREE).balance().general().agree_within(0.004, "lamp inside glass", room);
}

/// A glass ball in front of a large lamp: caustics that path tracing finds by chance.
#[test]
fn glass_ball_before_the_lamp() {
    let mut room = Room::open(grey());
    room.lamp(0.95, 3.0);
    room.sphere(Sphere::new(v(0.2, 0.1, 1.76), 0.2), Material::Dielectric { relative_ior: 1.5 });
    Team::with_light(THREE).agree_within(0.004, "glass ball", room);
}

/// The room is under water and the camera is in it, seen through no interface; the lamp is above.
#[test]
fn camera_and_room_inside_a_medium() {
    let mut room = Room::open(grey());
    room.lamp(0.8, 4.0);
    room.quad(
        v(-9.0, -9.0, 1.85),
        v(18.0, 0.0, 0.0),
        v(0.0, 18.0, 0.0),
        Material::Dielectric { relative_ior: 1.33 },
    );
    Team::with_light(THREE).agree_within(0.004, "under water", room);
}

#[test]
fn rough_conductor() {
    let mut room = Room::closed_above(metal(0.2, 0.2));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).balance().agree("rough conductor", room);
}

#[test]
fn anisotropic_conductor() {
    let mut room = Room::closed_above(metal(0.1, 0.5));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).agree("anisotropic conductor", room);
}

fn frosted(relative_ior: f64) -> Material {
    Material::RoughDielectric { relative_ior, alpha: DVec2::splat(0.5) }
}

/// Frosted glass over the whole opening: everything is lit through it, from the denser side.
#[test]
fn lamp_inside_rough_glass() {
    let mut room = Room::open(grey());
    room.lamp(0.8, 4.0);
    room.quad(v(-2.0, -2.0, 1.85), v(0.0, 4.0, 0.0), v(4.0, 0.0, 0.0), frosted(1.5));
    Team::with_light(THREE).general().agree("lamp inside rough glass", room);
}

/// Frosted glass in view, its far side lit: connections across the interface.
#[test]
#[ignore = "takes long"]
fn rough_glass_in_view() {
    let mut room = Room::open(grey());
    room.lamp(0.9, 2.0);
    room.quad(v(-0.9, -0.5, 0.4), v(1.8, 0.0, 0.0), v(0.0, 0.3, 1.2), frosted(1.5));
    Team::with_light(Depth::up_to(2)).balance().agree("rough glass in view", room);
}

#[test]
fn rough_glass_ball() {
    let mut room = Room::open(grey());
    room.lamp(0.8, 4.0);
    room.sphere(Sphere::new(v(0.3, -0.2, 1.1), 0.4), frosted(1.5));
    Team::with_light(THREE).agree("rough glass ball", room);
}

fn mixture(other: Material, weights: [f64; 2]) -> Material {
    Material::Mixture { components: Box::new([lambert(0.7, 0.6, 0.5), other]), weights }
}

/// Seen directly, a mirror in a mixture shows the room to path tracing and nothing to light
/// tracing; so it is out of view, lighting the floor.
#[test]
fn mixture_with_a_mirror() {
    let mut room = Room::open(grey());
    room.lamp(0.5, 4.0);
    let coat = mixture(Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) }, [0.5, 0.5]);
    room.quad(v(-1.0, -1.2, -0.1), v(2.0, 0.0, 0.0), v(0.0, -0.3, 0.45), coat);
    Team::with_light(THREE).balance().agree("mixture with a mirror", room);
}

#[test]
fn mixture_with_a_mirror_in_view() {
    let mut room = Room::closed_above(mixture(
        Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) },
        [0.6, 0.3],
    ));
    room.lamp(0.5, 4.0);
    Team::standard(THREE).agree("mixture in view", room);
}

#[test]
fn mixture_with_a_rough_conductor() {
    let mut room = Room::closed_above(mixture(metal(0.2, 0.2), [0.5, 0.4]));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).agree("mixture with metal", room);
}

/// A null interface is a scattering event and nothing else: every path through it is one event
/// longer.
#[test]
fn null_interface() {
    let mut room = Room::open(grey());
    room.lamp(0.8, 4.0);
    room.quad(v(-2.0, -2.0, 1.85), v(0.0, 4.0, 0.0), v(4.0, 0.0, 0.0), Material::Null);
    Team::with_light(THREE).agree("null", room);
}

/// Vertex normals on a coarse sphere, lit from the side: the two normals differ by up to 37°.
fn smooth_room(material: Material) -> Room {
    let mut room = Room::default();
    let sphere = Mesh::icosphere(1);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.7),
        glam::DQuat::IDENTITY,
        v(0.0, 0.0, 0.8),
    );
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, material);
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), lambert(0.6, 0.5, 0.4));
    let lamp = room.quad(v(2.0, -1.5, 0.3), v(0.0, 0.0, 1.2), v(0.0, 1.2, 0.0), black());
    room.emit(lamp, Rgb::new(10.0, 8.0, 6.0), false);
    room
}

#[test]
fn smooth_normals() {
    Team::with_light(THREE)
        .balance()
        .general()
        .agree("smooth normals", smooth_room(lambert(0.8, 0.7, 0.6)));
}

/// Hits sample the shading cosine and connections evaluate it: each alone must find the same, as
/// must a light tracer.
#[test]
fn smooth_normals_under_an_environment() {
    let mut room = Room::default();
    let sphere = Mesh::icosphere(0);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(1.2),
        glam::DQuat::IDENTITY,
        v(0.0, 0.0, 0.7),
    );
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, lambert(0.8, 0.7, 0.6));
    room.environment(ConstantEnvironment::new(Rgb::new(0.5, 0.7, 1.0)).expect("valid"));
    Team::with_light(Depth::exactly(1))
        .emission_only()
        .next_event_only()
        .agree("smooth normals, environment", room);
}

/// Light from the sphere to the floor and back: the walk's own factor.
#[test]
fn two_bounces_on_smooth_normals() {
    let mut room = smooth_room(lambert(0.8, 0.7, 0.6));
    let sphere = Mesh::icosphere(0);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.4),
        glam::DQuat::IDENTITY,
        v(1.1, 0.3, 0.6),
    );
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, lambert(0.8, 0.7, 0.6));
    Team::new(Depth::exactly(2)).path().light().agree_within(
        0.004,
        "two bounces on smooth normals",
        room,
    );
}

#[test]
fn smooth_normals_on_metal() {
    Team::with_light(Depth::up_to(2)).agree("smooth metal", smooth_room(metal(0.5, 0.5)));
}

/// Smooth normals at a Dirac vertex: the lens of glass is not seen by the camera but lights the
/// floor.
#[test]
fn smooth_normals_on_glass() {
    let mut room = Room::open(grey());
    room.lamp(0.95, 3.0);
    let sphere = Mesh::icosphere(1);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.2),
        glam::DQuat::IDENTITY,
        v(0.2, 0.1, 1.76),
    );
    room.mesh(
        &Mesh { normals: Some(normals), ..sphere },
        transform,
        Material::Dielectric { relative_ior: 1.5 },
    );
    Team::with_light(THREE).agree_within(0.004, "smooth glass", room);
}

/// Two planes a millionth apart, light and camera on opposite sides of nothing but the gap's rim,
/// and corners where 1/r² is unbounded.
#[test]
fn corners_and_thin_gaps() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 4.0);
    room.quad(v(-0.8, -0.8, 1e-6), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), lambert(0.9, 0.9, 0.9));
    room.quad(v(-0.6, 0.9, 0.0), v(0.4, 0.1, 0.0), v(0.0, 0.0, 0.7), lambert(0.9, 0.9, 0.9));
    Team::with_light(Depth::up_to(4)).agree("corners and gaps", room);
}

/// Clear coats, smooth and rough in stripes, over diffuse and metallic surfaces.
#[test]
fn clear_coats() {
    let board = |a: Rgb, b: Rgb| Texture::checkerboard(a, b);
    let coated = |base_color: Rgb, [roughness, metalness]: [f64; 2]| Material::Coated {
        base_color: base_color.into(),
        metallic_roughness: Rgb::new(0.0, roughness, metalness).into(),
        relative_ior: 1.5,
        coat: Box::new([
            board(Rgb::WHITE, Rgb::new(0.4, 0.0, 0.0)),
            board(Rgb::new(0.0, 0.3, 0.0), Rgb::new(0.0, 0.7, 0.0)),
        ]),
    };
    let mut room = Room::open(coated(Rgb::splat(0.5), [1.0, 0.0]));
    room.lamp(0.5, 4.0);
    let metal = coated(Rgb::new(0.9, 0.6, 0.3), [0.5, 0.5]);
    room.sphere(Sphere::new(v(0.3, -0.1, 0.5), 0.35), metal);
    Team::with_light(THREE).balance().general().agree("clear coats", room);
}
