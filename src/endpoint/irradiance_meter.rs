//! A meter of irradiance.

use super::{Camera, DirectionSample, Endpoint, EndpointError, PointSample, check};
use crate::film::FilmRegion;
use crate::geometry::{Frame, Place, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb, angle};
use glam::{DVec2, DVec3, UVec2};
use std::f64::consts::{FRAC_1_PI, PI};

const OBJECT: &str = "irradiance meter";
/// Pixels on a side of its film: as many samples in a pass as fill a batch.
pub(super) const FILM_SIDE: u32 = 32;

/// A camera that measures the irradiance (W/m²) at a point, of the light that comes from its
/// normal's side: `E = ∫ L cos θ dω`. [`measure`](crate::render::measure()) gives E.
///
/// As a camera it sees the hemisphere, `We = 1/π` per projected solid angle, and its film maps it
/// such that all pixels see as much projected solid angle: columns by sin² θ, rows by azimuth. The
/// image is radiance, and its mean over the film E/π. With filters that are wider than a pixel's
/// box, a part is lost at the film's border.
///
/// # Densities
/// It is a point that lies on a surface of its own ([`Place::Area`]): light walks are connected to it
/// as to a diffuse surface, and Dirac lights are seen by them (s ≥ 1, t = 1), but not by walks from
/// the meter, which never meet those. Its one point is chosen with probability 1, and that is what
/// its densities per area say: the measure of its position is the Dirac distribution. All
/// techniques draw the lens, so that the measure cancels out of everything else.
///
/// # Where it may be
/// Between the surfaces of the scene: a light that cannot reach any of them is not chosen, even if it
/// reaches the meter.
///
/// ```
/// use pathspace::endpoint::{IrradianceMeter, PointLight};
/// use pathspace::geometry::Disk;
/// use pathspace::glam::DVec3;
/// use pathspace::integrator::LightTracer;
/// use pathspace::math::Rgb;
/// use pathspace::render::{Settings, measure};
/// use pathspace::scene::{Material, WorldBuilder};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut scene = WorldBuilder::new();
/// let black = scene.add_material("black", Material::Black)?;
/// let below = Disk { center: DVec3::NEG_Z, normal: DVec3::Z, radius: 9.0 };
/// scene.add_disk("floor", below, black)?;
/// scene.add_light("bulb", PointLight::new(DVec3::new(0.0, 0.0, 2.0), Rgb::from(8.0))?)?;
/// let meter = IrradianceMeter::new(DVec3::ZERO, DVec3::Z)?;
/// let irradiance =
///     measure(&scene.build()?, &meter, &LightTracer::default(), &Settings::default())?;
/// // I/d², and as certain as that.
/// assert!((irradiance.mean().r() - 8.0 / 4.0).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrradianceMeter {
    point: SurfacePoint,
    frame: Frame,
}

impl IrradianceMeter {
    /// A meter at a position in space, or on a surface whose plane contains it up to rounding;
    /// `normal` (of any length but zero) points to the side from which it sees light.
    ///
    /// # Errors
    /// If a number is not finite, or the normal zero.
    pub fn new(position: DVec3, normal: DVec3) -> Result<Self, EndpointError> {
        let position = check::position(OBJECT, "position", position)?;
        let normal = check::direction(OBJECT, "normal", normal)?;
        let error = 4.0 * f64::EPSILON * position.abs().max_element();
        Ok(Self::at(&SurfacePoint::on_surface(position, error, normal), normal))
    }

    /// A meter at a surface point that a scene returned, which it covers without shadowing it, on
    /// the side that `direction` points to.
    #[must_use]
    pub fn at(point: &SurfacePoint, direction: DVec3) -> Self {
        let normal = point.geometric_normal;
        let normal = if normal.dot(direction) < 0.0 { -normal } else { normal };
        let point = SurfacePoint { geometric_normal: normal, shading_normal: normal, ..*point };
        Self { point, frame: Frame::from_normal(normal) }
    }
}

impl Endpoint for IrradianceMeter {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample { point: self.point, pdf: PerArea(1.0) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let is_seen = u.cmpge(DVec2::ZERO).all() && u.cmplt(DVec2::ONE).all();
        is_seen.then(|| {
            let (sine, (sin_phi, cos_phi)) = (u.x.sqrt(), angle::sin_cos_of_turn(u.y));
            let local = DVec3::new(sine * cos_phi, sine * sin_phi, (1.0 - u.x).sqrt());
            let direction = self.frame.to_world(local);
            let pdf = PerProjected(FRAC_1_PI);
            DirectionSample { from: *point, direction, pdf, weight: Rgb::WHITE }
        })
    }

    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(if point.geometric_normal.dot(direction) > 0.0 { FRAC_1_PI } else { 0.0 })
    }

    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        Rgb::splat(self.direction_pdf(point, direction).value())
    }
}

impl Camera for IrradianceMeter {
    fn film(&self) -> FilmRegion {
        FilmRegion::full(UVec2::splat(FILM_SIDE))
    }

    fn place(&self) -> Place {
        Place::Area
    }

    fn raster(&self, _point: &SurfacePoint, direction: DVec3) -> Option<DVec2> {
        let w = self.frame.to_local(direction);
        let u = DVec2::new(w.truncate().length_squared(), angle::turn(w.y, w.x));
        // Rounding must not carry it over the border.
        (w.z > 0.0).then(|| self.film().from_window(u.min(DVec2::splat(1.0 - 1e-12))))
    }

    fn response(&self) -> f64 {
        PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::testing::random;

    #[test]
    fn the_film_maps_the_hemisphere_forth_and_back() {
        let mut rng = random(1);
        for normal in [DVec3::Z, -DVec3::Z, DVec3::new(1.0, -2.0, 0.5)] {
            let meter = IrradianceMeter::new(DVec3::new(3.0, 1.0, -2.0), normal).unwrap();
            let point = meter.sample_point(0.0, DVec2::ZERO).unwrap().point;
            for _ in 0..1000 {
                let u = DVec2::new(rng(), rng());
                let ray = meter.sample_direction(&point, u).unwrap();
                assert!(ray.direction.dot(normal) > 0.0);
                assert_eq!(ray.pdf, meter.direction_pdf(&point, ray.direction));
                let raster = meter.raster(&point, ray.direction).unwrap();
                assert!(raster.distance(meter.film().from_window(u)) < 1e-9, "{u} {raster}");
                assert_eq!(meter.raster(&point, -ray.direction), None);
                assert!(meter.emit(&point, -ray.direction).is_black());
            }
        }
        let other_side =
            IrradianceMeter::at(&SurfacePoint::on_surface(DVec3::ONE, 0.0, DVec3::Z), -DVec3::ONE);
        assert_eq!(other_side.point.geometric_normal, -DVec3::Z);
        assert!(IrradianceMeter::new(DVec3::ZERO, DVec3::ZERO).is_err());
        assert!(IrradianceMeter::new(DVec3::NAN, DVec3::Z).is_err());
    }
}
