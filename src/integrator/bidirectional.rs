//! Bidirectional path tracing: one walk from the camera and one from a light, and every way to join
//! a part of the one to a part of the other (Lafortune and Willems 1993; Veach and Guibas 1994).
//! Restricted to a set of techniques it is any of the incremental integrators: the general kernel
//! that the dedicated ones are tested against.

use super::{Alone, Depth, Integrator, LightTracer};
use crate::endpoint::{Camera, Endpoint};
use crate::film::{BatchSample, BatchSink, Contribution, FilmRegion, FilmSample, Sink, Technique};
use crate::math::Rgb;
use crate::path::{
    Counters, End, GrowingPath, Heuristic, Path, RandomWalk, Roulette, Scratch, Segments,
    TechniqueSet, Vertex, Walks, Weighting, sample_emitter, sample_lens,
};
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

    /// Draws one sample and shows every path with a nonzero contribution, with its weight, to
    /// `visit`. The integrator itself is this with a sink; an audit or an experiment looks at the
    /// paths.
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
        let kernel = Kernel::new(self, scene, camera);
        let sample = &mut BatchSample { film, sampler };
        kernel.walk_from_camera(sample, scratch);
        let Scratch { counters, camera: from_camera, light: from_light, .. } = scratch;
        let mut offer = |path: Path<'_, 's, S, C>, raster, value, counters: &mut Counters| {
            if path.is_visible(counters) {
                visit(&path, &kernel.contribution(&path, raster, value));
            }
        };
        kernel.join_camera_walk(sample, from_camera, counters, &mut offer);
        for _ in 0..kernel.draw_light_walks(&mut sample.sampler) {
            kernel.walk_from_light(&mut sample.sampler, from_light, counters);
            kernel.join_light_walk(sample, from_camera, from_light, counters, &mut offer);
        }
    }
}

/// What does not change from sample to sample, and the steps of one. What is drawn is offered with
/// its place on the film and its value before it is known to be visible.
pub(super) struct Kernel<'a, 's, S: ?Sized, C: ?Sized> {
    scene: &'s S,
    camera: &'a C,
    region: FilmRegion,
    set: TechniqueSet,
    depth: Depth,
    roulette: Roulette,
    weighting: Weighting,
    /// Whether a vertex on a surface can be connected to.
    has_finite_lobes: bool,
    /// Over the number of light walks.
    light_share: f64,
}

