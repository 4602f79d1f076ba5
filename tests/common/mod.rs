//! A host renderer of its own: the analytic sphere with an emissive cap, whose every answer is
//! known (Le f_e ρ^k per bounce).
#![allow(dead_code, missing_docs, reason = "shared by several test programs")]

use glam::{DVec2, DVec3, UVec2};
use pathspace::bsdf::{Bsdf, BsdfSample, Lobes, TransportMode};
use pathspace::endpoint::{Camera, DirectionSample, Endpoint, Light, LightId, PointSample};
use pathspace::film::{FilmRegion, FilmSample};
use pathspace::geometry::{Frame, Place, SurfacePoint};
use pathspace::math::warp::square_to_cosine_hemisphere;
use pathspace::math::{PerArea, PerProjected, Rgb};
use pathspace::sampler::Sampler;
use pathspace::scene::{Scene, SurfaceArea};
use rand::RngExt;
use std::f64::consts::PI;

pub struct Random(pub rand_pcg::Pcg64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(rand_pcg::Pcg64::new(u128::from(seed) << 64 | 0x5bd1_e995, 1))
    }
}

impl Sampler for Random {
    fn next_1d(&mut self) -> f64 {
        (self.0.random::<u64>() >> 11) as f64 * (0.5f64).powi(53)
    }
}

pub struct Lambertian {
    pub albedo: f64,
    /// False of one that shows light from behind the surface as well.
    pub is_opaque: bool,
}

impl Bsdf for Lambertian {
    fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE_REFLECTION
    }
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let is_lit = !self.is_opaque || to_light.z > 0.0 && to_camera.z > 0.0;
        if is_lit { Rgb::splat(self.albedo / PI) } else { Rgb::BLACK }
    }
    fn pdf(&self, fixed: DVec3, next: DVec3, _: TransportMode) -> PerProjected {
        let is_sampled = !self.is_opaque || fixed.z > 0.0 && next.z > 0.0;
        PerProjected(if is_sampled { 1.0 / PI } else { 0.0 })
    }
    fn sample(&self, fixed: DVec3, _: TransportMode, _: f64, u2: DVec2) -> Option<BsdfSample> {
        let pdf = PerProjected(1.0 / PI);
        (fixed.z > 0.0).then(|| BsdfSample {
            next: square_to_cosine_hemisphere(u2),
            weight: Rgb::splat(self.albedo),
            pdf,
            pdf_reverse: pdf,
            dirac: false,
            relative_ior: 1.0,
        })
    }
}

/// The unit sphere, front side inside; the cap above `cos` emits radiance 1.
pub struct SphereCap {
    pub albedo: f64,
    pub cos: f64,
    pub is_opaque: bool,
    pub light: Cap,
}

pub struct Cap {
    cos: f64,
}

pub const LIGHT: LightId = LightId(0);

impl SphereCap {
    pub fn new(albedo: f64, area_fraction: f64) -> Self {
        let cos = 1.0 - 2.0 * area_fraction;
        Self { albedo, cos, is_opaque: true, light: Cap { cos } }
    }
}

fn on_sphere(outward: DVec3) -> SurfacePoint {
    SurfacePoint::on_surface(outward, 1e-15, -outward)
}

fn from_height(z: f64, u: f64) -> SurfacePoint {
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u).sin_cos();
    on_sphere(DVec3::new(r * cos, r * sin, z).normalize())
}

impl Endpoint for Cap {
    fn sample_point(&self, _: f64, u: DVec2) -> Option<PointSample> {
        let point = from_height(self.cos + (1.0 - self.cos) * u.x, u.y);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }
    fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
        PerArea(1.0 / (2.0 * PI * (1.0 - self.cos)))
    }
    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction =
            Frame::from_normal(point.geometric_normal).to_world(square_to_cosine_hemisphere(u));
        Some(DirectionSample {
            from: *point,
            direction,
            pdf: PerProjected(1.0 / PI),
            weight: Rgb::splat(PI),
        })
    }
    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(if point.geometric_normal.dot(direction) > 0.0 { 1.0 / PI } else { 0.0 })
    }
    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        if point.geometric_normal.dot(direction) > 0.0 { Rgb::WHITE } else { Rgb::BLACK }
    }
}

