//! A pinhole camera.

use super::{Camera, DirectionSample, Endpoint, EndpointError, PointSample, view, view::View};
use crate::film::FilmRegion;
use crate::geometry::{Place, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3, UVec2};

const OBJECT: &str = "pinhole camera";

/// A perspective camera whose lens is a point.
///
/// With A the area of the film's window on the plane at distance 1, the camera emits `1/(A cos³ θ)`
/// per solid angle, which is also the density of its directions: `∫ dσ / (A cos³ θ) = 1` over the
/// window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinholeCamera {
    view: View,
}

impl PinholeCamera {
    /// A camera at `position` looking at `target`, with square pixels; `up` points upwards in the
    /// image.
    ///
    /// # Errors
    /// If a number is not finite, position and target are the same, `up` is zero or parallel to the
    /// view, the field of view is not between 0 and 180 degrees, or the film has no pixels.
    pub fn new(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        vertical_fov_degrees: f64,
        resolution: UVec2,
    ) -> Result<Self, EndpointError> {
        let height = view::film_height(OBJECT, vertical_fov_degrees)?;
        Ok(Self { view: View::new(OBJECT, [position, target, up], height, resolution)? })
    }

    /// The same camera with a film that is displaced in its plane (a shifted lens): the view's axis
    /// meets it at this point, in pixels of the full film from its upper left corner. By default
    /// that is its centre.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn with_principal_point(self, pixel: DVec2) -> Result<Self, EndpointError> {
        Ok(Self { view: self.view.with_principal_point(pixel)? })
    }

    /// The same camera with left and right of its image exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { view: self.view.mirrored() }
    }

    /// The same camera, rendering only the pixels from `min` up to but without `max`.
    ///
    /// # Errors
    /// If the window is empty or reaches out of the film.
    pub fn with_window(self, min: UVec2, max: UVec2) -> Result<Self, EndpointError> {
        Ok(Self { view: self.view.with_window(min, max)? })
    }
}

impl Endpoint for PinholeCamera {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample { point: SurfacePoint::dirac(self.view.position), pdf: PerArea(1.0) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = self.view.direction_at(u.to_array()).into();
        let pdf = self.direction_pdf(point, direction);
        (pdf.value() > 0.0).then_some(DirectionSample {
            from: *point,
            direction,
            pdf,
            weight: Rgb::WHITE,
        })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(self.view.pinhole_density::<f64>(direction.into()))
    }

    fn emit(&self, _point: &SurfacePoint, direction: DVec3) -> Rgb {
        Rgb::splat(self.view.pinhole_density::<f64>(direction.into()))
    }
}

impl Camera for PinholeCamera {
    fn film(&self) -> FilmRegion {
        self.view.film
    }

    fn place(&self) -> Place {
        Place::Dirac
    }

    fn raster(&self, _point: &SurfacePoint, direction: DVec3) -> Option<DVec2> {
        let (raster, is_seen) = self.view.raster::<f64>(direction.into());
        is_seen.then_some(raster.into())
    }

    fn as_pinhole(&self) -> Option<&View> {
        Some(&self.view)
    }
}
