//! Exact answers: the entries of `data/analytic.json`, for every integrator that they name, under
//! their rule of acceptance,
//!
//! ```text
//! |m - e| ≤ max(tolerance |e|, 4 SE)      and      SE ≤ tolerance |e|.
//! ```
//!
//! Standard errors of the fast tests may be as large as 0.25 % of the answer where the entry's own
//! tolerance would take more than [`BUDGET`](entry::BUDGET) rays, so that 4 of them still see a
//! bias of 1 %, and 0.75 % where the light is rarely met; what is less precise says so where it is
//! called. With `PATHSPACE_ANALYTIC_FULL=1e9` all take as many rays as their tolerance needs, but
//! those that would take more than so many say how many, and keep to the fast rule; without a
//! number there is no limit. Light tracing cannot aim at a point, so it sees a square of a few
//! degrees and is compared with the mean over it. [`STATUS`] tells where every entry is tested, or
//! why it waits.
#![allow(missing_docs, reason = "a test program")]

#[path = "../examples/stability/measure.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod measure;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;

#[path = "analytic/camera.rs"]
mod camera;
#[path = "analytic/direct.rs"]
mod direct;
#[path = "analytic/entry.rs"]
mod entry;
#[path = "analytic/furnace.rs"]
mod furnace;
#[path = "analytic/specular.rs"]
mod specular;
#[path = "common/square_light.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod square_light;
#[path = "analytic/variance.rs"]
mod variance;

use std::collections::BTreeSet;

/// The tests of all entries: here, in another file, or none yet.
const STATUS: &[(&str, &str)] = &[
    ("A01", "here"),
    ("A02", "here"),
    (
        "A03",
        "here; bidirectional path tracing up to 20 bounces, since connections grow with the square",
    ),
    ("A04", "here"),
    ("A06", "here; uniform-area sampling cannot see the environment and reports 0"),
    ("A08", "here up to 3 bounces; sphere_cap.rs has each technique alone"),
    ("A10", "here; the fluxes in ledger.rs"),
    ("A12", "here; what is cut off in merging.rs"),
    ("A13", "here, by instant radiosity too; its angles are supplements of the opening"),
    ("A14", "here"),
    ("A15", "ledger.rs"),
    ("A16", "metropolis.rs, with A01 to A04, A06 and A08"),
    ("B01", "here"),
    ("B02", "here"),
    ("B03", "here"),
    ("B05", "here"),
    ("B06", "here"),
    ("B07", "here"),
    ("B09", "here"),
    ("B11", "here"),
    ("B13", "here"),
    ("B15", "here"),
    ("B17", "here"),
    ("B18", "here; uniform-area sampling not of adjacent faces, where its variance is infinite"),
    ("B19", "here; uniform-area sampling of one bounce, since the variance of more is infinite"),
    ("B20", "here"),
    ("C01", "here"),
    ("C02", "here"),
    ("C03", "here; standard errors of 1.5e-3 to 5e-3, not 1e-5"),
    ("C04", "waits for absorbing media"),
    ("C05", "here; a standard error of 5e-3, not 1e-4"),
    ("C07", "here; standard errors of 2e-3, not 1e-4"),
    ("C08", "here; light tracing cannot see through the interface and reports 0"),
    ("C11", "here"),
    ("C12", "here; all but photon mapping and merging report 0"),
    ("C13", "here"),
    ("C16", "here"),
    ("C17", "waits for a paraboloid or fine mesh"),
    ("C18", "here"),
    ("D01", "here; bsdf.rs tests the model by itself"),
    ("D02", "waits for the modified Phong model"),
    ("E01", "endpoints.rs"),
    ("E02", "endpoints.rs"),
    ("E03", "here"),
    ("E05", "here; all filters in agreement_exact.rs"),
    ("F01", "here"),
    ("F02", "sphere_cap.rs"),
    ("F03", "sphere_cap.rs"),
    ("F04", "here"),
    ("F05", "here: the rule has no cap"),
    ("F06", "src/path/roulette.rs"),
    ("F08", "here: the photons of light walks, and photon mapping"),
    ("F09", "here"),
    ("F10", "here"),
    ("F11", "sphere_cap.rs and verify.rs"),
    ("F12", "here"),
    ("F13", "sphere_cap.rs"),
    ("F15", "agreement_exact.rs; the means here"),
    ("F16", "agreement_exact.rs and src/path/weight.rs"),
    ("F17", "agreement_exact.rs"),
];

#[test]
fn every_entry_has_a_status() {
    let listed: BTreeSet<&str> = STATUS.iter().map(|(id, _)| *id).collect();
    let entries: BTreeSet<&str> =
        entry::all().iter().filter_map(|entry| entry["id"].as_str()).collect();
    assert_eq!(listed, entries);
    assert_eq!(listed.len(), STATUS.len());
}
