//! An environment given by a latitude-longitude image.

use super::{DirectionSample, Endpoint, EndpointError, Light, PointSample, extent::SceneExtent};
use crate::geometry::{Bounds, SurfacePoint};
use crate::math::angle;
use crate::math::distribution::PiecewiseConstant2d;
use crate::math::{PerArea, PerProjected, PerSolidAngle, Rgb};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI};

/// How radiance between the pixels' centres is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lookup {
    /// Each pixel is a patch of constant radiance, which is sampled exactly.
    #[default]
    PiecewiseConstant,
    /// Linear in both angles between the pixels' centres.
    Bilinear,
}

/// Radiance from infinitely far away, given by an image.
///
/// Row i of H covers the angles [π i/H, π (i+1)/H] from the up axis, +Y before rotation. The left edge of the image is at -Z, and columns
/// run to the right as seen from the inside, through +X at a quarter of the width.
///
/// A pixel is chosen in proportion to its largest component times its exact solid angle, then a direction uniformly in its solid angle, so
/// rows at the poles need no special care. With bilinear lookup the image is blurred over neighbours for sampling, which covers all
/// that the interpolation reaches.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
    bands: Vec<Band>,
    /// Columns are the image's axes in the world.
    rotation: DMat3,
    lookup: Lookup,
    /// `None` if everything is black.
    distribution: Option<PiecewiseConstant2d>,
    /// `∫ L dσ`.
    integral: Rgb,
    extent: SceneExtent,
}

/// The directions of a row of pixels.
#[derive(Clone, Copy, Debug)]
struct Band {
    /// sin²(θ/2) at its upper edge, which is (1 - cos θ)/2 and so uniform in solid angle.
    upper: f64,
    /// What is added to it at the lower edge.
    step: f64,
    /// Solid angle of each of its pixels, `Δφ (cos θ_0 - cos θ_1)`, without the difference.
    solid_angle: f64,
}

impl Band {
    fn new(row: usize, width: usize, height: usize) -> Self {
        let half_step = 0.5 * PI / height as f64;
        let [upper, lower] = [row, row + 1].map(|edge| (edge as f64 * half_step).sin().powi(2));
        let middle = (2 * row + 1) as f64 * half_step;
        Self { upper, step: lower - upper, solid_angle: 2.0 * PI / width as f64 * 2.0 * middle.sin() * half_step.sin() }
    }
}

/// A pixel, and a place inside it in [0, 1].
struct Place {
    column: usize,
    row: usize,
    within: DVec2,
}

impl EnvironmentMap {
    /// The rotation for scenes whose up axis is +Z: the left edge of the image is at +Y, a quarter of the width at +X.
    pub const Z_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

    /// From row-major pixels (W/(m² sr)), the uppermost row first. `rotation` turns the image's axes into the world's: the identity for +Y
    /// up, [`EnvironmentMap::Z_UP`], or any orthogonal matrix, reflections included.
    ///
    /// # Errors
    /// If the number of pixels is zero or not `width * height`, if a pixel is negative or not finite, or if the matrix is not orthogonal.
    pub fn new(width: u32, height: u32, pixels: Vec<Rgb>, rotation: DMat3) -> Result<Self, EndpointError> {
        let count = (width as usize).checked_mul(height as usize);
        if pixels.is_empty() || count != Some(pixels.len()) {
            return Err(EndpointError::PixelCount { width, height, pixels: pixels.len() });
        }
        if let Some(i) = pixels.iter().position(|p| !p.is_finite() || p.0.iter().any(|c| *c < 0.0)) {
            let i = i as u64;
            return Err(EndpointError::InvalidPixel { column: (i % u64::from(width)) as u32, row: (i / u64::from(width)) as u32 });
        }
        let rotation = orthogonal(rotation).ok_or(EndpointError::NotARotation { object: "environment map" })?;
        let map = Self {
            width: width as usize,
            height: height as usize,
            pixels,
            bands: (0..height as usize).map(|row| Band::new(row, width as usize, height as usize)).collect(),
            rotation,
            lookup: Lookup::default(),
            distribution: None,
            integral: Rgb::BLACK,
            extent: SceneExtent::default(),
        };
        Ok(map.with_lookup(Lookup::PiecewiseConstant))
    }

    /// The same map with another lookup.
    #[must_use]
    pub fn with_lookup(mut self, lookup: Lookup) -> Self {
        self.lookup = lookup;
        self.integral =
            (0..self.height).map(|row| (0..self.width).map(|c| self.pixel(c, row)).sum::<Rgb>() * self.bands[row].solid_angle).sum();
        // Relative to the brightest pixel, so that sums cannot overflow.
        let brightest = self.pixels.iter().map(|p| p.max_component()).fold(0.0, f64::max);
        if brightest > 0.0 {
            let mut weights = Vec::with_capacity(self.pixels.len());
            for row in 0..self.height {
                let solid_angle = self.bands[row].solid_angle;
                weights.extend((0..self.width).map(|column| solid_angle * self.importance(column, row, brightest)));
            }
            self.distribution = PiecewiseConstant2d::new(self.width, self.height, &weights);
        }
        self
    }

