//! Maps from the unit square to disks, hemispheres, spheres, cones and triangles.

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Uniform on the unit disk, without folding neighbourhoods (Shirley and Chiu 1997, concentric map).
#[must_use]
pub fn square_to_disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (r, angle) = if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * (p.y / p.x)) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y)) };
    r * DVec2::new(angle.cos(), angle.sin())
}

/// On the upper hemisphere with density `cos θ / π` per solid angle, that is `1/π` per projected solid angle (Malley's method).
#[must_use]
pub fn square_to_cosine_hemisphere(u: DVec2) -> DVec3 {
    let d = square_to_disk(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Uniform on the unit sphere, density `1/(4π)` per solid angle.
#[must_use]
pub fn square_to_sphere(u: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = 2.0 * (u.x * (1.0 - u.x)).sqrt();
    let (sin, cos) = (2.0 * PI * u.y).sin_cos();
    DVec3::new(r * cos, r * sin, z)
}

/// Barycentric coordinates (b1, b2) of a point uniform in a triangle: reflects the half square, so it is measure preserving.
#[must_use]
pub fn square_to_triangle(u: DVec2) -> DVec2 {
    // Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
    if u.y > u.x { DVec2::new(0.5 * u.x, u.y - 0.5 * u.x) } else { DVec2::new(u.x - 0.5 * u.y, 0.5 * u.y) }
}
