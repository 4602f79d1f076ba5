//! A point that a path can have as a vertex.

use crate::lanes::{Lane, Vector};
use glam::{DVec2, DVec3};

/// The kind of a point, which decides the measure of its density and its geometry term.
// As wide as what is beside it in a point: copies of padding wait for bytes stored before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum Place {
    /// On a surface with area.
    Area,
    /// A single point without a surface: a pinhole, a point light. No cosine.
    Dirac,
    /// Infinitely far away in the direction opposite to its normal's: environment, directional
    /// light, orthographic camera.
    Infinite,
}

/// The origin of a shading normal, which decides who sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum NormalOrigin {
    /// The shape itself or its vertex normals.
    #[default]
    Shape,
    /// A normal or bump map. Whoever looks from where such a normal faces away sees it turned by
    /// 180° around the geometric normal.
    Map,
}

/// A point on a surface, at a Dirac position, or at infinity. Plain data, without lifetime or
/// generics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World position. At infinity: the point where the shadow ray ends, or where the ray starts.
    pub position: DVec3,
    /// Bound on the rounding error of `position` along any axis, in world units.
    pub error: f64,
    /// Unit normal of the true surface; emission and sidedness follow it. At infinity: the
    /// direction *into* the scene, in which a light there emits. Without meaning at a Dirac
    /// position.
    pub geometric_normal: DVec3,
    /// Unit normal that scattering uses; equal to the geometric one on flat surfaces.
    pub shading_normal: DVec3,
    /// The origin of the shading normal.
    pub normal_origin: NormalOrigin,
    /// Direction of growing u, not necessarily orthogonal to the shading normal; zero if the
    /// surface has no preferred direction.
    pub tangent: DVec3,
    /// Surface parameters.
    pub uv: DVec2,
    /// The kind of point.
    pub place: Place,
    /// The medium that a walk came through to this point, as numbered by the scene; 0 where nothing
    /// is absorbed. See [`Scene::transmittance`](crate::scene::Scene::transmittance).
    pub medium: u16,
    /// The primitive that the point lies on, as numbered by the scene; [`SurfacePoint::NONE`] if
    /// there is none.
    pub primitive: u32,
    /// The surface (object, material slot …) as numbered by the scene; [`SurfacePoint::NONE`] if
    /// there is none.
    pub surface: u32,
}

impl SurfacePoint {
    /// Stands for "no primitive" and "no surface".
    pub const NONE: u32 = u32::MAX;

    /// A point on a surface whose shading normal is the geometric one.
    #[inline]
    #[must_use]
    pub fn on_surface(position: DVec3, error: f64, normal: DVec3) -> Self {
        Self {
            position,
            error,
            geometric_normal: normal,
            shading_normal: normal,
            normal_origin: NormalOrigin::Shape,
            tangent: DVec3::ZERO,
            uv: DVec2::ZERO,
            place: Place::Area,
            medium: 0,
            primitive: Self::NONE,
            surface: Self::NONE,
        }
    }

    /// A Dirac position: a pinhole or a point light.
    #[must_use]
    pub fn dirac(position: DVec3) -> Self {
        Self { place: Place::Dirac, ..Self::on_surface(position, 0.0, DVec3::Z) }
    }

    /// A point at infinity; `into_scene` is the unit direction from it into the scene.
    #[must_use]
    pub fn infinite(position: DVec3, into_scene: DVec3) -> Self {
        Self { place: Place::Infinite, ..Self::on_surface(position, 0.0, into_scene) }
    }

    /// True if shading and geometric normal are the same.
    #[inline]
    #[must_use]
    pub fn is_flat(&self) -> bool {
        self.shading_normal == self.geometric_normal
    }

    /// The cosine that enters the geometry term for a unit direction `w` at this point: `|n_g · w|`
    /// on a surface, 1 elsewhere.
    #[inline]
    #[must_use]
    pub fn cosine(&self, w: DVec3) -> f64 {
        match self.place {
            Place::Area => self.geometric_normal.dot(w).abs(),
            Place::Dirac | Place::Infinite => 1.0,
        }
    }

    /// The origin of a ray that leaves the surface into direction `w`: moved along the geometric
    /// normal to that side, just beyond the error bound of the position (Wächter 2008; Pharr, Jakob
    /// and Humphreys 2016, section 3.9). Scale-free: no absolute epsilon.
    #[inline]
    #[must_use]
    pub fn origin_towards(&self, w: DVec3) -> DVec3 {
        if self.place != Place::Area {
            return self.position;
        }
        let [position, normal, w] = [self.position, self.geometric_normal, w].map(Vector::from);
        moved_towards(position, self.error, normal, w).into()
    }
}

/// Positions on surfaces, moved along the normals to the sides of directions, just beyond the error
/// bounds, in lanes.
#[inline(always)]
pub(crate) fn moved_towards<L: Lane>(
    position: Vector<L>,
    error: L,
    normal: Vector<L>,
    w: Vector<L>,
) -> Vector<L> {
    // Rounding the sum moves each coordinate by half a unit in its last place at most.
    let rounding = (position.abs().max_element() + error) * f64::EPSILON;
    // A cube of that half side around the position extends this far along the normal.
    let Vector { x, y, z } = normal.abs();
    let offset = (error + rounding) * (x + y + z);
    position + normal * offset.copysign(normal.dot(w))
}
