//! All integrators estimate the same image: each kind of light, material, camera, filter and limit, in tiny scenes; and the exact answers that
//! they must not merely agree on. `analytic.json` entries are named by their ids.
//!
//! `cargo test --release --test agreement -- --nocapture --test-threads 1` prints the numbers.

#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "common/rooms.rs"]
mod rooms;

use compare::{Comparison, Named, assert_agree, measure};
use glam::{DAffine3, DMat3, DVec2, DVec3, UVec2};
use pathspace::endpoint::{ConstantEnvironment, DirectionalLight, EnvironmentMap, Lookup, PointLight, SpotLight};
use pathspace::film::{Filter, Technique};
use pathspace::geometry::Sphere;
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer, PathTracing, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, Roulette, Survival, TechniqueSet};
use pathspace::render::Render;
use pathspace::scene::{Material, Mesh, World};
use rooms::{Room, camera, lambert, lens_camera, parallel_camera, v};

// Integrators ---------------------------------------------------------------------------------------------------------------------------

/// The integrators of a test, with the depth that they share.
struct Team {
    depth: Depth,
    members: Vec<(&'static str, Box<dyn Render<World>>)>,
}

impl Team {
    fn new(depth: Depth) -> Self {
        Self { depth, members: Vec::new() }
    }

    fn with(mut self, name: &'static str, integrator: impl Render<World> + 'static) -> Self {
        self.members.push((name, Box::new(integrator)));
        self
    }

    /// Path tracing and bidirectional path tracing, which see everything but Dirac lights through Dirac lobes.
    fn standard(depth: Depth) -> Self {
        Self::new(depth).path().bidirectional().balance()
    }

    /// And light tracing.
    fn with_light(depth: Depth) -> Self {
        Self::standard(depth).light()
    }

    fn path(self) -> Self {
        let depth = self.depth;
        self.with("path", PathTracer { depth, ..PathTracer::default() })
    }

    fn emission_only(self) -> Self {
        let depth = self.depth;
        self.with("path, emission only", PathTracer { mode: PathTracing::EmissionOnly, depth, ..PathTracer::default() })
    }

    fn next_event_only(self) -> Self {
        let depth = self.depth;
        self.with("path, next event only", PathTracer { mode: PathTracing::NextEventOnly, depth, ..PathTracer::default() })
    }

    fn light(self) -> Self {
        let depth = self.depth;
        self.with("light", LightTracer { depth, ..LightTracer::default() })
    }

    fn uniform(self) -> Self {
        let depth = self.depth;
        self.with("uniform area", UniformArea { depth, ..UniformArea::default() })
    }

    fn bidirectional(self) -> Self {
        let depth = self.depth;
        self.with("bidirectional, power", Bidirectional { depth, ..Bidirectional::default() })
    }

    fn balance(self) -> Self {
        let depth = self.depth;
        self.with("bidirectional, balance", Bidirectional { depth, heuristic: Heuristic::Balance, ..Bidirectional::default() })
    }

    /// The general kernel with the techniques of the path tracer, and with those of the light tracer.
    fn general(self) -> Self {
        let depth = self.depth;
        let path = TechniqueSet { emitter_hits: true, emitter_sampling: true, ..TechniqueSet::NONE };
        let light = TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE };
        self.with("general, s < 2", Bidirectional { techniques: path, depth, ..Bidirectional::default() })
            .with("general, t = 1", Bidirectional { techniques: light, depth, ..Bidirectional::default() })
    }

    fn named(&self) -> Vec<Named<'_>> {
        self.members.iter().map(|(name, integrator)| (*name, integrator.as_ref())).collect()
    }

    fn agree(&self, case: &str, room: Room) {
        self.agree_within(0.0025, case, room);
    }

    fn agree_within(&self, target: f64, case: &str, room: Room) {
        assert_agree(case, &room.build(), &camera(), &self.named(), &Comparison { target, ..Comparison::default() });
    }
}

