//! Scenes with lights that are of no use to what the camera sees.

use crate::scenes::{Stage, cube, footprint_of, lambert};
use pathspace::endpoint::{
    Camera, ConstantEnvironment, DirectionalLight, EnvironmentMap, OrthographicCamera,
    PinholeCamera, PointLight, SpotLight,
};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::math::warp::square_to_sphere;
use pathspace::scene::{Material, Mesh, World};
use std::f64::consts::PI;

/// A scene with lights that are of no use, or of much less than others.
pub struct Scenario {
    pub world: World,
    /// The same without the lights, or the pebble, that are of no use; `None` if all are of use.
    pub alone: Option<World>,
    pub camera: Box<dyn Camera + Send>,
    pub depth: Depth,
}

/// A scenario and its place in the table.
pub struct Entry {
    pub row: &'static str,
    /// The quantity that is pushed.
    pub family: &'static str,
    /// Its value.
    pub value: f64,
    build: Box<dyn Fn() -> Scenario>,
}

impl Entry {
    /// Builds the scenario, which may take seconds.
    pub fn build(&self) -> Scenario {
        (self.build)()
    }
}

const FILM: UVec2 = UVec2::splat(12);
/// No light is looked at directly.
const DEPTH: Depth = Depth { min_bounces: 1, max_bounces: Some(3) };

/// The room [-1, 1]³ of albedo 0.5, with the ceiling's part y > 0 open or not.
fn add_room(stage: &mut Stage, at: DVec3, is_open: bool) {
    for (face, quad) in cube(at - DVec3::ONE, 2.0).into_iter().enumerate() {
        if is_open && face == 3 {
            let half = Quad { edge_u: 0.5 * quad.edge_u, ..quad };
            stage.face(half, lambert(0.5));
        } else {
            stage.face(quad, lambert(0.5));
        }
    }
}

/// A square that shines downwards (towards -y).
fn add_lamp(stage: &mut Stage, at: DVec3, half: f64, radiance: f64) {
    let (u, v) = (DVec3::X * (2.0 * half), DVec3::Z * (2.0 * half));
    let lamp = stage.quad(at - 0.5 * (u + v), u, v, Material::Black);
    stage.glow(lamp, radiance);
}

fn room_with_lamp() -> Stage {
    let mut stage = Stage::default();
    add_room(&mut stage, DVec3::ZERO, false);
    add_lamp(&mut stage, DVec3::Y * 0.95, 0.05, 100.0);
    stage
}

/// From one side of the room at `at` to the other.
fn eye(at: DVec3) -> PinholeCamera {
    let (position, target) = (at + DVec3::Z * 0.9, at - DVec3::Y * 0.2);
    PinholeCamera::new(position, target, DVec3::Y, 70.0, FILM).expect("valid")
}

fn sky(radiance: f64) -> ConstantEnvironment {
    ConstantEnvironment::new(Rgb::splat(radiance)).expect("valid")
}

fn point_light(at: DVec3, power: f64) -> PointLight {
    PointLight::new(at, Rgb::splat(power / (4.0 * PI))).expect("valid")
}

/// Direction i of n that are spread evenly.
fn spread(i: u32, n: u32) -> DVec3 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let u = DVec2::new((f64::from(i) + 0.5) / f64::from(n), (f64::from(i) * GOLDEN).fract());
    square_to_sphere(u)
}

fn scenario(stage: Stage, alone: Option<Stage>, camera: impl Camera + Send + 'static) -> Scenario {
    let (world, alone) = (stage.build(), alone.map(Stage::build));
    Scenario { world, alone, camera: Box::new(camera), depth: DEPTH }
}

