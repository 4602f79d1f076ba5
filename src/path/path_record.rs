//! A path evaluated from the definitions alone, factor by factor: the measure of an audit for an
//! integrator's numbers.

use super::mis::{Ends, PathDensities};
use super::view::ends;
use super::walk::{emission_density, emission_pdf};
use super::{Edge, MergedPath, Path, Stage, StartDensity, Weighting};
use crate::bsdf::TransportMode;
use crate::bsdf::shading::ShadedBsdf;
use crate::endpoint::{Endpoint, LightId};
use crate::film::Technique;
use crate::geometry::{Place, SurfacePoint};
use crate::math::Rgb;
use crate::scene::Scene;

/// Every factor of a path's contribution and of the densities of all techniques. Index i belongs to
/// vertex x_i, or to the edge x_i x_{i+1}.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRecord {
    /// The vertices x_0 … x_k.
    pub points: Vec<SurfacePoint>,
    /// True at the vertices where the path takes a Dirac lobe.
    pub dirac: Vec<bool>,
    /// Importance We at x_0, the BSDF f (Dirac: its coefficient) at x_1 … x_{k-1}, radiance Le at
    /// x_k.
    pub factors: Vec<Rgb>,
    /// G of each edge.
    pub geometry_terms: Vec<f64>,
    /// The share of light that media leave along each edge.
    pub transmittances: Vec<Rgb>,
    /// a_i, density per projected solid angle from x_i to x_{i+1}.
    pub towards_light: Vec<f64>,
    /// b_i, density per projected solid angle from x_i to x_{i-1}; b_0 is 0.
    pub towards_camera: Vec<f64>,
    /// Densities of the end points.
    pub ends: Ends,
}

impl PathRecord {
    /// Evaluates f, G and all densities at the given points, k ≥ 1. `dirac[i]` selects the Dirac
    /// part of the BSDF at x_i. Edges between coinciding points have G = 0.
    #[must_use]
    pub fn evaluate<S: Scene + ?Sized>(
        stage: &Stage<'_, S>,
        points: &[SurfacePoint],
        dirac: &[bool],
        light: LightId,
    ) -> Self {
        let Stage { scene, camera, .. } = *stage;
        let k = points.len() - 1;
        let none = Edge { direction: glam::DVec3::ZERO, geometry: 0.0 };
        let edge = |a: &SurfacePoint, b: &SurfacePoint| match (a.place, b.place) {
            // A lens at infinity that sees an environment directly: parallel lines have no
            // direction between their ends, but the lens has one.
            (Place::Infinite, Place::Infinite) => Edge::along(a, b, a.geometric_normal),
            _ => Edge::between(a, b).unwrap_or(none),
        };
        let edges: Vec<Edge> = points.windows(2).map(|pair| edge(&pair[0], &pair[1])).collect();
        let mut factors = vec![Rgb::BLACK; k + 1];
        let mut towards_light = vec![0.0; k + 1];
        let mut towards_camera = vec![0.0; k + 1];
        factors[0] = camera.emit(&points[0], edges[0].direction);
        towards_light[0] = camera.direction_pdf(&points[0], edges[0].direction).value();
        for i in 1..k {
            let bsdf = ShadedBsdf::new(scene.bsdf(&points[i]), &points[i]);
            let (to_light, to_camera) = (edges[i].direction, -edges[i - 1].direction);
            if dirac[i] {
                let value = bsdf.eval_dirac(to_light, to_camera);
                factors[i] = value.value;
                towards_light[i] = value.pdf_to_light.value();
                towards_camera[i] = value.pdf_to_camera.value();
            } else {
                factors[i] = bsdf.eval(to_light, to_camera);
                towards_light[i] = bsdf.pdf(to_camera, to_light, TransportMode::Radiance).value();
                towards_camera[i] =
                    bsdf.pdf(to_light, to_camera, TransportMode::Importance).value();
            }
        }
        let emitter = scene.light(light);
        let to_camera = -edges[k - 1].direction;
        factors[k] = emitter.emit(&points[k], to_camera);
        towards_camera[k] = emission_pdf(emitter, &points[k], &points[k - 1], to_camera);
        let start = emission_density(stage, light, &points[k - 1], &points[k]);
        let lens = StartDensity {
            walk: camera.point_pdf(&points[0]),
            connection: camera.pdf_from(&points[1], &points[0]),
        };
        Self {
            points: points.to_vec(),
            dirac: dirac.to_vec(),
            factors,
            geometry_terms: edges.iter().map(|edge| edge.geometry).collect(),
            transmittances: points
                .windows(2)
                .map(|pair| scene.transmittance(&pair[0], &pair[1]))
                .collect(),
            towards_light,
            towards_camera,
            ends: ends(emitter, [&points[0], &points[1], &points[k]], [lens, start]),
        }
    }

