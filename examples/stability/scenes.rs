//! Worlds with exact answers, at any place and scale.

#[path = "../../tests/common/stage.rs"]
#[allow(dead_code, reason = "shared by several programs")]
mod stage;

use pathspace::endpoint::{DirectionSample, Endpoint, Light, PinholeCamera, PointSample};
use pathspace::geometry::{Quad, Sphere, SurfacePoint};
use pathspace::glam::{DVec2, DVec3, UVec2};
use pathspace::math::{PerArea, PerProjected, Rgb};
use pathspace::scene::{Material, Mesh, World};
pub use stage::Stage;
use std::f64::consts::PI;

pub fn lambert(albedo: f64) -> Material {
    Material::Lambert { albedo: Rgb::splat(albedo) }
}

pub fn mirror(reflectance: f64) -> Material {
    Material::Mirror { reflectance: Rgb::splat(reflectance) }
}

/// The faces of a cube, their front sides inside: x = 0, x = 1, y = 0, y = 1, z = 0, z = 1.
pub fn cube(corner: DVec3, side: f64) -> [Quad; 6] {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * side);
    std::array::from_fn(|face| {
        let (n, u, v) = (axes[face / 2], axes[(face / 2 + 1) % 3], axes[(face / 2 + 2) % 3]);
        if face % 2 == 0 {
            Quad { origin: corner, edge_u: u, edge_v: v }
        } else {
            Quad { origin: corner + n, edge_u: v, edge_v: u }
        }
    })
}

