//! Maps from the unit square to disks, hemispheres, spheres, cones and triangles.

use super::angle::{sin_cos_of_octant, sin_cos_of_turn};
use crate::lanes::{Lane, Mask, Vector};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_4;

/// Uniform on the unit disk, without folding neighbourhoods (Shirley and Chiu 1997, concentric
/// map).
#[inline]
#[must_use]
pub fn square_to_disk(u: DVec2) -> DVec2 {
    disk(u.to_array()).into()
}

/// [`square_to_disk`] in lanes.
#[inline(always)]
fn disk<L: Lane>(u: [L; 2]) -> [L; 2] {
    let [x, y] = [u[0] * 2.0 - 1.0, u[1] * 2.0 - 1.0];
    // The angle to the nearer axis.
    let is_near_x = x.abs().more(y.abs());
    let (r, across) = (is_near_x.choose(x, y), is_near_x.choose(y, x));
    let is_center = r.equals(r.constant(0.0));
    let (sin, cos) = sin_cos_of_octant(across / r * FRAC_PI_4);
    let zero = r.constant(0.0);
    [
        is_center.choose(zero, r * is_near_x.choose(cos, sin)),
        is_center.choose(zero, r * is_near_x.choose(sin, cos)),
    ]
}

/// A direction in the upper hemisphere with density `cos θ / π` per solid angle, that is `1/π` per
/// projected solid angle (Malley's method).
#[inline]
#[must_use]
pub fn square_to_cosine_hemisphere(u: DVec2) -> DVec3 {
    cosine_hemisphere(u.to_array()).into()
}

/// [`square_to_cosine_hemisphere`] in lanes.
#[inline(always)]
pub(crate) fn cosine_hemisphere<L: Lane>(u: [L; 2]) -> Vector<L> {
    let [x, y] = disk(u);
    let height_squared = -(x * x + y * y) + 1.0;
    Vector::new(x, y, height_squared.greater(x.constant(0.0)).sqrt())
}

/// Uniform on the unit sphere, density `1/(4π)` per solid angle.
#[must_use]
pub fn square_to_sphere(u: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = 2.0 * (u.x * (1.0 - u.x)).sqrt();
    let (sin, cos) = sin_cos_of_turn(u.y);
    DVec3::new(r * cos, r * sin, z)
}

/// Barycentric coordinates (b1, b2) of a point uniform in a triangle: reflects the half square, so
/// it is measure preserving.
#[must_use]
pub fn square_to_triangle(u: DVec2) -> DVec2 {
    triangle(u.to_array()).into()
}

/// [`square_to_triangle`] in lanes.
#[inline(always)]
pub(crate) fn triangle<L: Lane>([x, y]: [L; 2]) -> [L; 2] {
    // Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
    let is_above = y.more(x);
    let (half_x, half_y) = (x * 0.5, y * 0.5);
    [is_above.choose(half_x, x - half_y), is_above.choose(y - half_x, half_y)]
}

/// A point of [0, 1] whose density is linear, in proportion to `start` at 0 and to `end` at 1,
/// neither negative, from `u` in [0, 1]. Monotonic.
#[must_use]
pub fn unit_to_linear(u: f64, start: f64, end: f64) -> f64 {
    // The root of (end - start) x² / 2 + start x = u (start + end) / 2 without the difference.
    let denominator = start + (start * start * (1.0 - u) + end * end * u).sqrt();
    if denominator > 0.0 { (u * (start + end) / denominator).min(1.0) } else { u }
}

/// `1 - cos θ` from `sin θ` for θ in [0, π/2], without cancellation: `s² / (1 + √(1 - s²))`.
#[inline]
#[must_use]
pub fn one_minus_cosine(sine: f64) -> f64 {
    let s2 = sine * sine;
    s2 / (1.0 + (1.0 - s2).max(0.0).sqrt())
}

/// Uniform on the cone of directions with `1 - cos θ <= one_minus_cosine_max` around +z, density
/// `1/(2π one_minus_cosine_max)` per solid angle. Taking `1 - cos` instead of `cos` keeps narrow
/// cones exact.
#[must_use]
pub fn square_to_cone(u: DVec2, one_minus_cosine_max: f64) -> DVec3 {
    direction_from_one_minus_cosine(u.x * one_minus_cosine_max, u.y)
}

/// The unit vector with `1 - cos θ = v` to +z and azimuth `2π turn`.
#[inline]
#[must_use]
pub fn direction_from_one_minus_cosine(v: f64, turn: f64) -> DVec3 {
    let r = (v * (2.0 - v)).max(0.0).sqrt();
    let (sin, cos) = sin_cos_of_turn(turn);
    DVec3::new(r * cos, r * sin, 1.0 - v)
}

