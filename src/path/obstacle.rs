//! The reasons for which a technique does not draw a path.

use super::{Family, LeftOut, PathDensities, PathRecord, Reason, TechniqueSet};
use crate::film::Technique;
use std::fmt;

/// The reason for which a technique does not draw a path. Vertices are numbered from the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Obstacle {
    /// It is among those that the set [excludes](TechniqueSet::excluded).
    Excluded,
    /// Its family is not in the set.
    NotInSet,
    /// The scene has no need of its family.
    LeftOut(Reason),
    /// It draws paths of another length.
    OtherLength,
    /// No ray hits the light.
    Unhittable,
    /// The light cannot be connected to.
    Unconnectible,
    /// Lens and light cannot be connected to each other.
    Unjoinable,
    /// The path takes a Dirac lobe at a vertex that it would connect or merge.
    Dirac(usize),
    /// The density of an end is 0.
    End,
    /// The density of the edge from the first vertex to the second is 0.
    Edge(usize, usize),
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Excluded => f.write_str("it is switched off"),
            Self::NotInSet => f.write_str("the integrator does not have it"),
            Self::LeftOut(reason) => reason.fmt(f),
            Self::OtherLength => f.write_str("its paths have another length"),
            Self::Unhittable => f.write_str("no ray hits the light by chance"),
            Self::Unconnectible => f.write_str("the light shines along one ray"),
            Self::Unjoinable => f.write_str("the film would see a Dirac distribution"),
            Self::Dirac(i) => {
                write!(f, "x_{i} takes a Dirac lobe, which meets nothing but what it samples")
            }
            Self::End => f.write_str("the density of an end is 0"),
            Self::Edge(from, to) => write!(f, "no walk goes from x_{from} to x_{to}"),
        }
    }
}

impl TechniqueSet {
    /// The reason for which a technique is not in the set, of which a scene had no need of some;
    /// `None` if it is.
    #[must_use]
    pub fn obstacle(&self, technique: Technique, left_out: &LeftOut) -> Option<Obstacle> {
        if self.contains(technique) {
            return None;
        }
        let family = Family::of(technique);
        Some(if self.has(family) {
            Obstacle::Excluded
        } else {
            let reason = left_out.families().find(|(left_out, _)| *left_out == family);
            reason.map_or(Obstacle::NotInSet, |(_, reason)| Obstacle::LeftOut(reason))
        })
    }
}

impl PathRecord {
    /// The reason for which a technique of any set has density 0 here, found without forming the
    /// density; `None` if it can draw the path.
    #[must_use]
    pub fn obstacle(&self, technique: Technique) -> Option<Obstacle> {
        let (k, t) = (self.edges(), usize::from(technique.t));
        if !technique.exists() || usize::from(technique.bounces()) + 1 != k {
            return Some(Obstacle::OtherLength);
        }
        if !self.is_admissible(technique) {
            return Some(match t {
                _ if technique.merged => Obstacle::Dirac(t - 1),
                _ if t == k + 1 => Obstacle::Unhittable,
                _ if k == 1 => Obstacle::Unjoinable,
                _ if t > 1 && self.dirac[t - 1] => Obstacle::Dirac(t - 1),
                _ if t < k => Obstacle::Dirac(t),
                _ => Obstacle::Unconnectible,
            });
        }
        let is_lost = |density: f64| density.is_nan() || density <= 0.0;
        let onwards = t + usize::from(!technique.merged);
        let by_camera = |i: usize| is_lost(self.towards_light[i] * self.geometry_terms[i]);
        let by_light = |i: usize| is_lost(self.towards_camera[i] * self.geometry_terms[i - 1]);
        if is_lost(self.end_density(technique)) {
            Some(Obstacle::End)
        } else if let Some(i) = (0..t - 1).find(|i| by_camera(*i)) {
            Some(Obstacle::Edge(i, i + 1))
        } else {
            (onwards..=k).find(|i| by_light(*i)).map(|i| Obstacle::Edge(i, i - 1))
        }
    }
}
