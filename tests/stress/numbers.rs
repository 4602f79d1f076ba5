//! Numbers at the ends of their ranges.

use pathspace::geometry::Frame;
use pathspace::glam::{DVec2, DVec3};
use pathspace::math::warp;
use pathspace::path::Heuristic;

/// Two techniques whose densities are as far apart as numbers allow.
#[test]
fn stress_s19_weights_of_extreme_densities() {
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0), Heuristic::Power(1.5)] {
        for (ratio, weight) in
            [(0.0, 1.0), (1e-300, 1.0), (1.0, 0.5), (1e300, 0.0), (f64::INFINITY, 0.0)]
        {
            let w: f64 = heuristic.weight([ratio]);
            assert!((w - weight).abs() < 1e-200, "{heuristic:?} {ratio}: {w}");
        }
    }
}

/// Warps at the ends of [0, 1).
#[test]
fn stress_s46_ends_of_the_unit_interval() {
    let last = 1.0f64.next_down();
    for u in [0.0, f64::MIN_POSITIVE, f64::EPSILON, 0.5, last] {
        for v in [0.0, f64::EPSILON, 0.5, last] {
            let u = DVec2::new(u, v);
            for w in [warp::square_to_sphere(u), warp::square_to_cosine_hemisphere(u)] {
                assert!((w.length() - 1.0).abs() < 1e-15, "{u} {w}");
            }
            assert!(warp::square_to_cosine_hemisphere(u).z >= 0.0);
            assert!(warp::square_to_disk(u).length() <= 1.0 + 1e-15);
        }
    }
}

#[test]
fn stress_s47_frames() {
    let check = |n: DVec3| {
        let Frame { x, y, z } = Frame::from_normal(n);
        let errors = [
            x.dot(y),
            y.dot(z),
            z.dot(x),
            x.length() - 1.0,
            y.length() - 1.0,
            x.cross(y).dot(z) - 1.0,
        ];
        assert!(errors.iter().all(|e| e.abs() < 4.0 * f64::EPSILON), "{n} {errors:?}");
    };
    for i in 0..1_000_000u32 {
        // Golden-ratio points, all the way to both poles.
        let (u, v) = ((f64::from(i) + 0.5) / 1e6, (f64::from(i) * 0.618_033_988_749_894_9).fract());
        check(warp::square_to_sphere(DVec2::new(u, v)).normalize());
    }
    for tiny in [0.0, 1e-300, 1e-160, 1e-16, 1e-8, 1e-4] {
        for sign in [1.0, -1.0] {
            check(DVec3::new(tiny, -tiny, sign).normalize());
            check(DVec3::new(1.0, tiny, sign * tiny).normalize());
        }
    }
}
