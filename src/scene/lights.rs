//! The lights of a world: emissive surfaces as endpoints, and the choice among all lights by their power.

use super::error::SceneError;
use crate::endpoint::{DirectionSample, Endpoint, Light, LightId, PointSample};
use crate::geometry::{Bounds, Frame, Shape, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb, warp};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI};

/// A light that a world can own.
pub(crate) type BoxedLight = Box<dyn Light + Send>;

/// The light of an emissive surface.
pub(crate) fn area_light(shapes: Vec<Shape>, first_primitive: u32, surface: u32, radiance: Rgb, two_sided: bool) -> BoxedLight {
    let areas: Vec<f64> = shapes.iter().map(Shape::area).collect();
    let choice = Choice::new(&areas);
    Box::new(SurfaceLight { area: areas.iter().sum(), shapes, choice, first_primitive, surface, radiance, two_sided })
}

/// Tells all lights how large the scene is and builds the table to choose among them.
pub(crate) fn prepare(lights: &mut [(String, BoxedLight)], bounds: &Bounds) -> Result<Choice, SceneError> {
    let mut powers = Vec::with_capacity(lights.len());
    for (name, light) in lights {
        light.set_scene_bounds(bounds);
        let power = light.power();
        power.0.iter().try_for_each(|&p| super::error::check(name, "power", p, "finite and not negative", |p| p >= 0.0))?;
        powers.push(power.mean());
    }
    Ok(Choice::new(&powers))
}

/// A choice among numbered things with given weights; those of weight 0 are never chosen.
#[derive(Debug)]
pub(crate) struct Choice {
    /// Upper end of each thing's share of [0, 1); empty if all weights are 0.
    cumulative: Vec<f64>,
    pmf: Vec<f64>,
}

impl Choice {
    /// From finite weights that are not negative.
    pub fn new(weights: &[f64]) -> Self {
        // Scaled first: the sum of large weights must not overflow.
        let largest = weights.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return Self { cumulative: Vec::new(), pmf: vec![0.0; weights.len()] };
        }
        let sum: f64 = weights.iter().map(|w| w / largest).sum();
        let pmf: Vec<f64> = weights.iter().map(|w| w / largest / sum).collect();
        let mut total = 0.0;
        let cumulative = pmf
            .iter()
            .map(|p| {
                total += p;
                total
            })
            .collect();
        Self { cumulative, pmf }
    }

    /// Chooses with a number in [0, 1); `None` if all weights are 0.
    pub fn sample(&self, u: f64) -> Option<(usize, f64)> {
        let last = self.cumulative.last()?;
        // Strictly greater: a share of width 0 is skipped.
        let chosen = self.cumulative.partition_point(|&c| c <= u * last);
        let chosen = if chosen < self.pmf.len() { chosen } else { self.pmf.iter().rposition(|&p| p > 0.0)? };
        Some((chosen, self.pmf[chosen]))
    }

    /// The probability of one of the things; 0 for a number that is none of them.
    pub fn pmf(&self, index: usize) -> f64 {
        self.pmf.get(index).copied().unwrap_or(0.0)
    }

    /// The id of a light chosen by this table.
    pub fn sample_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.sample(u).map(|(index, pmf)| (LightId(index as u32), pmf))
    }
}

/// A surface that emits the same radiance everywhere and into all directions of its front side, or of both.
#[derive(Debug)]
struct SurfaceLight {
    shapes: Vec<Shape>,
    choice: Choice,
    area: f64,
    first_primitive: u32,
    surface: u32,
    radiance: Rgb,
    two_sided: bool,
}

impl Endpoint for SurfaceLight {
    fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample> {
        let (i, _) = self.choice.sample(u1)?;
        let mut point = self.shapes[i].sample_area(u2);
        point.primitive = self.first_primitive + i as u32;
        point.surface = self.surface;
        Some(PointSample { point, pdf: PerArea(1.0 / self.area) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0 / self.area)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let back = self.two_sided && u.x < 0.5;
        let u = if self.two_sided { DVec2::new((2.0 * u.x).fract(), u.y) } else { u };
        let mut local = warp::square_to_cosine_hemisphere(u);
        local.z = if back { -local.z } else { local.z };
        let direction = Frame::from_normal(point.geometric_normal).to_world(local);
        let pdf = self.direction_pdf(point, direction);
        (pdf.0 > 0.0).then(|| DirectionSample { from: *point, direction, pdf, weight: self.radiance * (1.0 / pdf.0) })
    }

    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
        let cos = point.geometric_normal.dot(direction);
        PerProjected(match self.two_sided {
            true => 0.5 * FRAC_1_PI,
            false if cos > 0.0 => FRAC_1_PI,
            false => 0.0,
        })
    }

    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        if self.two_sided || point.geometric_normal.dot(direction) > 0.0 { self.radiance } else { Rgb::BLACK }
    }
}

impl Light for SurfaceLight {
    fn power(&self) -> Rgb {
        self.radiance * (PI * self.area * if self.two_sided { 2.0 } else { 1.0 })
    }

    fn can_be_hit(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_zero_are_never_chosen() {
        let choice = Choice::new(&[0.0, 1.0, 0.0, 3.0, 0.0]);
        assert_eq!(choice.sample(0.0), Some((1, 0.25)));
        assert_eq!(choice.sample(0.25), Some((3, 0.75)));
        assert_eq!(choice.sample(1.0f64.next_down()), Some((3, 0.75)));
        assert_eq!(choice.sample(1.0), Some((3, 0.75)));
        assert_eq!((choice.pmf(0), choice.pmf(9)), (0.0, 0.0));
        assert_eq!(Choice::new(&[0.0, 0.0]).sample(0.5), None);
        assert_eq!(Choice::new(&[]).sample(0.5), None);
        assert_eq!(Choice::new(&[1e308, 1e308]).sample(0.7), Some((1, 0.5)));
    }
}
