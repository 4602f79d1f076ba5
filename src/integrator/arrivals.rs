//! Trials, before a rendering, of which lights arrive in its picture.
//!
//! A light that never gets into the picture, such as a sky around a closed room, may be the brightest
//! of all. What is tried here scales the choice of lights by what arrives ([`Arrival`]); the image has
//! the same mean, whatever the trials say, because they take numbers of their own.

use super::{Crew, LightTracer, Stage};
use crate::endpoint::{Endpoint, LightId, PointSample};
use crate::film::{Contribution, FilmSample, Sample};
use crate::light_tree::{Arrival, LightTree, Trials};
use crate::path::{
    Counters, Depth, Edge, Ledger, Plan, RandomWalk, Scratch, Site, Steps, TechniqueSet, Vertex,
    Visit, advance,
};
use crate::sampler::{Independent, SampleSource, Sampler, Stream};
use crate::scene::Scene;
use std::cell::RefCell;
use std::ops::ControlFlow;

/// Pixels for each walk of the first round, and the fewest and most of those.
const PIXELS_PER_WALK: u64 = 8;
const WALKS: [u64; 2] = [64, 16_384];
/// The fewest walks at which an end is made although most connections are in vain, or fewer walks
/// than enough have arrived: of few lights, and of many.
const FEWEST: [u64; 2] = [256, 1024];
const MANY: usize = 256;
const ENOUGH: f64 = 16.0;
/// Scattering events of a walk.
const BOUNCES: u32 = 3;
/// Walks that a thread draws at a time.
const CHUNK: u64 = 64;
/// Tells the numbers of trials from those of samples.
const OWN_NUMBERS: u64 = 0x6172_7269_7661_6c73;

/// Observations of the lights of a stage.
#[derive(Clone, Debug)]
pub struct Arrivals {
    /// The part that arrives of each branch of the scene's tree.
    pub arrival: Arrival,
    /// Counts of what was done.
    pub counters: Counters,
}

impl Arrivals {
    /// Tries the lights of a stage, by a walk from the camera and one from a light for eight pixels,
    /// and up to one of each for every pixel as long as most connections are in vain or few walks
    /// arrive; by 64 and up to 256, or 1024 of many lights, for few pixels. Nothing depends on the
    /// number of passes. `None` if the scene chooses by no [tree](Scene::light_tree) or has a single
    /// light.
    #[must_use]
    pub fn observe<S: Scene + ?Sized>(stage: Stage<'_, S>, crew: &dyn Crew) -> Option<Self> {
        let tree = stage.scene.light_tree().filter(|tree| tree.len() > 1)?;
        let pixels = u64::from(stage.film.pixels());
        let mut walks = (pixels / PIXELS_PER_WALK).clamp(WALKS[0], WALKS[1]);
        let (mut all, mut counters, mut from) = (Observed::default(), Counters::default(), 0);
        let mut known = None;
        loop {
            let stage = Stage { arrival: known.as_ref(), ..stage };
            for (observed, done) in crew.collect(walks.div_ceil(CHUNK) as usize, |chunk| {
                let first = from + chunk as u64 * CHUNK;
                observe(stage, tree, first..(first + CHUNK).min(from + walks))
            }) {
                all.connections.add(&observed.connections);
                all.walks.add(&observed.walks);
                counters += done;
            }
            from += walks;
            walks = from;
            known = Some(Arrival::new(tree, &all.connections, &all.walks));
            let ([trials, connected], [_, arrived]) = (all.connections.total(), all.walks.total());
            let is_enough = connected >= 0.5 * trials && arrived >= ENOUGH;
            if is_enough || from >= pixels.max(FEWEST[usize::from(tree.len() > MANY)]) {
                break;
            }
        }
        // Neither its energy nor its samples are the image's.
        let counters =
            Counters { samples: 0, truncated_subpaths: 0, ledger: Ledger::default(), ..counters };
        Some(Self { arrival: known?, counters })
    }
}

/// Trials of both kinds.
#[derive(Default)]
struct Observed {
    connections: Trials,
    walks: Trials,
}

