//! Multiple importance sampling weights, as one sweep over ratios of densities.
//!
//! Number the vertices of a path from the lens, x_0 … x_k, and let
//!
//! ```text
//! a_i = p⊥(x_i → x_{i+1})   as a camera walk samples it at x_i,
//! b_i = p⊥(x_i → x_{i-1})   as a light walk samples it at x_i,
//! G_i = G(x_i, x_{i+1}).
//! ```
//!
//! The technique with t vertices from the camera samples the edges before the connecting one from the camera and those behind it from
//! the light, so two neighbouring techniques differ in two factors only,
//!
//! ```text
//! p(t+1) / p(t) = a_{t-1} G_{t-1} / (b_{t+1} G_t)         p(s = 0) / p(s = 1) = a_{k-1} G_{k-1} / p(x_k),
//! ```
//!
//! and the sweep multiplies outwards from the technique that drew the path. It divides only by densities with which the path was drawn, which
//! are not zero, and it never forms a density itself, which could overflow. At a Dirac vertex a and b are coefficients of the same Dirac
//! distribution and the geometry terms on both sides cancel in the product.
//!
//! Two ends have a density of their own: the point that next event estimation chooses on the light (s = 1) and the one that light
//! tracing chooses on the lens (t = 1) may be drawn differently than the start of a walk.
//!
//! The probabilities of Russian roulette depend on the walk, not on the path alone; they are left out of all weights alike and stay in the
//! throughput.
//!
//! Sources: Veach 1997, sections 9.2 and 10.2; the projected form is derived here.

use super::TechniqueSet;
use crate::film::Technique;

/// How the densities of several techniques make a weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heuristic {
    /// w_i = p_i / Σ p_j (Veach and Guibas 1995).
    Balance,
    /// w_i = p_i^β / Σ p_j^β; β = 2 is the usual choice.
    Power(f64),
}

impl Heuristic {
    /// `ratio^β`.
    #[inline]
    #[must_use]
    pub fn raise(self, ratio: f64) -> f64 {
        match self {
            Self::Balance => ratio,
            Self::Power(exponent) if exponent == 2.0 => ratio * ratio,
            Self::Power(exponent) => ratio.powf(exponent),
        }
    }

    /// The weight of a technique whose competitors have densities with the given ratios to its own.
    #[inline]
    #[must_use]
    pub fn weight(self, ratios: impl IntoIterator<Item = f64>) -> f64 {
        1.0 / (1.0 + ratios.into_iter().map(|ratio| self.raise(ratio)).sum::<f64>())
    }
}

impl Default for Heuristic {
    fn default() -> Self {
        Self::Power(2.0)
    }
}

/// The densities of the two ends of a path, and what can be done there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// Density of x_0 as the start of a camera walk.
    pub camera: f64,
    /// Density of x_0 as the point that x_1 connects to.
    pub camera_connection: f64,
    /// Density of x_k as the start of a light walk, probability of the light included.
    pub light: f64,
    /// Density of x_k as the point that x_{k-1} connects to, probability of the light included.
    pub light_connection: f64,
    /// Whether a camera walk can hit the light by chance.
    pub hittable: bool,
    /// Whether the light can be connected to.
    pub connectible: bool,
    /// Whether light and lens can be connected to each other: not if the film would see a Dirac distribution.
    pub joinable: bool,
}

/// The densities along a path, whoever keeps them. Vertex 0 is on the lens, vertex `edges()` on the light.
pub trait PathDensities {
    /// Number of edges k.
    fn edges(&self) -> usize;
    /// a_i for 0 ≤ i < k.
    fn towards_light(&self, i: usize) -> f64;
    /// b_i for 0 < i ≤ k.
    fn towards_camera(&self, i: usize) -> f64;
    /// G_i for 0 ≤ i < k.
    fn geometry(&self, i: usize) -> f64;
    /// Whether the path takes a Dirac lobe at x_i, 0 < i < k.
    fn is_dirac(&self, i: usize) -> bool;
    /// The ends.
    fn ends(&self) -> Ends;

    /// The technique with t vertices from the camera.
    fn technique(&self, t: usize) -> Technique {
        Technique { s: (self.edges() + 1 - t) as u16, t: t as u16 }
    }

    /// Whether the technique with t vertices from the camera can draw this path at all.
    fn is_admissible(&self, t: usize) -> bool {
        let (k, ends) = (self.edges(), self.ends());
        if t == 0 || t > k + 1 {
            return false;
        }
        if t == k + 1 {
            return ends.hittable;
        }
        if k == 1 {
            return ends.joinable;
        }
        let camera_end = t == 1 || !self.is_dirac(t - 1);
        let light_end = if t == k { ends.connectible } else { !self.is_dirac(t) };
        camera_end && light_end
    }

    /// Density of the two ends under the technique with t vertices from the camera.
    fn end_density(&self, t: usize) -> f64 {
        let (k, ends) = (self.edges(), self.ends());
        let camera = if t == 1 { ends.camera_connection } else { ends.camera };
        let light = match k + 1 - t {
            0 => 1.0,
            1 if t > 1 => ends.light_connection,
            _ => ends.light,
        };
        camera * light
    }

    /// Calls `visit(t, p(t) / p(current))` for every other admissible technique of nonzero density.
    fn sweep(&self, current: usize, mut visit: impl FnMut(usize, f64))
    where
        Self: Sized,
    {
        let k = self.edges();
        let base = self.end_density(current);
        let mut product = 1.0;
        for t in current..=k {
            product *= self.towards_light(t - 1) * self.geometry(t - 1);
            if t < k {
                product /= self.towards_camera(t + 1) * self.geometry(t);
            }
            if product == 0.0 {
                break;
            }
            if self.is_admissible(t + 1) {
                visit(t + 1, product * self.end_density(t + 1) / base);
            }
        }
        let mut product = 1.0;
        for t in (2..=current).rev() {
            if t == k + 1 {
                product /= self.towards_light(k - 1) * self.geometry(k - 1);
            } else {
                product *= self.towards_camera(t) * self.geometry(t - 1);
                product /= self.towards_light(t - 2) * self.geometry(t - 2);
            }
            if product == 0.0 {
                break;
            }
            if self.is_admissible(t - 1) {
                visit(t - 1, product * self.end_density(t - 1) / base);
            }
        }
    }

    /// The weight of the technique with t vertices from the camera within a set that contains it.
    fn weight(&self, t: usize, set: &TechniqueSet, heuristic: Heuristic) -> f64
    where
        Self: Sized,
    {
        let mut sum = 1.0;
        self.sweep(t, |other, ratio| {
            if set.contains(self.technique(other)) {
                sum += heuristic.raise(ratio);
            }
        });
        1.0 / sum
    }
}