/// The cube as a mesh of 12 triangles.
pub fn cube_mesh() -> Mesh {
    let mut mesh = Mesh::default();
    for quad in cube(DVec3::ZERO, 1.0) {
        let first = mesh.positions.len() as u32;
        let (o, u, v) = (quad.origin, quad.edge_u, quad.edge_v);
        mesh.positions.extend([o, o + u, o + u + v, o + v]);
        mesh.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

/// A cube all of whose walls reflect and emit.
pub fn furnace_box(corner: DVec3, side: f64, wall: &Material, radiance: f64) -> World {
    let mut stage = Stage::default();
    for face in cube(corner, side) {
        let face = stage.face(face, wall.clone());
        stage.glow(face, radiance);
    }
    stage.build()
}

/// A sphere whose inside reflects and emits.
pub fn furnace_sphere(center: DVec3, radius: f64, wall: &Material, radiance: f64) -> World {
    let mut stage = Stage::default();
    let sphere = stage.sphere(Sphere { inward: true, ..Sphere::new(center, radius) }, wall.clone());
    stage.glow(sphere, radiance);
    stage.build()
}

/// A sphere that reflects inside, a tenth of which also emits: the cap around +z.
pub fn cap_sphere(center: DVec3, radius: f64, albedo: f64, radiance: f64) -> World {
    let mut stage = Stage::default();
    let whole = Sphere { inward: true, axis: DVec3::Z, ..Sphere::new(center, radius) };
    stage.sphere(Sphere { cos_max: 0.8, ..whole }, lambert(albedo));
    let cap = stage.sphere(Sphere { cos_min: 0.8, ..whole }, lambert(albedo));
    stage.glow(cap, radiance);
    stage.build()
}

/// The square light [-1, 1]² at z = 2 over a floor of albedo 0.5 that reaches to `half`, `scale`
/// times as large and bright.
pub fn square_light(half: f64, offset: DVec3, scale: f64, radiance: f64) -> World {
    let mut stage = Stage::default();
    let square = |half: f64, z: f64| Quad {
        origin: offset + DVec3::new(-half, -half, z) * scale,
        edge_u: DVec3::X * (2.0 * half * scale),
        edge_v: DVec3::Y * (2.0 * half * scale),
    };
    stage.face(square(half, 0.0), lambert(0.5));
    let Quad { origin, edge_u, edge_v } = square(1.0, 2.0);
    let lamp = stage.face(Quad { origin, edge_u: edge_v, edge_v: edge_u }, Material::Black);
    stage.glow(lamp, radiance);
    stage.build()
}

/// A camera with one pixel.
pub fn camera(position: DVec3, target: DVec3, degrees: f64) -> PinholeCamera {
    camera_of(UVec2::ONE, position, target, degrees)
}

fn camera_of(film: UVec2, position: DVec3, target: DVec3, degrees: f64) -> PinholeCamera {
    let forward = (target - position).normalize();
    let up = if forward.z.abs() > 0.9 { DVec3::X } else { DVec3::Z };
    PinholeCamera::new(position, target, up, degrees, film).expect("valid camera")
}

/// A camera at `height` over a horizontal plane that sees the square of half side `half` around a
/// point of it.
pub fn footprint(point: DVec3, height: f64, half: f64) -> PinholeCamera {
    footprint_of(UVec2::ONE, point, height, half)
}

/// The same with a square film of more pixels.
pub fn footprint_of(film: UVec2, point: DVec3, height: f64, half: f64) -> PinholeCamera {
    camera_of(film, point + DVec3::Z * height, point, 2.0 * (half / height).atan().to_degrees())
}

/// The irradiance of a polygon of radiance 1, above the horizon and counter-clockwise as the
/// receiver sees it (Lambert 1760).
pub fn polygon_irradiance(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let n = corners.len();
    let edge = |i: usize| {
        let (a, b) = ((corners[i] - point).normalize(), (corners[(i + 1) % n] - point).normalize());
        let cross = a.cross(b);
        // The angle by its tangent: the arc cosine of nearly 1 has no digits.
        cross.length().atan2(a.dot(b)) * normal.dot(cross.normalize())
    };
    0.5 * (0..n).map(edge).sum::<f64>().abs()
}

/// The mean of a function over the square of half side `half` around the origin, by Gauss and
/// Legendre's rule of 5 × 5 points.
pub fn mean_over_square(half: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    let (a, b) = (
        (5.0 - 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0,
        (5.0 + 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0,
    );
    let (wa, wb) = ((322.0 + 13.0 * 70f64.sqrt()) / 1800.0, (322.0 - 13.0 * 70f64.sqrt()) / 1800.0);
    let rule = [(0.0, 128.0 / 450.0), (a, wa), (-a, wa), (b, wb), (-b, wb)];
    rule.iter()
        .flat_map(|&(x, wx)| rule.iter().map(move |&(y, wy)| (x, y, wx * wy)))
        .map(|(x, y, w)| w * f(half * x, half * y))
        .sum()
}

/// Fresnel's reflectance of a smooth interface at the given cosines on both sides (textbook form,
/// for comparison).
pub fn fresnel(near: f64, far: f64, relative_ior: f64) -> f64 {
    let s = (near - relative_ior * far) / (near + relative_ior * far);
    let p = (relative_ior * near - far) / (relative_ior * near + far);
    0.5 * (s * s + p * p)
}

/// The irradiance of a Lambertian sphere of radiance 1 wholly above the horizon.
pub fn sphere_irradiance(point: DVec3, normal: DVec3, sphere: &Sphere) -> f64 {
    let to_center = sphere.center - point;
    PI * sphere.radius * sphere.radius / to_center.length_squared()
        * normal.dot(to_center.normalize())
}

/// A beam of parallel light through a rectangle, which only walks from the light find.
pub struct Beam {
    direction: DVec3,
    center: DVec3,
    /// Half sides of the rectangle.
    u: DVec3,
    v: DVec3,
    irradiance: f64,
}

impl Beam {
    /// The beam that lights the square of a half side around the origin of a horizontal floor, and
    /// arrives at a cosine; with its irradiance on a perpendicular plane.
    pub fn onto_floor(half: f64, cosine: f64, irradiance: f64) -> Self {
        let sine = (1.0 - cosine * cosine).sqrt();
        let direction = DVec3::new(sine, 0.0, -cosine);
        let u = DVec3::new(cosine, 0.0, sine) * (half * cosine);
        Self { direction, center: direction * (-3.0 * half), u, v: DVec3::Y * half, irradiance }
    }

    fn area(&self) -> f64 {
        4.0 * self.u.length() * self.v.length()
    }
}

impl Endpoint for Beam {
    fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
        let point = SurfacePoint::infinite(self.center, self.direction);
        Some(PointSample { point, pdf: PerArea(1.0) })
    }

    fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let position = self.center + self.u * (2.0 * u.x - 1.0) + self.v * (2.0 * u.y - 1.0);
        Some(DirectionSample {
            from: SurfacePoint { position, ..*point },
            direction: self.direction,
            pdf: self.direction_pdf(point, self.direction),
            weight: self.power(),
        })
    }

    fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
        PerProjected(1.0 / self.area())
    }

    fn emit(&self, _: &SurfacePoint, _: DVec3) -> Rgb {
        Rgb::splat(self.irradiance)
    }
}

impl Light for Beam {
    fn power(&self) -> Rgb {
        Rgb::splat(self.irradiance * self.area())
    }

    fn can_be_hit(&self) -> bool {
        false
    }

    fn can_be_connected(&self) -> bool {
        false
    }
}
