//! An environment given by a latitude-longitude image.

use super::{AnyLight, DirectionSample, Endpoint, EndpointError, Light, PointSample, SceneExtent};
use crate::geometry::SurfacePoint;
use crate::math::angle;
use crate::math::distribution::{GridSample, PiecewiseConstant2d};
use crate::math::{PerArea, PerProjected, PerSolidAngle, Rgb, warp::unit_to_linear};
use glam::{DMat3, DVec2, DVec3, Vec2Swizzles};
use std::f64::consts::{FRAC_1_PI, PI};
use std::ops::{Add, Mul};

const BLOCK: usize = PiecewiseConstant2d::BLOCK;

/// The interpolation of radiance between the pixels' centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lookup {
    /// Each pixel is a patch of constant radiance.
    #[default]
    PiecewiseConstant,
    /// Linear in both angles between the pixels' centres: patches have their corners there. Those
    /// at the poles are half as high and constant along their height.
    Bilinear,
    /// The same but for the rows, which lie at equal angles from pole to pole: of H rows, row i at
    /// π i/(H - 1). Mitsuba's lookup (Jakob et al. 2022, plug-in `envmap`).
    BilinearToPoles,
}

/// Radiance from infinitely far away, given by an image.
///
/// Row i of H covers the angles [π i/H, π (i+1)/H] from the up axis, +Y before rotation. The left
/// edge of the image is at -Z, and columns run to the right as seen from the inside, through +X at
/// a quarter of the width.
///
/// Sampling chooses a patch in proportion to its mean largest component times its exact solid
/// angle, first its column, since with a sky above a ground neighbouring columns are alike and rows
/// are not: numbers next to each other then choose directions next to each other. In a patch of a
/// pixel the density is constant in solid angle; between pixels' centres it is linear in azimuth
/// and in solid angle from the upper edge, so that it differs from what is linear in both angles by
/// a factor from 2/3 to 2 in the rows next to the poles, and by next to nothing elsewhere. Where
/// rows reach the poles it is from 1/2 upwards, largest at a black pole, with finite variance.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    pixels: Pixels,
    /// The rows of patches.
    bands: Vec<Band>,
    /// Columns are the image's axes in the world.
    rotation: DMat3,
    lookup: Lookup,
    /// The largest component of all pixels. Sampling is relative to it, so that sums cannot
    /// overflow.
    brightest: f64,
    /// The patches, rows and columns exchanged, since the azimuth is chosen first; `None` if
    /// everything is black.
    distribution: Option<PiecewiseConstant2d>,
    /// `∫ D dσ`, D the density before it is normalised.
    density_integral: f64,
    /// `∫ L dσ`.
    integral: Rgb,
    extent: SceneExtent,
}

/// Pixels, column after column since sampling goes down one, and as f32 where that is what they
/// are: most time goes by waiting for memory.
#[derive(Clone, Debug)]
enum Pixels {
    Single(Vec<[f32; 3]>),
    Double(Vec<Rgb>),
}

impl From<Vec<Rgb>> for Pixels {
    fn from(pixels: Vec<Rgb>) -> Self {
        let is_single = |pixel: &Rgb| pixel.map(|c| f64::from(c as f32)) == *pixel;
        if pixels.iter().all(is_single) {
            Self::Single(pixels.iter().map(|pixel| pixel.0.map(|c| c as f32)).collect())
        } else {
            Self::Double(pixels)
        }
    }
}

impl Pixels {
    /// The pixels of row-major ones.
    fn of_rows(pixels: &[Rgb], width: usize) -> Self {
        let column = |i: usize| pixels[i..].iter().step_by(width).copied();
        (0..width).flat_map(column).collect::<Vec<_>>().into()
    }

    #[inline(always)]
    fn at(&self, index: usize) -> Rgb {
        match self {
            Self::Single(pixels) => Rgb(pixels[index].map(f64::from)),
            Self::Double(pixels) => pixels[index],
        }
    }
}

/// The directions of a row of patches.
#[derive(Clone, Copy, Debug)]
struct Band {
    /// sin²(θ/2) at its upper edge, which is (1 - cos θ)/2 and so uniform in solid angle.
    upper: f64,
    /// The difference from there to its lower edge.
    step: f64,
}

impl Band {
    /// The band between two polar angles.
    fn new(upper: f64, lower: f64) -> Self {
        Self {
            upper: libm::sin(0.5 * upper).powi(2),
            step: libm::sin(0.5 * (lower + upper)) * libm::sin(0.5 * (lower - upper)),
        }
    }

