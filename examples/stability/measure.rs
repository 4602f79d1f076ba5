//! The mean of a film and its standard error, by any integrator.

use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, FilmSample, Sink};
use pathspace::glam::DVec2;
use pathspace::integrator::{
    Bidirectional, Caller, Depth, InstantRadiosity, Integrator, LightTracer, Merging, PathTracer,
    PathTracing, PhotonMapping, Run, Stage, UniformArea, VertexConnectionMerging, WithNeeds,
};
use pathspace::math::statistics::Estimate;
use pathspace::path::{Heuristic, Ledger, Roulette, Scratch};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::World;

/// An integrator, as `analytic.json` names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// Path tracing that samples no light.
    Emission,
    /// Path tracing with next event estimation.
    Path,
    /// Uniform-area path sampling.
    UniformArea,
    /// Light tracing.
    Light,
    /// Bidirectional path tracing.
    Bidirectional,
    /// Photon mapping, with the [radius](Probe::radius) of the probe in all passes.
    PhotonMap,
    /// Vertex connection and merging, with the same radius.
    Merging,
    /// Instant radiosity, bounded and compensated.
    VirtualLights,
}

impl Method {
    /// Those that draw every sample by itself, without bias.
    pub const SINGLE: [Self; 5] =
        [Self::Emission, Self::Path, Self::UniformArea, Self::Light, Self::Bidirectional];
    /// Those whose samples share the light walks of a pass.
    pub const SHARED: [Self; 3] = [Self::PhotonMap, Self::Merging, Self::VirtualLights];
    pub const ALL: [Self; 8] = [
        Self::Emission,
        Self::Path,
        Self::UniformArea,
        Self::Light,
        Self::Bidirectional,
        Self::PhotonMap,
        Self::Merging,
        Self::VirtualLights,
    ];

    /// The key in `analytic.json`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Emission => "PT",
            Self::Path => "PT+NEE",
            Self::UniformArea => "UAS",
            Self::Light => "LT",
            Self::Bidirectional => "BDPT",
            Self::PhotonMap => "PM",
            Self::Merging => "VCM",
            Self::VirtualLights => "IR",
        }
    }
}

/// A measurement: scene, camera, film and samples.
#[derive(Clone, Copy)]
pub struct Probe<'a> {
    pub world: &'a World,
    pub camera: &'a (dyn Camera + Send),
    pub depth: Depth,
    pub roulette: Roulette,
    pub heuristic: Heuristic,
    /// The radius within which photons count as met.
    pub radius: f64,
    /// Samples of a pass that share light walks; only passes are independent of each other.
    pub pass: u64,
    /// True if all samples look through the middle of the film.
    pub fixed: bool,
}

/// Fewer passes have no standard error to speak of.
const FEWEST_PASSES: u64 = 64;
/// Light walks of a pass that leave photons.
const PHOTON_WALKS: u32 = 1000;

/// Moments of the film's mean over samples, or over passes of samples that share light walks, per
/// channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measured {
    pub channels: [Estimate; 3],
    pub samples: u64,
    /// Contributions that were infinite or not a number.
    pub non_finite: u64,
    pub rays: u64,
    pub truncated_subpaths: u64,
    pub ledger: Ledger,
}

impl Measured {
    /// The largest standard error of a channel, relative to what is expected of it.
    pub fn relative_error(&self, expected: [f64; 3]) -> f64 {
        let relative =
            |(m, e): (&Estimate, f64)| if e == 0.0 { 0.0 } else { m.standard_error() / e.abs() };
        self.channels.iter().zip(expected).map(relative).fold(0.0, f64::max)
    }

    /// The largest relative distance of a channel's mean from what is expected; of a channel that
    /// must be 0, its mean.
    pub fn deviation(&self, expected: [f64; 3]) -> f64 {
        let relative = |(m, e): (&Estimate, f64)| {
            if e == 0.0 { m.mean().abs() } else { ((m.mean() - e) / e).abs() }
        };
        // Not `max`, which loses what is not a number.
        self.channels
            .iter()
            .zip(expected)
            .map(relative)
            .fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
    }

    /// |mean - expected| ≤ max(tolerance |expected|, 4 standard errors) in every channel.
    pub fn agrees(&self, expected: [f64; 3], tolerance: f64) -> bool {
        self.channels.iter().zip(expected).all(|(m, e)| {
            (m.mean() - e).abs() <= (tolerance * e.abs()).max(4.0 * m.standard_error())
        })
    }
}

/// Sums what samples contribute to the film.
#[derive(Default)]
struct Sum {
    value: [f64; 3],
    non_finite: u64,
}

impl Sink for Sum {
    fn add(&mut self, _sample: usize, contribution: &Contribution) {
        let value = contribution.value * contribution.weight;
        if value.is_finite() && contribution.value.is_finite() {
            self.value.iter_mut().zip(value.0).for_each(|(sum, v)| *sum += v);
        } else {
            self.non_finite += 1;
        }
    }
}

