//! One path on the board: every factor of its contribution, its throughput step by step, and what
//! each technique would have made of it.

use crate::Fallible;
use crate::catalogue::{bidirectional, merging};
use crate::lesson::Lesson;
use crate::techniques;
use glam::{DVec3, UVec2};
use pathspace::geometry::{Place, SurfacePoint};
use pathspace::integrator::{
    Audit, AuditError, AuditedPath, AuditedTechnique, Depth, Merging, VertexConnectionMerging,
};
use pathspace::math::Rgb;
use pathspace::path::PathDensities;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::time::Duration;
use web_time::Instant;

/// Time after which the search for a path is given up.
const PATIENCE: Duration = Duration::from_secs(10);
/// Light walks of a pass, which as many samples share.
const LIGHT_WALKS: u32 = 1 << 12;

/// The search for a path through a pixel.
#[derive(Clone, Debug, Deserialize)]
pub struct BoardJob {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Scattering events of the path; `None` for any number.
    pub bounces: Option<u32>,
    /// The technique that must have drawn it, as `s,t` or `merge s,t`.
    pub technique: Option<String>,
    /// True if subpaths merge, too.
    #[serde(default)]
    pub merges: bool,
    /// The seed; another one finds another path.
    #[serde(default)]
    pub seed: u64,
    /// The radius within which subpaths merge.
    pub radius: Option<f64>,
}

/// A path with all its factors, or the reason why there is none.
#[derive(Clone, Debug, Serialize)]
pub struct Board {
    found: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    #[serde(flatten)]
    path: Option<Path>,
}

#[derive(Clone, Debug, Serialize)]
struct Path {
    sample: u32,
    bounces: usize,
    technique: String,
    raster: [f64; 2],
    vertices: Vec<Vertex>,
    ends: Ends,
    steps: Vec<Step>,
    contribution: [f64; 3],
    techniques: Vec<Technique>,
    verification: Verification,
}