pub fn all() -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut row = |row, family, values: &[f64], build: fn(f64) -> Scenario| {
        entries.extend(values.iter().map(|&value| {
            let build: Box<dyn Fn() -> Scenario> = Box::new(move || build(value));
            Entry { row, family, value, build }
        }));
    };
    row("S31", "power of a useless light", &[1e2, 1e4, 1e6], |ratio| {
        let stage = || {
            let mut stage = Stage::default();
            stage.square(0.0, 0.5, true, lambert(0.5));
            let lamp = stage.square(2.0, 1.0, false, Material::Black);
            stage.glow(lamp, 1.0);
            stage
        };
        let mut both = stage();
        let strong = both.square(3.0, 1.0, true, Material::Black);
        both.glow(strong, ratio);
        scenario(both, Some(stage()), footprint_of(FILM, DVec3::ZERO, 1.0, 0.25))
    });
    row("S76", "distance of a pebble beside a closed room", &[1e2, 1e3, 1e4, 1e6], |distance| {
        let mut stage = room_with_lamp();
        stage.environment(sky(0.05));
        stage.sphere(Sphere::new(DVec3::X * distance, 0.1), lambert(0.5));
        scenario(stage, Some(room_with_lamp()), eye(DVec3::ZERO))
    });
    row("S76", "distance of a pebble from a room with a window", &[1e2, 1e4, 1e6], |distance| {
        let stage = || {
            let mut stage = Stage::default();
            add_room(&mut stage, DVec3::ZERO, true);
            stage.environment(sky(1.0));
            stage
        };
        let mut both = stage();
        both.sphere(Sphere::new(DVec3::X * distance, 0.1), lambert(0.5));
        scenario(both, Some(stage()), eye(DVec3::ZERO))
    });
    for (kind, numbers, build) in HIDDEN {
        row("S77", kind, numbers, build);
    }
    row("S78", "decades of power over 25 lamps", &[6.0, 12.0, 24.0], |decades| {
        let mut stage = Stage::default();
        add_room(&mut stage, DVec3::ZERO, false);
        for i in 0..25 {
            // Neighbours differ by many decades.
            let power = LAMP * 10f64.powf(-decades * f64::from(i) / 24.0);
            let (x, z) = (f64::from(i * 7 % 25 % 5), f64::from(i * 7 % 25 / 5));
            stage.light(point_light(DVec3::new(x - 2.0, 2.0, z - 2.0) * 0.4, power));
        }
        scenario(stage, None, eye(DVec3::ZERO))
    });
    row("S79", "rooms with a lamp, one of them seen", &[10.0, 100.0], |rooms| {
        let stage = |lit| rooms_with_lamps(rooms as u32, lit, false);
        scenario(stage(rooms as u32), Some(stage(1)), eye(DVec3::ZERO))
    });
    row("S79", "rooms with a lamp, all of them seen", &[10.0, 100.0], |rooms| {
        let (position, target) = (DVec3::new(9.9, 30.0, 9.9), DVec3::new(9.9, 0.0, 9.9));
        let camera = OrthographicCamera::new(position, target, DVec3::Z, 22.0, FILM);
        let stage = rooms_with_lamps(rooms as u32, rooms as u32, true);
        scenario(stage, None, camera.expect("valid"))
    });
    row("S81", "lights around a ball", &[1e1, 1e3, 1e5], |lights| {
        let mut stage = Stage::default();
        stage.sphere(Sphere::new(DVec3::ZERO, 0.02), lambert(0.5));
        let lights = lights as u32;
        for i in 0..lights {
            // Uniform in the ball between the radii 0.05 and 0.5.
            let share = (f64::from(i) * 0.754_877_666_246_692_7).fract();
            let radius = (1.25e-4 + (0.125 - 1.25e-4) * share).cbrt();
            stage.light(point_light(radius * spread(i, lights), 1.0 / f64::from(lights)));
        }
        scenario(stage, None, footprint_of(FILM, DVec3::ZERO, 0.04, 0.02))
    });
    row("S82", "distance of two clusters of lights", &[1e2, 1e4, 1e6], |distance| {
        let clusters = |distances: &[f64]| {
            let mut stage = Stage::default();
            for (cluster, &distance) in distances.iter().enumerate() {
                let (at, power) = (DVec3::X * distance, 100f64.powi(cluster as i32));
                let (u, v) = (DVec3::X, DVec3::Y);
                stage.quad(at - 0.5 * (u + v), u, v, lambert(0.5));
                for i in 0..10 {
                    let up = DVec3::new(0.0, 0.0, 0.6);
                    stage.light(point_light(at + up + 0.3 * spread(i, 10), power));
                }
            }
            stage
        };
        let eye = footprint_of(FILM, DVec3::ZERO, 1.0, 0.5);
        scenario(clusters(&[0.0, distance]), Some(clusters(&[0.0])), eye)
    });
    entries
}

