//! A path with its numbers, as the definitions give them and as the integrator had them.

use crate::film::Technique;
use crate::math::Rgb;
use crate::path::{LeftOut, Obstacle, PathDensities, PathRecord, Verification, Weighting};
use glam::DVec2;
use std::f64::consts::PI;

/// A path that an integrator has drawn: every factor and density from the definitions
/// ([`record`](Self::record)), and what the integrator had made of it.
#[derive(Clone, Debug)]
pub struct AuditedPath {
    /// Number of the sample that drew it.
    pub sample: u32,
    /// The technique that drew it.
    pub technique: Technique,
    /// Position on the film, in pixels.
    pub raster: DVec2,
    /// Its factors and densities.
    pub record: PathRecord,
    /// Product of the probabilities with which the walks survived Russian roulette.
    pub survival: f64,
    /// The integrator's estimate `f/(n p)`, over `survival`, without the weight.
    pub value: Rgb,
    /// The integrator's weight.
    pub weight: f64,
    /// Distance of the two vertices that were merged.
    pub distance: Option<f64>,
    /// The errors of the integrator's numbers.
    pub verification: Verification,
    /// The weights of the integrator's techniques on the scene.
    pub weighting: Weighting,
    /// The techniques that the scene has no need of.
    pub left_out: LeftOut,
}

/// A technique for paths of the length of one path, and what it would have made of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditedTechnique {
    /// The technique.
    pub technique: Technique,
    /// The density p in the product measure of the vertices, if it were switched on; 0 if it cannot
    /// draw the path. That of a long path can leave the range of f64.
    pub density: f64,
    /// The estimate `f/(n p)`, if it were switched on; `None` if it cannot draw the path.
    pub estimate: Option<Rgb>,
    /// The weight; 0 if the technique does not draw the path.
    pub weight: f64,
    /// The reason for which it does not draw the path, in words by its `Display`; `None` if it does.
    pub obstacle: Option<Obstacle>,
}

impl AuditedTechnique {
    /// True if it is among those that the integrator runs on the scene, whether or not it can draw
    /// the path.
    #[must_use]
    pub fn is_in_set(&self) -> bool {
        use Obstacle::{Excluded, LeftOut, NotInSet};
        !matches!(self.obstacle, Some(Excluded | LeftOut(_) | NotInSet))
    }
}

impl AuditedPath {
    /// All techniques for paths of this length: hits and connections by s, then merges by s if there
    /// are any. Their weights sum to 1.
    pub fn techniques(&self) -> impl Iterator<Item = AuditedTechnique> {
        let (record, k) = (&self.record, self.record.edges());
        let merges = if self.weighting.merge_area() > 0.0 { 1..k } else { 0..0 };
        let connections = (1..=k + 1).rev().map(|t| record.technique(t));
        let merges = merges.rev().map(|m| record.merge(m));
        connections.chain(merges).map(|technique| self.look_at(technique))
    }

    fn look_at(&self, technique: Technique) -> AuditedTechnique {
        let Self { record, weighting, left_out, .. } = self;
        let (set, t) = (weighting.set(), usize::from(technique.t));
        let of_path = record.obstacle(technique);
        let obstacle = set.obstacle(technique, left_out).or(of_path);
        let (mut density, mut estimate) = (0.0, None);
        if of_path.is_none() {
            let (count, area) = (set.count(technique), weighting.merge_area());
            (density, estimate) = if technique.merged {
                let estimate = record.merge_estimate(t - 1, area, set.merges);
                (record.merge_density(t - 1, area), Some(estimate))
            } else {
                (record.density(t), Some(record.estimate(t) * (1.0 / count)))
            };
        }
        let is_drawn = obstacle.is_none();
        let weight = if is_drawn { record.weight(technique, weighting) } else { 0.0 };
        AuditedTechnique { technique, density, estimate, weight, obstacle }
    }

    /// The radius within which subpaths merged; 0 if none did.
    #[must_use]
    pub fn radius(&self) -> f64 {
        (self.weighting.merge_area() / PI).sqrt()
    }
}
