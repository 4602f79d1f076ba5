//! The table-driven part: an entry, its expected values, and what measures them.

use crate::measure::{Measured, Method, Probe};
use pathspace::endpoint::Camera;
use pathspace::integrator::Depth;
use pathspace::path::Roulette;
use pathspace::scene::World;
use serde_json::Value;
use std::sync::LazyLock;

/// Rays that a test may take to reach the entry's own tolerance.
pub const BUDGET: u64 = 100_000;
/// Rays that it may take to reach [`ERROR`].
pub const MOST: u64 = 3_000_000;
/// The largest relative standard error by which a bias of 1 % is still seen.
pub const ERROR: f64 = 0.0025;
/// The resolution where light walks rarely meet what is looked at, or camera walks the light: a
/// bias of 3 % is seen.
pub const RARE: f64 = 0.0075;

/// The most rays for one value where every entry's own tolerance is asked for, if it is.
fn in_full() -> Option<f64> {
    let rays = std::env::var("PATHSPACE_ANALYTIC_FULL").ok()?;
    Some(rays.parse().ok().filter(|&rays: &f64| rays > 1.0).unwrap_or(f64::INFINITY))
}

pub fn all() -> &'static [Value] {
    static TABLE: LazyLock<Value> = LazyLock::new(|| {
        serde_json::from_str(include_str!("../data/analytic.json")).expect("a JSON file")
    });
    TABLE["entries"].as_array().expect("entries")
}

/// One entry and the scene that realises it.
pub struct Entry<'a> {
    pub id: &'static str,
    data: &'static Value,
    pub probe: Probe<'a>,
    /// Required of standard errors, relative.
    pub error: f64,
    /// Most rays.
    pub rays: u64,
}

impl<'a> Entry<'a> {
    pub fn new(
        id: &'static str,
        world: &'a World,
        camera: &'a (dyn Camera + Send),
        depth: Depth,
    ) -> Self {
        let data = all().iter().find(|entry| entry["id"] == id).expect("an entry of the table");
        let tolerance = data["relative_tolerance"].as_f64().expect("a tolerance");
        Self {
            id,
            data,
            probe: Probe::new(world, camera, depth),
            error: tolerance.max(ERROR),
            rays: MOST,
        }
    }

    pub fn tolerance(&self) -> f64 {
        self.data["relative_tolerance"].as_f64().expect("a tolerance")
    }

    /// An expected value; an empty key for an entry that has only one.
    pub fn expected(&self, key: &str) -> f64 {
        expected(self.id, key)
    }

    pub fn roulette(mut self, roulette: Roulette) -> Self {
        self.probe.roulette = roulette;
        self
    }

    /// The radius of merges.
    pub fn radius(mut self, radius: f64) -> Self {
        self.probe.radius = radius;
        self
    }

    /// Other limits than [`ERROR`] and [`MOST`].
    pub fn within(mut self, error: f64, rays: u64) -> Self {
        (self.error, self.rays) = (error, rays);
        self
    }

    /// True if the entry names the integrator.
    fn names(&self, method: Method) -> bool {
        let keys = self.data["integrators"].as_array().expect("integrators");
        keys.iter().filter_map(Value::as_str).any(|key| {
            key == method.key() || key == "all" || key.split('(').next() == Some(method.key())
        })
    }

    /// All these integrators, which the entry names, measure the value of a key.
    pub fn check(&self, methods: &[Method], key: &str) {
        self.check_value(methods, key, self.expected(key));
    }

    /// A `check` of a value that follows from the entry's formula.
    pub fn check_value(&self, methods: &[Method], what: &str, expected: f64) {
        self.check_rgb(methods, what, [expected; 3]);
    }

    pub fn check_rgb(&self, methods: &[Method], what: &str, expected: [f64; 3]) {
        for (seed, &method) in methods.iter().enumerate() {
            assert!(self.names(method), "{} does not name {method:?}", self.id);
            let seed = 1 + seed as u64;
            let mut measured = self.probe.estimate(
                method,
                expected,
                [self.tolerance(), self.error],
                (BUDGET.min(self.rays), self.rays),
                seed,
            );
            let mut allowed = self.error;
            if let Some(most) =
                in_full().filter(|_| measured.relative_error(expected) > self.tolerance())
            {
                let more = 1.2 * (measured.relative_error(expected) / self.tolerance()).powi(2);
                if more * measured.rays as f64 <= most {
                    measured =
                        self.probe.sample(method, (more * measured.samples as f64) as u64, seed);
                    allowed = self.tolerance();
                } else {
                    println!(
                        "{} {what:12} {:6} would take {:.1e} rays",
                        self.id,
                        method.key(),
                        more * measured.rays as f64
                    );
                }
            }
            let error = measured.relative_error(expected);
            println!(
                "{} {what:12} {:6} {:.9} expected {:.9}, off by {:.1e}, SE {error:.1e}, {} samples{}",
                self.id,
                method.key(),
                measured.channels[1].mean(),
                expected[1],
                measured.deviation(expected),
                measured.samples,
                if error <= self.tolerance() { "" } else { " (fast)" },
            );
            assert_eq!(measured.non_finite, 0, "{} {what} {method:?}", self.id);
            assert!(
                measured.agrees(expected, self.tolerance()),
                "{} {what} {method:?}: {measured:?}, expected {expected:?}",
                self.id
            );
            assert!(
                error <= allowed,
                "{} {what} {method:?}: the relative standard error {error} is above {allowed}",
                self.id
            );
        }
    }

    /// These integrators cannot see this light: exactly 0.
    pub fn check_blind(&self, methods: &[Method]) {
        for &method in methods {
            let measured: Measured = self.probe.sample(method, 20_000, 7);
            assert!(
                measured.non_finite == 0 && measured.deviation([0.0; 3]) == 0.0,
                "{} {method:?}: {measured:?}",
                self.id
            );
        }
    }
}

/// An expected value of the table.
pub fn expected(id: &str, key: &str) -> f64 {
    let entry = all().iter().find(|entry| entry["id"] == id).expect("an entry of the table");
    let value = if key.is_empty() { &entry["expected"] } else { &entry["expected"][key] };
    value.as_f64().unwrap_or_else(|| panic!("{id} has no {key}"))
}