#[derive(Clone, Debug, Serialize)]
struct Vertex {
    position: [f64; 3],
    raster: Option<[f64; 2]>,
    normal: Option<[f64; 3]>,
    kind: &'static str,
    surface: Option<String>,
    factor_name: &'static str,
    factor: [f64; 3],
    /// Of the edge to the next vertex.
    g: Option<f64>,
    transmittance: Option<[f64; 3]>,
    towards_light: Option<f64>,
    towards_camera: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct Ends {
    camera: f64,
    camera_connection: f64,
    light: f64,
    light_connection: f64,
}

/// A step of the throughput, `T_k = f(x_k) G(x_k, x_{k+1}) T_{k-1}`.
#[derive(Clone, Debug, Serialize)]
struct Step {
    k: usize,
    factor: [f64; 3],
    g: f64,
    throughput: [f64; 3],
}

#[derive(Clone, Debug, Serialize)]
struct Technique {
    name: String,
    s: u16,
    t: u16,
    merged: bool,
    density: f64,
    estimate: Option<[f64; 3]>,
    weight: f64,
    possible: bool,
    reason: Option<String>,
}

#[derive(Clone, Debug, Serialize)]
struct Verification {
    value_error: f64,
    weight_error: f64,
    weight_sum_error: f64,
}

impl From<AuditedTechnique> for Technique {
    fn from(found: AuditedTechnique) -> Self {
        let AuditedTechnique { technique, density, estimate, weight, obstacle } = found;
        Self {
            name: techniques::name(technique),
            s: technique.s,
            t: technique.t,
            merged: technique.merged,
            density,
            estimate: estimate.map(|Rgb(estimate)| estimate),
            weight,
            possible: obstacle.is_none(),
            reason: obstacle.map(|obstacle| obstacle.to_string()),
        }
    }
}

impl Lesson {
    /// A path through a pixel, one of the brightest of those that are found first.
    ///
    /// # Errors
    /// The pixel is not in the picture, there is no such technique, or a number is out of range.
    pub fn path(&self, job: &BoardJob) -> Fallible<Board> {
        let depth = job.bounces.map_or(self.depths(), Depth::exactly);
        let merging = match job.merges {
            true => Merging { light_walks: Some(LIGHT_WALKS), ..merging(job.radius) },
            false => Merging { light_walks: Some(0), ..Merging::default() },
        };
        let audit = Audit {
            integrator: VertexConnectionMerging {
                bidirectional: bidirectional(depth),
                merging,
                ..VertexConnectionMerging::default()
            },
            technique: job.technique.as_deref().map(techniques::parse).transpose()?,
            pixel: Some(self.camera.film().window_min + UVec2::new(job.x, job.y)),
            seed: job.seed,
            ..Audit::default()
        };
        let start = Instant::now();
        let mut ask = || match start.elapsed() < PATIENCE {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        let none = |reason: String| Board { found: false, reason: Some(reason), path: None };
        Ok(match audit.find(&self.world, &*self.camera, &mut ask) {
            Ok(Some(path)) => Board { found: true, reason: None, path: Some(self.board(&path)) },
            Ok(None) => none(format!("no path that fits in {} s", PATIENCE.as_secs())),
            Err(error @ (AuditError::NotFound { .. } | AuditError::NotDrawn { .. })) => {
                none(error.to_string())
            }
            Err(error) => return Err(error.to_string()),
        })
    }

    fn board(&self, path: &AuditedPath) -> Path {
        let AuditedPath { record, verification, .. } = path;
        let k = record.edges();
        let steps = record.throughputs().zip(1..).map(|(throughput, i)| Step {
            k: i,
            factor: record.factors[i].0,
            g: record.geometry_terms[i],
            throughput: throughput.0,
        });
        Path {
            sample: path.sample,
            bounces: k - 1,
            technique: techniques::name(path.technique),
            raster: (path.raster - self.camera.film().window_min.as_dvec2()).to_array(),
            vertices: (0..=k).map(|i| self.vertex(path, i)).collect(),
            ends: Ends {
                camera: record.ends.camera,
                camera_connection: record.ends.camera_connection,
                light: record.ends.light,
                light_connection: record.ends.light_connection,
            },
            steps: steps.collect(),
            contribution: record.contribution().0,
            techniques: path.techniques().map(Technique::from).collect(),
            verification: Verification {
                value_error: verification.value_error,
                weight_error: verification.weight_error,
                weight_sum_error: verification.weight_sum_error,
            },
        }
    }

    fn vertex(&self, AuditedPath { record, .. }: &AuditedPath, i: usize) -> Vertex {
        let (k, x) = (record.edges(), &record.points[i]);
        let position = self.shown(&record.points, i);
        Vertex {
            position: position.to_array(),
            raster: self.raster(position).map(|raster| raster.to_array()),
            normal: (x.place != Place::Dirac).then(|| x.shading_normal.to_array()),
            kind: record.vertex_kind(i),
            surface: if i == 0 { None } else { self.world.surface_name(x).map(str::to_owned) },
            factor_name: record.factor_symbol(i),
            factor: record.factors[i].0,
            g: (i < k).then(|| record.geometry_terms[i]),
            transmittance: (i < k).then(|| record.transmittances[i].0),
            towards_light: (i < k).then(|| record.towards_light[i]),
            towards_camera: (i > 0).then(|| record.towards_camera[i]),
        }
    }

    /// The position of a vertex; of one at infinity, a place in its direction beyond the scene.
    fn shown(&self, points: &[SurfacePoint], i: usize) -> DVec3 {
        let x = &points[i];
        if x.place != Place::Infinite {
            return x.position;
        }
        let neighbour = if i == 0 { points.get(1) } else { points.get(i - 1) };
        let from = neighbour.map_or(DVec3::ZERO, |neighbour| neighbour.position);
        let bounds = self.world.bounds();
        from - x.geometric_normal * (bounds.max - bounds.min).length()
    }
}