/// Inverts the integral of the smoothstep function `3t² - 2t³`: a number in [0, 1] with density `2
/// (3t² - 2t³)`.
#[must_use]
pub fn square_to_smoothstep(u: f64) -> f64 {
    // Solves t³ (2 - t) = u. The left side is convex on [0, 1] and at least t³, so Newton's method
    // descends from ∛u to the root.
    let mut t = libm::cbrt(u);
    for _ in 0..20 {
        let slope = t * t * (6.0 - 4.0 * t);
        let next = t - (t * t * t * (2.0 - t) - u) / slope;
        // Otherwise the root is reached up to rounding, or u is 0 (and the slope too).
        if next < t {
            t = next;
        } else {
            break;
        }
    }
    t
}

#[cfg(test)]
pub(crate) mod testing {
    use rand::{Rng, SeedableRng};

    /// Uniform numbers in [0, 1) from a fixed seed.
    pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
        move || (rng.next_u64() >> 11) as f64 * 0.5f64.powi(53)
    }
}

#[cfg(test)]
mod tests {
    use super::{testing::random, *};
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    const CORNERS: [f64; 4] = [0.0, 0.5, 0.25, 1.0 - 0.5 * f64::EPSILON];

    #[test]
    fn warps_stay_in_their_domain_at_the_corners() {
        for (x, y) in CORNERS.iter().flat_map(|x| CORNERS.iter().map(move |y| (*x, *y))) {
            let u = DVec2::new(x, y);
            assert!(square_to_disk(u).length() <= 1.0 + 1e-15);
            for w in [
                square_to_cosine_hemisphere(u),
                square_to_sphere(u),
                square_to_cone(u, 0.3),
                square_to_cone(u, 2.0),
            ] {
                assert_abs_diff_eq!(w.length(), 1.0, epsilon = 1e-14);
            }
            let b = square_to_triangle(u);
            assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0);
            assert!(square_to_smoothstep(x) >= 0.0 && square_to_smoothstep(x) <= 1.0);
        }
    }

    #[test]
    fn linear_density_is_inverted() {
        for (start, end) in
            [(1.0, 1.0), (0.0, 3.0), (2.0, 0.0), (1e-9, 1.0), (0.7, 0.2), (1e150, 1e-150)]
        {
            let mut before = 0.0;
            for u in (0..=1000).map(|i| f64::from(i) / 1000.0) {
                let x = unit_to_linear(u, start, end);
                assert!(x >= before && x <= 1.0, "{start} {end}: {x} at {u}");
                let below = x * (start + 0.5 * (end - start) * x) / (0.5 * (start + end));
                assert_abs_diff_eq!(below, u, epsilon = 1e-14);
                before = x;
            }
        }
        assert_eq!(unit_to_linear(0.3, 0.0, 0.0), 0.3);
    }

    #[test]
    fn means_are_those_of_the_uniform_distributions() {
        let mut rng = random(7);
        let n = 200_000;
        let (mut disk, mut cosine, mut sphere, mut cone, mut triangle) =
            (0.0, 0.0, 0.0, 0.0, DVec2::ZERO);
        for _ in 0..n {
            let u = DVec2::new(rng(), rng());
            disk += square_to_disk(u).length_squared();
            cosine += square_to_cosine_hemisphere(u).z;
            sphere += square_to_sphere(u).z.powi(2);
            cone += 1.0 - square_to_cone(u, 0.2).z;
            triangle += square_to_triangle(u);
        }
        let n = f64::from(n);
        // Standard errors are at most 0.0007.
        assert_abs_diff_eq!(disk / n, 0.5, epsilon = 0.003);
        assert_abs_diff_eq!(cosine / n, 2.0 / 3.0, epsilon = 0.003);
        assert_abs_diff_eq!(sphere / n, 1.0 / 3.0, epsilon = 0.003);
        assert_abs_diff_eq!(cone / n, 0.1, epsilon = 0.001);
        assert_abs_diff_eq!(triangle.x / n, 1.0 / 3.0, epsilon = 0.003);
        assert_abs_diff_eq!(triangle.y / n, 1.0 / 3.0, epsilon = 0.003);
    }

    #[test]
    fn narrow_cones_keep_their_digits() {
        // A sphere as small as r/d = 1e-12.
        assert_relative_eq!(one_minus_cosine(1e-12), 5e-25, max_relative = 1e-15);
        assert_relative_eq!(one_minus_cosine(1.0), 1.0);
        let w = square_to_cone(DVec2::new(1.0, 0.0), 5e-25);
        assert_relative_eq!(w.x, 1e-12, max_relative = 1e-15);
    }

    #[test]
    fn smoothstep_inverts_its_integral() {
        for i in 1..1000 {
            let u = (f64::from(i) / 1000.0).powi(6);
            let t = square_to_smoothstep(u);
            assert_relative_eq!(t * t * t * (2.0 - t), u, max_relative = 1e-14);
        }
        assert_eq!(square_to_smoothstep(0.0), 0.0);
    }
}
