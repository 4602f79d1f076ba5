//! Bidirectional path tracing: one walk from the camera and one from a light, and every way to join a part of the one to a part of the
//! other (Lafortune and Willems 1993; Veach and Guibas 1994). Restricted to a set of techniques it is any of the incremental integrators:
//! the general kernel that the dedicated ones are tested against.

use super::{Depth, Integrator};
use crate::endpoint::{Camera, Endpoint};
use crate::film::{Contribution, FilmSample, Sink};
use crate::math::Rgb;
use crate::path::{Counters, Heuristic, Path, RandomWalk, Roulette, Scratch, TechniqueSet, Vertex, sample_emitter, sample_lens};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, Scene};

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
        let Scratch { counters, camera: camera_vertices, light: light_vertices } = scratch;
        counters.samples += 1;
        let set = self.techniques.pruned(&scene.needs());
        let region = camera.film();
        self.walk_from_camera(scene, camera, film, &set, sampler, camera_vertices, counters);
        self.walk_from_light(scene, &set, sampler, light_vertices, counters);

        let mut offer = |path: Option<Path<'_, 's, S, C>>, raster, counters: &mut Counters| {
            if let Some(path) = path
                && path.is_visible(counters)
            {
                let weight = path.weight(&set, self.heuristic);
                visit(&path, &Contribution { raster, value: path.value(), weight, technique: path.technique() });
            }
        };
        for t in 2..=camera_vertices.len() {
            let part = &camera_vertices[..t];
            // Scattering events of the path (s, t).
            let bounces = |s: usize| (s + t - 2) as u32;
            if set.emitter_hits && self.depth.contains(bounces(0)) && set.contains(technique(0, t)) {
                offer(Path::hit(scene, camera, part), film.raster, counters);
            }
            if !part[t - 1].is_connectible() {
                continue;
            }
            if self.depth.contains(bounces(1)) && set.contains(technique(1, t)) {
                sampler.stream(Stream::EmitterSampling(t as u32 - 1));
                if let Some(emitter) = sample_emitter(scene, &part[t - 1].point, sampler) {
                    let light_part = [emitter];
                    offer(Path::connect(scene, camera, part, &light_part), film.raster, counters);
                }
            }
            for s in 2..=light_vertices.len() {
                if self.depth.contains(bounces(s)) && set.contains(technique(s, t)) && light_vertices[s - 1].is_connectible() {
                    offer(Path::connect(scene, camera, part, &light_vertices[..s]), film.raster, counters);
                }
            }
        }
        for s in 1..=light_vertices.len() {
            let part = &light_vertices[..s];
            let connectible = s == 1 || part[s - 1].is_connectible();
            if !connectible || !self.depth.contains(s as u32 - 1) || !set.contains(technique(s, 1)) {
                continue;
            }
            sampler.stream(Stream::LensSampling(s as u32 - 1));
            let Some(lens) = sample_lens(camera, &part[s - 1].point, sampler) else { continue };
            let camera_part: [Vertex<S::Bsdf<'s>>; 1] = [lens];
            let path = Path::connect(scene, camera, &camera_part, part);
            let raster = path.as_ref().and_then(|path| {
                let direction = path.joint()?.direction;
                Some(camera.raster(&camera_part[0].point, direction)? - film.offset)
            });
            if let Some(raster) = raster
                && region.pixel_index(raster).is_some()
            {
                offer(path, raster, counters);
            }
        }
    }

    #[expect(clippy::too_many_arguments, reason = "a part of one function, split off for reading")]
    fn walk_from_camera<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        set: &TechniqueSet,
        sampler: &mut P,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
        counters: &mut Counters,
    ) {
        vertices.clear();
        if !set.has_camera_walk() {
            return;
        }
        let u = camera.film().to_window(film.raster + film.offset);
        let Some((walk, lens)) = RandomWalk::from_camera(scene, camera, u, sampler) else { return };
        vertices.push(lens);
        // The last vertex can only be hit: a connection needs one scattering event more.
        let last = u32::from(!set.emitter_hits);
        if let Some(limit) = self.depth.limit().checked_sub(last) {
            walk.record(vertices, limit, &self.walk_roulette(), sampler, counters);
        }
        if let [lens, first, ..] = &mut vertices[..] {
            lens.start.connection = camera.pdf_from(&first.point, &lens.point);
        }
    }

    fn walk_from_light<'s, S: Scene + ?Sized, P: Sampler>(
        &self,
        scene: &'s S,
        set: &TechniqueSet,
        sampler: &mut P,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
        counters: &mut Counters,
    ) {
        vertices.clear();
        if !set.has_light_walk() {
            return;
        }
        let Some((walk, start)) = RandomWalk::from_light(scene, sampler, counters) else { return };
        let light = start.light;
        vertices.push(start);
        // A light walk's vertex is connected, never hit; to the lens at the cost of one scattering event, to a camera walk of two.
        let last = if set.lens_sampling { 1 } else { 2 };
        let Some(limit) = self.depth.limit().checked_sub(last) else { return };
        if let Some(walk) = walk {
            walk.record(vertices, limit, &self.walk_roulette(), sampler, counters);
        }
        if let ([start, first, ..], Some(id)) = (&mut vertices[..], light) {
            start.start.connection = scene.light(id).pdf_from(&first.point, &start.point) * scene.pick_pmf(id);
        }
    }

    fn walk_roulette(&self) -> Roulette {
        Roulette { constant: Rgb::BLACK, ..self.roulette }
    }
}

fn technique(s: usize, t: usize) -> crate::film::Technique {
    crate::film::Technique { s: s as u16, t: t as u16 }
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
        self.for_each_path(scene, camera, film, sampler, scratch, |_, contribution| sink.add(contribution));
    }
}
