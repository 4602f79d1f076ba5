//! The extent of the scene as lights at infinity see it.

use super::DirectionSample;
use super::cover::{MAX_BOXES, cover, is_bounded};
use crate::geometry::{Bounds, Frame, SurfacePoint};
use crate::math::{PerProjected, Rgb, warp::square_to_disk};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// The share of rays that is divided evenly among the boxes, so that none starves beside a larger
/// one; the rest is divided by the area of their disks.
const EVEN_SHARE: f64 = 0.25;
/// Relative margin against rounding: positions start this much farther out than needed. It changes
/// no expected value.
const MARGIN: f64 = 1e-3;

/// A few boxes, one in most scenes, that together cover all surfaces: what lights at infinity must
/// illuminate.
///
/// A ray of such a light starts on a disk that covers one of the boxes as seen along it. A single
/// box around everything would let nearly all rays miss a room that something small is far away
/// from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneExtent {
    boxes: Arc<[Bounds]>,
}

impl From<Bounds> for SceneExtent {
    /// A single box.
    fn from(bounds: Bounds) -> Self {
        Self { boxes: std::iter::once(bounds).filter(is_bounded).collect() }
    }
}

impl SceneExtent {
    /// At most eight boxes that together cover the given ones, those of a scene's primitives; there
    /// are more than one only where that at least halves the area of their disks. Goes through them
    /// a few times.
    ///
    /// Empty and unbounded boxes are left out: nothing there can be illuminated from a disk of
    /// finite radius.
    #[must_use]
    pub fn covering<I>(boxes: I) -> Self
    where
        I: IntoIterator<Item = Bounds>,
        I::IntoIter: Clone,
    {
        Self { boxes: cover(boxes.into_iter()).into() }
    }

    /// The boxes.
    #[must_use]
    pub fn boxes(&self) -> &[Bounds] {
        &self.boxes
    }

    /// The box around all of them.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union)
    }

    /// Sum of the cross-sections of the spheres around the boxes: an upper bound on the area of the
    /// disks that [rays](Self::sample_direction) start on, at most 1.5 times its mean over all
    /// directions.
    #[must_use]
    pub fn cross_section(&self) -> f64 {
        self.boxes.iter().map(|bounds| PI * bounds.radius().powi(2)).sum()
    }

    /// Sum of the areas of the disks, perpendicular to `direction`, that cover the boxes as seen
    /// along it. Tight: an elongated box seen along its axis gets a small disk.
    #[must_use]
    pub fn disk_area(&self, direction: DVec3) -> f64 {
        self.boxes.iter().map(|bounds| PI * disk_square(bounds, direction)).sum()
    }

    /// A ray of the given radiance (of a Dirac direction: irradiance) from the infinite `point`,
    /// which starts before all boxes and passes one of them: uniform on the disk that covers it,
    /// after a choice by area and, for a quarter of the rays, even. `None` if there is nothing to
    /// cover.
    #[must_use]
    pub fn sample_direction(
        &self,
        point: &SurfacePoint,
        radiance: Rgb,
        u: DVec2,
    ) -> Option<DirectionSample> {
        let direction = point.geometric_normal;
        let from = SurfacePoint { position: self.sample_ray(direction, u)?, ..*point };
        let pdf = self.direction_pdf(&from);
        (pdf.value() > 0.0).then(|| DirectionSample {
            from,
            direction,
            pdf,
            weight: radiance / pdf.value(),
        })
    }

    /// The density per perpendicular area with which [`sample_direction`](Self::sample_direction)
    /// makes the ray through the position of the infinite `point`; 0 where it passes all disks.
    #[must_use]
    pub fn direction_pdf(&self, point: &SurfacePoint) -> PerProjected {
        let direction = point.geometric_normal;
        let disks = Disks::new(self, direction);
        let density = |(bounds, square): (&Bounds, f64)| {
            let offset = (point.position - bounds.center()).cross(direction);
            let is_passed = square > 0.0 && offset.length_squared() <= square;
            if is_passed { disks.share(square) / (PI * square) } else { 0.0 }
        };
        PerProjected(self.boxes.iter().zip(disks.squares).map(density).sum())
    }

    /// The infinite `point`, placed where the segment from `receiver` towards it has certainly left
    /// all boxes.
    #[must_use]
    pub fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        let beyond = |bounds: &Bounds| {
            (receiver.position.distance(bounds.center()) + bounds.radius()) * (1.0 + MARGIN)
        };
        let distance = self.boxes.iter().map(beyond).fold(0.0, f64::max);
        // In a scene that is a single point any segment will do, but it must have a direction.
        let distance = if distance > 0.0 { distance } else { 1.0 };
        SurfacePoint { position: receiver.position - point.geometric_normal * distance, ..*point }
    }

    fn sample_ray(&self, direction: DVec3, mut u: DVec2) -> Option<DVec3> {
        let disks = Disks::new(self, direction);
        let mut chosen = None;
        for (bounds, square) in self.boxes.iter().zip(disks.squares).filter(|(_, r2)| *r2 > 0.0) {
            let share = disks.share(square);
            chosen = Some((bounds.center(), square, (u.x / share).min(1.0)));
            if u.x < share {
                break;
            }
            u.x -= share;
        }
        let (center, square, x) = chosen?;
        let p = square_to_disk(DVec2::new(x, u.y)) * square.sqrt();
        let frame = Frame::from_normal(direction);
        // Something of another box may be in the way.
        let before = |other: &Bounds| (center - other.center()).dot(direction) + other.radius();
        let back = self.boxes.iter().map(before).fold(0.0, f64::max) * (1.0 + MARGIN);
        Some(center + frame.x * p.x + frame.y * p.y - direction * back)
    }
}

