//! Surfaces of a world: which primitives belong together, what they are made of and what they emit.

use super::mesh::Attributes;
use crate::endpoint::LightId;
use crate::material::{Relief, Texture};
use crate::math::Rgb;

/// Identifies a material of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// Identifies a surface of a world; what [`SurfacePoint::surface`](crate::geometry::SurfacePoint)
/// holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SurfaceId(pub u32);

/// The emission of a surface: the same radiance from every point into every direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Emitted radiance, W/(m² sr).
    pub radiance: Rgb,
    /// True if the back emits, too.
    pub two_sided: bool,
}

/// A surface: consecutive primitives of one material.
#[derive(Debug)]
pub(crate) struct Surface {
    pub name: String,
    pub material: MaterialId,
    /// Radiance, and whether the back emits, too.
    pub emission: Option<(Texture, bool)>,
    pub light: Option<LightId>,
    /// Black where there is nothing of the surface.
    pub cutout: Option<Texture>,
    pub first_primitive: u32,
    pub primitives: u32,
    pub attributes: Option<Attributes>,
    pub relief: Option<Box<Relief>>,
    /// Absorption coefficient of what lies behind it.
    pub absorption: Rgb,
    /// The number of that medium.
    pub medium: u16,
}

impl Surface {
    /// The surface's part of a list with an item for each primitive.
    pub fn range<'a, T>(&self, primitives: &'a [T]) -> &'a [T] {
        let first = self.first_primitive as usize;
        &primitives[first..first + self.primitives as usize]
    }
}
