//! The report measures what is known exactly, sees what is planted, and repeats itself to the bit.
#![allow(missing_docs, reason = "a test program")]

mod common;

#[path = "report/answer.rs"]
mod answer;
#[path = "report/consistent.rs"]
mod consistent;
#[path = "report/files.rs"]
mod files;
#[path = "report/findings.rs"]
mod findings;
#[path = "report/leave_out.rs"]
mod leave_out;
#[path = "report/missing.rs"]
mod missing;
#[path = "report/oracles.rs"]
mod oracles;
#[path = "report/planted.rs"]
mod planted;
#[path = "report/shards.rs"]
mod shards;
#[path = "common/square_light.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod square_light;
#[path = "report/target.rs"]
mod target;
#[path = "report/undecided.rs"]
mod undecided;

use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, Image, Sample, Sink, Technique};
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{Crew, Integrator, Run, Stage, Started};
use pathspace::math::Rgb;
use pathspace::path::{Scratch, TechniqueSet};
use pathspace::render::Budget;
use pathspace::report::{Contestant, Method, Plan, Reference, Report, SceneInfo, Step, study};
use pathspace::sampler::Sampler;
use pathspace::scene::Scene;
use std::ops::ControlFlow;

fn go_on(_: &Step<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn contestants<'a, S: Scene + ?Sized>(
    methods: &[(&str, &'a dyn Method<S>)],
) -> Vec<Contestant<'a, S>> {
    methods.iter().map(|&(name, method)| Contestant::new(name, method, true)).collect()
}

fn exactly(value: f64, size: UVec2) -> Reference {
    Reference::exact(Image::from_fn(size.x, size.y, |_, _| Rgb::splat(value))).unwrap()
}

/// A study against a known constant.
fn against<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    methods: &[(&str, &dyn Method<S>)],
    exact: f64,
    samples: u32,
    seeds: u32,
) -> Report {
    let plan = Plan { budget: Budget::Samples(samples), seeds, ..Plan::default() };
    let reference = exactly(exact, camera.film().window_size());
    study(scene, camera, &SceneInfo::default(), &contestants(methods), reference, &plan, &mut go_on)
        .unwrap()
        .report
}

/// The part of a page that people read: without scripts and embedded images.
fn readable(page: &str) -> String {
    let mut text = page[..page.find("<script>").unwrap()].to_owned();
    for start in ["src=\"data:", "data-values=\""] {
        let parts = text.split(start).enumerate();
        let rest = |(i, part): (usize, &str)| match i {
            0 => part.to_owned(),
            _ => part.split_once('"').unwrap().1.to_owned(),
        };
        text = parts.map(rest).collect();
    }
    text
}

fn cornell_box(size: u32) -> gallery::GalleryScene {
    gallery::build("cornell-box", UVec2::splat(size)).unwrap()
}

/// An integrator whose contributions are numbers from a formula: a user's own, for any scene.
struct Synthetic<F>(F);

impl<F> std::fmt::Debug for Synthetic<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Synthetic")
    }
}

impl<S: Scene + ?Sized, F: Fn(&mut dyn Sampler) -> f64 + Sync> Integrator<S> for Synthetic<F> {
    type Run<'a>
        = &'a Self
    where
        Self: 'a,
        S: 'a;

    fn name(&self) -> &'static str {
        "synthetic"
    }

    fn start<'a>(&'a self, _: Stage<'a, S>, _: &dyn Crew) -> Started<&'a Self> {
        Ok(self)
    }
}

impl<'a, S, F> Run<'a, S> for &'a Synthetic<F>
where
    S: Scene + ?Sized + 'a,
    F: Fn(&mut dyn Sampler) -> f64 + Sync,
{
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        TechniqueSet::BIDIRECTIONAL
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        scratch.counters.closest_rays += samples.len() as u64;
        for (number, Sample { film, sampler }) in samples.iter_mut().enumerate() {
            let (value, technique) = (Rgb::splat((self.0)(sampler)), Technique::new(0, 2));
            let contribution = Contribution { raster: film.raster, value, weight: 1.0, technique };
            sink.add(number, &contribution);
        }
    }
}