const THREE: Depth = Depth::up_to(3);

fn grey() -> Material {
    lambert(0.5, 0.5, 0.5)
}

fn black() -> Material {
    Material::Black
}

// Lights --------------------------------------------------------------------------------------------------------------------------------

#[test]
fn quad_light() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.4, 8.0);
    Team::with_light(THREE).general().next_event_only().agree("quad light", room);
}

/// A light large enough to be hit by chance, for the techniques that know nothing of it.
#[test]
fn large_quad_light() {
    let mut room = Room::open(grey());
    room.lamp(0.95, 2.0);
    Team::with_light(Depth::up_to(2)).emission_only().uniform().agree("large quad light", room);
}

#[test]
fn mesh_light() {
    let mut room = Room::closed_above(grey());
    let transform = DAffine3::from_scale_rotation_translation(v(0.25, 0.2, 0.1), glam::DQuat::from_rotation_y(0.5), v(0.1, 0.2, 1.6));
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
    let zone = Sphere { axis: v(0.0, 0.1, 1.0), cos_min: 0.2, cos_max: 0.95, inward: true, ..Sphere::new(v(0.0, 0.0, 1.2), 0.9) };
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
    room.light(SpotLight::new(v(0.6, -0.6, 1.7), v(-0.5, 0.5, -1.0), Rgb::new(4.0, 3.0, 2.0), 15.0, 40.0).expect("valid"));
    Team::with_light(THREE).next_event_only().agree("spot light", room);
}

#[test]
fn directional_light() {
    let mut room = Room::open(grey());
    room.light(DirectionalLight::new(v(0.3, 0.5, -1.0), Rgb::new(1.0, 2.0, 3.0)).expect("valid"));
    Team::with_light(THREE).next_event_only().agree("directional light", room);
}

#[test]
fn constant_environment() {
    let mut room = Room::open(grey());
    room.environment(ConstantEnvironment::new(Rgb::new(0.5, 0.7, 1.0)).expect("valid"));
    Team::with_light(THREE).emission_only().agree("constant environment", room);
}

/// An environment in view, with the blocker in front of it: s = 0 and (1, 1) draw the paths of one edge.
#[test]
fn environment_seen_directly() {
    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), grey());
    room.sphere(Sphere::new(v(0.2, 0.0, 0.8), 0.3), lambert(0.7, 0.5, 0.3));
    room.environment(sky(Lookup::PiecewiseConstant));
    let (world, team) = (room.build(), Team::with_light(Depth::up_to(1)));
    assert_agree("environment in view, pinhole", &world, &camera(), &team.named(), &Comparison::default());
    assert_agree("environment in view, thin lens", &world, &lens_camera(), &team.named(), &Comparison::default());
}

fn sky(lookup: Lookup) -> EnvironmentMap {
    // A dim sky with a colour gradient, black ground, and a hot spot.
    let pixel = |i: u32| match (i % 16, i / 16) {
        (7, 1) => Rgb::new(15.0, 12.0, 8.0),
        (x, y) if y < 5 => Rgb::new(0.2 + 0.05 * f64::from(x), 0.5, 0.1 * f64::from(y)),
        _ => Rgb::BLACK,
    };
    EnvironmentMap::new(16, 8, (0..128).map(pixel).collect(), EnvironmentMap::Z_UP).expect("valid").with_lookup(lookup)
}