    /// The share of its solid angle that lies above a direction with the up axis at +Y.
    fn part_above(&self, w: DVec3) -> f64 {
        // Without the difference near the upper pole.
        let s =
            if w.y > 0.0 { 0.5 * (w.x * w.x + w.z * w.z) / (1.0 + w.y) } else { 0.5 - 0.5 * w.y };
        ((s - self.upper) / self.step).clamp(0.0, 1.0)
    }
}

/// A patch, and a place inside it in [0, 1].
struct Place {
    column: usize,
    row: usize,
    within: DVec2,
}

impl EnvironmentMap {
    /// The rotation for scenes whose up axis is +Z: the left edge of the image is at +Y, a quarter
    /// of the width at +X.
    pub const Z_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

    /// A map of row-major pixels (W/(m² sr)), the uppermost row first. `rotation` turns the image's
    /// axes into the world's: the identity for +Y up, [`EnvironmentMap::Z_UP`], or any orthogonal
    /// matrix, reflections included.
    ///
    /// # Errors
    /// If the number of pixels is zero or not `width * height`, if a pixel is negative or not
    /// finite, or if the matrix is not orthogonal.
    pub fn new(
        width: u32,
        height: u32,
        pixels: Vec<Rgb>,
        rotation: DMat3,
    ) -> Result<Self, EndpointError> {
        let count = (width as usize).checked_mul(height as usize);
        if pixels.is_empty() || count != Some(pixels.len()) {
            return Err(EndpointError::PixelCount { width, height, pixels: pixels.len() });
        }
        if let Some(i) = pixels.iter().position(|p| !p.is_finite() || p.0.iter().any(|c| *c < 0.0))
        {
            let i = i as u64;
            return Err(EndpointError::InvalidPixel {
                column: (i % u64::from(width)) as u32,
                row: (i / u64::from(width)) as u32,
            });
        }
        let rotation = orthogonal(rotation)
            .ok_or(EndpointError::NotARotation { object: "environment map" })?;
        let brightest = pixels.iter().map(|p| p.max_component()).fold(0.0, f64::max);
        let map = Self {
            width: width as usize,
            height: height as usize,
            pixels: Pixels::of_rows(&pixels, width as usize),
            bands: Vec::new(),
            rotation,
            lookup: Lookup::default(),
            brightest,
            distribution: None,
            density_integral: 0.0,
            integral: Rgb::BLACK,
            extent: SceneExtent::default(),
        };
        Ok(map.with_lookup(Lookup::PiecewiseConstant))
    }

    /// The same map with another lookup.
    #[must_use]
    pub fn with_lookup(mut self, lookup: Lookup) -> Self {
        // There is no step between the poles of a single row.
        let is_row = self.height == 1 && lookup == Lookup::BilinearToPoles;
        self.lookup = if is_row { Lookup::Bilinear } else { lookup };
        let steps = self.steps();
        let step = PI / steps as f64;
        let edge =
            |row: usize| (row as f64 - self.displacement().y).clamp(0.0, steps as f64) * step;
        let last = steps + usize::from(self.lookup == Lookup::Bilinear);
        self.bands = (0..last).map(|row| Band::new(edge(row), edge(row + 1))).collect();
        (self.integral, self.density_integral) = (Rgb::BLACK, 0.0);
        let height = self.bands.len();
        for (row, band) in self.bands.iter().enumerate() {
            let solid_angle = self.solid_angle(band);
            let (mut radiance, mut density) = (Rgb::BLACK, 0.0);
            for column in 0..self.width {
                let middle = Place { column, row, within: DVec2::splat(0.5) };
                density += if self.brightest > 0.0 { self.density(&middle) } else { 0.0 };
                radiance += self.interpolate(&middle, |pixel| pixel);
            }
            self.integral += radiance * solid_angle;
            self.density_integral += density * solid_angle;
        }
        let weights = |column, first| self.weights(column, first);
        self.distribution = PiecewiseConstant2d::new(height, self.width, weights);
        self
    }

    /// The solid angle of each patch of a band.
    fn solid_angle(&self, band: &Band) -> f64 {
        4.0 * PI / self.width as f64 * band.step
    }

