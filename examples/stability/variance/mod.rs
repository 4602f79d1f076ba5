//! Variance × time where many lights are of no use: the world's own choice of lights against the
//! best of what is known for the scene.

mod choice;
mod images;
mod scenes;

use choice::Chosen;
use images::Images;
pub use images::{Effort, Price, Uncertain};
use pathspace::integrator::{Adaptive, Bidirectional, Depth, LightTracer, PathTracer, PathTracing};
use pathspace::render::Render;
use pathspace::scene::Scene;
pub use scenes::{Entry, Scenario, all};

/// The integrators that a verdict is on, and one more that others are compared with.
const METHODS: [&str; 5] = ["PT+NEE", "LT", "BDPT", "adaptive", "PT"];
/// Number of those that a verdict is on.
pub const JUDGED: usize = 4;
/// Most that variance × time may be of that of the lamp alone, which no choice of lights can reach
/// without knowing that the others are of no use.
const OVER_ALONE: f64 = 3.0;
/// Most that it may be of that with uniform choice where all lights are of use: to find that out costs
/// trials.
const OVER_UNIFORM: f64 = 1.5;
/// Standard errors of a logarithm that a ratio has to exceed its bound by to fail, and that means
/// may differ by.
const CERTAIN: f64 = 4.0;

/// A choice of lights, or of which there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lights {
    Own,
    Uniform,
    Power,
    /// Only those that are of use.
    Alone,
}

impl Lights {
    const ALL: [Self; 4] = [Self::Own, Self::Uniform, Self::Power, Self::Alone];
}

/// The outcome of a scene for one integrator and the world's own choice of lights.
#[derive(Clone, Debug)]
pub struct Comparison {
    pub row: &'static str,
    pub family: &'static str,
    pub value: f64,
    pub method: &'static str,
    /// Variance × price over the least of any method and choice.
    pub over_best: Uncertain,
    /// Over the same integrator with another choice; `None` for the lamp alone where all lights are
    /// of use.
    pub over_uniform: Uncertain,
    pub over_power: Uncertain,
    pub over_alone: Option<Uncertain>,
    /// Distance of the mean from that of path tracing with uniform choice, in standard errors.
    pub off: f64,
    pub is_good: bool,
}

/// Images of an integrator with a choice of lights.
struct Candidate {
    lights: Lights,
    method: usize,
    images: Images,
}

/// Renders images of all methods and choices, in turn, and compares.
pub fn judge(entry: &Entry, effort: Effort, seed: u64) -> Vec<Comparison> {
    let Scenario { world, alone, depth, camera } = &entry.build();
    let (uniform, power) = (Chosen::uniformly(world), Chosen::by_power(world));
    let mut candidates: Vec<Candidate> = Lights::ALL
        .into_iter()
        .filter(|lights| *lights != Lights::Alone || alone.is_some())
        .flat_map(|lights| (0..METHODS.len()).map(move |method| (lights, method)))
        .map(|(lights, method)| Candidate { lights, method, images: Images::default() })
        .collect();
    for image in 0..effort.images {
        let seed = seed + u64::from(image);
        for Candidate { lights, method, images } in &mut candidates {
            let (own, other) = (integrator(*method, *depth), integrator(*method, *depth));
            match (lights, alone) {
                (Lights::Own, _) => images.render(world, &**camera, &*own, effort, seed),
                (Lights::Power, _) => images.render(&power, &**camera, &*other, effort, seed),
                (Lights::Alone, Some(alone)) => {
                    images.render(alone, &**camera, &*own, effort, seed);
                }
                _ => images.render(&uniform, &**camera, &*other, effort, seed),
            }
        }
    }
    compare(entry, &candidates)
}

/// One of [`METHODS`].
fn integrator<S: Scene>(method: usize, depth: Depth) -> Box<dyn Render<S>> {
    let path_tracer = PathTracer { depth, ..PathTracer::default() };
    match METHODS[method] {
        "LT" => Box::new(LightTracer { depth, ..LightTracer::default() }),
        "BDPT" => Box::new(Bidirectional { depth, ..Bidirectional::default() }),
        "adaptive" => Box::new(Adaptive { depth, ..Adaptive::default() }),
        "PT" => Box::new(PathTracer { mode: PathTracing::EmissionOnly, ..path_tracer }),
        _ => Box::new(path_tracer),
    }
}

fn compare(entry: &Entry, candidates: &[Candidate]) -> Vec<Comparison> {
    let find = |lights, method| {
        let found = candidates.iter().find(|it| it.lights == lights && it.method == method);
        found.map(|candidate| &candidate.images)
    };
    // Of more lights than some hundreds, trials of so few pixels do not find out which one is not
    // hidden.
    let over_alone_bound = match entry.row == "S77" && entry.value > 100.0 {
        true => f64::INFINITY,
        false => OVER_ALONE,
    };
    let truth = find(Lights::Uniform, 0).map(Images::mean).unwrap_or_default();
    let off = |images: &Images| {
        let mean = images.mean();
        let error = mean.standard_error().hypot(truth.standard_error());
        (mean.mean() - truth.mean()).abs() / error
    };
    // Who sees nothing, or another image, is no measure of others.
    let best = candidates
        .iter()
        .filter(|it| it.lights == Lights::Alone || off(&it.images) < CERTAIN)
        .map(|it| it.images.inefficiency())
        .filter(|inefficiency| inefficiency.value > 0.0)
        .min_by(|a, b| a.value.total_cmp(&b.value))
        .unwrap_or(Uncertain { value: f64::NAN, error: 0.0 });
    let judged = |method| {
        let own = find(Lights::Own, method)?;
        let over = |lights| Some(own.inefficiency().over(find(lights, method)?.inefficiency()));
        let (over_uniform, over_alone) = (over(Lights::Uniform)?, over(Lights::Alone));
        let off = off(own);
        let is_good = off < CERTAIN
            && over_uniform
                .is_within(if over_alone.is_some() { 1.0 } else { OVER_UNIFORM }, CERTAIN)
            && over_alone.is_none_or(|ratio| ratio.is_within(over_alone_bound, CERTAIN));
        Some(Comparison {
            row: entry.row,
            family: entry.family,
            value: entry.value,
            method: METHODS[method],
            over_best: own.inefficiency().over(best),
            over_uniform,
            over_power: over(Lights::Power)?,
            over_alone,
            off,
            is_good,
        })
    };
    (0..JUDGED).filter_map(judged).collect()
}
