//! Points on surfaces, shapes, frames and robust intersection.

mod bounds;
mod frame;
mod intersect;
mod intersect_sphere;
mod point;
mod shape;

pub use bounds::Bounds;
pub use frame::Frame;
pub use intersect::{Contact, Intersection, Ray};
pub use point::{Place, SurfacePoint};
pub use shape::{Disk, Quad, Shape, Sphere, Triangle};
pub(crate) use shape::{gamma, interpolated};
