//! An environment given by a function of direction.

use super::{DirectionSample, Endpoint, EndpointError, Light, PointSample, SceneExtent, check};
use crate::geometry::SurfacePoint;
use crate::math::distribution::{GridSample, PiecewiseConstant2d};
use crate::math::{PerArea, PerProjected, Rgb, angle, warp::square_to_sphere};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::fmt;

const OBJECT: &str = "function environment";
const BLOCK: usize = PiecewiseConstant2d::BLOCK;
/// Cells of the table: bands of the same height along z, and sectors of the same azimuth.
const BANDS: usize = 64;
const SECTORS: usize = 128;
const CELLS: usize = BANDS * SECTORS;
/// Directions on a side of the grid that the function is asked for in each cell.
const TRIES: usize = 3;
/// The share of directions that are uniform on the sphere.
const UNIFORM_SHARE: f64 = 0.25;

/// Radiance from infinitely far away as a function of direction: a sky given by a formula.
///
/// # Densities
/// The sphere is divided into 64 × 128 cells of the same solid angle (bands along z, sectors of
/// azimuth), and the function is asked for nine directions in each when the light is made. A cell is
/// then chosen in proportion to the mean of its largest component, mixed with the uniform
/// distribution, which has a share of a quarter; in the cell all directions are alike. So the
/// density per solid angle of a direction in cell i, of mean b_i, is
///
/// ```text
/// p = (3/4 b_i / mean b + 1/4) / 4π
/// ```
///
/// It is never 0: what the table has not seen, such as a disk of the sun that fits between the
/// directions, is still drawn, with the variance of uniform sampling. Better two lights then: the sky
/// as a function, the sun as a [`DirectionalLight`](super::DirectionalLight).
///
/// ```
/// use pathspace::endpoint::FunctionEnvironment;
/// use pathspace::math::Rgb;
/// use pathspace::scene::WorldBuilder;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// // The overcast sky of the CIE: three times as bright at the zenith as at the horizon.
/// let sky = FunctionEnvironment::new(|w| {
///     Rgb::from(if w.y > 0.0 { (1.0 + 2.0 * w.y) / 3.0 } else { 0.0 })
/// })?;
/// WorldBuilder::new().set_environment("sky", sky)?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct FunctionEnvironment<F> {
    radiance: F,
    /// Means over the cells of bands one after the other, of which the uniform share is a part.
    weights: Vec<f64>,
    sum: f64,
    distribution: Option<PiecewiseConstant2d>,
    /// `∫ L dσ`, as the table has it.
    integral: Rgb,
    extent: SceneExtent,
}

impl<F: Fn(DVec3) -> Rgb + Sync> FunctionEnvironment<F> {
    /// The radiance (W/(m² sr)) that comes from a direction, a unit vector that points from the scene
    /// to the sky. The function must give finite numbers, none of them negative, and always the same.
    ///
    /// # Errors
    /// If a radiance is negative or not finite in one of the directions of the table.
    pub fn new(radiance: F) -> Result<Self, EndpointError> {
        let (mut weights, mut integral) = (Vec::with_capacity(CELLS), Rgb::BLACK);
        for cell in 0..CELLS {
            let mut mean = 0.0;
            for k in 0..TRIES * TRIES {
                let within = DVec2::new((k / TRIES) as f64, (k % TRIES) as f64) + 0.5;
                let towards = direction_in(cell, within / TRIES as f64);
                let value = check::emission(OBJECT, "radiance", radiance(towards))?;
                mean += value.max_component() / (TRIES * TRIES) as f64;
                integral += value * (4.0 * PI / (CELLS * TRIES * TRIES) as f64);
            }
            weights.push(mean);
        }
        let mean = weights.iter().sum::<f64>() / CELLS as f64;
        let floor = if mean > 0.0 { mean * UNIFORM_SHARE / (1.0 - UNIFORM_SHARE) } else { 1.0 };
        weights.iter_mut().for_each(|weight| *weight += floor);
        Ok(Self::of(radiance, weights, integral))
    }

    /// The same light, all of whose directions are alike: density 1/4π.
    #[must_use]
    pub fn uniformly_sampled(self) -> Self {
        Self::of(self.radiance, vec![1.0; CELLS], self.integral)
    }

    fn of(radiance: F, weights: Vec<f64>, integral: Rgb) -> Self {
        let distribution =
            PiecewiseConstant2d::new(SECTORS, BANDS, |band, first| block(&weights, band, first));
        let sum = weights.iter().sum();
        Self { radiance, weights, sum, distribution, integral, extent: SceneExtent::default() }
    }
}

/// The weights of a block of sectors.
fn block(weights: &[f64], band: usize, first: usize) -> [f64; BLOCK] {
    let mut block = [0.0; BLOCK];
    block.copy_from_slice(&weights[band * SECTORS + first..][..BLOCK]);
    block
}

/// The direction at a place in [0, 1]² of a cell.
fn direction_in(cell: usize, within: DVec2) -> DVec3 {
    let corner = DVec2::new((cell / SECTORS) as f64, (cell % SECTORS) as f64);
    square_to_sphere((corner + within) / DVec2::new(BANDS as f64, SECTORS as f64))
}

/// The cell of a direction.
fn cell_of(towards: DVec3) -> usize {
    let band = (0.5 * (1.0 - towards.z) * BANDS as f64) as usize;
    let sector = (angle::turn(towards.y, towards.x) * SECTORS as f64) as usize;
    band.min(BANDS - 1) * SECTORS + sector.min(SECTORS - 1)
}