#[test]
fn environment_map() {
    let mut room = Room::open(grey());
    room.environment(sky(Lookup::PiecewiseConstant));
    Team::with_light(THREE).agree("environment map", room);
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

/// The faint light is the only one that the camera's half of the scene sees, so that no other hides an error in its probability.
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

/// A mirrored instance emits on the side of its front, as a mesh whose vertices are mirrored and whose winding is reversed does.
#[test]
fn mirrored_instance() {
    let tetrahedron = |sign: f64, reverse: bool| {
        let positions = [v(0.0, 0.0, 0.0), v(0.5, 0.0, 0.1), v(0.1, 0.6, 0.0), v(0.1, 0.1, 0.4)].map(|p| v(sign * p.x, p.y, p.z)).to_vec();
        let indices = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|[a, b, c]| if reverse { [a, c, b] } else { [a, b, c] }).to_vec();
        Mesh { positions, indices, ..Mesh::default() }
    };
    let world = |mesh: Mesh, x: f64| {
        let mut room = Room::closed_above(grey());
        let transform = DAffine3 { matrix3: DMat3::from_diagonal(v(x, 1.0, 1.0)), translation: v(0.2, -0.2, 1.2) };
        let mesh = room.mesh(&mesh, transform, grey());
        room.emit(mesh, Rgb::new(3.0, 4.0, 5.0), false);
        room.build()
    };
    let team = Team::new(Depth::up_to(2)).path().light().bidirectional();
    let comparison = Comparison::default();
    let worlds = [("instance", world(tetrahedron(1.0, false), -1.0)), ("vertices", world(tetrahedron(-1.0, true), 1.0))];
    let mut measured = Vec::new();
    for (label, world) in &worlds {
        for (name, integrator) in team.named() {
            measured.push(measure(world, &camera(), (&format!("{name}, {label}"), integrator), &comparison));
        }
    }
    compare::assert_measurements_agree("mirrored instance", &measured, &comparison);
}

/// A speck far away makes the disk that rays from infinity start on ten times as wide: more variance, the same mean.
#[test]
fn a_larger_scene_changes_no_light_at_infinity() {
    let world = |directional: bool, speck: bool| {
        let mut room = Room::open(grey());
        if directional {
            room.light(DirectionalLight::new(v(0.3, 0.5, -1.0), Rgb::new(1.0, 2.0, 3.0)).expect("valid"));
        } else {
            room.environment(sky(Lookup::PiecewiseConstant));
        }
        if speck {
            room.quad(v(7.0, 9.0, 9.0), v(1e-6, 0.0, 0.0), v(0.0, 1e-6, 0.0), black());
        }
        room.build()
    };
    let team = Team::new(Depth::up_to(2)).bidirectional().light();
    // The light tracer hits the room with one ray in thirty.
    let comparison = Comparison { target: 0.004, ..Comparison::default() };
    for directional in [true, false] {
        let mut measured = Vec::new();
        for speck in [false, true] {
            for (name, integrator) in team.named() {
                let name = format!("{name}{}", if speck { ", speck" } else { "" });
                measured.push(measure(&world(directional, speck), &camera(), (&name, integrator), &comparison));
            }
        }
        compare::assert_measurements_agree("larger scene", &measured, &comparison);
    }
}

// Materials -----------------------------------------------------------------------------------------------------------------------------

/// A mirror that the camera does not see lights the floor: paths light – mirror – floor – lens.
#[test]
fn mirror_beside_the_floor() {
    let mut room = Room::open(grey());
    room.lamp(0.5, 4.0);
    // Leans over the room from the front, below the camera's view, its front towards the back wall.
    room.quad(v(-1.0, -1.2, -0.1), v(2.0, 0.0, 0.0), v(0.0, -0.3, 0.45), Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) });
    Team::with_light(THREE).general().agree("mirror", room);
}

/// A mirror in view: light tracing cannot see it, the others must agree all the same.
#[test]
fn mirror_in_view() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 4.0);
    room.sphere(Sphere::new(v(0.4, -0.2, 1.1), 0.3), Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) });
    let general = TechniqueSet { emitter_hits: true, emitter_sampling: true, ..TechniqueSet::NONE };
    Team::standard(Depth::up_to(4))
        .with("general, s < 2", Bidirectional { techniques: general, depth: Depth::up_to(4), ..Bidirectional::default() })
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
    room.quad(v(-2.0, -2.0, 1.85), v(0.0, 4.0, 0.0), v(4.0, 0.0, 0.0), Material::Dielectric { relative_ior: 1.5 });
    Team::with_light(THREE).general().agree_within(0.004, "lamp inside glass", room);
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
    room.quad(v(-9.0, -9.0, 1.85), v(18.0, 0.0, 0.0), v(0.0, 18.0, 0.0), Material::Dielectric { relative_ior: 1.33 });
    Team::with_light(THREE).agree_within(0.004, "under water", room);
}

