//! The findings of single runs, beside their images.

use crate::integrator::{Guidance, Normalization, Notes};
use serde::{Deserialize, Serialize};

/// The constant that the Markov chains of a run were scaled with: [`Normalization`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NormalizationReport {
    /// Its estimate: the mean of the image over pixels and channels.
    pub mean: f64,
    /// The standard error of `mean`, relative; infinite if nothing contributed.
    #[serde(with = "crate::report::stats::number")]
    pub relative_standard_error: f64,
    /// Candidates that it was estimated from.
    pub candidates: u64,
    /// Sets of candidates of which none contributed, so that their passes are black.
    pub black: u32,
}

/// The findings of a run on guiding: [`Guidance`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GuidanceReport {
    /// True if walks were guided.
    pub is_used: bool,
    /// Variance × cost of path tracing without guiding over that with it, as far as it is known; 0
    /// if it is not.
    pub expected_gain: f64,
    /// Parts of space for which directions are known.
    pub parts: usize,
    /// Samples that were learnt from.
    pub samples: u64,
}

/// The findings of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FindingsReport {
    /// Of Markov chains.
    pub normalization: Option<NormalizationReport>,
    /// Of guiding.
    pub guidance: Option<GuidanceReport>,
}

impl FindingsReport {
    /// The findings in a run's notes; `None` if there are none.
    pub(in crate::report) fn of(notes: &Notes) -> Option<Self> {
        let findings = Self {
            normalization: notes.normalization.as_ref().map(NormalizationReport::from),
            guidance: notes.guidance.as_ref().map(GuidanceReport::from),
        };
        (findings != Self::default()).then_some(findings)
    }
}

impl From<&Normalization> for NormalizationReport {
    fn from(found: &Normalization) -> Self {
        let Normalization { candidates, black, .. } = *found;
        let mean = found.mean();
        let error = if mean > 0.0 { found.relative_error() } else { f64::INFINITY };
        Self { mean, relative_standard_error: error, candidates, black }
    }
}

impl From<&Guidance> for GuidanceReport {
    fn from(found: &Guidance) -> Self {
        let Guidance { is_used, gain: expected_gain, parts, samples } = *found;
        Self { is_used, expected_gain, parts, samples }
    }
}
