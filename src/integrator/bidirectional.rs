//! Bidirectional path tracing: one subpath from the camera and one from a light, and every way to
//! join a part of the one to a part of the other (Lafortune and Willems 1993; Veach and Guibas
//! 1994). Restricted to a set of techniques it is any of the incremental integrators: the general
//! form that the dedicated ones are tested against.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::{Crew, Depth, Integrator, Notes, Run, Stage, Started};
use crate::endpoint::Endpoint;
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::math::Rgb;
use crate::path::{
    Counters, End, Heuristic, LeftOut, Out, Path, RandomWalk, Roulette, Scratch, Site, Steps,
    Subpaths, TechniqueSet, Vertex, Visit, Weighting, advance, join, sample_emitter, sample_lens,
};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, Scene};
use std::ops::ControlFlow;

/// Bidirectional path tracing over any set of techniques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bidirectional {
    /// The techniques to run, before those that a scene cannot use are left out.
    pub techniques: TechniqueSet,
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
    /// The weights of the techniques.
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

    pub(super) fn run<S: Scene + ?Sized>(self, stage: Stage<'_, S>) -> Pairs<'_, S> {
        let Self { techniques, depth, roulette, heuristic } = self;
        let (set, left_out) = (techniques.pruned(&stage.needs), techniques.left_out(&stage.needs));
        let depth = depth.within(&stage.needs);
        let roulette = Roulette { constant: Rgb::BLACK, ..roulette };
        Pairs { stage, set, left_out, depth, roulette, weighting: Weighting::new(set, heuristic) }
    }

    /// Draws one sample and shows every path with a nonzero contribution, with its weight, to
    /// `visit`, as an audit or an experiment looks at them.
    pub fn for_each_path<'s, S: Scene + ?Sized, P: Sampler>(
        &self,
        stage: Stage<'s, S>,
        sample: Sample<P>,
        scratch: &mut Scratch<'s, S>,
        mut visit: impl FnMut(&Path<'_, 's, S>, &Contribution),
    ) {
        let mut look = |path: &Path<'_, 's, S>, contribution, _: &mut Out<'_>, counters: &mut _| {
            if path.is_visible(counters) {
                visit(path, &contribution);
            }
        };
        let nothing_else = &mut |_, _: &Contribution| {};
        self.run(stage).trace(&mut [sample], nothing_else, scratch, &mut look);
    }
}

impl<S: Scene + ?Sized> Integrator<S> for Bidirectional {
    type Run<'a>
        = Pairs<'a, S>
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "bidirectional"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Pairs<'a, S>> {
        Ok(self.run(stage))
    }
}

/// A rendering by pairs of subpaths.
pub struct Pairs<'a, S: Scene + ?Sized> {
    stage: Stage<'a, S>,
    set: TechniqueSet,
    left_out: LeftOut,
    depth: Depth,
    roulette: Roulette,
    weighting: Weighting,
}

/// Walks from the camera.
struct CameraWalks<'r, 'a, S: Scene + ?Sized>(&'r Pairs<'a, S>);

/// Walks from the light of the samples that have more than this number.
struct LightSubpaths<'r, 'a, S: Scene + ?Sized>(&'r Pairs<'a, S>, u32);

impl<'a, S: Scene + ?Sized> Run<'a, S> for Pairs<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.set
    }

    fn notes(&self) -> Notes {
        Notes { left_out: self.left_out, ..Notes::default() }
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        self.trace(samples, sink, scratch, &mut |path, contribution, out, counters| {
            if contribution.technique.s == 0 {
                return out.add(&contribution);
            }
            counters.shadow_rays += 1;
            let ends = shadow_ray(path, out);
            out.connect(ends, contribution);
        });
    }
}

impl<'a, S: Scene + ?Sized> Steps<'a, S> for CameraWalks<'_, 'a, S> {
    const KEEPS: bool = true;

    #[inline]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        site.subpaths.camera.clear();
        if !self.0.set.has_camera_subpath() {
            return None;
        }
        let (walk, lens) = self.0.stage.camera_walk(site.sample)?;
        site.subpaths.camera.push(lens);
        (self.0.set.bsdf_sampling || self.0.depth.limit() > 0).then_some(walk)
    }

    #[inline]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        // The last vertex can only be hit: a connection needs one scattering event more.
        let connected = u32::from(!self.0.set.bsdf_sampling);
        visit.limit(self.0.depth.limit().saturating_sub(connected))?;
        visit.scatter(&self.0.roulette).flow()
    }
}

impl<'a, S: Scene + ?Sized> Steps<'a, S> for LightSubpaths<'_, 'a, S> {
    const KEEPS: bool = true;

    #[inline]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let Self(Pairs { stage, depth, .. }, number) = self;
        let Site { sample, subpaths, counters, .. } = site;
        subpaths.light.clear();
        if *number >= subpaths.light_subpaths {
            return None;
        }
        let (walk, start) = RandomWalk::from_light(stage.scene, &mut sample.sampler, counters)?;
        subpaths.light.push(start);
        let has_use =
            stage.needs.contains(Needs::FINITE_LOBES) && depth.limit() >= self.connection();
        walk?.if_useful(has_use, counters)
    }

    #[inline]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.limit(self.0.depth.limit().saturating_sub(self.connection()))?;
        visit.scatter(&self.0.roulette).flow()
    }
}

impl<S: Scene + ?Sized> LightSubpaths<'_, '_, S> {
    /// Number of scattering events of the shortest connection: one to the lens, two to a camera
    /// subpath.
    fn connection(&self) -> u32 {
        if self.0.set.lens_sampling { 1 } else { 2 }
    }
}