fn metal(x: f64, y: f64) -> Material {
    Material::RoughConductor { eta: Rgb::new(0.2, 0.9, 1.2), k: Rgb::new(3.9, 2.5, 2.2), alpha: DVec2::new(x, y) }
}

#[test]
fn rough_conductor() {
    let mut room = Room::closed_above(metal(0.2, 0.2));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).agree("rough conductor", room);
}

#[test]
fn anisotropic_conductor() {
    let mut room = Room::closed_above(metal(0.1, 0.5));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).agree("anisotropic conductor", room);
}

fn frosted(relative_ior: f64) -> Material {
    Material::RoughDielectric { relative_ior, alpha: DVec2::splat(0.3) }
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
fn rough_glass_in_view() {
    let mut room = Room::open(grey());
    room.lamp(0.5, 4.0);
    room.quad(v(-0.9, -0.5, 0.4), v(1.8, 0.0, 0.0), v(0.0, 0.3, 1.2), frosted(1.5));
    Team::with_light(THREE).agree("rough glass in view", room);
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

/// Seen directly, a mirror in a mixture shows the room to path tracing and nothing to light tracing; so it is out of view, lighting the floor.
#[test]
fn mixture_with_a_mirror() {
    let mut room = Room::open(grey());
    room.lamp(0.5, 4.0);
    let coat = mixture(Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) }, [0.5, 0.5]);
    room.quad(v(-1.0, -1.2, -0.1), v(2.0, 0.0, 0.0), v(0.0, -0.3, 0.45), coat);
    Team::with_light(THREE).agree("mixture with a mirror", room);
}

#[test]
fn mixture_with_a_mirror_in_view() {
    let mut room = Room::closed_above(mixture(Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) }, [0.6, 0.3]));
    room.lamp(0.5, 4.0);
    Team::standard(THREE).agree("mixture in view", room);
}

#[test]
fn mixture_with_a_rough_conductor() {
    let mut room = Room::closed_above(mixture(metal(0.2, 0.2), [0.5, 0.4]));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).agree("mixture with metal", room);
}

/// A null interface is a scattering event and nothing else: every path through it is one event longer.
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
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(0.7), glam::DQuat::IDENTITY, v(0.0, 0.0, 0.8));
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, material);
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), lambert(0.6, 0.5, 0.4));
    let lamp = room.quad(v(2.0, -1.5, 0.3), v(0.0, 0.0, 1.2), v(0.0, 1.2, 0.0), black());
    room.emit(lamp, Rgb::new(10.0, 8.0, 6.0), false);
    room
}

#[test]
fn smooth_normals() {
    Team::with_light(THREE).general().agree("smooth normals", smooth_room(lambert(0.8, 0.7, 0.6)));
}

/// Hits sample the shading cosine and connections evaluate it: each alone must find the same, as must a light tracer.
#[test]
fn smooth_normals_under_an_environment() {
    let mut room = Room::default();
    let sphere = Mesh::icosphere(0);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(1.2), glam::DQuat::IDENTITY, v(0.0, 0.0, 0.7));
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, lambert(0.8, 0.7, 0.6));
    room.environment(ConstantEnvironment::new(Rgb::new(0.5, 0.7, 1.0)).expect("valid"));
    Team::with_light(Depth::exactly(1)).emission_only().next_event_only().agree("smooth normals, environment", room);
}

