//! Errors of studies.

use crate::film::OutputError;
use crate::render::{RenderError, Shard};
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A reason for which a study could not be made or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A rendering failed; of which integrator.
    #[error("{name}: {source}")]
    Render {
        /// The integrator's name.
        name: String,
        /// The cause.
        source: RenderError,
    },
    /// The plan has fewer than two seeds, which say nothing about the error.
    #[error("{0} seeds are too few: the spread of at least two says how large the error is")]
    TooFewSeeds(u32),
    /// The target error is not a positive number.
    #[error("target error {0} is not a positive number")]
    Target(f64),
    /// Two contestants have this name.
    #[error("two integrators are called {0:?}")]
    DuplicateName(String),
    /// The reference's size is not that of the camera's film: (reference, film).
    #[error("reference has {} × {} pixels, the film {} × {}", .0[0], .0[1], .1[0], .1[1])]
    ReferenceSize([u32; 2], [u32; 2]),
    /// The reference has this many pixels that are not finite.
    #[error("reference has {0} pixels that are not finite")]
    ReferenceNotFinite(usize),
    /// The reference has no pixels.
    #[error("reference has no pixels")]
    ReferenceEmpty,
    /// The integrator with this name, which should render a part of the reference, cannot draw every
    /// path.
    #[error("{0} cannot draw every path, so it renders no reference")]
    ReferenceIncomplete(String),
    /// The integrator with this name, which should render a part of the reference, is not unbiased.
    #[error("{0} is not unbiased, so it renders no reference")]
    ReferenceBiased(String),
    /// The rendering of the reference was stopped before it had two runs of both halves.
    #[error("reference was stopped before its error could be told")]
    ReferenceStopped,
    /// A file of a run is missing, there twice, damaged, or of another study.
    #[error("run {}: {reason}", path.display())]
    Run {
        /// The file.
        path: PathBuf,
        /// The reason, in words.
        reason: String,
    },
    /// A study whose runs depend on clocks or on errors has no parts.
    #[error("shard {0} of a study needs a budget in samples, and no target error")]
    ShardOfTime(Shard),
    /// There are fewer runs than shards.
    #[error("shard {shard} has no runs: there are {runs} in all")]
    EmptyShard {
        /// The shard.
        shard: Shard,
        /// The runs of all integrators.
        runs: u32,
    },
    /// An image could not be read or written.
    #[error("{0}")]
    Image(#[from] OutputError),
    /// A file could not be written or read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// The conversion of an error in reading or writing a file, for `map_err`.
pub(super) fn file_error(path: &Path) -> impl FnOnce(io::Error) -> ReportError {
    move |source| ReportError::File { path: path.to_owned(), source }
}
