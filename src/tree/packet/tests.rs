//! Facets of few against the exact test, where f32 is least sure.

use super::RAYS;
use super::plane::Facet;
use super::rays::limited;
use crate::geometry::{Quad, Ray, Shape, Triangle};
use crate::lanes::dispatch;
use crate::math::warp::square_to_sphere;
use crate::tree::tests::levels;
use fearless_simd::{Level, f32x16, prelude::*};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What f32 says of a facet and sixteen rays: whether they may hit, whether they certainly do, and
/// between which distances.
#[derive(Clone, Copy)]
struct Verdict {
    may: bool,
    must: bool,
    near: f32,
    far: f32,
}

fn verdicts(level: Level, facet: &Facet, rays: &[(DVec3, DVec3); RAYS]) -> [Verdict; RAYS] {
    dispatch!(level, simd => {
        let row = |component: &dyn Fn(&(DVec3, DVec3)) -> f64| {
            f32x16::from_fn(simd, |lane| component(&rays[lane]) as f32)
        };
        let origin = [0, 1, 2].map(|axis| row(&|ray| ray.0[axis]));
        let direction = [0, 1, 2].map(|axis| row(&|ray| ray.1[axis]));
        let seen = facet.meet(simd, &origin, &direction);
        let may = seen.hits(limited(simd, u64::MAX, f32x16::splat(simd, f32::INFINITY)));
        let (may, must) = (may.to_bitmask(), seen.certain().to_bitmask());
        let (near, far) = (seen.near.to_array(), seen.far.to_array());
        std::array::from_fn(|lane| Verdict {
            may: may >> lane & 1 != 0,
            must: must >> lane & 1 != 0,
            near: near[lane],
            far: far[lane],
        })
    })
}

fn point(rng: &mut Pcg64Mcg) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0)))
}

fn direction(rng: &mut Pcg64Mcg) -> DVec3 {
    square_to_sphere(DVec2::new(rng.random(), rng.random()))
}

/// A facet within the cube: of any size and shape down to a height of 1e-7, which is below what
/// f32 tells apart, and now and then in a plane of two axes.
fn facet(rng: &mut Pcg64Mcg) -> (DVec3, [DVec3; 2]) {
    loop {
        let mut size = || 10f64.powf(rng.random_range(-4.0..0.3));
        let (long, short) = (size(), size());
        let flat = rng.random_range(0..3) == 0;
        let mut edge = || {
            let d = direction(rng);
            if flat { DVec3::new(d.x, d.y, 0.0).normalize() } else { d }
        };
        let e1 = edge() * long;
        let e2 = e1 * 0.5 + edge() * short;
        let corner = point(rng);
        let corners = [corner, corner + e1, corner + e2, corner + e1 + e2];
        if corners.iter().all(|p| p.abs().max_element() <= 1.0) {
            return (corner, [e1, e2]);
        }
    }
}

/// A ray from within the cube to or beside a point of the facet or of its outline, perhaps almost
/// along its plane.
fn ray(rng: &mut Pcg64Mcg, corner: DVec3, [e1, e2]: [DVec3; 2]) -> (DVec3, DVec3) {
    loop {
        let (mut u, mut v) = (rng.random::<f64>(), rng.random::<f64>());
        match rng.random_range(0..6) {
            0 => u = 0.0,
            1 => v = 0.0,
            2 => u = 1.0 - v,
            3 => u = 1.0,
            _ => {}
        }
        let off = 10f64.powf(rng.random_range(-9.0..-5.0)) * f64::from(rng.random_range(-1..2));
        let aim = corner + e1 * u + e2 * v + direction(rng) * off;
        let from = if rng.random() {
            point(rng)
        } else {
            let rise = 10f64.powf(rng.random_range(-9.0..0.0));
            let along = e1 * rng.random_range(-1.0..1.0) + e2 * rng.random_range(-1.0..1.0);
            aim + along.normalize() + e1.cross(e2).normalize() * rise
        };
        let d = (aim - from).normalize();
        if from.abs().max_element() <= 1.0 && d.is_finite() {
            return (from, d);
        }
    }
}

/// Nothing that the exact test hits is missed, what is certain is hit, and its distance is between
/// the bounds.
#[test]
fn facets_of_few_are_neither_missed_nor_hit_by_mistake() {
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let (mut hits, mut sure, mut certain, mut plain) = (0, 0, 0, 0);
    for round in 0..if cfg!(debug_assertions) { 1000 } else { 10_000 } {
        let (corner, edges) = facet(&mut rng);
        let is_triangle = rng.random();
        let shape = if is_triangle {
            let vertices = [corner, corner + edges[0], corner + edges[1]];
            Shape::Triangle(Triangle { vertices })
        } else {
            Shape::Quad(Quad { origin: corner, edge_u: edges[0], edge_v: edges[1] })
        };
        let facet = Facet::new(corner, edges, is_triangle);
        let mut rays = [(); RAYS].map(|()| ray(&mut rng, corner, edges));
        // The last goes from anywhere to anywhere on the facet.
        let aim = shape.sample_area(DVec2::new(rng.random(), rng.random())).position;
        let from = point(&mut rng);
        rays[RAYS - 1] = (from, (aim - from).normalize());
        for level in levels() {
            let verdicts = verdicts(level, &facet, &rays);
            for ((origin, direction), verdict) in rays.into_iter().zip(verdicts) {
                let Verdict { may, must, near, far } = verdict;
                let exact = shape.intersect(&Ray::new(origin, direction));
                let case = format!("{shape:?}, {origin:?} to {direction:?}, {level:?}, {round}");
                assert!(may || exact.is_none(), "missed: {case}");
                assert!(exact.is_some() || !must, "not hit: {case}");
                if let Some(hit) = exact {
                    let range = f64::from(near)..=f64::from(far);
                    assert!(range.contains(&hit.t), "{} not in {range:?}: {case}", hit.t);
                    hits += 1;
                    sure += usize::from(must);
                }
            }
            let height =
                edges[0].cross(edges[1]).length() / (edges[0].length() + edges[1].length());
            if height > 0.03 {
                plain += 1;
                certain += usize::from(verdicts[RAYS - 1].must);
            }
        }
    }
    assert!(hits > 2 * sure / 3 && sure > hits / 4, "{sure} of {hits} hits are certain");
    assert!(certain > plain * 98 / 100, "{certain} of {plain} plain hits are certain");
}