    /// The same of a path that two subpaths merge at x_m: the camera subpath ends at `points[m]`,
    /// the light subpath at `photon`. The BSDF is that of `points[m]`, with the directions of the
    /// two edges.
    #[must_use]
    pub fn evaluate_merge<S: Scene + ?Sized>(
        stage: &Stage<'_, S>,
        points: &[SurfacePoint],
        (m, photon): (usize, SurfacePoint),
        dirac: &[bool],
        light: LightId,
    ) -> Self {
        let mut record = Self::evaluate(stage, points, dirac, light);
        let mut beyond = points.to_vec();
        beyond[m] = photon;
        let beyond = Self::evaluate(stage, &beyond, dirac, light);
        record.geometry_terms[m..].copy_from_slice(&beyond.geometry_terms[m..]);
        record.transmittances[m..].copy_from_slice(&beyond.transmittances[m..]);
        record.factors[m + 1..].copy_from_slice(&beyond.factors[m + 1..]);
        record.towards_light[m + 1..].copy_from_slice(&beyond.towards_light[m + 1..]);
        record.towards_camera[m + 1..].copy_from_slice(&beyond.towards_camera[m + 1..]);
        record.ends.light_connection = beyond.ends.light_connection;
        let towards = |from: &SurfacePoint, to: &SurfacePoint| {
            Edge::between(from, to).map_or(glam::DVec3::ZERO, |edge| edge.direction)
        };
        let to_light = towards(&photon, &points[m + 1]);
        let to_camera = towards(&points[m], &points[m - 1]);
        let bsdf = ShadedBsdf::new(stage.scene.bsdf(&points[m]), &points[m]);
        record.factors[m] = bsdf.eval(to_light, to_camera);
        record.towards_light[m] = bsdf.pdf(to_camera, to_light, TransportMode::Radiance).value();
        record.towards_camera[m] = bsdf.pdf(to_light, to_camera, TransportMode::Importance).value();
        record
    }

