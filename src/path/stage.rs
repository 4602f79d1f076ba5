//! The subject of a rendering, and what is drawn of it.

use super::{Depth, LeftOut, RandomWalk, TechniqueSet, Vertex};
use crate::endpoint::{Camera, LightId};
use crate::film::{FilmRegion, Kernel, Sample, Technique};
use crate::geometry::SurfacePoint;
use crate::light_tree::{Arrival, LightTree};
use crate::sampler::Sampler;
use crate::scene::{Needs, Scene};
use std::fmt;

/// Scene, camera and everything else that is the same for all samples of a rendering.
pub struct Stage<'a, S: Scene + ?Sized> {
    /// The scene.
    pub scene: &'a S,
    /// The camera.
    pub camera: &'a dyn Camera,
    /// The camera's film.
    pub film: FilmRegion,
    /// The kernel of the pixel filter.
    pub kernel: Kernel,
    /// The features that the scene needs. An integrator leaves out the rest.
    pub needs: Needs,
    /// Samples that the rendering will take over all pixels, as far as that is known.
    pub samples: u64,
    /// The rendering's seed, for random numbers that are not those of samples.
    pub seed: u64,
    /// The light that arrives in the picture, by which the choice of lights is scaled where the
    /// scene has a [tree](Scene::light_tree) of them.
    pub arrival: Option<&'a Arrival>,
}

impl<'a, S: Scene + ?Sized> Stage<'a, S> {
    /// A stage with a box filter, 64 samples per pixel and seed 0, where nothing is known of the
    /// light that arrives.
    pub fn new(scene: &'a S, camera: &'a dyn Camera) -> Self {
        let film = camera.film();
        Self {
            scene,
            camera,
            film,
            kernel: Kernel::default(),
            needs: scene.needs(),
            samples: 64 * u64::from(film.pixels()),
            seed: 0,
            arrival: None,
        }
    }

    /// The same stage with a view of its scene, and the needs of that. Both have the same lights.
    pub fn viewed<'v, V: Scene + ?Sized>(&self, scene: &'v V, needs: Needs) -> Stage<'v, V>
    where
        'a: 'v,
    {
        let Self { camera, film, kernel, samples, seed, arrival, .. } = *self;
        Stage { scene, camera, film, kernel, needs, samples, seed, arrival }
    }

    /// Chooses the light at which a walk starts; see [`Scene::pick_light`].
    #[inline]
    #[must_use]
    pub fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        match self.tree() {
            Some((tree, arrival)) => of_light(tree.sample_regardless(Some(arrival), u)),
            None => self.scene.pick_light(u),
        }
    }

    /// The probability with which `pick_light` chooses a light.
    #[inline]
    #[must_use]
    pub fn pick_pmf(&self, id: LightId) -> f64 {
        match self.tree() {
            Some((tree, arrival)) => tree.pmf_regardless(Some(arrival), id.0),
            None => self.scene.pick_pmf(id),
        }
    }

    /// Chooses a light to connect `receiver` to; see [`Scene::pick_light_for`].
    #[inline]
    #[must_use]
    pub fn pick_light_for(&self, receiver: &SurfacePoint, u: f64) -> Option<(LightId, f64)> {
        match self.tree() {
            Some((tree, arrival)) => of_light(tree.sample(receiver, Some(arrival), u)),
            None => self.scene.pick_light_for(receiver, u),
        }
    }

    /// The probability with which `pick_light_for` chooses a light for the same receiver.
    #[inline]
    #[must_use]
    pub fn pick_pmf_for(&self, receiver: &SurfacePoint, id: LightId) -> f64 {
        match self.tree() {
            Some((tree, arrival)) => tree.pmf(receiver, Some(arrival), id.0),
            None => self.scene.pick_pmf_for(receiver, id),
        }
    }

    /// The light that is chosen for certain, because there is no other.
    #[inline]
    pub(super) fn only_light(&self) -> Option<LightId> {
        let only = self.scene.light_tree()?.only().map(LightId)?;
        self.pick_light(0.0).filter(|choice| *choice == (only, 1.0)).map(|_| only)
    }

    #[inline]
    fn tree(&self) -> Option<(&'a LightTree, &'a Arrival)> {
        self.arrival.and_then(|arrival| Some((self.scene.light_tree()?, arrival)))
    }

    /// Starts the camera walk of a sample; with the vertex on the lens.
    #[inline(always)]
    pub fn camera_walk<P: Sampler>(
        &self,
        Sample { film, sampler }: &mut Sample<P>,
    ) -> Option<(RandomWalk<'a, S>, Vertex<S::Bsdf<'a>>)> {
        let u = self.film.to_window(film.raster + film.offset);
        RandomWalk::from_camera(self.scene, self.camera, u, sampler)
    }
}

#[inline]
fn of_light(choice: Option<(u32, f64)>) -> Option<(LightId, f64)> {
    choice.map(|(item, pmf)| (LightId(item), pmf))
}

impl<S: Scene + ?Sized> Clone for Stage<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Scene + ?Sized> Copy for Stage<'_, S> {}

impl<S: Scene + ?Sized> fmt::Debug for Stage<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stage")
            .field("film", &self.film)
            .field("needs", &self.needs)
            .field("samples", &self.samples)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

/// The techniques and path lengths that a run draws on a stage.
pub struct Plan<'a, S: Scene + ?Sized> {
    /// The subject of the rendering.
    pub stage: Stage<'a, S>,
    /// The techniques that draw paths.
    pub techniques: TechniqueSet,
    /// The path lengths that count and that the scene has light for.
    pub depth: Depth,
    /// The techniques that the stage does not need, and why.
    pub left_out: LeftOut,
}

impl<'a, S: Scene + ?Sized> Plan<'a, S> {
    /// Techniques and path lengths, less what the stage does not need.
    pub fn new(stage: Stage<'a, S>, techniques: TechniqueSet, depth: Depth) -> Self {
        // Its weights would make room for what nobody can draw.
        let lens_is_lost = techniques.lens_sampling && !stage.camera.can_be_connected();
        let drawable =
            TechniqueSet { lens_sampling: techniques.lens_sampling && !lens_is_lost, ..techniques };
        let left_out = drawable.left_out(&stage.needs);
        Self {
            stage,
            techniques: drawable.pruned(&stage.needs),
            depth: depth.within(&stage.needs),
            left_out: if lens_is_lost { left_out.without_lens() } else { left_out },
        }
    }

    /// True if paths are drawn by a technique.
    #[inline]
    #[must_use]
    pub fn draws(&self, technique: Technique) -> bool {
        self.depth.contains(technique.bounces().into()) && self.techniques.contains(technique)
    }
}

impl<S: Scene + ?Sized> fmt::Debug for Plan<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Plan")
            .field("stage", &self.stage)
            .field("techniques", &self.techniques)
            .field("depth", &self.depth)
            .finish_non_exhaustive()
    }
}
