//! Families of techniques, and the reasons why a scene has no need of some.

use crate::film::Technique;
use std::fmt;

/// A family of techniques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// s = 0.
    BsdfSampling,
    /// s = 1, t ≥ 2.
    NextEventEstimation,
    /// s ≥ 2, t ≥ 2.
    Connections,
    /// t = 1, s ≥ 1.
    LensSampling,
    /// Vertices uniform by area.
    UniformArea,
    /// Merges of subpaths, s ≥ 2, t ≥ 2.
    Merges,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::UniformArea,
        Self::BsdfSampling,
        Self::NextEventEstimation,
        Self::Connections,
        Self::LensSampling,
        Self::Merges,
    ];

    /// The family of a technique (s, t) with t ≥ 1.
    #[inline]
    #[must_use]
    pub const fn of(technique: Technique) -> Self {
        if technique.merged {
            return Self::Merges;
        }
        match (technique.s, technique.t) {
            (0, _) => Self::BsdfSampling,
            (_, 1) => Self::LensSampling,
            (1, _) => Self::NextEventEstimation,
            _ => Self::Connections,
        }
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BsdfSampling => "s = 0 (BSDF sampling)",
            Self::NextEventEstimation => "s = 1 (next event estimation)",
            Self::Connections => "s ≥ 2, t ≥ 2 (connections)",
            Self::LensSampling => "t = 1 (lens sampling)",
            Self::UniformArea => "vertices uniform by area",
            Self::Merges => "merges",
        })
    }
}

/// The reason for which a family of techniques is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Reason {
    /// It would contribute nothing: there is no light.
    NoLight,
    /// It would contribute nothing: no ray can hit a light.
    NoHittableLight,
    /// It would contribute nothing: no light can be connected to.
    NoConnectibleLight,
    /// It would contribute nothing: every surface is black or has Dirac lobes alone, which no
    /// connection meets.
    NoFiniteLobe,
    /// It would contribute nothing: no light reaches a surface.
    NoIllumination,
    /// It would draw (1, 1) alone, whose paths s = 0 draws, too.
    Redundant,
    /// It would draw what connections draw as well: no lobe is narrow.
    Connectible,
    /// It would contribute nothing: no light walk can be connected to the lens.
    UnconnectibleLens,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoLight => "there is no light",
            Self::NoHittableLight => "no ray can hit a light",
            Self::NoConnectibleLight => "no light can be connected to",
            Self::NoFiniteLobe => "no surface has a lobe to connect to",
            Self::NoIllumination => "no light reaches a surface",
            Self::Redundant => {
                "only light that is seen directly would be left to it, and s = 0 draws that"
            }
            Self::Connectible => "every path can be connected",
            Self::UnconnectibleLens => "the camera sees along one ray, which no light walk meets",
        })
    }
}

/// The techniques that an integrator leaves out on a scene, and the reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct LeftOut {
    pub(super) reasons: [Option<Reason>; Family::ALL.len()],
    pub(super) most_bounces: Option<u32>,
}

impl LeftOut {
    /// The same without lens sampling, because the camera cannot be connected to.
    pub(super) fn without_lens(mut self) -> Self {
        for (family, reason) in Family::ALL.into_iter().zip(&mut self.reasons) {
            if family == Family::LensSampling {
                *reason = Some(Reason::UnconnectibleLens);
            }
        }
        self
    }

    /// The families, each with its reason.
    pub fn families(&self) -> impl Iterator<Item = (Family, Reason)> {
        Family::ALL
            .into_iter()
            .zip(self.reasons)
            .filter_map(|(family, reason)| Some((family, reason?)))
    }

    /// The number of scattering events after which no path carries light, if the scene has such a
    /// bound.
    #[must_use]
    pub fn most_bounces(&self) -> Option<u32> {
        self.most_bounces
    }

    /// Each omission and its reason, in words.
    pub fn items(&self) -> impl Iterator<Item = (String, String)> {
        let bound = self.most_bounces.map(|n| match n {
            0 => ("scattering".to_owned(), "no light reaches a surface".to_owned()),
            1 => (
                "more than one scattering event".to_owned(),
                "no light gets from one surface to another".to_owned(),
            ),
            n => (
                format!("more than {n} scattering events"),
                "no light scatters more often".to_owned(),
            ),
        });
        self.families()
            .map(|(family, reason)| (family.to_string(), reason.to_string()))
            .chain(bound)
    }

    /// True if nothing is left out.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let items: Vec<String> = self.items().map(|(what, why)| format!("{what}: {why}")).collect();
        f.write_str(if items.is_empty() { "nothing" } else { "" })?;
        f.write_str(&items.join("; "))
    }
}