/// Numbers of hidden lights.
const NUMBERS: &[f64] = &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5];
/// Power of a light that is seen; a hidden one has ten times as much.
const LAMP: f64 = 3.0;

/// A kind of lights, numbers of them, and the room with a lamp and so many of them outside of it.
type Hidden = (&'static str, &'static [f64], fn(f64) -> Scenario);

const HIDDEN: [Hidden; 8] = [
    ("a hidden sky", &[1.0], |_| hidden(1.0, |stage, _| stage.environment(sky(1.0)))),
    ("a hidden environment map", &[1.0], |_| {
        hidden(1.0, |stage, _| {
            let pixel = |i: u32| Rgb::splat(f64::from(1 + i % 3));
            let pixels = (0..32).map(pixel).collect();
            let map = EnvironmentMap::new(8, 4, pixels, EnvironmentMap::Z_UP);
            stage.environment(map.expect("valid"));
        })
    }),
    ("hidden suns", NUMBERS, |number| {
        hidden(number, |stage, at| {
            stage.light(DirectionalLight::new(-at, Rgb::WHITE).expect("valid"));
        })
    }),
    ("hidden point lights", NUMBERS, |number| {
        hidden(number, |stage, at| stage.light(point_light(at, 10.0 * LAMP)))
    }),
    ("hidden spot lights", NUMBERS, |number| {
        hidden(number, |stage, at| {
            let intensity = Rgb::splat(10.0 * LAMP);
            stage.light(SpotLight::new(at, -at, intensity, 10.0, 30.0).expect("valid"));
        })
    }),
    ("hidden quads", NUMBERS, |number| {
        hidden(number, |stage, at| add_lamp(stage, at, 0.05, 1000.0))
    }),
    ("hidden spheres", NUMBERS, |number| {
        hidden(number, |stage, at| {
            let lamp = stage.sphere(Sphere::new(at, 0.05), Material::Black);
            stage.glow(lamp, 300.0);
        })
    }),
    ("hidden meshes", NUMBERS, |number| {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = Mesh {
            positions: corners.map(|corner| 0.1 * corner).to_vec(),
            indices: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Mesh::default()
        };
        hidden(number, |stage, at| {
            let lamp = stage.mesh(&mesh, DAffine3::from_translation(at), Material::Black);
            stage.glow(lamp, 400.0);
        })
    }),
];

fn hidden(number: f64, add: impl Fn(&mut Stage, DVec3)) -> Scenario {
    let (number, mut stage) = (number as u32, room_with_lamp());
    for i in 0..number {
        // In a shell around the room.
        let radius = 3.0 * (1.0 + f64::from(i) / f64::from(number));
        add(&mut stage, radius * spread(i, number));
    }
    scenario(stage, Some(room_with_lamp()), eye(DVec3::ZERO))
}

/// Rooms in rows of ten, the first of which has a lamp if `lit` is 1.
fn rooms_with_lamps(rooms: u32, lit: u32, are_open: bool) -> Stage {
    let mut stage = Stage::default();
    for i in 0..rooms {
        let at = DVec3::new(f64::from(i % 10), 0.0, f64::from(i / 10)) * 2.2;
        add_room(&mut stage, at, are_open);
        if i < lit {
            add_lamp(&mut stage, at + DVec3::Y * 0.95, 0.05, 100.0);
        }
    }
    stage
}