impl<'a, 's, S: Scene + ?Sized, C: Camera + ?Sized> Kernel<'a, 's, S, C> {
    #[inline]
    pub fn new(integrator: &Bidirectional, scene: &'s S, camera: &'a C) -> Self {
        let needs = scene.needs();
        let set = integrator.techniques.pruned(&needs);
        Self {
            scene,
            camera,
            region: camera.film(),
            set,
            depth: integrator.depth.within(&needs),
            roulette: Roulette { constant: Rgb::BLACK, ..integrator.roulette },
            weighting: Weighting::new(set, integrator.heuristic),
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

    pub fn walk_from_camera<P: Sampler>(
        &self,
        sample: &mut BatchSample<P>,
        scratch: &mut Scratch<'s, S>,
    ) {
        let Scratch { counters, camera: vertices, .. } = scratch;
        if let Some(walk) = self.start_from_camera(sample, vertices) {
            walk.record_while(
                vertices,
                self.camera_limit(),
                &self.roulette,
                &mut sample.sampler,
                counters,
                |first| self.goes_on(first),
            );
        }
        self.finish_from_camera(vertices);
    }

    pub fn walk_from_light<P: Sampler>(
        &self,
        sampler: &mut P,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
        counters: &mut Counters,
    ) {
        if let Some(walk) = self.start_from_light(sampler, vertices, counters) {
            walk.record(vertices, self.light_limit(), &self.roulette, sampler, counters);
        }
        self.finish_from_light(vertices);
    }

    /// Scattering events of a camera walk.
    fn camera_limit(&self) -> u32 {
        // The last vertex can only be hit: a connection needs one scattering event more.
        self.depth.limit().saturating_sub(u32::from(!self.set.emitter_hits))
    }

    /// Whether a camera walk goes on from its first surface: if lens sampling comes first, only
    /// where that could not.
    fn goes_on(&self, first: &Vertex<S::Bsdf<'s>>) -> bool {
        !self.set.lens_first || first.dirac
    }

    /// Begins the list of a camera walk's vertices; returns the walk if there is one.
    fn start_from_camera<P: Sampler>(
        &self,
        BatchSample { film, sampler }: &mut BatchSample<P>,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
    ) -> Option<RandomWalk<'s, S>> {
        vertices.clear();
        if !self.set.has_camera_walk() {
            return None;
        }
        let u = self.region.to_window(film.raster + film.offset);
        let (walk, lens) = RandomWalk::from_camera(self.scene, self.camera, u, sampler)?;
        vertices.push(lens);
        (self.set.emitter_hits || self.depth.limit() > 0).then_some(walk)
    }

    fn finish_from_camera(&self, vertices: &mut [Vertex<S::Bsdf<'s>>]) {
        if let [lens, first, ..] = vertices {
            lens.start.connection = self.camera.pdf_from(&first.point, &lens.point);
        }
        self.weighting.complete_camera_walk(vertices);
    }

    /// Scattering events of a light walk: its last vertex is connected, never hit; to the lens at
    /// the cost of one scattering event, to a camera walk of two.
    fn light_limit(&self) -> u32 {
        self.depth.limit().saturating_sub(if self.set.lens_sampling { 1 } else { 2 })
    }

    /// Begins the list of a light walk's vertices; returns the walk if it is of use.
    fn start_from_light<P: Sampler>(
        &self,
        sampler: &mut P,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
        counters: &mut Counters,
    ) -> Option<RandomWalk<'s, S>> {
        vertices.clear();
        let (walk, start) = RandomWalk::from_light(self.scene, sampler, counters)?;
        vertices.push(start);
        let walk = walk?;
        if !self.has_finite_lobes || self.depth.limit() < if self.set.lens_sampling { 1 } else { 2 }
        {
            walk.truncate(counters);
            return None;
        }
        Some(walk)
    }

    fn finish_from_light(&self, vertices: &mut [Vertex<S::Bsdf<'s>>]) {
        if let [start, first, ..] = vertices
            && let Some(id) = start.light
        {
            let light = self.scene.light(id);
            start.start.connection =
                light.pdf_from(&first.point, &start.point) * self.scene.pick_pmf(id);
            self.weighting.complete_light_walk(vertices, light);
        }
    }

    /// Draws with all techniques that need no light walk.
    #[inline]
    fn join_camera_walk<P: Sampler>(
        &self,
        sample: &mut BatchSample<P>,
        from_camera: &[Vertex<S::Bsdf<'s>>],
        counters: &mut Counters,
        offer: &mut impl FnMut(Path<'_, 's, S, C>, DVec2, Rgb, &mut Counters),
    ) {
        for t in 2..=from_camera.len() {
            for s in 0..2 {
                self.join((s, t), sample, [from_camera, &[]], counters, offer);
            }
        }
    }

    /// Draws with all techniques that need one.
    #[inline]
    fn join_light_walk<P: Sampler>(
        &self,
        sample: &mut BatchSample<P>,
        from_camera: &[Vertex<S::Bsdf<'s>>],
        from_light: &[Vertex<S::Bsdf<'s>>],
        counters: &mut Counters,
        offer: &mut impl FnMut(Path<'_, 's, S, C>, DVec2, Rgb, &mut Counters),
    ) {
        for t in 1..=from_camera.len().max(1) {
            for s in if t == 1 { 1 } else { 2 }..=from_light.len() {
                self.join((s, t), sample, [from_camera, from_light], counters, offer);
            }
        }
    }

    /// Draws with one technique, given the walks.
    #[inline]
    pub fn join<P: Sampler>(
        &self,
        (s, t): (usize, usize),
        BatchSample { film, sampler }: &mut BatchSample<P>,
        [camera_walk, light_walk]: [&[Vertex<S::Bsdf<'s>>]; 2],
        counters: &mut Counters,
        offer: &mut impl FnMut(Path<'_, 's, S, C>, DVec2, Rgb, &mut Counters),
    ) {
        let technique = Technique { s: s as u16, t: t as u16 };
        let left_to_lens = self.set.lens_first && t == 2 && s > 0;
        if !self.depth.contains((s + t - 2) as u32) || !self.set.contains(technique) || left_to_lens
        {
            return;
        }
        let (scene, camera) = (self.scene, self.camera);
        let from_light = &light_walk[..if s > 1 || t == 1 { s } else { 0 }];
        if s > 1 && !from_light[s - 1].is_connectible() {
            return;
        }
        if t == 1 {
            sampler.stream(Stream::LensSampling(s as u32 - 1));
            let Some(lens) = sample_lens(camera, &from_light[s - 1].point, sampler) else { return };
            let from_camera = [lens.vertex(scene, camera)];
            counters.connections += 1;
            let path = Path::connect(scene, camera, &from_camera, from_light);
            let raster = path.as_ref().and_then(|path| {
                let direction = path.joint()?.direction;
                Some(camera.raster(&from_camera[0].point, direction)? - film.offset)
            });
            if let Some(raster) = raster
                && self.region.pixel_index(raster).is_some()
            {
                self.offer(path, raster, self.light_share, sampler, counters, offer);
            }
            return;
        }
        let from_camera = &camera_walk[..t];
        let raster = film.raster;
        if s == 0 {
            return self.offer(
                Path::hit(scene, camera, from_camera),
                raster,
                1.0,
                sampler,
                counters,
                offer,
            );
        }
        if !from_camera[t - 1].is_connectible() {
            return;
        }
        if s == 1 {
            sampler.stream(Stream::EmitterSampling(t as u32 - 1));
            let Some(emitter) = sample_emitter(scene, &from_camera[t - 1].point, sampler) else {
                return;
            };
            counters.connections += 1;
            self.offer(
                Path::connect(scene, camera, from_camera, &[emitter.vertex(scene, camera)]),
                raster,
                1.0,
                sampler,
                counters,
                offer,
            );
        } else {
            counters.connections += 1;
            self.offer(
                Path::connect(scene, camera, from_camera, from_light),
                raster,
                self.light_share,
                sampler,
                counters,
                offer,
            );
        }
    }

    /// Offers a path, unless roulette decides that its visibility is not worth a ray.
    #[inline]
    fn offer<P: Sampler>(
        &self,
        path: Option<Path<'_, 's, S, C>>,
        raster: DVec2,
        share: f64,
        sampler: &mut P,
        counters: &mut Counters,
        offer: &mut impl FnMut(Path<'_, 's, S, C>, DVec2, Rgb, &mut Counters),
    ) {
        let Some(path) = path else { return };
        let mut value = path.value() * share;
        if path.joint().is_some() {
            let weight = || self.weighting.weight(&path);
            let Some(probability) = self.roulette.test_shadow(value, weight, || sampler.next_1d())
            else {
                return;
            };
            value = value / probability;
        }
        offer(path, raster, value, counters);
    }

    /// Takes offers of a sample: what needs a test of visibility becomes a segment.
    fn postpone<'v, K: BatchSink>(
        &'v self,
        sample: usize,
        segments: &'v mut Segments,
        sink: &'v mut K,
    ) -> impl FnMut(Path<'_, 's, S, C>, DVec2, Rgb, &mut Counters) + 'v {
        move |path, raster, value, counters| {
            let contribution = self.contribution(&path, raster, value);
            let Technique { s, t } = path.technique();
            if s == 0 {
                return sink.add(sample, &contribution);
            }
            counters.shadow_rays += 1;
            let (s, t) = (usize::from(s), usize::from(t));
            let near = if t == 1 {
                segments.keep(&path.vertex(0).point)
            } else {
                End::Camera(t as u32 - 1)
            };
            let far = match path.facing() {
                Some(facing) => segments.keep(&facing),
                // Of emitter sampling the light walk knows nothing.
                None if s == 1 => segments.keep(&path.vertex(t).point),
                None => End::Light(s as u32 - 1),
            };
            segments.push(sample, [near, far], contribution);
        }
    }

    /// What a path contributes that was offered, if it is visible.
    #[inline]
    pub fn contribution(
        &self,
        path: &Path<'_, 's, S, C>,
        raster: DVec2,
        value: Rgb,
    ) -> Contribution {
        Contribution {
            raster,
            value,
            weight: self.weighting.weight(path),
            technique: path.technique(),
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
        self.sample_batch(
            scene,
            camera,
            &mut [BatchSample { film, sampler }],
            &mut Alone(sink),
            scratch,
        );
    }

    fn sample_batch<'s, C: Camera + ?Sized, P: Sampler, K: BatchSink>(
        &self,
        scene: &'s S,
        camera: &C,
        samples: &mut [BatchSample<P>],
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        let kernel = Kernel::new(self, scene, camera);
        let Scratch { counters, walks, wavefront, .. } = &mut *scratch;
        counters.samples += samples.len() as u64;
        walks.resize_with(walks.len().max(samples.len()), Walks::default);
        wavefront.paths.clear();
        for (i, sample) in samples.iter_mut().enumerate() {
            let walk = kernel.start_from_camera(sample, &mut walks[i].camera);
            wavefront.paths.extend(walk.map(|walk| GrowingPath::new(i, walk)));
        }
        scratch.record(scene, kernel.camera_limit(), &kernel.roulette, samples, |first| {
            kernel.goes_on(first)
        });
        let Scratch { counters, walks, wavefront, .. } = &mut *scratch;
        for (i, sample) in samples.iter_mut().enumerate() {
            let Walks { camera: from_camera, light_walks, .. } = &mut walks[i];
            kernel.finish_from_camera(from_camera);
            kernel.join_camera_walk(
                sample,
                from_camera,
                counters,
                &mut kernel.postpone(i, &mut wavefront.segments, sink),
            );
            *light_walks = kernel.draw_light_walks(&mut sample.sampler);
        }
        wavefront.test(scene, walks, sink);
        let rounds =
            walks[..samples.len()].iter().map(|walks| walks.light_walks).max().unwrap_or_default();
        let only_to_lens =
            kernel.set.lens_first && kernel.set.lens_sampling && !kernel.set.connections;
        for round in 0..rounds {
            let Scratch { counters, walks, wavefront, .. } = &mut *scratch;
            if only_to_lens {
                // No weights: the light walks are light tracing's.
                let (tracer, share) = (
                    LightTracer { depth: self.depth, roulette: self.roulette },
                    kernel.light_share,
                );
                let has_walk = |i: usize| round < walks[i].light_walks;
                tracer.walk(
                    scene,
                    camera,
                    samples,
                    has_walk,
                    &mut Scaled { sink, share },
                    counters,
                    wavefront,
                );
                continue;
            }
            let with_walks =
                |(_, (_, walks)): &(usize, (&mut BatchSample<P>, &mut Walks<'s, S>))| {
                    round < walks.light_walks
                };
            for (i, (sample, walks)) in samples.iter_mut().zip(walks).enumerate().filter(with_walks)
            {
                let walk = kernel.start_from_light(&mut sample.sampler, &mut walks.light, counters);
                wavefront.paths.extend(walk.map(|walk| GrowingPath::new(i, walk)));
            }
            scratch.record(scene, kernel.light_limit(), &kernel.roulette, samples, |_| true);
            let Scratch { counters, walks, wavefront, .. } = &mut *scratch;
            for (i, (sample, walks)) in
                samples.iter_mut().zip(&mut *walks).enumerate().filter(with_walks)
            {
                kernel.finish_from_light(&mut walks.light);
                let offer = &mut kernel.postpone(i, &mut wavefront.segments, sink);
                kernel.join_light_walk(sample, &walks.camera, &walks.light, counters, offer);
            }
            wavefront.test(scene, walks, sink);
        }
    }
}

/// A sink that receives a part of each contribution's value.
struct Scaled<'a, K> {
    sink: &'a mut K,
    share: f64,
}

impl<K: BatchSink> BatchSink for Scaled<'_, K> {
    fn add(&mut self, sample: usize, contribution: &Contribution) {
        self.sink
            .add(sample, &Contribution { value: contribution.value * self.share, ..*contribution });
    }
}
