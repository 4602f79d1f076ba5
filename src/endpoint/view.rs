//! The part that all cameras share: their position, their axes, and the map between the film and
//! the plane at distance 1.

use super::{EndpointError, check};
use crate::film::FilmRegion;
use crate::lanes::{Lane, Mask, Vector};
use glam::{DVec2, DVec3, UVec2};

/// A view: x to the right, y up, looking along `forward`, all three of unit length; left-handed if
/// it is mirrored.
/// Film coordinates have their origin at the upper left.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    object: &'static str,
    /// World position of the lens, or of its centre.
    pub position: DVec3,
    /// The direction that points to the right in the image.
    pub right: DVec3,
    /// The direction that points upwards in the image.
    pub up: DVec3,
    /// The viewing direction.
    pub forward: DVec3,
    /// The film.
    pub film: FilmRegion,
    /// Side of a pixel on the film plane, which is at distance 1.
    pub pitch: f64,
    /// The point at which the view's axis meets the film, in pixels of the full film.
    pub principal_point: DVec2,
}

impl View {
    /// `film_height` is the height of the whole film on the film plane.
    pub(super) fn new(
        object: &'static str,
        [position, target, up]: [DVec3; 3],
        film_height: f64,
        resolution: UVec2,
    ) -> Result<Self, EndpointError> {
        check::position(object, "position", position)?;
        check::position(object, "target", target)?;
        check::position(object, "up vector", up)?;
        if position == target {
            return Err(EndpointError::CameraAtTarget { object });
        }
        let forward = check::direction(object, "view", target - position)?;
        let up = check::direction(object, "up vector", up)
            .map_err(|_| EndpointError::UpParallelToView { object })?;
        let right = forward.cross(up);
        if right.length() < 1e-10 {
            return Err(EndpointError::UpParallelToView { object });
        }
        let right = right.normalize();
        if resolution.x.checked_mul(resolution.y).is_none_or(|pixels| pixels == 0) {
            return Err(EndpointError::FilmSize { object, resolution });
        }
        let pitch = check::positive(object, "pixel size", film_height / f64::from(resolution.y))?;
        Ok(Self {
            object,
            position,
            right,
            up: right.cross(forward),
            forward,
            film: FilmRegion::full(resolution),
            pitch,
            principal_point: 0.5 * resolution.as_dvec2(),
        })
    }

    /// The same view with only the pixels from `min` up to but without `max`.
    pub(super) fn with_window(self, min: UVec2, max: UVec2) -> Result<Self, EndpointError> {
        let resolution = self.film.resolution;
        if min.cmpge(max).any() || max.cmpgt(resolution).any() {
            return Err(EndpointError::WindowOutsideFilm {
                object: self.object,
                min,
                max,
                resolution,
            });
        }
        Ok(Self { film: FilmRegion { resolution, window_min: min, window_max: max }, ..self })
    }

    /// The same view with left and right of its image exchanged.
    pub(super) fn mirrored(self) -> Self {
        Self { right: -self.right, ..self }
    }

    /// The same view through a film that is displaced in its plane.
    pub(super) fn with_principal_point(self, pixel: DVec2) -> Result<Self, EndpointError> {
        let principal_point =
            check::position(self.object, "principal point", pixel.extend(0.0))?.truncate();
        Ok(Self { principal_point, ..self })
    }

    /// Area of the window on the film plane.
    #[inline]
    #[must_use]
    pub fn window_area(&self) -> f64 {
        f64::from(self.film.pixels()) * self.pitch * self.pitch
    }

    /// The point of the film plane, x to the right and y up, for window coordinates.
    #[inline]
    #[must_use]
    pub fn plane_at(&self, u: DVec2) -> DVec2 {
        let from_center = self.film.from_window(u) - self.principal_point;
        DVec2::new(from_center.x, -from_center.y) * self.pitch
    }

    /// The point of the full film, in pixels, for a point of the film plane.
    #[inline]
    #[must_use]
    pub fn raster_at(&self, plane: DVec2) -> DVec2 {
        DVec2::new(plane.x, -plane.y) / self.pitch + self.principal_point
    }

    /// The directions from the middle of the lens through window coordinates, in lanes.
    #[inline(always)]
    pub(crate) fn direction_at<L: Lane>(&self, [x, y]: [L; 2]) -> Vector<L> {
        let FilmRegion { window_min: min, .. } = self.film;
        let (size, center) = (self.film.window_size(), self.principal_point);
        let right = (x * f64::from(size.x) + f64::from(min.x) - center.x) * self.pitch;
        let down = (y * f64::from(size.y) + f64::from(min.y) - center.y) * self.pitch;
        let axis = |axis| Vector::constant(axis, x);
        let through = axis(self.forward) + (axis(self.right) * right + axis(self.up) * -down);
        through * (x.constant(1.0) / through.length_squared().sqrt())
    }

    /// The components of a vector to the right and up.
    #[inline]
    #[must_use]
    pub fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(self.right.dot(v), self.up.dot(v))
    }

    /// The vector with the given components to the right and up.
    #[inline]
    #[must_use]
    pub fn in_plane(&self, v: DVec2) -> DVec3 {
        self.right * v.x + self.up * v.y
    }

    /// `1 / (A cosⁿ θ)`, given cos θ and its power, for directions into the film plane's half space,
    /// 0 for others; in lanes. Defined beyond the window, since pixel filters reach there.
    #[inline(always)]
    pub(super) fn film_density<L: Lane>(&self, cosine: L, power: L) -> L {
        let density = cosine.constant(1.0) / (power * self.window_area());
        // Infinitely far out on the film plane no film can be.
        let is_seen = cosine.is_positive() & density.less(cosine.constant(f64::INFINITY));
        is_seen.choose(density, cosine.constant(0.0))
    }

    /// The density and the importance of a pinhole's directions per solid angle, in lanes.
    #[inline(always)]
    pub(crate) fn pinhole_density<L: Lane>(&self, direction: Vector<L>) -> L {
        let cosine = direction.dot_with(self.forward);
        self.film_density(cosine, cosine * (cosine * cosine))
    }

    /// The points of the full film, in pixels, at which directions from the middle of the lens are
    /// recorded, and where they are, in lanes.
    #[inline(always)]
    pub(crate) fn raster<L: Lane>(&self, direction: Vector<L>) -> ([L; 2], L::Mask) {
        let cosine = direction.dot_with(self.forward);
        let right = direction.dot_with(self.right) / cosine;
        let down = -(direction.dot_with(self.up) / cosine);
        let center = self.principal_point;
        let raster = [right / self.pitch + center.x, down / self.pitch + center.y];
        let is_finite = |x: L| x.abs().less(x.constant(f64::INFINITY));
        (raster, cosine.is_positive() & is_finite(raster[0]) & is_finite(raster[1]))
    }
}

/// The height of the film plane at distance 1.
pub(super) fn film_height(
    object: &'static str,
    vertical_fov_degrees: f64,
) -> Result<f64, EndpointError> {
    if !(vertical_fov_degrees > 0.0 && vertical_fov_degrees < 180.0) {
        let (quantity, range) = ("vertical field of view", "(0, 180)");
        return Err(EndpointError::AngleOutOfRange {
            object,
            quantity,
            degrees: vertical_fov_degrees,
            range,
        });
    }
    Ok(2.0 * libm::tan(0.5 * vertical_fov_degrees.to_radians()))
}
