//! A camera with a thin lens: depth of field.

use super::{
    Camera, DirectionSample, Endpoint, EndpointError, PointSample, check, view, view::View,
};
use crate::film::FilmRegion;
use crate::geometry::{Disk, Place, Shape, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3, UVec2};

const OBJECT: &str = "thin lens camera";

/// A perspective camera with a lens of radius r, sharp on the plane at the focus distance.
///
/// With A the area of the film's window on the plane at distance 1, the camera emits `1/(A π r²
/// cos⁴ θ)` per lens area and projected solid angle. From every point of the lens, directions are
/// uniform on the image of the window in the plane of focus: `p⊥ = 1/(A cos⁴ θ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLensCamera {
    view: View,
    lens: Disk,
    focus_distance: f64,
}

impl ThinLensCamera {
    /// A camera at `position` looking at `target`, with square pixels; `up` points upwards in the
    /// image. `focus_distance` is measured along the view.
    ///
    /// # Errors
    /// As for [`PinholeCamera::new`](super::PinholeCamera::new), and if the aperture's radius or
    /// the focus distance is not positive. For an aperture of radius 0 take the pinhole camera.
    pub fn new(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        vertical_fov_degrees: f64,
        aperture_radius: f64,
        focus_distance: f64,
        resolution: UVec2,
    ) -> Result<Self, EndpointError> {
        let height = view::film_height(OBJECT, vertical_fov_degrees)?;
        let view = View::new(OBJECT, [position, target, up], height, resolution)?;
        let radius = check::positive(OBJECT, "aperture radius", aperture_radius)?;
        let lens = Disk { center: position, normal: view.forward, radius };
        check::positive(OBJECT, "lens area", Shape::Disk(lens).area())?;
        Ok(Self {
            view,
            lens,
            focus_distance: check::positive(OBJECT, "focus distance", focus_distance)?,
        })
    }

    /// The same camera with a film that is displaced in its plane (a shifted lens): the view's axis
    /// meets it at this point, in pixels of the full film from its upper left corner. By default
    /// that is its centre.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn with_principal_point(self, pixel: DVec2) -> Result<Self, EndpointError> {
        Ok(Self { view: self.view.with_principal_point(pixel)?, ..self })
    }

    /// The same camera with left and right of its image exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { view: self.view.mirrored(), ..self }
    }

    /// The same camera, rendering only the pixels from `min` up to but without `max`.
    ///
    /// # Errors
    /// If the window is empty or reaches out of the film.
    pub fn with_window(self, min: UVec2, max: UVec2) -> Result<Self, EndpointError> {
        Ok(Self { view: self.view.with_window(min, max)?, ..self })
    }

    /// The position of a point of the lens on it, relative to the centre.
    fn on_lens(&self, point: &SurfacePoint) -> DVec2 {
        self.view.across(point.position - self.view.position)
    }

    /// The density of a direction per projected solid angle.
    #[inline]
    fn density(&self, direction: DVec3) -> f64 {
        let square = self.view.forward.dot(direction).powi(2);
        self.view.film_density(self.view.forward.dot(direction), square * square)
    }
}

impl Endpoint for ThinLensCamera {
    fn sample_point(&self, _u1: f64, u2: DVec2) -> Option<PointSample> {
        let point = Shape::Disk(self.lens).sample_area(u2);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0 / Shape::Disk(self.lens).area())
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        // The slope of the ray that meets the plane of focus where the ray through the centre of
        // the lens does.
        let slope = self.view.plane_at(u) - self.on_lens(point) / self.focus_distance;
        let direction = (self.view.forward + self.view.in_plane(slope)).normalize();
        let pdf = self.direction_pdf(point, direction);
        let weight = Rgb::splat(self.point_pdf(point).value());
        (pdf.value() > 0.0).then_some(DirectionSample { from: *point, direction, pdf, weight })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(self.density(direction))
    }

    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        Rgb::splat(self.density(direction) * self.point_pdf(point).value())
    }
}

impl Camera for ThinLensCamera {
    fn film(&self) -> FilmRegion {
        self.view.film
    }

    fn place(&self) -> Place {
        Place::Area
    }

    fn raster(&self, point: &SurfacePoint, direction: DVec3) -> Option<DVec2> {
        let cosine = self.view.forward.dot(direction);
        let raster = self.view.raster_at(
            self.view.across(direction) / cosine + self.on_lens(point) / self.focus_distance,
        );
        (cosine > 0.0 && raster.is_finite()).then_some(raster)
    }
}