impl Light for Cap {
    fn power(&self) -> Rgb {
        Rgb::splat(PI * 2.0 * PI * (1.0 - self.cos))
    }
    fn can_be_hit(&self) -> bool {
        true
    }
}

impl Scene for SphereCap {
    type Bsdf<'a> = Lambertian;
    type Light = dyn Light;

    fn intersect(&self, from: &SurfacePoint, w: DVec3) -> Option<SurfacePoint> {
        let o = from.position;
        let b = -o.dot(w);
        let t = if from.place == Place::Area {
            2.0 * b
        } else {
            b + (1.0 - (o + w * b).length_squared()).sqrt()
        };
        (t > 0.0).then(|| on_sphere((o + w * t).normalize()))
    }
    fn visible(&self, _: &SurfacePoint, _: &SurfacePoint) -> bool {
        true
    }
    fn bsdf(&self, _: &SurfacePoint) -> Lambertian {
        Lambertian { albedo: self.albedo, is_opaque: self.is_opaque }
    }
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        (x.position.z >= self.cos).then_some(LIGHT)
    }
    fn light(&self, _: LightId) -> &(dyn Light + 'static) {
        &self.light
    }
    fn pick_light(&self, _: f64) -> Option<(LightId, f64)> {
        Some((LIGHT, 1.0))
    }
    fn pick_pmf(&self, _: LightId) -> f64 {
        1.0
    }
}

impl SurfaceArea for SphereCap {
    fn total_area(&self) -> f64 {
        4.0 * PI
    }
    fn sample_surface(&self, _: f64, u: DVec2) -> SurfacePoint {
        from_height(1.0 - 2.0 * u.x, u.y)
    }
}

/// A pinhole at the origin that looks down -z through a square film at distance 1 with the given
/// half width.
pub struct DownCamera {
    pub half_width: f64,
}

impl Endpoint for DownCamera {
    fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
        Some(PointSample { point: SurfacePoint::dirac(DVec3::ZERO), pdf: PerArea(1.0) })
    }
    fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }
    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let p = (2.0 * u - 1.0) * self.half_width;
        let direction = DVec3::new(p.x, p.y, -1.0).normalize();
        Some(DirectionSample {
            from: *point,
            direction,
            pdf: self.direction_pdf(point, direction),
            weight: Rgb::WHITE,
        })
    }
    fn direction_pdf(&self, _: &SurfacePoint, w: DVec3) -> PerProjected {
        let area = 4.0 * self.half_width * self.half_width;
        PerProjected(if w.z < 0.0 { 1.0 / (area * -w.z.powi(3)) } else { 0.0 })
    }
    fn emit(&self, point: &SurfacePoint, w: DVec3) -> Rgb {
        Rgb::splat(self.direction_pdf(point, w).value())
    }
}

impl Camera for DownCamera {
    fn film(&self) -> FilmRegion {
        FilmRegion::full(UVec2::ONE)
    }
    fn raster(&self, _: &SurfacePoint, w: DVec3) -> Option<DVec2> {
        (w.z < 0.0).then(|| {
            let p = DVec2::new(w.x, w.y) / (-w.z * self.half_width);
            0.5 * (p + 1.0)
        })
    }
}

/// A sample of the one-pixel film.
pub fn film_sample(sampler: &mut impl Sampler) -> FilmSample {
    FilmSample { raster: sampler.next_2d(), offset: DVec2::ZERO }
}

/// Mean and standard error of the mean.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    n: f64,
    mean: f64,
    m2: f64,
}

impl Moments {
    pub fn add(&mut self, x: f64) {
        self.n += 1.0;
        let d = x - self.mean;
        self.mean += d / self.n;
        self.m2 += d * (x - self.mean);
    }
    pub fn mean(&self) -> f64 {
        self.mean
    }
    pub fn variance(&self) -> f64 {
        self.m2 / (self.n - 1.0)
    }
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.n).sqrt()
    }
}