impl<F: Fn(DVec3) -> Rgb + Sync> Endpoint for FunctionEnvironment<F> {
    fn sample_point(&self, _u1: f64, u2: DVec2) -> Option<PointSample> {
        let weights = |band, first| block(&self.weights, band, first);
        let GridSample { row, column, within } = self.distribution.as_ref()?.sample(u2, weights);
        let towards = direction_in(row * SECTORS + column, DVec2::new(within.y, within.x));
        let point = SurfacePoint::infinite(DVec3::ZERO, -towards);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
        let weight = self.weights[cell_of(-point.geometric_normal)];
        PerArea(weight / self.sum * CELLS as f64 / (4.0 * PI))
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        self.extent.sample_direction(point, (self.radiance)(-point.geometric_normal), u)
    }

    fn direction_pdf(&self, point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        self.extent.direction_pdf(point)
    }

    fn emit(&self, point: &SurfacePoint, _direction: DVec3) -> Rgb {
        (self.radiance)(-point.geometric_normal)
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        self.extent.facing(point, receiver)
    }
}

impl<F: Fn(DVec3) -> Rgb + Sync> Light for FunctionEnvironment<F> {
    /// The flux into the spheres around the boxes of the scene's extent, as the table has it.
    fn power(&self) -> Rgb {
        self.integral * self.extent.cross_section()
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        self.extent = extent.clone();
    }
}

impl<F> fmt::Debug for FunctionEnvironment<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FunctionEnvironment")
            .field("integral", &self.integral)
            .field("extent", &self.extent)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::{Estimate, chi_square};
    use crate::math::warp::testing::random;

    /// A bright spot, a black part, and something in between.
    fn sky(w: DVec3) -> Rgb {
        let spot = 50.0 * w.dot(DVec3::new(0.6, 0.0, 0.8)).max(0.0).powi(40);
        Rgb::new(1.0, 0.5, 0.25) * (w.y.max(0.0) + spot)
    }

    #[test]
    fn directions_have_the_density_that_is_told() {
        let (mut rng, samples) = (random(1), 400_000);
        let sky = FunctionEnvironment::new(sky).unwrap();
        for light in [sky.clone(), sky.uniformly_sampled()] {
            let (mut counts, mut expected) = (vec![0.0; CELLS], vec![0.0; CELLS]);
            for (cell, expected) in expected.iter_mut().enumerate() {
                let towards = direction_in(cell, DVec2::splat(0.5));
                let point = SurfacePoint::infinite(DVec3::ZERO, -towards);
                *expected = light.point_pdf(&point).value() * 4.0 * PI / CELLS as f64;
            }
            assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(expected.iter().all(|p| *p > 0.2 / CELLS as f64));
            // Places within cells: the two halves of each axis.
            let mut quarters = [0.0; 4];
            for _ in 0..samples {
                let sample = light.sample_point(0.5, DVec2::new(rng(), rng())).unwrap();
                assert_eq!(sample.pdf, light.point_pdf(&sample.point));
                let towards = -sample.point.geometric_normal;
                counts[cell_of(towards)] += 1.0;
                let half = |x: f64| usize::from(x.fract() >= 0.5);
                let band = half(0.5 * (1.0 - towards.z) * BANDS as f64);
                let sector = half(angle::turn(towards.y, towards.x) * SECTORS as f64);
                quarters[2 * band + sector] += 1.0;
            }
            expected.iter_mut().for_each(|p| *p *= f64::from(samples));
            let test = chi_square(&counts, &expected, 10.0);
            assert!(test.p_value > 1e-4, "{test:?}");
            let test = chi_square(&quarters, &[0.25 * f64::from(samples); 4], 10.0);
            assert!(test.p_value > 1e-4, "{test:?}");
        }
    }

    /// `∫ cos⁴⁰ dω = 2π/41` and `∫ max(cos, 0) dω = π`.
    #[test]
    fn energy_is_that_of_the_function() {
        let expected = 50.0 * 2.0 * PI / 41.0 + PI;
        let mut light = FunctionEnvironment::new(sky).unwrap();
        assert!((light.integral.r() / expected - 1.0).abs() < 1e-3, "{:?}", light.integral);
        light.set_scene_extent(&crate::geometry::Bounds::of_points([DVec3::ZERO, DVec3::X]).into());
        let power = expected * light.extent.cross_section();
        assert!((light.power().r() / power - 1.0).abs() < 1e-3);
        let mut rng = random(2);
        let estimate: Estimate = (0..200_000)
            .map(|_| {
                let sample = light.sample_point(0.5, DVec2::new(rng(), rng())).unwrap();
                light.emit(&sample.point, DVec3::ZERO).r() / sample.pdf.value()
            })
            .collect();
        assert!(estimate.z_score(expected).abs() < 4.0, "{estimate:?} {expected}");
        assert!(estimate.standard_error() < 0.0025 * expected);
    }

    #[test]
    fn bad_functions_are_refused() {
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            let light = FunctionEnvironment::new(|w| Rgb::from(if w.x > 0.9 { bad } else { 1.0 }));
            assert!(light.is_err());
        }
        // What was nowhere seen may shine all the same.
        let light = FunctionEnvironment::new(|_| Rgb::BLACK).unwrap();
        let sample = light.sample_point(0.5, DVec2::splat(0.3)).unwrap();
        assert!((sample.pdf.value() * 4.0 * PI - 1.0).abs() < 1e-12);
    }
}
