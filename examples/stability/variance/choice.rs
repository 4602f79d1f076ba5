//! A world whose lights are chosen otherwise.

use pathspace::endpoint::{Light, LightId};
use pathspace::geometry::SurfacePoint;
use pathspace::glam::DVec3;
use pathspace::math::distribution::AliasTable;
use pathspace::scene::{Needs, Scene, World};

/// A world whose lights are chosen by fixed weights.
pub struct Chosen<'a> {
    world: &'a World,
    table: Option<AliasTable>,
}

impl<'a> Chosen<'a> {
    /// All alike.
    pub fn uniformly(world: &'a World) -> Self {
        Self::by(world, |_| 1.0)
    }

    /// By their power.
    pub fn by_power(world: &'a World) -> Self {
        Self::by(world, |id| world.light(id).power().mean())
    }

    fn by(world: &'a World, weight: impl Fn(LightId) -> f64) -> Self {
        let weights: Vec<f64> =
            (0..world.light_count()).map(|id| weight(LightId(id as u32))).collect();
        Self { world, table: AliasTable::new(&weights) }
    }
}

impl Scene for Chosen<'_> {
    type Bsdf<'a>
        = <World as Scene>::Bsdf<'a>
    where
        Self: 'a;
    type Light = <World as Scene>::Light;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        self.world.intersect(from, direction)
    }

    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.world.visible(a, b)
    }

    fn intersect_many<'a>(
        &self,
        rays: impl Iterator<Item = (&'a SurfacePoint, DVec3)>,
        found: impl FnMut(usize, Option<SurfacePoint>),
    ) {
        self.world.intersect_many(rays, found);
    }

    fn visible_many<'a>(
        &self,
        segments: impl Iterator<Item = (&'a SurfacePoint, &'a SurfacePoint)>,
        answer: impl FnMut(usize, bool),
    ) {
        self.world.visible_many(segments, answer);
    }

    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        self.world.bsdf(x)
    }

    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.world.light_at(x)
    }

    fn environment(&self) -> Option<LightId> {
        self.world.environment()
    }

    fn light(&self, id: LightId) -> &Self::Light {
        self.world.light(id)
    }

    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        let (index, pmf) = self.table.as_ref()?.sample(u);
        Some((LightId(index as u32), pmf))
    }

    fn pick_pmf(&self, id: LightId) -> f64 {
        self.table.as_ref().map_or(0.0, |table| table.pmf(id.0 as usize))
    }

    fn needs(&self) -> Needs {
        self.world.needs()
    }
}
