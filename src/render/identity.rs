//! The identity of a rendering, by name: by it, a checkpoint knows its rendering again.

use super::Settings;
use crate::endpoint::{Camera, answers};
use crate::integrator::AnyIntegrator;
use crate::math::Fingerprint;
use crate::sampler::SamplerKind;
use crate::scene::Scene;
use std::collections::BTreeMap;

/// Everything that decides what a pass adds to a film, as text, by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Identity(pub BTreeMap<String, String>);

impl Identity {
    pub fn new<S: Scene + ?Sized, P>(
        scene: &S,
        camera: &dyn Camera,
        integrator: &dyn AnyIntegrator<S, P>,
        settings: &Settings,
        sampler: Option<SamplerKind>,
    ) -> Self {
        let scene = scene.fingerprint().map_or_else(|| "unknown".to_owned(), hexadecimal);
        let view = hexadecimal(Fingerprint::of(answers(camera)));
        let target = settings.target_error.map_or_else(|| "none".to_owned(), |e| e.to_string());
        let samples = settings.budget.samples();
        let own = || "the caller's own".to_owned();
        let entries = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("scene", scene),
            ("camera", view),
            ("film", format!("{:?}", camera.film())),
            ("integrator", integrator.name().to_owned()),
            ("settings of the integrator", format!("{integrator:?}")),
            ("sampler", sampler.map_or_else(own, |sampler| format!("{sampler:?}"))),
            ("seed", settings.seed.to_string()),
            ("filter", format!("{:?}", settings.filter)),
            ("samples per pixel", samples.map_or_else(own_time, |samples| samples.to_string())),
            ("target error", target),
            ("observation of lights", settings.observes_lights.to_string()),
        ];
        Self(entries.map(|(name, value)| (name.to_owned(), value)).into())
    }

    /// The first entry in which another one differs: its name, the other value and the own one.
    pub fn difference(&self, other: &Self) -> Option<[String; 3]> {
        let names = self.0.keys().chain(other.0.keys());
        let value = |of: &Self, name| of.0.get(name).cloned().unwrap_or_else(|| "none".to_owned());
        let mut values = names.map(|name| [name.clone(), value(other, name), value(self, name)]);
        values.find(|[_, other, own]| other != own)
    }
}

fn own_time() -> String {
    "as many as there is time for".to_owned()
}

fn hexadecimal(number: u64) -> String {
    format!("{number:016x}")
}
