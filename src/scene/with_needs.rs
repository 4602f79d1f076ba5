//! A scene that says it needs something else than it does.

use super::{Needs, Scene, SurfaceArea};
use crate::endpoint::LightId;
use crate::geometry::SurfacePoint;
use glam::{DVec2, DVec3};
use std::fmt;

/// A scene with other needs: with [`Needs::ALL`] nothing is left out, which shows what leaving out
/// saves and that it changes nothing.
pub struct WithNeeds<'a, S: ?Sized> {
    /// The scene.
    pub scene: &'a S,
    /// The needs that it is to have.
    pub needs: Needs,
}

impl<'a, S: ?Sized> WithNeeds<'a, S> {
    /// The scene with nothing left out.
    #[must_use]
    pub fn all(scene: &'a S) -> Self {
        Self { scene, needs: Needs::ALL }
    }
}

impl<S: ?Sized> fmt::Debug for WithNeeds<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("WithNeeds").field("needs", &self.needs).finish_non_exhaustive()
    }
}

impl<S: Scene + ?Sized> Scene for WithNeeds<'_, S> {
    type Bsdf<'b>
        = S::Bsdf<'b>
    where
        Self: 'b;
    type Light = S::Light;

    #[inline]
    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        self.scene.intersect(from, direction)
    }
    #[inline]
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.scene.visible(a, b)
    }
    #[inline]
    fn intersect_many<'b>(
        &self,
        rays: impl Iterator<Item = (&'b SurfacePoint, DVec3)>,
        found: impl FnMut(usize, Option<SurfacePoint>),
    ) {
        self.scene.intersect_many(rays, found);
    }
    #[inline]
    fn visible_many<'b>(
        &self,
        segments: impl Iterator<Item = (&'b SurfacePoint, &'b SurfacePoint)>,
        answer: impl FnMut(usize, bool),
    ) {
        self.scene.visible_many(segments, answer);
    }
    #[inline]
    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        self.scene.bsdf(x)
    }
    #[inline]
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.scene.light_at(x)
    }
    fn environment(&self) -> Option<LightId> {
        self.scene.environment()
    }
    fn light(&self, id: LightId) -> &Self::Light {
        self.scene.light(id)
    }
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.scene.pick_light(u)
    }
    fn pick_pmf(&self, id: LightId) -> f64 {
        self.scene.pick_pmf(id)
    }
    #[inline]
    fn needs(&self) -> Needs {
        self.needs
    }
}

impl<S: SurfaceArea + ?Sized> SurfaceArea for WithNeeds<'_, S> {
    fn total_area(&self) -> f64 {
        self.scene.total_area()
    }
    fn sample_surface(&self, u1: f64, u2: DVec2) -> SurfacePoint {
        self.scene.sample_surface(u1, u2)
    }
}