/// The disks that cover the boxes as seen along a direction, and the choice among them.
struct Disks {
    /// Squared radii; 0 where there is no box or nothing to cover.
    squares: [f64; MAX_BOXES],
    sum: f64,
    even: f64,
}

impl Disks {
    fn new(extent: &SceneExtent, direction: DVec3) -> Self {
        let mut squares = [0.0; MAX_BOXES];
        for (square, bounds) in squares.iter_mut().zip(&*extent.boxes) {
            *square = disk_square(bounds, direction);
        }
        let number = squares.iter().filter(|square| **square > 0.0).count();
        Self { squares, sum: squares.iter().sum(), even: EVEN_SHARE / number as f64 }
    }

    /// The probability of a disk that is one of them; 1 if it is the only one.
    fn share(&self, square: f64) -> f64 {
        self.even + (1.0 - EVEN_SHARE) * (square / self.sum)
    }
}

/// The squared radius of the disk that covers a box as seen along a direction.
fn disk_square(bounds: &Bounds, direction: DVec3) -> f64 {
    let h = 0.5 * (bounds.max - bounds.min);
    // The farthest corner from the axis; opposite corners are equally far.
    let corners =
        [h, DVec3::new(-h.x, h.y, h.z), DVec3::new(h.x, -h.y, h.z), DVec3::new(h.x, h.y, -h.z)];
    let widest = corners.iter().map(|c| c.cross(direction).length_squared()).fold(0.0, f64::max);
    widest * (1.0 + 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::chi_square;
    use crate::math::warp::{square_to_sphere, testing::random};

    fn cube(center: DVec3, half: f64) -> Bounds {
        Bounds { min: center - half, max: center + half }
    }

    /// A flat box; a room and pebbles far away, one of them a point.
    fn extents() -> Vec<SceneExtent> {
        let flat = Bounds { min: DVec3::new(-1.0, 2.0, 5.0), max: DVec3::new(4.0, 2.5, 5.0) };
        let mut extents = vec![SceneExtent::from(flat)];
        for far in [1e1, 1e3, 1e6] {
            let room = Bounds { min: DVec3::new(-1.0, -2.0, 0.0), max: DVec3::new(1.0, 1.0, 2.0) };
            let pebbles = [(DVec3::X, 0.1), (DVec3::new(0.6, 0.0, 0.8), 0.0), (-DVec3::Y, 0.02)];
            let pebbles = pebbles.map(|(at, half)| cube(at * far, half));
            extents.push(SceneExtent::covering(pebbles.into_iter().chain([room])));
            assert_eq!(extents.last().expect("one").boxes().len(), 4);
        }
        extents
    }

    fn inside(bounds: &Bounds, rng: &mut impl FnMut() -> f64) -> DVec3 {
        bounds.min + (bounds.max - bounds.min) * DVec3::new(rng(), rng(), rng())
    }

    fn at(position: DVec3, direction: DVec3) -> SurfacePoint {
        SurfacePoint::infinite(position, direction)
    }

    #[test]
    fn every_ray_to_a_surface_has_a_density_and_starts_outside() {
        let mut rng = random(3);
        for extent in extents() {
            for _ in 0..1000 {
                let w = square_to_sphere(DVec2::new(rng(), rng()));
                let u = DVec2::new(rng(), rng());
                let ray = extent.sample_direction(&at(DVec3::ZERO, w), Rgb::WHITE, u).unwrap();
                assert_eq!(ray.pdf, extent.direction_pdf(&ray.from));
                assert_eq!(ray.weight, Rgb::WHITE / ray.pdf.value());
                for bounds in extent.boxes() {
                    let corners = [bounds.min, bounds.max, inside(bounds, &mut rng)];
                    for x in corners.iter().filter(|_| bounds.radius() > 0.0) {
                        assert!(extent.direction_pdf(&at(*x, w)).value() > 0.0, "{x} {w}");
                    }
                    let depth = |x: DVec3| (x - bounds.center()).dot(w);
                    assert!(depth(ray.from.position) < -bounds.radius());
                    let receiver = SurfacePoint::on_surface(3.0 * corners[2], 0.0, DVec3::Z);
                    let far = extent.facing(&at(DVec3::ZERO, w), &receiver).position;
                    assert!(far.distance(bounds.center()) > bounds.radius());
                }
            }
        }
    }

    #[test]
    fn no_box_starves() {
        let mut rng = random(4);
        for extent in extents() {
            let w = square_to_sphere(DVec2::new(rng(), rng()));
            for bounds in extent.boxes().iter().filter(|bounds| bounds.radius() > 0.0) {
                let pdf = extent.direction_pdf(&at(bounds.center(), w)).value();
                assert!(pdf * PI * disk_square(bounds, w) >= EVEN_SHARE / MAX_BOXES as f64);
            }
        }
    }

    /// Chi-square of the starts on a grid over each disk, against the integral of the density over
    /// each cell by midpoints; that over all cells is 1.
    #[test]
    fn starts_have_the_density_that_is_told() {
        const CELLS: usize = 8;
        let mut rng = random(5);
        for extent in extents() {
            for overlap in [false, true] {
                // Seen along the line through two boxes, their disks overlap.
                let w = match (extent.boxes(), overlap) {
                    ([a, .., b], true) => (a.center() - b.center()).normalize(),
                    _ => square_to_sphere(DVec2::new(rng(), rng())),
                };
                let frame = Frame::from_normal(w);
                let disks: Vec<(DVec2, f64)> = extent
                    .boxes()
                    .iter()
                    .map(|b| (frame.to_local(b.center()).truncate(), disk_square(b, w).sqrt()))
                    .filter(|(_, radius)| *radius > 0.0)
                    .collect();
                // A cell belongs to the first disk whose square contains it.
                let cell = |p: DVec2| {
                    disks.iter().enumerate().find_map(|(disk, (center, radius))| {
                        let q = (p - center) / radius;
                        (q.abs().max_element() <= 1.0).then(|| {
                            let [x, y] =
                                [q.x, q.y].map(|q| (0.5 * (q + 1.0) * CELLS as f64) as usize);
                            (disk * CELLS + y.min(CELLS - 1)) * CELLS + x.min(CELLS - 1)
                        })
                    })
                };
                let cells = disks.len() * CELLS * CELLS;
                let (mut expected, mut counts) = (vec![0.0; cells], vec![0.0; cells]);
                let grid = CELLS * 60;
                for (disk, (center, radius)) in disks.iter().enumerate() {
                    for i in 0..grid * grid {
                        let q = DVec2::new((i % grid) as f64 + 0.5, (i / grid) as f64 + 0.5);
                        let p = center + (q * (2.0 / grid as f64) - 1.0) * *radius;
                        let Some(index) = cell(p).filter(|index| index / (CELLS * CELLS) == disk)
                        else {
                            continue;
                        };
                        let on_ray = at(frame.to_world(p.extend(0.0)), w);
                        let area = (2.0 * radius / grid as f64).powi(2);
                        expected[index] += extent.direction_pdf(&on_ray).value() * area;
                    }
                }
                let total: f64 = expected.iter().sum();
                assert!((total - 1.0).abs() < 1e-3, "{total}");
                let samples = 200_000;
                for _ in 0..samples {
                    let u = DVec2::new(rng(), rng());
                    let start = extent.sample_ray(w, u).unwrap();
                    counts[cell(frame.to_local(start).truncate()).expect("in a disk")] += 1.0;
                }
                expected.iter_mut().for_each(|share| *share *= f64::from(samples) / total);
                let test = chi_square(&counts, &expected, 20.0);
                assert!(test.p_value > 1e-4, "{test:?}");
            }
        }
    }

    #[test]
    fn nothing_to_cover_gives_no_ray() {
        for bounds in [
            Bounds::EMPTY,
            Bounds::of_points([DVec3::ONE]),
            Bounds { min: DVec3::ZERO, max: DVec3::INFINITY },
        ] {
            let point = at(DVec3::ONE, DVec3::X);
            for extent in [SceneExtent::from(bounds), SceneExtent::covering([bounds; 3])] {
                assert_eq!(extent.direction_pdf(&point), PerProjected::ZERO);
                assert_eq!(extent.sample_direction(&point, Rgb::WHITE, DVec2::ZERO), None);
                let far = extent.facing(&point, &SurfacePoint::dirac(DVec3::ONE)).position;
                assert!(far.is_finite() && far != DVec3::ONE);
            }
        }
    }
}