/// Light from the sphere to the floor and back: the walk's own factor.
#[test]
fn two_bounces_on_smooth_normals() {
    let mut room = smooth_room(lambert(0.8, 0.7, 0.6));
    let sphere = Mesh::icosphere(0);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(0.4), glam::DQuat::IDENTITY, v(1.1, 0.3, 0.6));
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, lambert(0.8, 0.7, 0.6));
    Team::new(Depth::exactly(2)).path().light().agree_within(0.004, "two bounces on smooth normals", room);
}

#[test]
fn smooth_normals_on_metal() {
    Team::with_light(Depth::up_to(2)).agree("smooth metal", smooth_room(metal(0.3, 0.3)));
}

/// Smooth normals at a Dirac vertex: the lens of glass is not seen by the camera but lights the floor.
#[test]
fn smooth_normals_on_glass() {
    let mut room = Room::open(grey());
    room.lamp(0.95, 3.0);
    let sphere = Mesh::icosphere(1);
    let normals = sphere.positions.clone();
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(0.2), glam::DQuat::IDENTITY, v(0.2, 0.1, 1.76));
    room.mesh(&Mesh { normals: Some(normals), ..sphere }, transform, Material::Dielectric { relative_ior: 1.5 });
    Team::with_light(THREE).agree_within(0.004, "smooth glass", room);
}

// Cameras and filters -------------------------------------------------------------------------------------------------------------------

fn lit_room() -> World {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 4.0);
    room.build()
}

#[test]
fn thin_lens() {
    let team = Team::with_light(Depth::up_to(2)).general();
    assert_agree("thin lens", &lit_room(), &lens_camera(), &team.named(), &Comparison::default());
}

#[test]
fn orthographic() {
    let team = Team::with_light(Depth::up_to(2)).general();
    assert_agree("orthographic", &lit_room(), &parallel_camera(), &team.named(), &Comparison::default());
}

/// Both ends at infinity: no technique may join them directly.
#[test]
fn orthographic_under_an_environment() {
    let mut room = Room::open(grey());
    room.environment(sky(Lookup::PiecewiseConstant));
    let team = Team::with_light(Depth::up_to(2));
    assert_agree("orthographic, environment", &room.build(), &parallel_camera(), &team.named(), &Comparison::default());
}

/// The border pixels are blocks of their own in the comparison; light tracing must splat what is outside of the film into it.
#[test]
fn filters() {
    let team = Team::new(Depth::up_to(1)).path().light().bidirectional();
    let world = lit_room();
    for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { standard_deviation: 0.9 }] {
        let comparison = Comparison { filter, ..Comparison::default() };
        assert_agree(&format!("{filter:?}"), &world, &camera(), &team.named(), &comparison);
    }
}

/// A lamp seen directly, whose sharp edges the filter moves by half a block.
#[test]
fn filters_blur_alike() {
    let mut room = Room::default();
    let lamp = room.quad(v(-0.3, 0.0, 0.3), v(0.5, 0.0, 0.0), v(0.0, 0.0, 0.6), black());
    room.emit(lamp, Rgb::WHITE, false);
    let (world, team) = (room.build(), Team::with_light(Depth::up_to(0)));
    for filter in [Filter::Tent, Filter::Gaussian { standard_deviation: 1.5 }] {
        assert_agree(&format!("{filter:?}"), &world, &camera(), &team.named(), &Comparison { filter, ..Comparison::default() });
    }
}

