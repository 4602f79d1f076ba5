//! A meter of radiance.

use super::irradiance_meter::FILM_SIDE;
use super::{Camera, DirectionSample, Endpoint, EndpointError, PointSample, check};
use crate::film::FilmRegion;
use crate::geometry::{Place, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3, UVec2};

const OBJECT: &str = "radiance meter";

/// A camera that measures the radiance (W/(m² sr)) along one ray, as it arrives at a position. All
/// pixels of its film see the same ray, and the image's mean is the radiance.
///
/// # Densities
/// Position and direction are Dirac distributions: both are chosen with probability 1, which is what
/// the densities of its samples say. No light walk goes through that ray by chance, so the lens
/// cannot be [connected](Camera::can_be_connected) to: t = 1 is left out, with the reason in the
/// rendering's notes. What t = 1 alone draws, as caustics of point lights, is missing and said to
/// be ([`blind_spots`](crate::render::Render::blind_spots)); light tracing sees nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceMeter {
    position: DVec3,
    direction: DVec3,
}

impl RadianceMeter {
    /// A meter at `position` that looks into `direction`, of any length but zero.
    ///
    /// # Errors
    /// If a number is not finite, or the direction zero.
    pub fn new(position: DVec3, direction: DVec3) -> Result<Self, EndpointError> {
        Ok(Self {
            position: check::position(OBJECT, "position", position)?,
            direction: check::direction(OBJECT, "direction", direction)?,
        })
    }
}

impl Endpoint for RadianceMeter {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample { point: SurfacePoint::dirac(self.position), pdf: PerArea(1.0) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, _u: DVec2) -> Option<DirectionSample> {
        let (direction, pdf) = (self.direction, PerProjected(1.0));
        Some(DirectionSample { from: *point, direction, pdf, weight: Rgb::WHITE })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        PerProjected::ZERO
    }

    fn emit(&self, _point: &SurfacePoint, _direction: DVec3) -> Rgb {
        Rgb::BLACK
    }
}

impl Camera for RadianceMeter {
    fn film(&self) -> FilmRegion {
        FilmRegion::full(UVec2::splat(FILM_SIDE))
    }

    fn place(&self) -> Place {
        Place::Dirac
    }

    fn raster(&self, _point: &SurfacePoint, _direction: DVec3) -> Option<DVec2> {
        None
    }

    fn can_be_connected(&self) -> bool {
        false
    }
}
