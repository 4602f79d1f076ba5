//! Points on surfaces, shapes, frames and robust intersection.

mod bounds;
mod frame;
mod point;
mod shape;

pub use bounds::Bounds;
pub use frame::Frame;
pub use point::{Place, SurfacePoint};
pub use shape::{Disk, Quad, Shape, Sphere, Triangle};
