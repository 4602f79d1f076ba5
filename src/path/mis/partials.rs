//! MIS partial sums: weights in constant time. Each vertex of a subpath keeps the part of the sum
//! over techniques that belongs to those which end the subpath before it.
//!
//! Number the vertices of a subpath v_1 … v_n from its start and let
//!
//! ```text
//! d_1 = p(v_1),  d_j = p⊥(v_{j-1} → v_j) G_j   with which the walk reached v_j,
//! c_j = p⊥(v_j → v_{j-1})                      with which the other walk would go on from v_j,
//! ```
//!
//! G_j the geometry term of the edge from v_{j-1} to v_j. Seen from a technique that ends this
//! subpath at v_m and samples v_m from there with density x by the other walk, the techniques that
//! end it at v_{m-1}, v_{m-2}, … have relative densities
//!
//! ```text
//! x / d_m,
//! x / d_m · c_m G_m / d_{m-1},
//! x / d_m · c_m G_m / d_{m-1} · c_{m-1} G_{m-1} / d_{m-2},    …
//! ```
//!
//! Of these only x and c_m depend on the connection. With r the power of the heuristic and n_j the
//! share of the technique that ends at v_j (r of its number of samples, 0 if it is not in the set
//! or cannot draw the path) their sum is, by Horner's rule,
//!
//! ```text
//! r(x / d_m) (n_{m-1} + r(c_m G_m / d_{m-1}) R_{m-1}),
//! R_j = n_{j-1} + r(c_j G_j / d_{j-1}) R_{j-1},
//! ```
//!
//! where R_1 is n_0 for a light subpath, whose start a camera walk can hit, and 0 for a camera
//! subpath. The start may be drawn differently for a connection to it: n_1 has the ratio of the two
//! densities.
//!
//! A merge at v_j has η d_j times the density of the connection that ends this subpath at v_{j-1},
//! so with N light walks to merge with it adds r(N η d_j) to R_j before the next step, if the path
//! takes a finite lobe at v_j. At its own end v_m a connection adds r(N η x). A merge has two sides,
//! both with x = 1/η.
//!
//! Sources: weights by recursion are of van Antwerpen 2011 and Georgiev 2012; this one, of ratios
//! as in [`PathDensities`](super::PathDensities), is derived here.

use super::Heuristic;
use crate::endpoint::{Camera, Endpoint, Light};
use crate::lanes::{Lane, Mask};
use crate::path::{Family, Path, Stage, TechniqueSet, Vertex};
use crate::photon_map::has_area;
use crate::scene::Scene;
use std::f64::consts::PI;

/// The multiple importance sampling weights of a set of techniques, from the MIS partial sums that
/// the vertices of complete subpaths keep.
#[derive(Clone, Copy, Debug)]
pub struct Weighting {
    set: TechniqueSet,
    heuristic: Heuristic,
    /// Shares of the families, 0 of those that are not in the set.
    bsdf_sampling: f64,
    next_event: f64,
    connections: f64,
    lens_sampling: f64,
    merges: f64,
    /// η = πr².
    merge_area: f64,
    is_correlation_aware: bool,
}

/// A side of a merge: one of its two subpaths before it meets the other, as weights know it. The sum
/// over the techniques that end the subpath earlier is `nearest + r(p⊥) farther`, with the density
/// p⊥ of the other walk to go on along this one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MergeSide {
    /// Of the connection that ends the subpath one vertex earlier.
    pub nearest: f64,
    /// Of all others, without the factor.
    pub farther: f64,
}

/// A side of a connection, in lanes: the numbers of a subpath that ends there from which the sum
/// over the techniques follows that end it earlier.
#[derive(Clone, Copy, Debug)]
pub(in crate::path) struct Side<L> {
    /// d of the last vertex.
    density: L,
    /// n of the technique that ends the subpath one vertex earlier.
    share: L,
    /// Geometry term of the last edge.
    geometry: L,
    /// d of the vertex before.
    density_before: L,
    /// The partial sum of the vertex before.
    partial: L,
    /// The share of merges at the last vertex.
    merges: L,
}

impl<L: Lane> Side<L> {
    #[inline(always)]
    pub fn new([density, share, geometry, density_before, partial, merges]: [L; 6]) -> Self {
        Self { density, share, geometry, density_before, partial, merges }
    }

    /// The side of a subpath that is its start alone, by its density and the share of hits.
    #[inline(always)]
    pub fn of_start(density: L, hitting: L) -> Self {
        let (none, one) = (density.constant(0.0), density.constant(1.0));
        Self::new([density, hitting, none, one, none, none])
    }