impl<'a, S: Scene + ?Sized> Pairs<'a, S> {
    /// Draws samples and offers each path that may contribute, with its contribution if it is
    /// visible.
    #[inline]
    fn trace<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
        offer: &mut impl FnMut(&Path<'_, 'a, S>, Contribution, &mut Out<'_>, &mut Counters),
    ) {
        let scene = self.stage.scene;
        scratch.counters.samples += samples.len() as u64;
        advance(scene, &CameraWalks(self), samples, sink, scratch);
        let mut rounds = 0;
        join(scene, samples, sink, scratch, |site| {
            self.finish_camera_subpath(site.subpaths);
            for t in 2..=site.subpaths.camera.len() {
                (0..2).for_each(|s| self.draw_technique((s, t), site, offer));
            }
            site.subpaths.light_subpaths = self.draw_light_walks(&mut site.sample.sampler);
            rounds = rounds.max(site.subpaths.light_subpaths);
        });
        for number in 0..rounds {
            advance(scene, &LightSubpaths(self, number), samples, sink, scratch);
            join(scene, samples, sink, scratch, |site| {
                self.finish_light_subpath(site.subpaths);
                for t in 1..=site.subpaths.camera.len().max(1) {
                    let first = if t == 1 { 1 } else { 2 };
                    (first..=site.subpaths.light.len())
                        .for_each(|s| self.draw_technique((s, t), site, offer));
                }
            });
        }
    }

    fn draw_light_walks<P: Sampler>(&self, sampler: &mut P) -> u32 {
        if !self.set.has_light_subpath() {
            return 0;
        }
        self.set.light_subpaths.draw(|| {
            sampler.stream(Stream::Emission);
            sampler.next_1d()
        })
    }

    /// Draws with one technique, given the subpaths.
    #[inline]
    fn draw_technique<P: Sampler>(
        &self,
        (s, t): (usize, usize),
        Site { sample: Sample { film, sampler }, subpaths, out, counters }: &mut Site<'_, 'a, S, P>,
        offer: &mut impl FnMut(&Path<'_, 'a, S>, Contribution, &mut Out<'_>, &mut Counters),
    ) {
        let technique = Technique::new(s as u16, t as u16);
        if !(self.depth.contains(technique.bounces().into()) && self.set.contains(technique)) {
            return;
        }
        let Stage { scene, camera, film: region, .. } = self.stage;
        let (from_camera, from_light) = (&subpaths.camera, &subpaths.light);
        let is_closed = |subpath: &[Vertex<_>], n: usize| n > 1 && !subpath[n - 1].is_connectible();
        if s > 0 && (is_closed(from_light, s) || is_closed(from_camera, t)) {
            return;
        }
        let sampled;
        let (camera_part, light_part): (&[_], &[_]) = match (s, t) {
            (0, _) => (&from_camera[..t], &[]),
            (_, 1) => {
                sampler.stream(Stream::LensSampling(s as u32 - 1));
                let lens = sample_lens(camera, &from_light[s - 1].point, sampler);
                let Some(lens) = lens else { return };
                sampled = [lens.vertex(scene, camera)];
                (&sampled, &from_light[..s])
            }
            (1, _) => {
                sampler.stream(Stream::NextEvent(t as u32 - 1));
                let emitter = sample_emitter(scene, &from_camera[t - 1].point, sampler);
                let Some(emitter) = emitter else { return };
                sampled = [emitter.vertex(scene, camera)];
                (&from_camera[..t], &sampled)
            }
            _ => (&from_camera[..t], &from_light[..s]),
        };
        counters.connections += u64::from(s > 0);
        let Some(path) = Path::new(scene, camera, camera_part, light_part) else { return };
        let raster =
            if t == 1 { path.lens_raster().map(|p| p - film.offset) } else { Some(film.raster) };
        let Some(raster) = raster.filter(|p| t > 1 || region.pixel_index(*p).is_some()) else {
            return;
        };
        let value = path.value() / self.set.count(technique);
        let weight = self.weighting.weight(&path);
        offer(&path, Contribution { raster, value, weight, technique }, out, counters);
    }

    /// Completes a camera subpath with what is known only now.
    fn finish_camera_subpath(&self, Subpaths { camera, .. }: &mut Subpaths<'a, S>) {
        if let [lens, first, ..] = &mut camera[..] {
            lens.start.connection = self.stage.camera.pdf_from(&first.point, &lens.point);
        }
        self.weighting.complete_camera_subpath(camera);
    }

    /// Completes a light subpath with what is known only now.
    fn finish_light_subpath(&self, Subpaths { light, .. }: &mut Subpaths<'a, S>) {
        let scene = self.stage.scene;
        if let [start, first, ..] = &mut light[..]
            && let Some(id) = start.light
        {
            let connection = scene.light(id).pdf_from(&first.point, &start.point);
            start.start.connection = connection * scene.pick_pmf_for(&first.point, id);
            self.weighting.complete_light_subpath(light, scene.light(id));
        }
    }
}

/// The ends of the shadow ray of a path that was connected.
#[inline]
fn shadow_ray<S: Scene + ?Sized>(path: &Path<'_, '_, S>, out: &mut Out<'_>) -> [End; 2] {
    let Technique { s, t, .. } = path.technique();
    let near = if t == 1 { out.keep(&path.vertex(0).point) } else { End::Camera(u32::from(t) - 1) };
    let far = match path.facing() {
        Some(facing) => out.keep(&facing),
        // The light subpath knows nothing of a sampled point.
        None if s == 1 => out.keep(&path.vertex(t.into()).point),
        None => End::Light(u32::from(s) - 1),
    };
    [near, far]
}
