//! Bidirectional path tracing: one walk from the camera and one from a light, and every way to join a part of the one to a part of the
//! other (Lafortune and Willems 1993; Veach and Guibas 1994). Restricted to a set of techniques it is any of the incremental integrators:
//! the general kernel that the dedicated ones are tested against.

use super::{Alone, BatchSample, Depth, Integrator, LightTracer};
use crate::endpoint::{Camera, Endpoint};
use crate::film::{Contribution, FilmRegion, FilmSample, Sink, Technique};
use crate::math::Rgb;
use crate::path::{Counters, Heuristic, Path, RandomWalk, Roulette, Scratch, TechniqueSet, Vertex, sample_emitter, sample_lens};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, Scene};
use glam::DVec2;

/// Bidirectional path tracing over any set of techniques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bidirectional {
    /// The techniques to run, before those that a scene cannot use are left out.
    pub techniques: TechniqueSet,
    /// Which path lengths count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
    /// How the techniques are weighted.
    pub heuristic: Heuristic,
}

impl Default for Bidirectional {
    fn default() -> Self {
        Self {
            techniques: TechniqueSet::BIDIRECTIONAL,
            depth: Depth::default(),
            roulette: Roulette::default(),
            heuristic: Heuristic::default(),
        }
    }
}

impl Bidirectional {
    /// All techniques up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    /// Draws one sample and shows every path with a nonzero contribution, with its weight, to `visit`. The integrator itself is this
    /// with a sink; an audit or an experiment looks at the paths.
    pub fn for_each_path<'s, S, C, P>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        scratch: &mut Scratch<'s, S>,
        mut visit: impl FnMut(&Path<'_, 's, S, C>, &Contribution),
    ) where
        S: Scene + ?Sized,
        C: Camera + ?Sized,
        P: Sampler,
    {
        scratch.counters.samples += 1;
        let kernel = Kernel::new(self, scene, camera, film);
        kernel.walk_from_camera(sampler, scratch);
        kernel.join_camera_walk(sampler, scratch, &mut visit);
        for _ in 0..kernel.draw_light_walks(sampler) {
            kernel.walk_from_light(sampler, scratch);
            for t in 1..=scratch.camera.len().max(1) {
                for s in if t == 1 { 1 } else { 2 }..=scratch.light.len() {
                    kernel.join(s, t, sampler, scratch, &mut visit);
                }
            }
        }
    }
}

/// What does not change in the course of one sample, and its steps.
pub(super) struct Kernel<'a, 's, S: ?Sized, C: ?Sized> {
    scene: &'s S,
    camera: &'a C,
    film: FilmSample,
    region: FilmRegion,
    set: TechniqueSet,
    depth: Depth,
    roulette: Roulette,
    heuristic: Heuristic,
    /// Whether a vertex on a surface can be connected to.
    has_finite_lobes: bool,
    /// Over the number of light walks.
    light_share: f64,
}

impl<'a, 's, S: Scene + ?Sized, C: Camera + ?Sized> Kernel<'a, 's, S, C> {
    #[inline]
    pub fn new(integrator: &Bidirectional, scene: &'s S, camera: &'a C, film: FilmSample) -> Self {
        let needs = scene.needs();
        let set = integrator.techniques.pruned(&needs);
        Self {
            scene,
            camera,
            film,
            region: camera.film(),
            set,
            depth: integrator.depth.within(&needs),
            roulette: Roulette { constant: Rgb::BLACK, ..integrator.roulette },
            heuristic: integrator.heuristic,
            has_finite_lobes: needs.contains(Needs::FINITE_LOBES),
            light_share: 1.0 / set.light_walks.count(),
        }
    }

    /// How many light walks this sample has.
    #[inline]
    pub fn draw_light_walks<P: Sampler>(&self, sampler: &mut P) -> u32 {
        if !self.set.has_light_walk() {
            return 0;
        }
        self.set.light_walks.draw(|| {
            sampler.stream(Stream::Emission);
            sampler.next_1d()
        })
    }

    pub fn walk_from_camera<P: Sampler>(&self, sampler: &mut P, scratch: &mut Scratch<'s, S>) {
        let (vertices, counters) = (&mut scratch.camera, &mut scratch.counters);
        vertices.clear();
        if !self.set.has_camera_walk() {
            return;
        }
        let u = self.region.to_window(self.film.raster + self.film.offset);
        let Some((walk, lens)) = RandomWalk::from_camera(self.scene, self.camera, u, sampler) else { return };
        vertices.push(lens);
        // The last vertex can only be hit: a connection needs one scattering event more.
        let last = u32::from(!self.set.emitter_hits);
        if let Some(limit) = self.depth.limit().checked_sub(last) {
            // If lens sampling comes first, the walk goes on only where it could not.
            let go_on = |first: &Vertex<S::Bsdf<'s>>| !self.set.lens_first || first.dirac;
            walk.record_while(vertices, limit, &self.roulette, sampler, counters, go_on);
        }
        if let [lens, first, ..] = &mut vertices[..] {
            lens.start.connection = self.camera.pdf_from(&first.point, &lens.point);
        }
    }

    pub fn walk_from_light<P: Sampler>(&self, sampler: &mut P, scratch: &mut Scratch<'s, S>) {
        let (vertices, counters) = (&mut scratch.light, &mut scratch.counters);
        vertices.clear();
        let Some((walk, start)) = RandomWalk::from_light(self.scene, sampler, counters) else { return };
        let light = start.light;
        vertices.push(start);
        // A light walk's vertex is connected, never hit; to the lens at the cost of one scattering event, to a camera walk of two.
        let last = if self.set.lens_sampling { 1 } else { 2 };
        match (walk, self.depth.limit().checked_sub(last).filter(|_| self.has_finite_lobes)) {
            (Some(walk), Some(limit)) => walk.record(vertices, limit, &self.roulette, sampler, counters),
            (Some(walk), None) => walk.truncate(counters),
            (None, _) => {}
        }
        if let ([start, first, ..], Some(id)) = (&mut vertices[..], light) {
            start.start.connection = self.scene.light(id).pdf_from(&first.point, &start.point) * self.scene.pick_pmf(id);
        }
    }

