//! Paths that integrators cannot draw.

use crate::path::{DrawnBy, MissingPaths};
use serde::{Deserialize, Serialize};

/// The names of [`DrawnBy`] in files.
#[derive(Serialize, Deserialize)]
#[serde(remote = "DrawnBy", rename_all = "lowercase")]
enum DrawnByName {
    Connections,
    Merges,
    Nothing,
}

/// Paths that an integrator cannot draw: [`MissingPaths`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MissingReport {
    /// Their class and their lights, in words.
    pub what: String,
    /// The integrators that draw them.
    #[serde(with = "DrawnByName")]
    pub drawn_by: DrawnBy,
}

impl MissingReport {
    /// Those of a run. Whoever claims to be complete knows that the scene has none that
    /// bidirectional path tracing draws.
    pub(in crate::report) fn all(missing: &[MissingPaths], is_complete: bool) -> Vec<Self> {
        let is_left =
            |paths: &&MissingPaths| !is_complete || paths.drawn_by != DrawnBy::Connections;
        let report =
            |paths: &MissingPaths| Self { what: paths.to_string(), drawn_by: paths.drawn_by };
        missing.iter().filter(is_left).map(report).collect()
    }
    /// The paths that an integrator cannot draw and others do, in one line.
    pub(super) fn sentence(missing: &[Self]) -> Option<String> {
        let drawn = missing.iter().filter(|paths| paths.drawn_by != DrawnBy::Nothing);
        let items: Vec<&str> = drawn.map(|paths| paths.what.as_str()).collect();
        (!items.is_empty()).then(|| items.join("; "))
    }
}