    /// The weights of a block of patches of a column in the order of rows: solid angle times
    /// density in the middle.
    #[inline(always)]
    fn weights(&self, column: usize, first: usize) -> [f64; BLOCK] {
        let columns = [column, self.column_right_of(column)];
        let first_pixel = first as isize - isize::from(self.lookup == Lookup::Bilinear);
        // Both columns at a time, so that neither waits for the other to come from memory.
        let mut pixels = [[0.0; 2]; BLOCK + 1];
        for (row, pixels) in (first_pixel..).zip(&mut pixels) {
            let row = (row.max(0) as usize).min(self.height - 1);
            let brightness = |column| self.pixel(column, row).max_component();
            *pixels = [brightness(columns[0]), brightness(columns[1])];
        }
        let mut weights = [0.0; BLOCK];
        for (i, (band, weight)) in self.bands[first..].iter().zip(&mut weights).enumerate() {
            let mean = match self.lookup {
                Lookup::PiecewiseConstant => pixels[i][0],
                _ => bilinear([pixels[i], pixels[i + 1]], DVec2::splat(0.5)),
            };
            *weight = self.solid_angle(band) * (mean / self.brightest);
        }
        weights
    }

    /// Radiance that arrives from the direction `towards` the environment (unit, in the world).
    #[must_use]
    pub fn radiance(&self, towards: DVec3) -> Rgb {
        self.interpolate(&self.place(self.rotation.transpose() * towards), |pixel| pixel)
    }

    /// The density per solid angle but for a constant factor, where `within` is a part of the
    /// patch's solid angle.
    fn density(&self, place: &Place) -> f64 {
        self.interpolate(place, |pixel| pixel.max_component()) / self.brightest
    }

    fn interpolate<T: Mul<f64, Output = T> + Add<Output = T>>(
        &self,
        place: &Place,
        value: impl Fn(Rgb) -> T,
    ) -> T {
        let Place { column, row, within } = *place;
        match self.lookup {
            Lookup::PiecewiseConstant => value(self.pixel(column, row)),
            _ => bilinear(self.corners(column, row, value), within),
        }
    }

    /// Values of the pixels around a patch between their centres, the upper ones first.
    #[inline]
    fn corners<T>(&self, left: usize, row: usize, value: impl Fn(Rgb) -> T) -> [[T; 2]; 2] {
        let right = self.column_right_of(left);
        let (upper, lower) = if self.lookup == Lookup::Bilinear {
            (row.saturating_sub(1), row.min(self.height - 1))
        } else {
            (row, row + 1)
        };
        let at = |column, row| value(self.pixel(column, row));
        // Not by `array::map`, which moves them through memory.
        [[at(left, upper), at(right, upper)], [at(left, lower), at(right, lower)]]
    }

    #[inline(always)]
    fn pixel(&self, column: usize, row: usize) -> Rgb {
        self.pixels.at(column * self.height + row)
    }

    #[inline(always)]
    fn column_right_of(&self, left: usize) -> usize {
        if left + 1 == self.width { 0 } else { left + 1 }
    }

    /// The displacement of patches against the grid of columns and steps, to the right and
    /// upwards.
    fn displacement(&self) -> DVec2 {
        match self.lookup {
            Lookup::PiecewiseConstant => DVec2::ZERO,
            Lookup::Bilinear => DVec2::splat(0.5),
            Lookup::BilinearToPoles => DVec2::new(0.5, 0.0),
        }
    }

    /// The distance of the poles in distances of rows.
    fn steps(&self) -> usize {
        self.height - usize::from(self.lookup == Lookup::BilinearToPoles)
    }

    /// The one place that decides which patch a direction belongs to, in the image's axes, for
    /// lookup and for sampling.
    fn place(&self, w: DVec3) -> Place {
        let split = |x: f64, count: usize| {
            let cell = (x as usize).min(count - 1);
            (cell, x - cell as f64)
        };
        let x = angle::turn(w.x, -w.z) * self.width as f64 - self.displacement().x;
        let (column, x) = split(if x < 0.0 { x + self.width as f64 } else { x }, self.width);
        let polar = FRAC_1_PI * angle::atan2((w.x * w.x + w.z * w.z).sqrt(), w.y);
        let (row, y) = split(polar * self.steps() as f64 + self.displacement().y, self.bands.len());
        Place { column, row, within: DVec2::new(x, y) }
    }