/// A rendering of a window is the same part of the whole image, for every camera.
#[test]
fn crop_windows() {
    let world = lit_room();
    let (min, max) = (UVec2::new(4, 8), UVec2::new(12, 16));
    let comparison = Comparison { filter: Filter::Tent, target: 0.0025, ..Comparison::default() };
    let team = Team::new(Depth::up_to(1)).path().light().bidirectional();
    let crop = |m: compare::Measured| compare::Measured {
        images: m.images.iter().map(|image| image.crop(min.to_array(), max.to_array()).expect("inside")).collect(),
        ..m
    };
    let window = |whole: &dyn pathspace::endpoint::Camera, part: &dyn pathspace::endpoint::Camera, case: &str| {
        let mut measured: Vec<_> = team.named().into_iter().map(|i| measure(&world, part, i, &comparison)).collect();
        let finer = Comparison { target: 0.001, ..comparison };
        measured.push(crop(measure(&world, whole, ("path, whole film", &PathTracer::up_to(1)), &finer)));
        compare::assert_measurements_agree(case, &measured, &comparison);
    };
    window(&camera(), &camera().with_window(min, max).expect("inside"), "crop, pinhole");
    window(&lens_camera(), &lens_camera().with_window(min, max).expect("inside"), "crop, thin lens");
    window(&parallel_camera(), &parallel_camera().with_window(min, max).expect("inside"), "crop, orthographic");
}

// Depth, roulette, sets of techniques -----------------------------------------------------------------------------------------------------

/// The images of exactly 0, 1, 2 and 3 bounces sum to that of up to 3, for each integrator.
#[test]
fn bounces_add_up() {
    let world = lit_room();
    let comparison = Comparison { target: 0.004, ..Comparison::default() };
    type Make = fn(Depth) -> Box<dyn Render<World>>;
    let makers: [(&str, Make); 4] = [
        ("path", |depth| Box::new(PathTracer { depth, ..PathTracer::default() })),
        ("light", |depth| Box::new(LightTracer { depth, ..LightTracer::default() })),
        ("bidirectional", |depth| Box::new(Bidirectional { depth, ..Bidirectional::default() })),
        ("uniform area", |depth| Box::new(UniformArea { depth, ..UniformArea::default() })),
    ];
    for (name, make) in makers {
        let limit = if name == "uniform area" { 1 } else { 3 };
        let whole = make(Depth::up_to(limit));
        let whole = measure(&world, &camera(), (&format!("{name}, up to {limit}"), &*whole), &comparison);
        let parts: Vec<_> = (0..=limit)
            .map(|k| measure(&world, &camera(), (&format!("{name}, exactly {k}"), &*make(Depth::exactly(k))), &comparison))
            .collect();
        let mut sum = parts[0].images.clone();
        for (i, image) in sum.iter_mut().enumerate() {
            for (j, pixel) in image.pixels_mut().iter_mut().enumerate() {
                *pixel = parts.iter().map(|part| part.images[i].pixels()[j]).sum();
            }
        }
        let sum = compare::Measured { name: format!("{name}, sum"), images: sum, samples_per_pixel: 0 };
        compare::assert_measurements_agree(name, &[whole, sum], &comparison);
    }
}

/// Without a limit and with roulette: the same as a limit so deep that nothing is left.
#[test]
fn roulette_replaces_a_deep_limit() {
    let world = lit_room();
    let deep = Depth::up_to(24);
    let harsh = Roulette { start: 0, survival: Survival::Fixed(0.8), ..Roulette::default() };
    let early = Roulette { start: 0, ..Roulette::default() };
    let team = Team::new(Depth::default())
        .path()
        .light()
        .bidirectional()
        .with("path, early roulette", PathTracer { roulette: early, ..PathTracer::default() })
        .with("light, fixed survival", LightTracer { roulette: harsh, ..LightTracer::default() })
        .with("bidirectional, fixed", Bidirectional { roulette: harsh, ..Bidirectional::default() })
        .with("path, 24 bounces", PathTracer { depth: deep, roulette: Roulette::NEVER, ..PathTracer::default() });
    assert_agree("roulette", &world, &camera(), &team.named(), &Comparison { target: 0.0025, ..Comparison::default() });
}

