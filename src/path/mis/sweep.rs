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
//! The technique with t vertices from the camera samples the edges before the connecting one from
//! the camera and those behind it from the light, so two neighbouring techniques differ in two
//! factors only,
//!
//! ```text
//! p(t+1) / p(t)       = a_{t-1} G_{t-1} / (b_{t+1} G_t),
//! p(s = 0) / p(s = 1) = a_{k-1} G_{k-1} / p(x_k),
//! ```
//!
//! and the sweep multiplies outwards from the technique that drew the path. It divides only by
//! densities with which the path was drawn, which are not zero, and it never forms a density
//! itself, which could overflow. At a Dirac vertex a and b are coefficients of the same Dirac
//! distribution and the geometry terms on both sides cancel in the product.
//!
//! Two ends have a density of their own: the point that next event estimation chooses on the light
//! (s = 1) and the one that light tracing chooses on the lens (t = 1) may be drawn differently than
//! the start of a walk.
//!
//! A technique with n samples per sample of the image has the density n p in all weights.
//!
//! The probabilities of Russian roulette depend on the walk, not on the path alone; they are left
//! out of all weights alike and stay in the throughput.
//!
//! The sweep takes time in proportion to k; bidirectional path tracing takes constant time by
//! the [partial sums](super::Weighting) of its subpaths, with the same result.
//!
//! Sources: Veach 1997, sections 9.2 and 10.2; the projected form is derived here.

use crate::film::Technique;
use crate::path::TechniqueSet;

/// The heuristic that makes a weight of the densities of several techniques.
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
            Self::Power(2.0) => ratio * ratio,
            Self::Power(exponent) => ratio.powf(exponent),
        }
    }

    /// The weight of a technique, given the ratios of the other techniques' densities to its own.
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
    /// True if a camera walk can hit the light by chance.
    pub hittable: bool,
    /// True if the light can be connected to.
    pub connectible: bool,
    /// True if light and lens can be connected to each other: not if the film would see a Dirac
    /// distribution.
    pub joinable: bool,
}

/// The densities along a path, whoever keeps them. Vertex 0 is on the lens, vertex `edges()` on the
/// light.
pub trait PathDensities {
    /// Number of edges k.
    fn edges(&self) -> usize;
    /// a_i for 0 ≤ i < k.
    fn towards_light(&self, i: usize) -> f64;
    /// b_i for 0 < i ≤ k.
    fn towards_camera(&self, i: usize) -> f64;
    /// G_i for 0 ≤ i < k.
    fn geometry(&self, i: usize) -> f64;
    /// True if the path takes a Dirac lobe at x_i, 0 < i < k.
    fn is_dirac(&self, i: usize) -> bool;
    /// The ends.
    fn ends(&self) -> Ends;

    /// The technique with t vertices from the camera.
    fn technique(&self, t: usize) -> Technique {
        Technique::new((self.edges() + 1 - t) as u16, t as u16)
    }

    /// True if the technique with t vertices from the camera can draw this path at all.
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
        let own = set.count(self.technique(t));
        self.sweep(t, |other, ratio| {
            let other = self.technique(other);
            if set.contains(other) {
                sum += heuristic.raise(ratio * (set.count(other) / own));
            }
        });
        1.0 / sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Excluded;
    use approx::assert_relative_eq;

    /// Densities given as plain lists.
    struct Listed {
        a: Vec<f64>,
        b: Vec<f64>,
        g: Vec<f64>,
        dirac: Vec<bool>,
        ends: Ends,
    }

    impl PathDensities for Listed {
        fn edges(&self) -> usize {
            self.g.len()
        }
        fn towards_light(&self, i: usize) -> f64 {
            self.a[i]
        }
        fn towards_camera(&self, i: usize) -> f64 {
            self.b[i]
        }
        fn geometry(&self, i: usize) -> f64 {
            self.g[i]
        }
        fn is_dirac(&self, i: usize) -> bool {
            self.dirac[i]
        }
        fn ends(&self) -> Ends {
            self.ends
        }
    }

    const ENDS: Ends = Ends {
        camera: 1.0,
        camera_connection: 1.0,
        light: 0.5,
        light_connection: 0.25,
        hittable: true,
        connectible: true,
        joinable: true,
    };