    // ANCHOR: throughput
    /// The word for vertex x_i: lens, pinhole, surface, specular, light and so on.
    #[must_use]
    pub fn vertex_kind(&self, i: usize) -> &'static str {
        match (i, self.points[i].place) {
            (0, Place::Area) => "lens",
            (0, Place::Dirac) => "pinhole",
            (0, Place::Infinite) => "lens at ∞",
            (i, Place::Area) if i == self.edges() => "light",
            (i, Place::Dirac) if i == self.edges() => "point light",
            (i, Place::Infinite) if i == self.edges() => "light at ∞",
            _ if self.dirac[i] => "specular",
            _ => "surface",
        }
    }

    /// The symbol for the factor at vertex x_i: We, f, f (δ) or Le.
    #[must_use]
    pub fn factor_symbol(&self, i: usize) -> &'static str {
        match i {
            0 => "We",
            _ if i == self.edges() => "Le",
            _ if self.dirac[i] => "f (δ)",
            _ => "f",
        }
    }

    /// The throughput `T = Π_{i=1}^{k-1} f(x_i) G(x_i, x_{i+1})`, with what media leave of it.
    #[must_use]
    pub fn throughput(&self) -> Rgb {
        self.throughputs().last().unwrap_or(Rgb::WHITE)
    }

    /// The product T from factor to factor, T_1 … T_{k-1}: each vertex that scatters adds its BSDF
    /// and the edge behind it,
    ///
    /// ```text
    /// T_0 = 1,    T_i = f(x_i) G(x_i, x_{i+1}) T_{i-1},    T_{k-1} = T,
    /// ```
    ///
    /// as a walk from the lens does, which divides each step by the density `p⊥ G` of its next
    /// vertex and so needs no G.
    pub fn throughputs(&self) -> impl Iterator<Item = Rgb> {
        (1..self.edges()).scan(Rgb::WHITE, |product, i| {
            *product = *product * self.factors[i] * self.edge_term(i);
            Some(*product)
        })
    }
    // ANCHOR_END: throughput

    // ANCHOR: contribution
    /// The measurement contribution `We · G(x_0, x_1) · T · Le`.
    #[must_use]
    pub fn contribution(&self) -> Rgb {
        self.factors[0] * self.edge_term(0) * self.throughput() * self.factors[self.edges()]
    }
    // ANCHOR_END: contribution

    /// The geometry term of an edge times its transmittance.
    fn edge_term(&self, i: usize) -> Rgb {
        self.geometry_terms[i] * self.transmittances[i]
    }

    /// The density of the path, in the product measure of its places, under the technique with t
    /// vertices from the camera; 0 if that technique cannot draw it. Long paths can leave the range
    /// of f64 here; weights never form this product.
    #[must_use]
    pub fn density(&self, t: usize) -> f64 {
        self.density_of(self.technique(t))
    }

    /// The same under the merge at x_m, within discs of the given area: both subpaths have drawn
    /// x_m.
    #[must_use]
    pub fn merge_density(&self, m: usize, merge_area: f64) -> f64 {
        merge_area * self.density_of(self.merge(m))
    }

    fn density_of(&self, technique: Technique) -> f64 {
        if !self.is_admissible(technique) {
            return 0.0;
        }
        let (k, t) = (self.edges(), usize::from(technique.t));
        let onwards = t + usize::from(!technique.merged);
        let camera: f64 =
            (0..t - 1).map(|i| self.towards_light[i] * self.geometry_terms[i]).product();
        let light: f64 =
            (onwards..=k).map(|i| self.towards_camera[i] * self.geometry_terms[i - 1]).product();
        self.end_density(technique) * camera * light
    }

    /// `f/p` under the technique with t vertices from the camera, multiplied up edge by edge so
    /// that it stays in range.
    #[must_use]
    pub fn estimate(&self, t: usize) -> Rgb {
        self.product(self.technique(t))
    }

    /// `f/(N p)` under the merge at x_m, within discs of the given area and with N light walks.
    #[must_use]
    pub fn merge_estimate(&self, m: usize, merge_area: f64, light_walks: u32) -> Rgb {
        self.product(self.merge(m)) * (1.0 / (f64::from(light_walks) * merge_area))
    }

    fn product(&self, technique: Technique) -> Rgb {
        let t = usize::from(technique.t);
        let mut value = self.factors[0] * (1.0 / self.end_density(technique));
        for i in 0..self.edges() {
            let g = self.geometry_terms[i];
            let density = if i + 1 < t {
                self.towards_light[i] * g
            } else if i + 1 == t && !technique.merged {
                1.0
            } else {
                self.towards_camera[i + 1] * g
            };
            value = value * self.factors[i + 1] * (g / density) * self.transmittances[i];
        }
        value
    }
}

impl PathDensities for PathRecord {
    fn edges(&self) -> usize {
        self.points.len() - 1
    }
    fn towards_light(&self, i: usize) -> f64 {
        self.towards_light[i]
    }
    fn towards_camera(&self, i: usize) -> f64 {
        self.towards_camera[i]
    }
    fn geometry(&self, i: usize) -> f64 {
        self.geometry_terms[i]
    }
    fn is_dirac(&self, i: usize) -> bool {
        self.dirac[i]
    }
    fn ends(&self) -> Ends {
        self.ends
    }
}