/// Draws some of the walks from the camera and from lights.
fn observe<S: Scene + ?Sized>(
    stage: Stage<'_, S>,
    tree: &LightTree,
    walks: std::ops::Range<u64>,
) -> (Observed, Counters) {
    let source = Independent { seed: stage.seed ^ OWN_NUMBERS };
    let samples = || {
        let draw = |walk: u64| {
            let mut sampler = source.sampler(walk as u32, 0);
            let raster = stage.film.from_window(sampler.next_2d());
            Sample { film: FilmSample { raster, ..FilmSample::default() }, sampler }
        };
        walks.clone().map(draw).collect::<Vec<_>>()
    };
    let (depth, mut scratch) = (Depth::up_to(BOUNCES), Scratch::default());
    let plan = Plan::new(stage, TechniqueSet::BIDIRECTIONAL, depth);
    let from_camera = Connections { tree, trials: RefCell::default() };
    let nowhere = &mut |_: usize, _: &Contribution| {};
    advance(&plan, &from_camera, &mut samples(), nowhere, &mut scratch);

    let from_lights = Starts { lights: RefCell::default() };
    let mut arrive = vec![false; samples().len()];
    let sink = &mut |sample: usize, _: &Contribution| arrive[sample] = true;
    advance(&plan, &from_lights, &mut samples(), sink, &mut scratch);
    let mut trials = Trials::default();
    for (light, arrives) in from_lights.lights.into_inner().into_iter().zip(arrive) {
        if let Some(LightId(item)) = light {
            let used = tree.pmf_regardless(stage.arrival, item);
            let weight = tree.pmf_regardless(None, item) / used;
            trials.push(item, weight, f64::from(u8::from(arrives)));
        }
    }
    let connections = from_camera.trials.into_inner();
    (Observed { connections, walks: trials }, scratch.counters)
}

/// A walk from the camera whose vertices try to connect to a light.
struct Connections<'t> {
    tree: &'t LightTree,
    trials: RefCell<Trials>,
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for Connections<'_> {
    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        if visit.walk.is_from_connectible()
            && let Some((LightId(item), value)) = visit.emitted()
        {
            // What a walk finds by chance, connections may take long to choose.
            self.trials.borrow_mut().push(item, 1.0, value.luminance());
        }
        let Visit { plan: Plan { stage, .. }, vertex, sample, counters, .. } = visit;
        if vertex.is_connectible() {
            let x = &vertex.point;
            sample.sampler.stream(Stream::NextEvent(visit.walk.bounces() + 1));
            let (u0, u1, u2) =
                (sample.sampler.next_1d(), sample.sampler.next_1d(), sample.sampler.next_2d());
            // By half to learn of what would be chosen, by half to learn of all branches.
            let found = match u0 < 0.5 {
                true => stage.pick_light_for(x, 2.0 * u0).map(|(id, _)| id),
                false => self.tree.sample_evenly(2.0 * u0 - 1.0).map(|(item, _)| LightId(item)),
            };
            if let Some(id) = found {
                counters.shadow_rays += 1;
                let used = 0.5 * (stage.pick_pmf_for(x, id) + self.tree.pmf_evenly(id.0));
                let sampled = stage.scene.light(id).sample_from(x, u1, u2);
                let value = sampled.and_then(|sampled| contribution(stage, vertex, id, &sampled));
                let weight = self.tree.pmf(x, None, id.0) / used;
                self.trials.borrow_mut().push(id.0, weight, value.unwrap_or(0.0) / used);
            }
        }
        visit.limit(BOUNCES)
    }
}

/// Luminance of `T f G V Le / p` of a point sampled on a light.
fn contribution<S: Scene + ?Sized>(
    stage: &Stage<'_, S>,
    vertex: &Vertex<S::Bsdf<'_>>,
    id: LightId,
    PointSample { point, pdf }: &PointSample,
) -> Option<f64> {
    let (edge, bsdf) = (Edge::between(&vertex.point, point)?, vertex.bsdf.as_ref()?);
    let radiance = stage.scene.light(id).emit(point, -edge.direction);
    let scattered = bsdf.eval(edge.direction, vertex.to_previous) * radiance;
    let passing = stage.scene.transmittance(&vertex.point, point);
    let value = vertex.throughput * scattered * (edge.geometry / pdf.value()) * passing;
    let value = value.luminance();
    (value.is_finite() && value > 0.0 && stage.scene.visible(&vertex.point, point)).then_some(value)
}

/// The walks of a light tracer, with the lights that they start at.
struct Starts {
    lights: RefCell<Vec<Option<LightId>>>,
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for Starts {
    const CONNECTS: bool = true;

    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let Site { plan, sample, counters, .. } = site;
        let found = RandomWalk::from_light(&plan.stage, &mut sample.sampler, counters);
        let light = found.as_ref().and_then(|(_, start)| start.light);
        self.lights.borrow_mut().push(light);
        found?.0
    }

    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        LightTracer::default().connect(visit);
    }

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        LightTracer::default().scatter(visit)
    }
}
