//! A node of the light tree and its importance.

use super::LightBounds;
use crate::geometry::{Place, SurfacePoint};
use glam::{DVec3, Vec3};

/// The children of a node are at most as many.
pub(super) const CHILDREN: usize = 4;
/// Rounding of cosines to f32, outwards.
const MARGIN: f32 = 1e-6;
/// Squared distances below count as this: an importance must not overflow.
const LEAST_SQUARE: f64 = 1e-290;

/// Lights that are near each other: in a sphere, with a cone of directions. A line of memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    center: DVec3,
    /// Infinite for lights without bounds.
    radius: f64,
    intensity: f64,
    axis: Vec3,
    cos_o: f32,
    cos_e: f32,
    /// The number of children, and the first of them, which are neighbours; or 0 and the item.
    link: u32,
}

impl Node {
    /// Nodes and items have numbers below.
    pub const MOST: u32 = 1 << 29;

    pub fn new(lights: &LightBounds) -> Self {
        let is_bounded = lights.is_bounded();
        Self {
            center: if is_bounded { lights.bounds.center() } else { DVec3::ZERO },
            radius: if is_bounded { lights.bounds.radius() } else { f64::INFINITY },
            intensity: lights.intensity,
            axis: lights.axis.as_vec3(),
            cos_o: (lights.theta_o.cos() as f32 - MARGIN).max(-1.0),
            cos_e: (lights.theta_e.cos() as f32 - MARGIN).max(-1.0),
            link: 0,
        }
    }

    pub fn set_item(&mut self, item: u32) {
        self.link = item << 3;
    }

    pub fn set_children(&mut self, first: u32, count: usize) {
        self.link = first << 3 | count as u32;
    }

    /// The first child and the number of children; the item and 0.
    #[inline]
    pub fn link(&self) -> (u32, usize) {
        (self.link >> 3, (self.link & 7) as usize)
    }

    /// An estimate of the irradiance that the lights cause at a point, where they are not hidden
    /// (Conty Estevez and Kulla 2018, section 4.3, from bounding spheres and for either side of the
    /// receiver). 0 only if it is certain that no light comes.
    #[inline]
    pub fn importance(&self, x: &SurfacePoint) -> f64 {
        if self.radius == f64::INFINITY || x.place == Place::Infinite {
            return self.intensity;
        }
        let to_center = self.center - x.position;
        let (square, radius_square) = (to_center.length_squared(), self.radius * self.radius);
        if square <= radius_square || square < LEAST_SQUARE {
            return self.intensity / radius_square.max(LEAST_SQUARE);
        }
        let inverse = 1.0 / square.sqrt();
        // θ_u, half the angle that the sphere is seen under.
        let sine_u = self.radius * inverse;
        let cosine_u = (1.0 - sine_u * sine_u).max(0.0).sqrt();
        let mut importance = self.intensity * inverse * inverse;
        if self.cos_o > -1.0 {
            let cosine = -to_center.dot(self.axis.as_dvec3()) * inverse;
            let cos_o = f64::from(self.cos_o);
            let (cosine, sine) = less(cosine, (cos_o, (1.0 - cos_o * cos_o).sqrt()));
            let (cosine, _) = less_of((cosine, sine), (cosine_u, sine_u));
            if cosine <= f64::from(self.cos_e).max(0.0) {
                return 0.0;
            }
            importance *= cosine;
        }
        if x.place == Place::Area {
            let cosine = (to_center.dot(x.geometric_normal) * inverse).abs();
            importance *= less(cosine, (cosine_u, sine_u)).0;
        }
        importance
    }
}

/// Cosine and sine of the angle of a cosine less another, or of 0 if that is larger.
#[inline]
fn less(cosine: f64, other: (f64, f64)) -> (f64, f64) {
    let cosine = cosine.clamp(-1.0, 1.0);
    less_of((cosine, (1.0 - cosine * cosine).sqrt()), other)
}

#[inline]
fn less_of((cos_a, sin_a): (f64, f64), (cos_b, sin_b): (f64, f64)) -> (f64, f64) {
    if cos_a >= cos_b {
        return (1.0, 0.0);
    }
    (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b)
}
