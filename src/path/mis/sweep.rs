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
//! Half-way between two connections the sweep passes a merge: both walks sample x_m, and they are
//! taken as meeting there if their points are within a distance r of each other. With η = πr² its
//! density is
//!
//! ```text
//! p(merge at x_m) = p(t = m + 1) · η b_{m+1} G_m = p(t = m) · η a_{m-1} G_{m-1},
//! ```
//!
//! the probability that the second walk falls into the disc, and n is the number of light walks
//! that a camera walk merges with (Georgiev et al. 2012; Hachisuka, Pantaleoni and Jensen 2012).
//!
//! The probabilities of Russian roulette depend on the walk, not on the path alone; they are left
//! out of all weights alike and stay in the throughput.
//!
//! The sweep takes time in proportion to k; bidirectional path tracing takes constant time by
//! the [partial sums](super::Weighting) of its subpaths, with the same result.
//!
//! Sources: Veach 1997, sections 9.2 and 10.2; the projected form is derived here.

use super::Weighting;
use crate::film::Technique;
use crate::lanes::Lane;

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
            Self::Power(exponent) => libm::pow(ratio, exponent),
        }
    }

    /// True if lanes can raise ratios.
    #[inline]
    pub(in crate::path) fn is_in_lanes(self) -> bool {
        matches!(self, Self::Balance | Self::Power(2.0))
    }

    /// [`raise`](Self::raise) in lanes.
    #[inline(always)]
    pub(in crate::path) fn raise_in_lanes<L: Lane>(self, ratio: L) -> L {
        if self == Self::Balance { ratio } else { ratio * ratio }
    }

    // ANCHOR: weight
    /// The weight of a technique, given the ratios of the other techniques' densities to its own.
    #[inline]
    #[must_use]
    pub fn weight(self, ratios: impl IntoIterator<Item = f64>) -> f64 {
        1.0 / (1.0 + ratios.into_iter().map(|ratio| self.raise(ratio)).sum::<f64>())
    }
    // ANCHOR_END: weight
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
    /// A, the area around x_1 that the lens sees within 1° of its direction: the size of what
    /// [`correlation`](PathDensities::correlation) takes as near. 1 if the lens is at infinity.
    pub footprint: f64,
    /// The probability that another light walk starts within such an area; of a light without an
    /// area, at this very point or direction.
    pub light_footprint: f64,
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

    /// The connection with t vertices from the camera; if t = k + 1, the hit.
    fn technique(&self, t: usize) -> Technique {
        Technique::new((self.edges() + 1 - t) as u16, t as u16)
    }

    /// The merge at x_m.
    fn merge(&self, m: usize) -> Technique {
        Technique::merge((self.edges() + 1 - m) as u16, m as u16 + 1)
    }

    /// All techniques of paths of this length that can draw this one at all, merges last.
    fn admissible(&self) -> impl Iterator<Item = Technique> {
        let k = self.edges();
        let connections = (1..=k + 1).map(|t| self.technique(t));
        connections
            .chain((1..k).map(|m| self.merge(m)))
            .filter(|technique| self.is_admissible(*technique))
    }

    /// True if a technique for paths of this length can draw this one at all.
    fn is_admissible(&self, technique: Technique) -> bool {
        let (k, t, ends) = (self.edges(), usize::from(technique.t), self.ends());
        if technique.merged {
            return t >= 2 && t <= k && !self.is_dirac(t - 1);
        }
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

    /// Density of the two ends under a technique.
    fn end_density(&self, technique: Technique) -> f64 {
        let ends = self.ends();
        let Technique { s, t, merged } = technique;
        let camera = if t == 1 { ends.camera_connection } else { ends.camera };
        let light = match s {
            0 => 1.0,
            1 if t > 1 && !merged => ends.light_connection,
            _ => ends.light,
        };
        camera * light
    }

    /// Calls `visit(technique, p(technique) / p(current))` for every other admissible technique of
    /// nonzero density, merges within discs of the given area among them if that is not zero.
    fn sweep(&self, current: Technique, merge_area: f64, mut visit: impl FnMut(Technique, f64))
    where
        Self: Sized,
    {
        let (k, t) = (self.edges(), usize::from(current.t));
        let density = |technique: Technique| {
            self.end_density(technique) * if technique.merged { merge_area } else { 1.0 }
        };
        let base = density(current);
        let mut meet = |technique: Technique, product: f64| {
            if self.is_admissible(technique) {
                visit(technique, product * density(technique) / base);
            }
        };
        // ANCHOR: sweep
        // Upwards from the connection with i vertices from the camera to the merge at x_i, and on
        // to the connection with one more. A current merge is half-way.
        let mut product = 1.0;
        for i in t - usize::from(current.merged)..=k {
            if !(current.merged && i + 1 == t) {
                product *= self.towards_light(i - 1) * self.geometry(i - 1);
                if merge_area > 0.0 && i < k && product > 0.0 {
                    meet(self.merge(i), product);
                }
            }
            if i < k {
                product /= self.towards_camera(i + 1) * self.geometry(i);
            }
            if product == 0.0 {
                break;
            }
            meet(self.technique(i + 1), product);
        }
        // ANCHOR_END: sweep
        // Downwards to the merge at x_{i-1} and the connection with i - 1 vertices.
        let mut product = 1.0;
        for i in (2..=t).rev() {
            if i == k + 1 {
                product /= self.towards_light(k - 1) * self.geometry(k - 1);
            } else {
                if !(current.merged && i == t) {
                    product *= self.towards_camera(i) * self.geometry(i - 1);
                    if merge_area > 0.0 && product > 0.0 {
                        meet(self.merge(i - 1), product);
                    }
                }
                product /= self.towards_light(i - 2) * self.geometry(i - 2);
            }
            if product == 0.0 {
                break;
            }
            meet(self.technique(i - 1), product);
        }
    }

    /// The weight of a technique of a weighting's set.
    fn weight(&self, technique: Technique, weighting: &Weighting) -> f64
    where
        Self: Sized,
    {
        let (set, heuristic) = (weighting.set(), weighting.heuristic());
        let count = |technique: Technique| {
            let is_correlated = technique.merged && weighting.is_correlation_aware();
            let m = usize::from(technique.t) - 1;
            set.count(technique) * if is_correlated { self.correlation(m) } else { 1.0 }
        };
        let (mut sum, own) = (1.0, count(technique));
        self.sweep(technique, weighting.merge_area(), |other, ratio| {
            if set.contains(other) {
                sum += heuristic.raise(ratio * (count(other) / own));
            }
        });
        1.0 / sum
    }

    /// The part of the light walks merged at x_m that counts as independent: all that one query
    /// finds share the camera subpath before it.
    ///
    /// ```text
    /// ρ_m = P_c / (P_c + P_l - P_c P_l),    ρ_1 = 1,
    /// P_c = Π_{1≤j≤m} min(1, A α_j),        P_l = Π_{m≤j<k} min(1, A β_j),
    /// ```
    ///
    /// with the densities per area α_j = a_{j-1} G_{j-1} and β_j = b_{j+1} G_j with which the walks
    /// sample x_j, and the [footprint](Ends::footprint) A (Grittmann, Georgiev and Slusallek 2021).
    fn correlation(&self, m: usize) -> f64 {
        if m <= 1 {
            return 1.0;
        }
        let ends = self.ends();
        // Sums of logarithms, because both products can underflow.
        let log = |density: f64| libm::log(density.clamp(f64::MIN_POSITIVE, 1.0));
        let near = |density: f64| ends.footprint * density;
        let camera: f64 = (0..m).map(|i| log(near(self.towards_light(i) * self.geometry(i)))).sum();
        let light: f64 = (m..self.edges())
            .map(|i| {
                let start = if i + 1 == self.edges() { ends.light_footprint } else { 1.0 };
                log(near(self.towards_camera(i + 1) * self.geometry(i)) * start)
            })
            .sum();
        1.0 / (1.0 + libm::exp(light - camera) - libm::exp(light))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Excluded, TechniqueSet};
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
        footprint: 0.01,
        light_footprint: 0.02,
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
                let excluded = [Some(Excluded::NONE), without(1), without(k + 1)];
                for (excluded, merges) in excluded.into_iter().flatten().zip([3, 0, 7]) {
                    let set = TechniqueSet { excluded, merges, ..TechniqueSet::BIDIRECTIONAL };
                    let independent = Weighting::new(set, heuristic).with_merge_radius(0.2);
                    for weighting in [independent, independent.correlation_aware()] {
                        let sum: f64 = path
                            .admissible()
                            .filter(|technique| set.contains(*technique))
                            .map(|technique| path.weight(technique, &weighting))
                            .sum();
                        assert_relative_eq!(sum, 1.0, max_relative = 1e-12);
                    }
                }
            }
        }
    }

    /// Whatever is left out, connections and merges, what is left shares the weight.
    #[test]
    fn weights_of_what_is_left_sum_to_one() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg32::seed_from_u64(9);
        let (mut left, mut left_out) = (0, [0, 0]);
        for round in 0..2000 {
            let mut path = random_path(rng.random_range(1..=9), round);
            let k = path.edges();
            (1..k).for_each(|i| path.dirac[i] = rng.random_bool(0.2));
            let part = rng.random_range(0.1..0.9);
            let chosen: Vec<_> = path.admissible().filter(|_| rng.random_bool(part)).collect();
            let excluded = chosen.iter().try_fold(Excluded::NONE, |set, one| set.with(*one));
            let excluded = excluded.expect("a short path");
            let set = TechniqueSet { excluded, merges: 5, ..TechniqueSet::BIDIRECTIONAL };
            let on: Vec<_> = path.admissible().filter(|one| set.contains(*one)).collect();
            assert_eq!(on.len() + chosen.len(), path.admissible().count());
            chosen.iter().for_each(|one| left_out[usize::from(one.merged)] += 1);
            let heuristic = [Heuristic::Balance, Heuristic::Power(2.0)][round as usize % 2];
            let independent = Weighting::new(set, heuristic).with_merge_radius(0.2);
            for weighting in [independent, independent.correlation_aware()] {
                let sum: f64 = on.iter().map(|one| path.weight(*one, &weighting)).sum();
                if !on.is_empty() {
                    assert_relative_eq!(sum, 1.0, max_relative = 1e-12);
                    left += 1;
                }
            }
        }
        assert!(left > 3000 && left_out[0] > 1000 && left_out[1] > 1000, "{left} {left_out:?}");
    }

    #[test]
    fn ratios_are_those_of_the_products_of_densities() {
        let mut path = random_path(5, 3);
        path.dirac[2] = true;
        let (k, area) = (path.edges(), 0.3);
        let density = |technique: Technique| {
            let t = usize::from(technique.t);
            let onwards = t + usize::from(!technique.merged);
            let camera: f64 = (0..t - 1).map(|i| path.a[i] * path.g[i]).product();
            let light: f64 = (onwards..=k).map(|i| path.b[i] * path.g[i - 1]).product();
            let near = if technique.merged { area } else { 1.0 };
            path.end_density(technique) * camera * light * near
        };
        // Less what connects to the Dirac vertex, and the merge there.
        assert_eq!(path.admissible().count(), k + 1 - 2 + k - 1 - 1);
        for current in path.admissible() {
            let mut visited = Vec::new();
            path.sweep(current, area, |technique, ratio| {
                let expected = density(technique) / density(current);
                assert_relative_eq!(ratio, expected, max_relative = 1e-12);
                visited.push(technique);
            });
            visited.push(current);
            visited.sort();
            let mut all: Vec<_> = path.admissible().collect();
            all.sort();
            assert_eq!(visited, all);
        }
    }

    /// Photons of the camera's first hit are independent; those behind a narrow lobe of the camera
    /// that see far are as one.
    #[test]
    fn what_one_query_finds_is_counted_by_how_near_the_camera_walks_are() {
        let mut path = random_path(4, 8);
        path.a = vec![1e4; 5];
        path.b = vec![1e-9; 5];
        path.g = vec![1.0; 4];
        assert_eq!(path.correlation(1), 1.0);
        // P_c = 1 since A α = 100: nothing of the light's side is shared.
        assert_relative_eq!(path.correlation(2), 1.0, max_relative = 1e-12);
        path.a = vec![1e-9; 5];
        path.b = vec![1e4; 5];
        // P_l = 1: ρ = P_c, of three edges.
        let expected = (0.01f64 * 1e-9).powi(3);
        assert_relative_eq!(path.correlation(3), expected, max_relative = 1e-9);
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
        let [lens, light] = [1, 4].map(|t| path.technique(t));
        path.sweep(lens, 0.0, |technique, r| {
            assert!(
                technique == light || technique.s == 0,
                "techniques that connect to a mirror are not admissible: {technique}"
            );
            if technique == light {
                ratio = r;
            }
        });
        let ends = path.end_density(light) / path.end_density(lens);
        assert_relative_eq!(ratio, ends * 0.3 / p, max_relative = 1e-14);
    }

    #[test]
    fn extreme_geometry_terms_do_not_leave_the_range() {
        for scale in [1e-30, 1e-12, 1.0, 1e12, 1e30] {
            let mut path = random_path(20, 5);
            path.g.iter_mut().for_each(|g| *g *= scale);
            let set = TechniqueSet { bsdf_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
            let weighting = Weighting::new(set, Heuristic::Power(2.0));
            let sum: f64 = (1..=20).map(|t| path.weight(path.technique(t), &weighting)).sum();
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