/// The distances of an integrator's numbers for a path from the definitions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verification {
    /// Relative difference of the unweighted estimate f/p, Russian roulette taken out; infinite if
    /// one of the two is not finite.
    pub value_error: f64,
    /// Difference of the weight.
    pub weight_error: f64,
    /// |Σ w - 1| over all techniques of the set that can draw the path, each weight by a sweep of
    /// its own.
    pub weight_sum_error: f64,
}

impl Verification {
    /// The largest of the three errors; infinite if one of them is not a number.
    #[must_use]
    pub fn worst(&self) -> f64 {
        let errors = [self.value_error, self.weight_error, self.weight_sum_error];
        // `max` alone would ignore what is not a number.
        if errors.iter().any(|error| error.is_nan()) {
            f64::INFINITY
        } else {
            errors.into_iter().fold(0.0, f64::max)
        }
    }
}

impl<'s, S: Scene + ?Sized + 's> Path<'_, 's, S> {
    /// Evaluates the path anew from its points: f, G, densities, nothing cached.
    #[must_use]
    pub fn record(&self) -> PathRecord {
        let k = self.edges();
        let densities = self.densities();
        let points: Vec<SurfacePoint> = (0..=k).map(|i| self.vertex(i).point).collect();
        let dirac: Vec<bool> = (0..=k).map(|i| i > 0 && i < k && densities.is_dirac(i)).collect();
        PathRecord::evaluate(self.stage, &points, &dirac, self.light)
    }

    /// Re-evaluates the path from the definitions and compares.
    #[must_use]
    pub fn verify(&self, weighting: &Weighting) -> Verification {
        let (record, technique) = (self.record(), self.technique());
        let exact = record.estimate(technique.t.into());
        let cached = self.value() * self.survival();
        Verification::of([cached, exact], self.weight(weighting), &record, technique, weighting)
    }
}

impl<'s, S: Scene + ?Sized + 's> MergedPath<'_, 's, S> {
    /// Evaluates the path anew from its points: f, G, densities, nothing cached.
    #[must_use]
    pub fn record(&self) -> PathRecord {
        let (k, m) = (self.edges(), self.meeting());
        let points: Vec<SurfacePoint> = (0..=k).map(|i| self.vertex(i).point).collect();
        let dirac: Vec<bool> = (0..=k).map(|i| i > 0 && i < k && self.is_dirac(i)).collect();
        let photon = (m, self.photon().point);
        PathRecord::evaluate_merge(self.stage, &points, photon, &dirac, self.light())
    }

    /// Re-evaluates the path from the definitions and compares.
    #[must_use]
    pub fn verify(&self, weighting: &Weighting) -> Verification {
        let (record, technique) = (self.record(), self.technique());
        let walks = weighting.set().merges;
        let exact = record.merge_estimate(self.meeting(), weighting.merge_area(), walks);
        let cached = self.value(weighting) * self.survival();
        Verification::of([cached, exact], self.weight(weighting), &record, technique, weighting)
    }
}

impl Verification {
    fn of(
        [cached, exact]: [Rgb; 2],
        weight: f64,
        record: &PathRecord,
        technique: Technique,
        weighting: &Weighting,
    ) -> Self {
        let scale = exact.map(f64::abs).max_component().max(f64::MIN_POSITIVE);
        let is_merging = weighting.merge_area() > 0.0;
        let sum: f64 = record
            .admissible()
            .filter(|technique| {
                (is_merging || !technique.merged)
                    && weighting.set().contains(*technique)
                    && record.obstacle(*technique).is_none()
            })
            .map(|technique| record.weight(technique, weighting))
            .sum();
        Self {
            value_error: if cached.is_finite() && exact.is_finite() {
                (cached - exact).map(f64::abs).max_component() / scale
            } else {
                f64::INFINITY
            },
            weight_error: (weight - record.weight(technique, weighting)).abs(),
            weight_sum_error: (sum - 1.0).abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_is_not_a_small_error() {
        let verification =
            Verification { value_error: 0.5, weight_error: 0.25, weight_sum_error: 0.0 };
        assert_eq!(verification.worst(), 0.5);
        assert_eq!(Verification { weight_error: f64::NAN, ..verification }.worst(), f64::INFINITY);
    }
}
