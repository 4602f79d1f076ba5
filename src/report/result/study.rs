//! A study with its images.

use super::pyramid::Pyramid;
use super::report::Report;
use crate::film::Image;
use crate::report::stats::{Errors, Reference};

/// Parts of a run's budget after which the first run's image is kept.
pub(in crate::report) const SNAPSHOTS: [f64; 3] = [1.0 / 16.0, 0.25, 1.0];

/// A finished, or stopped, study.
#[derive(Clone, Debug)]
pub struct Study {
    /// The numbers.
    pub report: Report,
    /// Images of each integrator, in the order of `report.methods`.
    pub images: Vec<MethodImages>,
    /// The reference.
    pub reference: Reference,
    /// Images of the techniques of bidirectional path tracing.
    pub pyramid: Option<Pyramid>,
}

/// Images of one integrator.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodImages {
    /// Mean of all runs.
    pub mean: Image,
    /// The first run after about 1/16, 1/4 and all of its budget, as far as a sample per pixel
    /// takes less.
    pub snapshots: Vec<Snapshot>,
    /// Images of its techniques, if they were measured.
    pub pyramid: Option<Pyramid>,
}

/// An image of the first run.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Part of the budget of a run.
    pub part: f64,
    /// Samples per pixel.
    pub samples: u32,
    /// Wall-clock seconds.
    pub wall: f64,
    /// The image.
    pub image: Image,
    /// Its errors.
    pub errors: Errors,
}
