//! What a rendering is of, and who works on it.

use crate::endpoint::Camera;
use crate::film::{FilmRegion, Kernel, Sample};
use crate::path::{RandomWalk, Vertex};
use crate::sampler::Sampler;
use crate::scene::{Needs, Scene};
use std::fmt;
use std::sync::OnceLock;

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
    /// What the scene needs. An integrator leaves out the rest.
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

/// The threads of a rendering.
pub trait Crew: Sync {
    /// Calls a task with every number below `count`, each once, in any order and at the same time;
    /// returns when all are done.
    fn each(&self, count: usize, task: &(dyn Fn(usize) + Sync));
}

impl dyn Crew + '_ {
    /// What a task returns for every number below `count`, in the order of the numbers.
    pub fn collect<T: Send + Sync>(
        &self,
        count: usize,
        task: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        let slots: Vec<OnceLock<T>> = (0..count).map(|_| OnceLock::new()).collect();
        self.each(count, &|i| {
            slots[i].get_or_init(|| task(i));
        });
        slots.into_iter().filter_map(OnceLock::into_inner).collect()
    }
}

/// The calling thread alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Caller;

impl Crew for Caller {
    fn each(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(task);
    }
}