fn technique_world(floor: Material) -> World {
    let mut room = Room::default();
    // Surfaces do not touch, so that 1/r² of a connection has a finite variance.
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), floor.clone());
    room.quad(v(-0.8, 1.2, 0.4), v(1.6, 0.0, 0.0), v(0.1, 0.2, 1.2), floor);
    room.lamp(0.9, 2.0);
    room.build()
}

/// Every (s, t) alone and unweighted has the mean of path tracing at this path length.
fn techniques_alone(case: &str, world: &World, bounces: u32, comparison: &Comparison) {
    let depth = Depth::exactly(bounces);
    let only = |s: u16| {
        let only = Some(Technique { s, t: bounces as u16 + 2 - s });
        Bidirectional { techniques: TechniqueSet { only, ..TechniqueSet::BIDIRECTIONAL }, depth, ..Bidirectional::default() }
    };
    let alone: Vec<(String, Bidirectional)> =
        (0..=bounces as u16 + 1).map(|s| (format!("only ({s}, {})", bounces as u16 + 2 - s), only(s))).collect();
    let path = PathTracer { depth, ..PathTracer::default() };
    let mut team: Vec<Named<'_>> = vec![("path", &path)];
    team.extend(alone.iter().map(|(name, integrator)| (name.as_str(), integrator as &dyn Render<World>)));
    assert_agree(&format!("{case}, {bounces} bounces"), world, &camera(), &team, comparison);
}

#[test]
fn each_technique_alone() {
    let world = technique_world(grey());
    techniques_alone("Lambert", &world, 1, &Comparison::default());
    techniques_alone("Lambert", &world, 2, &Comparison { target: 0.005, ..Comparison::default() });
}

#[test]
fn each_technique_alone_on_metal() {
    let world = technique_world(metal(0.3, 0.3));
    techniques_alone("metal", &world, 1, &Comparison { target: 0.003, ..Comparison::default() });
    techniques_alone("metal", &world, 2, &Comparison { target: 0.006, ..Comparison::default() });
}

#[test]
#[ignore = "the same with longer paths"]
fn each_technique_alone_with_three_bounces() {
    for material in [grey(), metal(0.3, 0.3)] {
        techniques_alone(
            "three bounces",
            &technique_world(material),
            3,
            &Comparison { target: 0.006, most: 20_000, ..Comparison::default() },
        );
    }
}

/// Removing any one technique leaves the mean: the weights of the others fill the gap.
#[test]
fn without_any_one_technique() {
    let world = technique_world(metal(0.3, 0.3));
    for bounces in 1..=2u16 {
        let depth = Depth::exactly(u32::from(bounces));
        let without = |s| {
            let without = Some(Technique { s, t: bounces + 2 - s });
            Bidirectional { techniques: TechniqueSet { without, ..TechniqueSet::BIDIRECTIONAL }, depth, ..Bidirectional::default() }
        };
        let sets: Vec<(String, Bidirectional)> = (0..=bounces + 1).map(|s| (format!("without s = {s}"), without(s))).collect();
        let path = PathTracer { depth, ..PathTracer::default() };
        let mut team: Vec<Named<'_>> = vec![("path", &path)];
        team.extend(sets.iter().map(|(name, integrator)| (name.as_str(), integrator as &dyn Render<World>)));
        assert_agree(&format!("without one, {bounces} bounces"), &world, &camera(), &team, &Comparison::default());
    }
}

// Hard geometry -------------------------------------------------------------------------------------------------------------------------

/// Two planes a millionth apart, light and camera on opposite sides of nothing but the gap's rim, and corners where 1/r² is unbounded.
#[test]
fn corners_and_thin_gaps() {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 4.0);
    room.quad(v(-0.8, -0.8, 1e-6), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), lambert(0.9, 0.9, 0.9));
    room.quad(v(-0.6, 0.9, 0.0), v(0.4, 0.1, 0.0), v(0.0, 0.0, 0.7), lambert(0.9, 0.9, 0.9));
    Team::with_light(Depth::up_to(4)).agree("corners and gaps", room);
}
