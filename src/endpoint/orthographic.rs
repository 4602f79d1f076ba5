//! A camera of parallel rays.

use super::{Camera, DirectionSample, Endpoint, EndpointError, PointSample, view::View};
use crate::film::FilmRegion;
use crate::geometry::{Place, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3, UVec2};

const OBJECT: &str = "orthographic camera";

/// A camera infinitely far away whose rays are parallel. It sees what is in front of the plane
/// through its position.
///
/// Its point at infinity is a Dirac direction; what other cameras do by direction it does by
/// position, uniform on the window in the camera's plane: it emits 1/A per area perpendicular to
/// the view, A being the window's area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthographicCamera {
    view: View,
}

impl OrthographicCamera {
    /// A camera at `position` looking towards `target`, with square pixels, whose film is
    /// `film_height` high in world units; `up` points upwards in the image.
    ///
    /// # Errors
    /// If a number is not finite, position and target are the same, `up` is zero or parallel to the
    /// view, the height is not positive, or the film has no pixels.
    pub fn new(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        film_height: f64,
        resolution: UVec2,
    ) -> Result<Self, EndpointError> {
        Ok(Self { view: View::new(OBJECT, [position, target, up], film_height, resolution)? })
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

    /// The distance of a point in front of the camera's plane.
    fn depth(&self, point: &SurfacePoint) -> f64 {
        self.view.forward.dot(point.position - self.view.position)
    }

    fn sees(&self, receiver: &SurfacePoint) -> bool {
        receiver.place != Place::Infinite && self.depth(receiver) > 0.0
    }
}

impl Endpoint for OrthographicCamera {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample {
            point: SurfacePoint::infinite(self.view.position, self.view.forward),
            pdf: PerArea(1.0),
        })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let position = self.view.position + self.view.in_plane(self.view.plane_at(u));
        let direction = self.view.forward;
        let pdf = self.direction_pdf(point, direction);
        Some(DirectionSample {
            from: SurfacePoint { position, ..*point },
            direction,
            pdf,
            weight: Rgb::WHITE,
        })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        PerProjected(1.0 / self.view.window_area())
    }

    fn emit(&self, _point: &SurfacePoint, _direction: DVec3) -> Rgb {
        Rgb::splat(1.0 / self.view.window_area())
    }

    fn sample_from(&self, receiver: &SurfacePoint, u1: f64, u2: DVec2) -> Option<PointSample> {
        let sample = self.sample_point(u1, u2).filter(|_| self.sees(receiver))?;
        Some(PointSample { point: self.facing(&sample.point, receiver), ..sample })
    }

    fn pdf_from(&self, receiver: &SurfacePoint, point: &SurfacePoint) -> PerArea {
        if self.sees(receiver) { self.point_pdf(point) } else { PerArea::ZERO }
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        SurfacePoint {
            position: receiver.position - self.view.forward * self.depth(receiver),
            ..*point
        }
    }
}

impl Camera for OrthographicCamera {
    fn film(&self) -> FilmRegion {
        self.view.film
    }

    fn place(&self) -> Place {
        Place::Infinite
    }

    fn raster(&self, point: &SurfacePoint, _direction: DVec3) -> Option<DVec2> {
        let raster = self.view.raster_at(self.view.across(point.position - self.view.position));
        raster.is_finite().then_some(raster)
    }
}
