//! Points on surfaces, shapes, frames and robust intersection.
//!
//! | what | item |
//! |---|---|
//! | vertex of a path: position, both normals, error bound | [`SurfacePoint`], [`Place`] |
//! | triangle, quad, disk, sphere or part of one; sampled uniformly by area | [`Shape`] |
//! | ray and the point where it meets a shape | [`Ray`], [`Intersection`] |
//! | orthonormal frame | [`Frame`] |
//! | axis-aligned bounding box | [`Bounds`] |
//!
//! There is no absolute epsilon: a point knows the bound of its own rounding error, rays start just
//! beyond it (Wächter 2008; Pharr, Jakob and Humphreys 2023, section 6.8), and a [`Contact`] says
//! which end of a ray lies on a shape by construction.

mod bounds;
mod frame;
mod intersect;
mod intersect_sphere;
mod point;
mod shape;

pub use bounds::Bounds;
pub use frame::Frame;
pub(crate) use frame::around;
pub use intersect::{Contact, Intersection, Ray};
pub(crate) use intersect::{Met, largest_axis, shear_along, sheared};
pub(crate) use point::moved_towards;
pub use point::{NormalOrigin, Place, SurfacePoint};
pub use shape::{Disk, Facing, Quad, Shape, Sphere, Triangle};
pub(crate) use shape::{gamma, interpolated, spanned};