impl<'a> Probe<'a> {
    pub fn new(world: &'a World, camera: &'a (dyn Camera + Send), depth: Depth) -> Self {
        Self {
            world,
            camera,
            depth,
            roulette: Roulette::default(),
            heuristic: Heuristic::default(),
            radius: 0.05,
            pass: 64,
            fixed: false,
        }
    }

    pub fn run(&self, integrator: &impl Integrator<World>, samples: u64, seed: u64) -> Measured {
        let source = Independent { seed };
        let (mut scratch, mut measured) = (Scratch::default(), Measured::default());
        let region = self.camera.film();
        let stage = Stage { seed, ..Stage::new(self.world, self.camera) };
        let mut run = integrator.start(stage, &Caller).expect("a run");
        let (each, observations) = match run.prepares() {
            true => (self.pass, samples.div_ceil(self.pass).max(FEWEST_PASSES)),
            false => (1, samples),
        };
        for observation in 0..observations {
            if run.prepares() {
                run.begin_pass(observation as u32, &Caller).expect("memory");
            }
            let mut sum = Sum::default();
            for i in observation * each..(observation + 1) * each {
                let mut sampler = source.sampler((i >> 24) as u32, (i & 0xff_ffff) as u32);
                let u = if self.fixed { DVec2::splat(0.5) } else { sampler.next_2d() };
                let film = FilmSample { raster: region.from_window(u), offset: DVec2::ZERO };
                run.sample(film, sampler, &mut sum, &mut scratch);
            }
            let channels = measured.channels.iter_mut().zip(sum.value);
            channels.for_each(|(channel, value)| channel.push(value / each as f64));
            measured.non_finite += sum.non_finite;
        }
        measured.samples = each * observations;
        scratch.counters += run.take_preparation();
        let counters = scratch.counters;
        measured.non_finite += counters.non_finite;
        measured.rays = counters.rays();
        measured.truncated_subpaths = counters.truncated_subpaths;
        measured.ledger = counters.ledger;
        measured
    }

    /// A given number of samples.
    pub fn sample(&self, method: Method, samples: u64, seed: u64) -> Measured {
        let Self { depth, roulette, heuristic, radius, .. } = *self;
        let path_tracer = PathTracer { depth, roulette, heuristic, ..PathTracer::default() };
        let bidirectional = Bidirectional { depth, roulette, heuristic, ..Default::default() };
        let merging = Merging { light_walks: Some(PHOTON_WALKS), ..Merging::fixed(radius) };
        match method {
            Method::Emission => self.run(
                &PathTracer { mode: PathTracing::EmissionOnly, ..path_tracer },
                samples,
                seed,
            ),
            Method::Path => self.run(&path_tracer, samples, seed),
            Method::UniformArea => self.run(&UniformArea { depth, roulette }, samples, seed),
            Method::Light => self.run(&LightTracer { depth, roulette }, samples, seed),
            Method::Bidirectional => self.run(&bidirectional, samples, seed),
            Method::PhotonMap => self.run(
                &PhotonMapping { depth, roulette, merging, ..PhotonMapping::default() },
                samples,
                seed,
            ),
            // Merges are left out where connections draw all.
            Method::Merging => self.run(
                &WithNeeds::all(VertexConnectionMerging {
                    bidirectional,
                    merging,
                    ..Default::default()
                }),
                samples,
                seed,
            ),
            // Each sample connects to all virtual lights, and few samples see what they can show.
            Method::VirtualLights => Self { pass: 8, ..*self }.run(
                &InstantRadiosity { path_tracer, ..InstantRadiosity::default() },
                samples,
                seed,
            ),
        }
    }

    /// A measurement by as many samples as a relative standard error of `target` takes, if that is
    /// at most `rays.0` rays; else by as many as one of `acceptable` takes, but at most about
    /// `rays.1` rays. A run of its own judges the variance.
    pub fn estimate(
        &self,
        method: Method,
        expected: [f64; 3],
        [target, acceptable]: [f64; 2],
        rays: (u64, u64),
        seed: u64,
    ) -> Measured {
        let probe = self.sample(method, 64, !seed);
        let most = |m: &Measured, rays: u64| {
            (rays as f64 * m.samples as f64 / (m.rays as f64).max(1.0)).clamp(64.0, 1e8)
        };
        // Rare events need a pilot that sees them.
        let pilot =
            self.sample(method, most(&probe, rays.1 / 32).min(50_000.0) as u64, seed ^ 0x5555);
        let blank = pilot.channels.iter().all(|m| m.mean() == 0.0);
        let error = if blank { f64::INFINITY } else { pilot.relative_error(expected) };
        let wanted = |target: f64| 1.3 * pilot.samples as f64 * (error / target).powi(2);
        let (few, many) = (most(&pilot, rays.0), most(&pilot, rays.1));
        let samples = if wanted(target) <= few {
            wanted(target).max(few.min(1000.0))
        } else {
            wanted(0.85 * acceptable).clamp(few, many)
        };
        self.sample(method, samples as u64, seed)
    }
}
