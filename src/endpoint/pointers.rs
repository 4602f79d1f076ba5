//! Cameras behind references, boxes and shared pointers are cameras.

use super::{Camera, DirectionSample, Endpoint, PointSample, View};
use crate::film::FilmRegion;
use crate::geometry::{Place, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Hands on every question, those with provided answers, too: an answer of its own may be another.
macro_rules! hand_on {
    ($($pointer:ty),+) => {$(
        impl<C: Camera + ?Sized> Endpoint for $pointer
        where
            Self: Sync,
        {
            fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample> {
                (**self).sample_point(u1, u2)
            }

            fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
                (**self).point_pdf(point)
            }

            fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
                (**self).sample_direction(point, u)
            }

            fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
                (**self).direction_pdf(point, direction)
            }

            fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
                (**self).emit(point, direction)
            }

            fn sample_from(
                &self,
                receiver: &SurfacePoint,
                u1: f64,
                u2: DVec2,
            ) -> Option<PointSample> {
                (**self).sample_from(receiver, u1, u2)
            }

            fn pdf_from(&self, receiver: &SurfacePoint, point: &SurfacePoint) -> PerArea {
                (**self).pdf_from(receiver, point)
            }

            fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
                (**self).facing(point, receiver)
            }
        }

        impl<C: Camera + ?Sized> Camera for $pointer
        where
            Self: Sync,
        {
            fn film(&self) -> FilmRegion {
                (**self).film()
            }

            fn place(&self) -> Place {
                (**self).place()
            }

            fn raster(&self, point: &SurfacePoint, direction: DVec3) -> Option<DVec2> {
                (**self).raster(point, direction)
            }

            fn project(&self, position: DVec3) -> Option<DVec2> {
                (**self).project(position)
            }

            fn can_be_connected(&self) -> bool {
                (**self).can_be_connected()
            }

            fn response(&self) -> f64 {
                (**self).response()
            }

            fn as_pinhole(&self) -> Option<&View> {
                (**self).as_pinhole()
            }
        }
    )+};
}

hand_on!(&C, Box<C>, Arc<C>);