    fn random_path(k: usize, seed: u64) -> Listed {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg32::seed_from_u64(seed);
        let mut list = |n: usize| (0..n).map(|_| rng.random_range(0.1..10.0)).collect::<Vec<f64>>();
        Listed { a: list(k + 1), b: list(k + 1), g: list(k), dirac: vec![false; k + 1], ends: ENDS }
    }

    #[test]
    fn weights_sum_to_one_for_any_set_and_heuristic() {
        for k in 1..=20 {
            for (seed, heuristic) in
                [Heuristic::Balance, Heuristic::Power(2.0), Heuristic::Power(0.7)]
                    .into_iter()
                    .enumerate()
            {
                let mut path = random_path(k, seed as u64 * 100 + k as u64);
                if k > 4 {
                    path.dirac[2] = true;
                }
                let without = |t| Excluded::NONE.with(path.technique(t));
                let sets = [Some(Excluded::NONE), without(1), without(k + 1)];
                for excluded in sets.into_iter().flatten() {
                    let set = TechniqueSet { excluded, ..TechniqueSet::BIDIRECTIONAL };
                    let sum: f64 = (1..=k + 1)
                        .filter(|&t| path.is_admissible(t) && set.contains(path.technique(t)))
                        .map(|t| path.weight(t, &set, heuristic))
                        .sum();
                    assert_relative_eq!(sum, 1.0, max_relative = 1e-12);
                }
            }
        }
    }

    #[test]
    fn ratios_are_those_of_the_products_of_densities() {
        let path = random_path(5, 3);
        let k = path.edges();
        let density = |t: usize| {
            let camera: f64 = (0..t - 1).map(|i| path.a[i] * path.g[i]).product();
            let light: f64 = (t + 1..=k).map(|i| path.b[i] * path.g[i - 1]).product();
            path.end_density(t) * camera * light
        };
        for current in 1..=k + 1 {
            let mut visited = 0;
            path.sweep(current, |t, ratio| {
                assert_relative_eq!(ratio, density(t) / density(current), max_relative = 1e-12);
                visited += 1;
            });
            assert_eq!(visited, k);
        }
    }

    /// The ratio of densities across a planar mirror between two Lambertian surfaces is 1, whatever
    /// the distances.
    #[test]
    fn a_mirror_between_two_diffuse_surfaces_does_not_change_the_ratio() {
        // x_0 lens, x_1 = a, x_2 mirror, x_3 = b, x_4 light. The mirror samples with probability 1
        // both ways.
        let p = std::f64::consts::FRAC_1_PI;
        let path = Listed {
            a: vec![0.3, p, 1.0, p, 0.0],
            b: vec![0.0, p, 1.0, p, p],
            g: vec![0.7, 0.123, 4.56, 0.7],
            dirac: vec![false, false, true, false, false],
            ends: ENDS,
        };
        // From connecting (x_0, x_1) to connecting (x_3, x_4): x_1, x_3 change sides; the edge x_0
        // x_1 is sampled instead of x_3 x_4.
        let mut ratio = 0.0;
        path.sweep(1, |t, r| {
            assert!(
                t == 4 || t == 5,
                "techniques that connect to a mirror are not admissible: t = {t}"
            );
            if t == 4 {
                ratio = r;
            }
        });
        let ends = path.end_density(4) / path.end_density(1);
        assert_relative_eq!(ratio, ends * 0.3 / p, max_relative = 1e-14);
    }

    #[test]
    fn extreme_geometry_terms_do_not_leave_the_range() {
        for scale in [1e-30, 1e-12, 1.0, 1e12, 1e30] {
            let mut path = random_path(20, 5);
            path.g.iter_mut().for_each(|g| *g *= scale);
            let set = TechniqueSet { bsdf_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
            let sum: f64 = (1..=20).map(|t| path.weight(t, &set, Heuristic::Power(2.0))).sum();
            assert_relative_eq!(sum, 1.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn zero_and_infinite_ratios_are_legal() {
        assert_eq!(Heuristic::Power(2.0).weight([f64::INFINITY]), 0.0);
        assert_eq!(Heuristic::Power(2.0).weight([0.0]), 1.0);
        assert_eq!(Heuristic::Balance.weight([1e200, 1e200]), 0.5e-200);
    }
}