    #[inline(always)]
    pub fn numbers(self) -> [L; 6] {
        let Self { density, share, geometry, density_before, partial, merges } = self;
        [density, share, geometry, density_before, partial, merges]
    }

    /// The sum, if the other walk would sample the last vertex with density x, one of the technique
    /// that ends the subpath one vertex earlier, and one of all others; and go on with density
    /// `onwards`.
    #[inline(always)]
    fn sum(&self, raise: impl Fn(L) -> L, x: [L; 2], onwards: L) -> L {
        let (nearest, farther) = (x[0] / self.density, x[1] / self.density);
        let farther = farther * onwards * self.geometry / self.density_before;
        product(raise(nearest), self.share) + product(raise(farther), self.partial)
    }
}

impl Weighting {
    /// The weights of a set by a heuristic; without a radius, so that nothing is merged.
    #[inline]
    #[must_use]
    pub fn new(set: TechniqueSet, heuristic: Heuristic) -> Self {
        let light_subpaths = heuristic.raise(set.light_subpaths.count());
        let share = |has: bool, share| if has { share } else { 0.0 };
        Self {
            set,
            heuristic,
            bsdf_sampling: share(set.bsdf_sampling, 1.0),
            next_event: share(set.next_event, 1.0),
            connections: share(set.connections, light_subpaths),
            lens_sampling: share(set.lens_sampling, light_subpaths),
            merges: 0.0,
            merge_area: 0.0,
            is_correlation_aware: false,
        }
    }

    /// The same with subpaths merged whose ends are nearer than a radius. One so small that its
    /// square leaves the range of f64 merges nothing.
    #[must_use]
    pub fn with_merge_radius(self, radius: f64) -> Self {
        let area = PI * radius * radius;
        if self.set.merges == 0 || !has_area(radius) {
            return Self { merges: 0.0, merge_area: 0.0, ..self };
        }
        let merges = self.heuristic.raise(self.set.merges.into());
        Self { merges, merge_area: area, ..self }
    }

    /// The same with a merge's light walks counted by how [independent](super::PathDensities::correlation)
    /// they are, in time proportional to the length of a path.
    #[must_use]
    pub fn correlation_aware(self) -> Self {
        Self { is_correlation_aware: true, ..self }
    }

    /// The set of techniques.
    #[inline]
    #[must_use]
    pub fn set(&self) -> &TechniqueSet {
        &self.set
    }

    /// The heuristic.
    #[inline]
    #[must_use]
    pub fn heuristic(&self) -> Heuristic {
        self.heuristic
    }

    /// η, the area of the disc within which subpaths are merged; 0 if none are.
    #[inline]
    #[must_use]
    pub fn merge_area(&self) -> f64 {
        self.merge_area
    }

    /// True if the light walks of a merge are counted by how independent they are.
    #[inline]
    #[must_use]
    pub fn is_correlation_aware(&self) -> bool {
        self.is_correlation_aware
    }

    /// True if weights do not follow from partial sums, so that [`weight`](Self::weight) sweeps.
    #[inline]
    #[must_use]
    pub fn needs_sweep(&self) -> bool {
        !self.set.excluded.is_empty() || (self.is_correlation_aware && self.merges > 0.0)
    }

    /// Enters what is known of the vertices of a camera subpath once it is complete: the density of
    /// the lens as the end of a connection, and the partial sums.
    pub fn complete_camera_subpath<B>(&self, subpath: &mut [Vertex<B>], camera: &dyn Camera) {
        if let [lens, first, ..] = subpath {
            lens.start.connection = camera.pdf_from(&first.point, &lens.point);
        }
        self.complete(subpath, 0.0, self.lens_sampling);
    }

