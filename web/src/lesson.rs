//! A scene with its camera, as the sliders want it.

use crate::{Fallible, outline};
use glam::{DVec2, DVec3, UVec2};
use pathspace::endpoint::Camera;
use pathspace::film::Filter;
use pathspace::gallery::{self, GalleryScene};
use pathspace::import::{self, Options};
use pathspace::integrator::{
    Caller, Depth, Integrator, Merging, Run, Stage, VertexConnectionMerging,
};
use pathspace::scene::{Needs, Variation, World};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A scene of the gallery, or a file.
#[derive(Clone, Debug, Deserialize)]
pub struct SceneJob {
    /// A name of the gallery, or `file`.
    pub scene: String,
    /// The name of the file.
    #[serde(default)]
    pub name: String,
    /// Width of the film in pixels; of a file's, the most.
    pub width: u32,
    /// Height of the film in pixels; of a file's, the most.
    pub height: u32,
    /// The most scattering events; `None` for the scene's own.
    pub depth: Option<u32>,
    /// The factor by which lamps are scaled.
    #[serde(default = "one")]
    pub light_size: f64,
    /// The roughness α of mirrors, metals, glass and coats; `None` for their own.
    pub roughness: Option<f64>,
}

fn one() -> f64 {
    1.0
}

/// The facts about a scene that the page shows.
#[derive(Clone, Debug, Serialize)]
pub struct Summary<'a> {
    name: &'a str,
    description: &'a str,
    width: u32,
    height: u32,
    depth: Option<u32>,
    warnings: &'a [String],
    triangles: usize,
    lights: usize,
    min: [f64; 3],
    max: [f64; 3],
    eye: Option<[f64; 3]>,
    radius: Option<f64>,
}

/// A scene with its camera.
pub struct Lesson {
    name: String,
    description: String,
    warnings: Vec<String>,
    depth: Option<u32>,
    pub(crate) world: World,
    pub(crate) camera: Box<dyn Camera + Send>,
    pub(crate) filter: Filter,
}

impl std::fmt::Debug for Lesson {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lesson").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Lesson {
    /// The scene of a job; of a file, its bytes.
    ///
    /// # Errors
    /// There is no such scene, the file cannot be read, or a number is out of range.
    pub fn new(job: &SceneJob, file: Option<&[u8]>) -> Fallible<Self> {
        let size = UVec2::new(job.width, job.height);
        let variation = Variation { light_size: job.light_size, roughness: job.roughness };
        let mut lesson = match file {
            Some(bytes) => Self::read(&job.name, bytes, size, variation)?,
            None if job.scene == "file" => return Err("no file is given".to_owned()),
            None => gallery::build_varied(&job.scene, size, variation)
                .map(Self::from)
                .map_err(|error| error.to_string())?,
        };
        lesson.depth = job.depth.or(lesson.depth);
        Ok(lesson)
    }

    fn read(name: &str, bytes: &[u8], size: UVec2, variation: Variation) -> Fallible<Self> {
        let options = Options { variation, size: Some(size), ..Options::default() };
        let import = import::gltf::from_slice(name, bytes, size, &options)
            .map_err(|error| error.to_string())?;
        let warnings = import.warnings.iter().map(ToString::to_string);
        let warnings = warnings.chain(import.world.warnings().iter().map(ToString::to_string));
        let warnings = warnings.chain(import.notes.iter().cloned()).collect();
        let view = import.views.into_iter().next().ok_or("the file has no camera")?;
        Ok(Self {
            name: name.to_owned(),
            description: format!("Scene of a file, seen by its camera {}.", view.name),
            warnings,
            depth: import.hints.max_bounces,
            world: import.world,
            camera: view.camera,
            filter: view.filter,
        })
    }

    /// The path lengths that are rendered.
    pub(crate) fn depths(&self) -> Depth {
        Depth { min_bounces: 0, max_bounces: self.depth }
    }

    /// Facts about the scene.
    #[must_use]
    pub fn summary(&self) -> Summary<'_> {
        let bounds = self.world.bounds();
        let size = self.camera.film().window_size();
        let lens = self.camera.sample_point(0.5, DVec2::splat(0.5));
        Summary {
            name: &self.name,
            description: &self.description,
            width: size.x,
            height: size.y,
            depth: self.depth,
            warnings: &self.warnings,
            triangles: self.world.primitive_count(),
            lights: self.world.light_count(),
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
            eye: lens.map(|lens| lens.point.position.to_array()),
            radius: self.radius(),
        }
    }

    /// The radius within which subpaths merge in the first pass unless a job says otherwise.
    fn radius(&self) -> Option<f64> {
        let merging = Merging { light_walks: Some(1), ..Merging::default() };
        let integrator = VertexConnectionMerging { merging, ..VertexConnectionMerging::default() };
        let stage = Stage { needs: Needs::ALL, ..Stage::new(&self.world, &*self.camera) };
        let mut run = Integrator::start(&integrator, stage, &Caller).ok()?;
        run.begin_pass(0, &Caller).ok()?;
        Some((run.weighting().merge_area() / PI).sqrt())
    }

    /// The edges of the scene: segments of six numbers each.
    #[must_use]
    pub fn outline(&self) -> Vec<f32> {
        outline::of(&self.world)
    }

    /// The positions in the picture of points in space, three numbers each; NaN behind the lens.
    #[must_use]
    pub fn project(&self, points: &[f64]) -> Vec<f64> {
        let raster =
            |x: &[f64; 3]| self.raster(DVec3::from_array(*x)).unwrap_or(DVec2::NAN).to_array();
        points.as_chunks().0.iter().flat_map(raster).collect()
    }

    /// The position in the picture, in pixels, of a point in space, hidden or not.
    pub(crate) fn raster(&self, position: DVec3) -> Option<DVec2> {
        let window = self.camera.film().window_min.as_dvec2();
        self.camera.project(position).map(|raster| raster - window)
    }
}

impl From<GalleryScene> for Lesson {
    fn from(scene: GalleryScene) -> Self {
        Self {
            name: scene.name.to_owned(),
            description: scene.description.to_owned(),
            warnings: scene.world.warnings().iter().map(ToString::to_string).collect(),
            depth: scene.max_bounces,
            world: scene.world,
            camera: scene.camera,
            filter: Filter::Box,
        }
    }
}
