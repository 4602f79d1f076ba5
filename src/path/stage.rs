//! The subject of a rendering, and what is drawn of it.

use super::{Depth, LeftOut, RandomWalk, TechniqueSet, Vertex};
use crate::endpoint::Camera;
use crate::film::{FilmRegion, Kernel, Sample};
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
}

impl<'a, S: Scene + ?Sized> Stage<'a, S> {
    /// A stage with a box filter, 64 samples per pixel and seed 0.
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
        }
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
        Self {
            stage,
            techniques: techniques.pruned(&stage.needs),
            depth: depth.within(&stage.needs),
            left_out: techniques.left_out(&stage.needs),
        }
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