    /// Draws with all techniques that need no light walk.
    #[inline]
    fn join_camera_walk<P: Sampler>(
        &self,
        sampler: &mut P,
        scratch: &mut Scratch<'s, S>,
        visit: &mut impl FnMut(&Path<'_, 's, S, C>, &Contribution),
    ) {
        for t in 2..=scratch.camera.len() {
            for s in 0..2 {
                self.join(s, t, sampler, scratch, visit);
            }
        }
    }

    /// Draws with one technique, given the walks, and shows what contributes to `visit`.
    #[inline]
    pub fn join<P: Sampler>(
        &self,
        s: usize,
        t: usize,
        sampler: &mut P,
        scratch: &mut Scratch<'s, S>,
        visit: &mut impl FnMut(&Path<'_, 's, S, C>, &Contribution),
    ) {
        let technique = Technique { s: s as u16, t: t as u16 };
        let left_to_lens = self.set.lens_first && t == 2 && s > 0;
        if !self.depth.contains((s + t - 2) as u32) || !self.set.contains(technique) || left_to_lens {
            return;
        }
        let (scene, camera) = (self.scene, self.camera);
        let Scratch { counters, camera: camera_vertices, light: light_vertices, .. } = scratch;
        let from_light = &light_vertices[..if s > 1 || t == 1 { s } else { 0 }];
        if s > 1 && !from_light[s - 1].is_connectible() {
            return;
        }
        if t == 1 {
            sampler.stream(Stream::LensSampling(s as u32 - 1));
            let Some(lens) = sample_lens(camera, &from_light[s - 1].point, sampler) else { return };
            let from_camera = [lens.vertex()];
            counters.connections += 1;
            let path = Path::connect(scene, camera, &from_camera, from_light);
            let raster = path.as_ref().and_then(|path| {
                let direction = path.joint()?.direction;
                Some(camera.raster(&from_camera[0].point, direction)? - self.film.offset)
            });
            if let Some(raster) = raster
                && self.region.pixel_index(raster).is_some()
            {
                self.offer(path, raster, self.light_share, sampler, counters, visit);
            }
            return;
        }
        let from_camera = &camera_vertices[..t];
        let raster = self.film.raster;
        if s == 0 {
            return self.offer(Path::hit(scene, camera, from_camera), raster, 1.0, sampler, counters, visit);
        }
        if !from_camera[t - 1].is_connectible() {
            return;
        }
        if s == 1 {
            sampler.stream(Stream::EmitterSampling(t as u32 - 1));
            let Some(emitter) = sample_emitter(scene, &from_camera[t - 1].point, sampler) else { return };
            counters.connections += 1;
            self.offer(Path::connect(scene, camera, from_camera, &[emitter.vertex()]), raster, 1.0, sampler, counters, visit);
        } else {
            counters.connections += 1;
            self.offer(Path::connect(scene, camera, from_camera, from_light), raster, self.light_share, sampler, counters, visit);
        }
    }

    /// Tests visibility last.
    #[inline]
    fn offer<P: Sampler>(
        &self,
        path: Option<Path<'_, 's, S, C>>,
        raster: DVec2,
        share: f64,
        sampler: &mut P,
        counters: &mut Counters,
        visit: &mut impl FnMut(&Path<'_, 's, S, C>, &Contribution),
    ) {
        let Some(path) = path else { return };
        let weight = || path.weight(&self.set, self.heuristic);
        let mut value = path.value() * share;
        if path.joint().is_some() {
            let Some(probability) = self.roulette.test_shadow(value, weight, || sampler.next_1d()) else { return };
            value = value / probability;
        }
        if path.is_visible(counters) {
            visit(&path, &Contribution { raster, value, weight: weight(), technique: path.technique() });
        }
    }
}

impl<S: Scene + ?Sized> Integrator<S> for Bidirectional {
    fn name(&self) -> &'static str {
        "bidirectional"
    }

    fn techniques(&self, needs: &Needs) -> TechniqueSet {
        self.techniques.pruned(needs)
    }

    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        if !(self.techniques.lens_first && self.techniques.lens_sampling && !self.techniques.connections) {
            return self.for_each_path(scene, camera, film, sampler, scratch, |_, contribution| sink.add(contribution));
        }
        // No weights: the light walks are light tracing's, the camera walk draws the rest.
        scratch.counters.samples += 1;
        let kernel = Kernel::new(self, scene, camera, film);
        kernel.walk_from_camera(sampler, scratch);
        kernel.join_camera_walk(sampler, scratch, &mut |_, contribution| sink.add(contribution));
        let (tracer, share) = (LightTracer { depth: self.depth, roulette: self.roulette }, kernel.light_share);
        for _ in 0..kernel.draw_light_walks(sampler) {
            let sample = BatchSample { film, sampler: &mut *sampler };
            tracer.walk(scene, camera, &mut [sample], &mut Alone(&mut Scaled { sink: &mut *sink, share }), scratch);
        }
    }
}

/// A sink that receives a part of each contribution's value.
struct Scaled<'a, K> {
    sink: &'a mut K,
    share: f64,
}

impl<K: Sink> Sink for Scaled<'_, K> {
    fn add(&mut self, contribution: &Contribution) {
        self.sink.add(&Contribution { value: contribution.value * self.share, ..*contribution });
    }
}
