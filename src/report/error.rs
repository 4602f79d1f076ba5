//! Why there is no report.

use crate::film::OutputError;
use crate::render::RenderError;
use std::error::Error;
use std::fmt;
use std::path::PathBuf;

/// Why a study could not be made or written.
#[derive(Debug)]
#[non_exhaustive]
pub enum ReportError {
    /// A rendering failed; of which integrator.
    Render {
        /// The integrator's name.
        name: String,
        /// What went wrong.
        source: RenderError,
    },
    /// The plan has fewer than two seeds, which say nothing about the error.
    TooFewSeeds(u32),
    /// The target error is not a positive number.
    Target(f64),
    /// Two contestants have this name.
    DuplicateName(String),
    /// The reference's size is not that of the camera's film: (reference, film).
    ReferenceSize([u32; 2], [u32; 2]),
    /// The reference has this many pixels that are not finite.
    ReferenceNotFinite(usize),
    /// The reference has no pixels.
    ReferenceEmpty,
    /// The rendering of the reference was stopped before it had two runs of both halves.
    ReferenceStopped,
    /// An image could not be read or written.
    Image(OutputError),
    /// A file could not be written or read.
    File {
        /// Which file.
        path: PathBuf,
        /// What went wrong.
        source: Box<dyn Error + Send + Sync>,
    },
}

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Render { name, source } => write!(f, "{name}: {source}"),
            Self::TooFewSeeds(seeds) => write!(
                f,
                "{seeds} seeds are too few: the spread of at least two says how large the error is"
            ),
            Self::Target(target) => write!(f, "target error {target} is not a positive number"),
            Self::DuplicateName(name) => write!(f, "two integrators are called {name:?}"),
            Self::ReferenceSize([a, b], [c, d]) => {
                write!(f, "reference has {a} × {b} pixels, the film {c} × {d}")
            }
            Self::ReferenceNotFinite(pixels) => {
                write!(f, "reference has {pixels} pixels that are not finite")
            }
            Self::ReferenceEmpty => f.write_str("reference has no pixels"),
            Self::ReferenceStopped => {
                f.write_str("reference was stopped before its error could be told")
            }
            Self::Image(error) => error.fmt(f),
            Self::File { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl Error for ReportError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            Self::Render { source, .. } => Some(source),
            Self::Image(source) => Some(source),
            Self::File { source, .. } => Some(source.as_ref()),
            _ => None,
        }
    }
}

impl From<OutputError> for ReportError {
    fn from(error: OutputError) -> Self {
        Self::Image(error)
    }
}

/// For `map_err` on what is done with a file.
pub(super) fn file_error<E: Into<Box<dyn Error + Send + Sync>>>(
    path: &std::path::Path,
) -> impl FnOnce(E) -> ReportError {
    move |source| ReportError::File { path: path.to_owned(), source: source.into() }
}