    /// Radiance that arrives from the direction `towards` the environment (unit, in the world).
    #[must_use]
    pub fn radiance(&self, towards: DVec3) -> Rgb {
        let Place { column, row, within } = self.place(towards);
        match self.lookup {
            Lookup::PiecewiseConstant => self.pixel(column, row),
            Lookup::Bilinear => {
                // The nearer neighbour in each direction, if there is one; around the axis there always is.
                let (columns, x) = if within.x < 0.5 {
                    ([if column == 0 { self.width - 1 } else { column - 1 }, column], within.x + 0.5)
                } else {
                    ([column, if column + 1 == self.width { 0 } else { column + 1 }], within.x - 0.5)
                };
                let (rows, y) = if within.y < 0.5 {
                    ([row.saturating_sub(1), row], within.y + 0.5)
                } else {
                    ([row, (row + 1).min(self.height - 1)], within.y - 0.5)
                };
                let across = |row: usize| self.pixel(columns[0], row) * (1.0 - x) + self.pixel(columns[1], row) * x;
                across(rows[0]) * (1.0 - y) + across(rows[1]) * y
            }
        }
    }

    /// What a pixel is worth to sampling. With bilinear lookup neighbours shine into it; the kernel (1 2 1)/4 in both directions keeps
    /// the ratio of radiance to importance at 4 or below.
    fn importance(&self, column: usize, row: usize, scale: f64) -> f64 {
        let value = |c: usize, r: usize| self.pixel(c, r).max_component() / scale;
        match self.lookup {
            Lookup::PiecewiseConstant => value(column, row),
            Lookup::Bilinear => {
                let columns = [(column + self.width - 1) % self.width, column, (column + 1) % self.width];
                let rows = [row.saturating_sub(1), row, (row + 1).min(self.height - 1)];
                let across = |r: usize| 0.25 * value(columns[0], r) + 0.5 * value(columns[1], r) + 0.25 * value(columns[2], r);
                0.25 * across(rows[0]) + 0.5 * across(rows[1]) + 0.25 * across(rows[2])
            }
        }
    }

    fn pixel(&self, column: usize, row: usize) -> Rgb {
        self.pixels[row * self.width + column]
    }

    /// The one place that decides which pixel a direction belongs to, for lookup and for sampling.
    fn place(&self, towards: DVec3) -> Place {
        let w = self.rotation.transpose() * towards;
        let split = |x: f64, count: usize| {
            let scaled = x * count as f64;
            let cell = (scaled as usize).min(count - 1);
            (cell, scaled - cell as f64)
        };
        let (column, x) = split(angle::turn(w.x, -w.z), self.width);
        let (row, y) = split(FRAC_1_PI * angle::atan2((w.x * w.x + w.z * w.z).sqrt(), w.y), self.height);
        Place { column, row, within: DVec2::new(x, y) }
    }

    /// Density per solid angle of sampling the direction `towards` the environment.
    fn pdf(&self, towards: DVec3) -> PerSolidAngle {
        let Some(distribution) = &self.distribution else {
            return PerSolidAngle::ZERO;
        };
        let Place { column, row, .. } = self.place(towards);
        PerSolidAngle(distribution.pmf(column, row) / self.bands[row].solid_angle)
    }
}

/// The orthogonal matrix that an almost orthogonal one means, by Gram and Schmidt.
fn orthogonal(m: DMat3) -> Option<DMat3> {
    let error = m.transpose() * m - DMat3::IDENTITY;
    if !error.to_cols_array().iter().all(|e| e.abs() < 1e-4) {
        return None;
    }
    let x = m.x_axis.normalize();
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize();
    let z = x.cross(y);
    Some(DMat3::from_cols(x, y, if z.dot(m.z_axis) < 0.0 { -z } else { z }))
}

impl Endpoint for EnvironmentMap {
    fn sample_point(&self, _u1: f64, u2: DVec2) -> Option<PointSample> {
        let cell = self.distribution.as_ref()?.sample(u2);
        let (sin_phi, cos_phi) = angle::sin_cos_of_turn((cell.column as f64 + cell.within.x) / self.width as f64);
        let band = self.bands[cell.row];
        let s = band.upper + band.step * cell.within.y;
        let sin_theta = 2.0 * (s * (1.0 - s)).max(0.0).sqrt();
        let local = DVec3::new(sin_theta * sin_phi, 1.0 - 2.0 * s, -sin_theta * cos_phi);
        let point = SurfacePoint::infinite(DVec3::ZERO, -(self.rotation * local).normalize());
        // Asked of the direction itself: at a pixel's border rounding may have moved it next door.
        let pdf = self.point_pdf(&point);
        (pdf.value() > 0.0).then_some(PointSample { point, pdf })
    }

    fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
        PerArea(self.pdf(-point.geometric_normal).value())
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = point.geometric_normal;
        let pdf = self.direction_pdf(point, direction);
        let from = SurfacePoint { position: self.extent.sample_ray(direction, u), ..*point };
        (pdf.value() > 0.0).then(|| DirectionSample { from, direction, pdf, weight: self.emit(point, direction) / pdf.value() })
    }

    fn direction_pdf(&self, point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        self.extent.ray_pdf(point.geometric_normal)
    }

    fn emit(&self, point: &SurfacePoint, _direction: DVec3) -> Rgb {
        self.radiance(-point.geometric_normal)
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        self.extent.facing(point, receiver)
    }
}

impl Light for EnvironmentMap {
    /// The flux into the sphere around the scene, `π R² ∫ L dσ`.
    fn power(&self) -> Rgb {
        self.integral * (PI * self.extent.radius().powi(2))
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn is_black(&self) -> bool {
        self.integral.is_black()
    }

    fn set_scene_bounds(&mut self, bounds: &Bounds) {
        self.extent = SceneExtent::new(bounds);
    }
}