    /// Density per solid angle of sampling a direction in the image's axes, whose place is given.
    #[inline(always)]
    fn pdf(&self, w: DVec3, &Place { column, row, within }: &Place) -> PerSolidAngle {
        if self.distribution.is_none() {
            return PerSolidAngle::ZERO;
        }
        let within = DVec2::new(within.x, self.bands[row].part_above(w));
        PerSolidAngle(self.density(&Place { column, row, within }) / self.density_integral)
    }

    /// Radiance from the direction `towards` the environment, and the density per solid angle of
    /// sampling it.
    #[inline(always)]
    fn radiance_and_pdf(&self, towards: DVec3) -> (Rgb, PerSolidAngle) {
        let w = self.rotation.transpose() * towards;
        let place = self.place(w);
        (self.interpolate(&place, |pixel| pixel), self.pdf(w, &place))
    }

    /// A point chosen by the image, with its radiance.
    #[inline(always)]
    fn sample(&self, u2: DVec2) -> Option<(PointSample, Rgb)> {
        let weights = |column, first| self.weights(column, first);
        let GridSample { row: column, column: row, within } =
            self.distribution.as_ref()?.sample(u2.yx(), weights);
        let mut within = within.yx();
        if self.lookup != Lookup::PiecewiseConstant {
            let [[a, b], [c, d]] =
                self.corners(column, row, |pixel| pixel.max_component() / self.brightest);
            within.y = unit_to_linear(within.y, a + b, c + d);
            within.x = unit_to_linear(
                within.x,
                a * (1.0 - within.y) + c * within.y,
                b * (1.0 - within.y) + d * within.y,
            );
        }
        let (sin_phi, cos_phi) = angle::sin_cos_of_turn(
            (column as f64 + within.x + self.displacement().x) / self.width as f64,
        );
        let band = self.bands[row];
        let s = band.upper + band.step * within.y;
        let sin_theta = 2.0 * (s * (1.0 - s)).max(0.0).sqrt();
        let local = DVec3::new(sin_theta * sin_phi, 1.0 - 2.0 * s, -sin_theta * cos_phi);
        let towards = (self.rotation * local).normalize();
        // Asked of the direction itself: at a patch's border rounding may have moved it next door.
        let (radiance, pdf) = self.radiance_and_pdf(towards);
        let point = SurfacePoint::infinite(DVec3::ZERO, -towards);
        let pdf = PerArea(pdf.value());
        (pdf.value() > 0.0).then_some((PointSample { point, pdf }, radiance))
    }
}

/// The value between four corners, the upper ones first.
#[inline(always)]
fn bilinear<T>([[a, b], [c, d]]: [[T; 2]; 2], DVec2 { x, y }: DVec2) -> T
where
    T: Mul<f64, Output = T> + Add<Output = T>,
{
    (a * (1.0 - x) + b * x) * (1.0 - y) + (c * (1.0 - x) + d * x) * y
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
        self.sample(u2).map(|(sample, _)| sample)
    }

    fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
        let w = self.rotation.transpose() * -point.geometric_normal;
        PerArea(self.pdf(w, &self.place(w)).value())
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        self.extent.sample_direction(point, self.emit(point, point.geometric_normal), u)
    }

    fn direction_pdf(&self, point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        self.extent.direction_pdf(point)
    }

    fn emit(&self, point: &SurfacePoint, _direction: DVec3) -> Rgb {
        self.radiance(-point.geometric_normal)
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        self.extent.facing(point, receiver)
    }
}

impl Light for EnvironmentMap {
    /// The flux into the spheres around the boxes of the scene's extent, `Σ π R² ∫ L dσ`.
    fn power(&self) -> Rgb {
        self.integral * self.extent.cross_section()
    }

    fn sample_emission(
        &self,
        receiver: &SurfacePoint,
        _u1: f64,
        u2: DVec2,
    ) -> Option<(PointSample, Option<Rgb>)> {
        let (PointSample { point, pdf }, radiance) = self.sample(u2)?;
        let point = self.extent.facing(&point, receiver);
        Some((PointSample { point, pdf }, Some(radiance)))
    }

    fn emission_and_pdf(
        &self,
        _receiver: &SurfacePoint,
        point: &SurfacePoint,
        _direction: DVec3,
    ) -> (Rgb, PerArea) {
        let (radiance, pdf) = self.radiance_and_pdf(-point.geometric_normal);
        (radiance, PerArea(pdf.value()))
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn is_black(&self) -> bool {
        self.integral.is_black()
    }

    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        self.extent = extent.clone();
    }

    fn into_any(self) -> AnyLight {
        AnyLight::Map(Box::new(self))
    }
}