    /// The same of a light subpath.
    pub fn complete_light_subpath<S: Scene + ?Sized>(
        &self,
        subpath: &mut [Vertex<S::Bsdf<'_>>],
        stage: &Stage<'_, S>,
    ) {
        if let [start, first, ..] = subpath
            && let Some(id) = start.light
        {
            let light = stage.scene.light(id);
            start.start.connection =
                light.pdf_from(&first.point, &start.point) * stage.pick_pmf_for(&first.point, id);
            self.complete(subpath, self.hitting(light), self.sampling(light));
        }
    }

    /// Enters the partial sums, given n_0 and the share of connections to the start.
    fn complete<B>(&self, walk: &mut [Vertex<B>], hitting: f64, to_start: f64) {
        for m in 0..walk.len() {
            walk[m].partial = match &walk[..=m] {
                [_] => hitting,
                up_to => {
                    let vertex = &up_to[m];
                    let nearest = if vertex.dirac {
                        0.0
                    } else {
                        self.share(up_to, [to_start, self.connections])
                    };
                    let merge = if vertex.dirac { 0.0 } else { self.merge(density(up_to)) };
                    nearest + self.farther(up_to, 1.0, vertex.pdf_back.value()) + merge
                }
            };
        }
    }

    /// The weight of the technique that drew a path of complete subpaths, within the set.
    #[must_use]
    pub fn weight<S: Scene + ?Sized>(&self, path: &Path<'_, '_, S>) -> f64 {
        if self.needs_sweep() {
            return path.weight(self);
        }
        let (camera, light) = (path.camera_part, path.light_part);
        let (emitter, joint) = (path.stage.scene.light(path.light), path.joint_densities());
        let others = match (path.joint, light) {
            (None, _) | (_, []) => {
                let start = path.light_start();
                let (walk, connection) = (start.walk.value(), start.connection.value());
                let x = if camera.len() == 2 { walk } else { connection };
                let to_lens = if path.ends_are_joinable() { self.lens_sampling } else { 0.0 };
                self.side(
                    camera,
                    [x, walk],
                    joint.towards_camera,
                    [to_lens, self.sampling(emitter)],
                )
            }
            (Some(edge), [start, ..]) => {
                let is_to_lens = camera.len() == 1;
                let x = joint.towards_light
                    * edge.geometry
                    * if is_to_lens { 1.0 / camera[0].start.bias() } else { 1.0 };
                let by_camera = if light.len() > 1 {
                    self.side(
                        light,
                        [x; 2],
                        joint.behind,
                        [self.sampling(emitter), self.connections],
                    ) + self.merge(x)
                } else {
                    let density =
                        if is_to_lens { start.start.walk } else { start.start.connection };
                    product(self.heuristic.raise(x / density.value()), self.hitting(emitter))
                };
                let x = joint.towards_camera
                    * edge.geometry
                    * if light.len() == 1 { 1.0 / start.start.bias() } else { 1.0 };
                let by_light = if is_to_lens {
                    0.0
                } else {
                    self.side(camera, [x; 2], joint.before, [self.lens_sampling, self.connections])
                        + self.merge(x)
                };
                (by_camera + by_light) / self.heuristic.raise(self.set.count(path.technique()))
            }
        };
        1.0 / (1.0 + others)
    }

    /// True if the weights of connections between surfaces can be computed in lanes.
    pub(in crate::path) fn has_lanes(&self) -> bool {
        self.heuristic.is_in_lanes() && !self.needs_sweep()
    }

    /// The weight of a technique of a family, in lanes, if `has_lanes`, by the sums over those that
    /// end the two subpaths earlier.
    #[inline(always)]
    pub(in crate::path) fn weight_of<L: Lane>(&self, family: Family, sums: [L; 2]) -> L {
        let count = self.heuristic.raise(self.set.family_count(family));
        sums[0].constant(1.0) / ((sums[0] + sums[1]) / count + 1.0)
    }

    /// The sum over the techniques that end the subpath of a side earlier, in lanes, with the
    /// densities with which the other walk would sample its last vertex and go on.
    #[inline(always)]
    pub(in crate::path) fn sum_of<L: Lane>(&self, side: &Side<L>, x: L, onwards: L) -> L {
        let raise = |ratio: L| self.heuristic.raise_in_lanes(ratio);
        side.sum(raise, [x; 2], onwards) + product(raise(x * self.merge_area), side.merges)
    }

    /// The camera's side of a connection at the last vertex of a complete camera subpath.
    #[inline]
    pub(in crate::path) fn camera_side_of<B>(&self, subpath: &[Vertex<B>]) -> Side<f64> {
        self.side_of(subpath, [self.lens_sampling, self.connections])
    }

    /// The light's side of a connection at the last vertex of a complete light subpath.
    #[inline]
    pub(in crate::path) fn light_side_of<B>(
        &self,
        subpath: &[Vertex<B>],
        light: &(impl Light + ?Sized),
    ) -> Side<f64> {
        if subpath.len() == 1 {
            return Side::of_start(density(subpath), self.hitting(light));
        }
        self.side_of(subpath, [self.sampling(light), self.connections])
    }

    fn side_of<B>(&self, walk: &[Vertex<B>], shares: [f64; 2]) -> Side<f64> {
        let (geometry, density_before, partial) = match walk {
            [before @ .., previous, last] => {
                let up_to = &walk[..=before.len()];
                (last.geometry, density(up_to), previous.partial)
            }
            _ => (0.0, 1.0, 0.0),
        };
        let (share, merges) = (self.share(walk, shares), self.merges);
        Side { density: density(walk), share, geometry, density_before, partial, merges }
    }

    /// The camera's side of merges at the last vertex of a complete camera subpath.
    #[must_use]
    pub fn camera_side<B>(&self, subpath: &[Vertex<B>]) -> MergeSide {
        self.merge_side(subpath, [self.lens_sampling, self.connections])
    }

    /// The light's side of merges at the last vertex of a complete light subpath.
    #[must_use]
    pub fn light_side<S: Scene + ?Sized>(
        &self,
        subpath: &[Vertex<S::Bsdf<'_>>],
        scene: &S,
    ) -> MergeSide {
        let light = subpath.first().and_then(|start| start.light);
        let sampling = light.map_or(0.0, |id| self.sampling(scene.light(id)));
        self.merge_side(subpath, [sampling, self.connections])
    }

    fn merge_side<B>(&self, subpath: &[Vertex<B>], shares: [f64; 2]) -> MergeSide {
        let ratio = 1.0 / self.merge_area / density(subpath);
        MergeSide {
            nearest: product(self.heuristic.raise(ratio), self.share(subpath, shares)),
            farther: self.farther(subpath, ratio, 1.0),
        }
    }

    /// The weight of a merge, of its two sides, each with the density with which the other walk
    /// would go on along it from where they meet.
    #[inline]
    #[must_use]
    pub fn merge_weight(&self, sides: [(&MergeSide, f64); 2]) -> f64 {
        let others: f64 = sides
            .map(|(side, onwards)| {
                side.nearest + product(self.heuristic.raise(onwards), side.farther)
            })
            .into_iter()
            .sum();
        1.0 / (1.0 + others / self.merges)
    }

    /// The share of a merge at a vertex that the other walk samples with density x.
    #[inline]
    fn merge(&self, x: f64) -> f64 {
        product(self.merges, self.heuristic.raise(self.merge_area * x))
    }

    /// The part of the sum of the techniques that end a subpath before its last vertex, which the
    /// other walk would sample from there with density x: one x of the technique that ends it one
    /// vertex earlier, and one of all others.
    fn side<B>(&self, walk: &[Vertex<B>], x: [f64; 2], onwards: f64, shares: [f64; 2]) -> f64 {
        let raise = |ratio| self.heuristic.raise(ratio);
        self.side_of(walk, shares).sum(raise, x, onwards)
    }

    /// n of the technique that ends a subpath one vertex earlier, by the shares of connections to
    /// the start and to others.
    fn share<B>(&self, walk: &[Vertex<B>], [to_start, to_others]: [f64; 2]) -> f64 {
        match walk {
            [start, _] => product(to_start, self.heuristic.raise(start.start.bias())),
            [.., before, _] if !before.dirac => to_others,
            _ => 0.0,
        }
    }

    /// The sum over the techniques that end a subpath two or more vertices earlier, if the one that
    /// ends it one earlier has density `ratio`.
    fn farther<B>(&self, walk: &[Vertex<B>], ratio: f64, onwards: f64) -> f64 {
        let [before @ .., last] = walk else { return 0.0 };
        let Some(previous) = before.last() else { return 0.0 };
        product(
            self.heuristic.raise(ratio * onwards * last.geometry / density(before)),
            previous.partial,
        )
    }

    /// The share of hits of a light.
    pub(in crate::path) fn hitting(&self, light: &(impl Light + ?Sized)) -> f64 {
        if light.can_be_hit() { self.bsdf_sampling } else { 0.0 }
    }

    fn sampling(&self, light: &(impl Light + ?Sized)) -> f64 {
        if light.can_be_connected() { self.next_event } else { 0.0 }
    }
}

/// d: the density with which a walk reached the last vertex of a subpath.
fn density<B>(walk: &[Vertex<B>]) -> f64 {
    match walk {
        [.., before, last] => before.pdf_next.value() * last.geometry,
        [start] => start.start.walk.value(),
        [] => 1.0,
    }
}

/// A product that nothing infinite makes of nothing.
#[inline(always)]
fn product<L: Lane>(a: L, b: L) -> L {
    let zero = a.constant(0.0);
    (a.equals(zero) | b.equals(zero)).choose(zero, a * b)
}
