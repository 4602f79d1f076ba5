//! All lights behind one type, without virtual calls to those of this crate.

use super::{
    AreaLight, ConstantEnvironment, DirectionSample, DirectionalLight, Endpoint, EnvironmentMap,
    FlatLight, Light, LightKind, PointLight, PointSample, SceneExtent, SpotLight,
};
use crate::geometry::{Bounds, SurfacePoint};
use crate::light_tree::LightBounds;
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// A light of a [`World`](crate::scene::World): one of this crate's, or one of a user's own.
pub enum AnyLight {
    /// Emission from surfaces.
    Area(Box<AreaLight>),
    /// A point.
    Point(PointLight),
    /// A point that shines into a cone.
    Spot(Box<SpotLight>),
    /// Parallel light.
    Directional(DirectionalLight),
    /// The same radiance from everywhere around.
    Constant(ConstantEnvironment),
    /// An image around the scene.
    Map(Box<EnvironmentMap>),
    /// A light of a user's own.
    Custom(Box<dyn Light + Send>),
}

/// Asks the light.
macro_rules! ask {
    ($any:expr, $light:ident => $question:expr) => {
        match $any {
            Self::Area($light) => $question,
            Self::Point($light) => $question,
            Self::Spot($light) => $question,
            Self::Directional($light) => $question,
            Self::Constant($light) => $question,
            Self::Map($light) => $question,
            Self::Custom($light) => $question,
        }
    };
}

impl Endpoint for AnyLight {
    #[inline]
    fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample> {
        ask!(self, light => light.sample_point(u1, u2))
    }

    #[inline]
    fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
        ask!(self, light => light.point_pdf(point))
    }

    #[inline]
    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        ask!(self, light => light.sample_direction(point, u))
    }

    #[inline]
    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
        ask!(self, light => light.direction_pdf(point, direction))
    }

    #[inline]
    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        ask!(self, light => light.emit(point, direction))
    }

    #[inline]
    fn sample_from(&self, receiver: &SurfacePoint, u1: f64, u2: DVec2) -> Option<PointSample> {
        ask!(self, light => light.sample_from(receiver, u1, u2))
    }

    #[inline]
    fn pdf_from(&self, receiver: &SurfacePoint, point: &SurfacePoint) -> PerArea {
        ask!(self, light => light.pdf_from(receiver, point))
    }

    #[inline]
    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        ask!(self, light => light.facing(point, receiver))
    }
}

impl Light for AnyLight {
    fn power(&self) -> Rgb {
        ask!(self, light => light.power())
    }

    #[inline]
    fn can_be_hit(&self) -> bool {
        ask!(self, light => light.can_be_hit())
    }

    #[inline]
    fn sample_emission(
        &self,
        receiver: &SurfacePoint,
        u1: f64,
        u2: DVec2,
    ) -> Option<(PointSample, Option<Rgb>)> {
        ask!(self, light => light.sample_emission(receiver, u1, u2))
    }

    #[inline]
    fn emission_and_pdf(
        &self,
        receiver: &SurfacePoint,
        point: &SurfacePoint,
        direction: DVec3,
    ) -> (Rgb, PerArea) {
        ask!(self, light => light.emission_and_pdf(receiver, point, direction))
    }

    fn bounds(&self) -> Option<LightBounds> {
        ask!(self, light => light.bounds())
    }

    #[inline]
    fn can_be_connected(&self) -> bool {
        ask!(self, light => light.can_be_connected())
    }

    fn kind(&self) -> LightKind {
        ask!(self, light => light.kind())
    }

    fn is_black(&self) -> bool {
        ask!(self, light => light.is_black())
    }

    fn can_illuminate(&self, bounds: &Bounds) -> bool {
        ask!(self, light => light.can_illuminate(bounds))
    }

    #[inline]
    fn as_flat(&self) -> Option<&FlatLight> {
        ask!(self, light => light.as_flat())
    }

    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        ask!(self, light => light.set_scene_extent(extent));
    }

    fn into_any(self) -> AnyLight {
        self
    }
}

impl std::fmt::Debug for AnyLight {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Area(light) => light.fmt(f),
            Self::Point(light) => light.fmt(f),
            Self::Spot(light) => light.fmt(f),
            Self::Directional(light) => light.fmt(f),
            Self::Constant(light) => light.fmt(f),
            Self::Map(light) => light.fmt(f),
            Self::Custom(_) => f.write_str("Custom"),
        }
    }
}
