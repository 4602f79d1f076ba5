//! The host's geometry, as a scene.

use super::lamp::HeadLamp;
use super::material::RetroReflector;
use pathspace::endpoint::{AreaLight, Light, LightId};
use pathspace::geometry::{Place, Shape, Sphere, SurfacePoint};
use pathspace::glam::{DVec2, DVec3};
use pathspace::math::Rgb;
use pathspace::scene::{Needs, Scene, SurfaceArea};
use std::error::Error;
use std::f64::consts::PI;

/// A square of ground, y = 0, and balls. The last ball is a lamp; the head lamp is the second
/// light.
pub struct ToyScene {
    ground: RetroReflector,
    balls: Vec<(Sphere, RetroReflector)>,
    lights: [Box<dyn Light>; 2],
}

/// The ground is primitive 0, ball i is primitive i + 1.
const GROUND: u32 = 0;
const GROUND_HALF_WIDTH: f64 = 5.0;

impl ToyScene {
    pub fn new() -> Result<Self, Box<dyn Error>> {
        let material = |diffuse, retro, exponent| RetroReflector {
            diffuse: Rgb(diffuse),
            retro: Rgb(retro),
            exponent,
        };
        let ball = |x, y, z, radius| Sphere::new(DVec3::new(x, y, z), radius);
        let lamp = ball(1.2, 3.5, -0.8, 0.4);
        let balls = vec![
            (ball(-2.1, 1.0, 0.0, 1.0), material([0.6, 0.2, 0.15], [0.0; 3], 0.0)),
            (ball(0.0, 1.0, -0.7, 1.0), material([0.1, 0.25, 0.1], [0.3, 0.5, 0.3], 8.0)),
            (ball(2.1, 1.0, 0.0, 1.0), material([0.05, 0.05, 0.2], [0.6, 0.6, 0.7], 60.0)),
            (lamp, material([0.0; 3], [0.0; 3], 0.0)),
        ];
        // One of the crate's lights, on the host's surface: it must know the number by which the
        // host calls that primitive.
        let primitive = balls.len() as u32;
        let glow = AreaLight::new(
            vec![Shape::Sphere(lamp)],
            primitive,
            primitive,
            Rgb::new(30.0, 25.0, 20.0),
            false,
        )?;
        let position = DVec3::new(-0.5, 3.2, 8.0);
        let axis = (DVec3::new(0.5, 0.6, 0.0) - position).normalize();
        let head_lamp =
            HeadLamp { position, axis, intensity: Rgb::new(16.0, 20.0, 26.0), exponent: 40.0 };
        let ground = material([0.5, 0.5, 0.5], [0.1, 0.1, 0.1], 20.0);
        Ok(Self { ground, balls, lights: [Box::new(glow), Box::new(head_lamp)] })
    }

    fn primitives(&self) -> std::ops::RangeInclusive<u32> {
        GROUND..=self.balls.len() as u32
    }

    /// Distance at which a ray meets a primitive. That a ray which starts on a primitive is at
    /// distance 0 from it is known, not computed: so there is no self-intersection, and no epsilon
    /// against it.
    fn distance(&self, primitive: u32, from: &SurfacePoint, direction: DVec3) -> Option<f64> {
        let touches = from.place == Place::Area && from.primitive == primitive;
        if primitive == GROUND {
            let t = -from.position.y / direction.y;
            let hit = from.position + direction * t;
            let inside = hit.x.abs() <= GROUND_HALF_WIDTH && hit.z.abs() <= GROUND_HALF_WIDTH;
            return (!touches && t > 0.0 && inside).then_some(t);
        }
        let sphere = &self.balls[primitive as usize - 1].0;
        let offset = from.position - sphere.center;
        let middle = -offset.dot(direction);
        if touches {
            return (middle > 0.0).then_some(2.0 * middle);
        }
        let half_chord =
            (sphere.radius.powi(2) - (offset + direction * middle).length_squared()).sqrt();
        // A ray that misses has a half chord that is not a number, which no comparison accepts.
        [middle - half_chord, middle + half_chord].into_iter().find(|t| *t > 0.0)
    }

    /// The point of a primitive next to `position`, which is on it up to rounding.
    fn point(&self, primitive: u32, position: DVec3) -> SurfacePoint {
        let point = if primitive == GROUND {
            SurfacePoint::on_surface(position.with_y(0.0), 1e-15 * position.length(), DVec3::Y)
        } else {
            let sphere = &self.balls[primitive as usize - 1].0;
            sphere.point_at((position - sphere.center).normalize())
        };
        SurfacePoint { primitive, surface: primitive, ..point }
    }
}

impl Scene for ToyScene {
    /// A host with several models would use an enum or `&'a dyn Bsdf`.
    type Bsdf<'a> = &'a RetroReflector;
    type Light = dyn Light;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        let hits = self.primitives().filter_map(|p| Some((self.distance(p, from, direction)?, p)));
        let (t, primitive) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(self.point(primitive, from.position + direction * t))
    }

    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let segment = b.position - a.position;
        let (length, direction) = (segment.length(), segment.normalize_or_zero());
        !self.primitives().any(|p| match (p == a.primitive, p == b.primitive) {
            (true, true) => false, // balls are convex, the ground is flat
            (_, false) => self.distance(p, a, direction).is_some_and(|t| t < length),
            (false, true) => self.distance(p, b, -direction).is_some_and(|t| t < length),
        })
    }

    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        if x.primitive == GROUND { &self.ground } else { &self.balls[x.primitive as usize - 1].1 }
    }

    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        (x.primitive as usize == self.balls.len()).then_some(LightId(0))
    }

    fn light(&self, id: LightId) -> &Self::Light {
        &*self.lights[id.0 as usize]
    }

    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        Some((LightId(u32::from(u >= 0.5)), 0.5))
    }

    fn pick_pmf(&self, _id: LightId) -> f64 {
        0.5
    }

    /// Optional: integrators leave out what the scene does not need.
    fn needs(&self) -> Needs {
        Needs::ALL.without(Needs::DIRAC_LOBES | Needs::ENVIRONMENT | Needs::UNCONNECTIBLE_LIGHTS)
    }
}

/// Optional: only uniform-area path sampling asks for it.
impl SurfaceArea for ToyScene {
    fn total_area(&self) -> f64 {
        4.0 * GROUND_HALF_WIDTH.powi(2)
            + self.balls.iter().map(|(ball, _)| 4.0 * PI * ball.radius.powi(2)).sum::<f64>()
    }

    fn sample_surface(&self, u1: f64, u2: DVec2) -> SurfacePoint {
        let mut area = u1 * self.total_area() - 4.0 * GROUND_HALF_WIDTH.powi(2);
        if area < 0.0 {
            let p = (u2 * 2.0 - 1.0) * GROUND_HALF_WIDTH;
            return self.point(GROUND, DVec3::new(p.x, 0.0, p.y));
        }
        let last = self.balls.len() - 1;
        let chosen = self.balls[..last].iter().position(|(ball, _)| {
            area -= 4.0 * PI * ball.radius.powi(2);
            area < 0.0
        });
        let chosen = chosen.unwrap_or(last);
        let point = Shape::Sphere(self.balls[chosen].0).sample_area(u2);
        SurfacePoint { primitive: chosen as u32 + 1, surface: chosen as u32 + 1, ..point }
    }
}
