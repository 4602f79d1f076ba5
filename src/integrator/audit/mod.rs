//! The audit of one path: all that makes up its contribution, as a teacher puts it on the board.

mod audited_path;
mod paths;

pub use audited_path::{AuditedPath, AuditedTechnique};

use super::{Caller, Integrator, IntegratorError, Merging, Run, Stage, VertexConnectionMerging};
use crate::endpoint::Camera;
use crate::film::{Contribution, FilmSample, Sample, Technique};
use crate::path::{Obstacle, Scratch};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::{Needs, Scene};
use glam::{DVec2, UVec2};
use std::cell::Cell;
use std::ops::ControlFlow;

/// The search for one path to look at, among those that an integrator draws.
///
/// ```
/// use pathspace::film::Technique;
/// use pathspace::gallery;
/// use pathspace::glam::UVec2;
/// use pathspace::integrator::{Audit, Bidirectional, Depth};
/// use std::ops::ControlFlow;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = gallery::build("cornell-box", UVec2::splat(64))?;
/// let mut audit = Audit { technique: Some(Technique::new(2, 2)), ..Audit::default() };
/// audit.integrator.bidirectional.depth = Depth::exactly(2);
/// let go_on = &mut || ControlFlow::Continue(());
/// let path = audit.find(&scene.world, &scene.camera, go_on)?.ok_or("stopped")?;
/// // T_1 and T_2, on the way to the contribution We · G(x_0, x_1) · T_2 · Le.
/// assert_eq!(path.record.throughputs().count(), 2);
/// for technique in path.techniques() {
///     match technique.obstacle {
///         None => println!("{}: w = {}", technique.technique, technique.weight),
///         Some(reason) => println!("{}: {reason}", technique.technique),
///     }
/// }
/// let sum: f64 = path.techniques().map(|technique| technique.weight).sum();
/// assert!((sum - 1.0).abs() < 1e-12 && path.verification.worst() < 1e-9);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Audit {
    /// Path lengths, techniques, weights and merges. If any light walks merge, nothing is left out
    /// that the scene does not need: merges are shown everywhere. As many samples share the light
    /// walks of a pass as there are such walks.
    pub integrator: VertexConnectionMerging,
    /// The technique that must have drawn the path; `None` for any.
    pub technique: Option<Technique>,
    /// The pixel, column and row, that the path must be seen in; `None` for any.
    pub pixel: Option<UVec2>,
    /// Number of paths that fit, in the order in which they are drawn, of which the one with the
    /// largest weighted contribution is taken: the first one may matter to no image. After the
    /// first, a thousand samples at most are drawn for more.
    pub candidates: u32,
    /// Number of samples after which the search is given up.
    pub max_samples: u32,
    /// The seed; another one finds another path.
    pub seed: u64,
}

/// Samples that are drawn after the first path that fits.
const FURTHER: u32 = 1000;

/// The brightest of 32 paths of any length by any technique (s, t); no merges.
impl Default for Audit {
    fn default() -> Self {
        let merging = Merging { light_walks: Some(0), ..Merging::default() };
        Self {
            integrator: VertexConnectionMerging { merging, ..VertexConnectionMerging::default() },
            technique: None,
            pixel: None,
            candidates: 32,
            max_samples: 10_000_000,
            seed: 0,
        }
    }
}

impl Audit {
    /// The path; `None` if `ask`, which is called before each sample, stops the search before one
    /// fits.
    ///
    /// # Errors
    /// If the pixel is not on the film, the technique cannot be drawn, the integrator refuses its
    /// settings, or no path fits.
    pub fn find<S: Scene + ?Sized>(
        &self,
        scene: &S,
        camera: &dyn Camera,
        ask: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Option<AuditedPath>, AuditError> {
        let film = camera.film();
        let corner = self.pixel.map(UVec2::as_dvec2);
        if let Some(pixel) = self.pixel
            && film.pixel_index(pixel.as_dvec2()).is_none()
        {
            return Err(AuditError::Pixel { pixel, resolution: film.resolution });
        }
        let shared = self.integrator.merging.light_walks(film.pixels());
        let needs = if shared > 0 { Needs::ALL } else { scene.needs() };
        let stage = Stage { needs, seed: self.seed, ..Stage::new(scene, camera) };
        let mut run = Integrator::<S>::start(&self.integrator, stage, &Caller)?;
        run.keep_subpaths();
        let (depth, left_out) = (run.pairs.plan.depth, run.pairs.plan.left_out);
        if let Some(technique) = self.technique {
            if !technique.exists() {
                return Err(AuditError::NoTechnique { technique });
            }
            if !depth.contains(technique.bounces().into()) {
                return Err(AuditError::Length { technique });
            }
            if let Some(obstacle) = run.techniques().obstacle(technique, &left_out) {
                return Err(AuditError::NotDrawn { technique, obstacle });
            }
        }
        let fits = |found: &Contribution| {
            corner.is_none_or(|corner| found.raster.floor() == corner)
                && self.technique.is_none_or(|wanted| found.technique == wanted)
        };
        let (source, mut scratch) = (Independent { seed: self.seed }, Scratch::default());
        let (choice, chosen) = (Choice::among(self.candidates), Cell::new(None));
        let (mut sample, mut end) = (0, self.max_samples);
        while sample < end && !choice.is_made() {
            if ask().is_break() {
                return Ok(chosen.into_inner());
            }
            if run.prepares() && sample % shared == 0 {
                run.begin_pass(sample / shared, &Caller)?;
            }
            let weighting = *run.weighting();
            let mut sampler = source.sampler(sample, 0);
            let u = sampler.next_2d();
            // Camera walks start in the pixel; light walks must happen to meet it.
            let raster = corner.map_or_else(|| film.from_window(u), |corner| corner + u);
            let film = FilmSample { raster, offset: DVec2::ZERO };
            let choose = |found: &Contribution, distance, record, survival, verification| {
                let Contribution { raster, value, weight, technique } = *found;
                chosen.set(Some(AuditedPath {
                    sample,
                    technique,
                    raster,
                    record,
                    survival,
                    value,
                    weight,
                    distance,
                    verification,
                    weighting,
                    left_out,
                }));
            };
            run.for_each_path(
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, found| {
                    if fits(found) && choice.prefers(found) {
                        let verification = path.verify(&weighting);
                        choose(found, None, path.record(), path.survival(), verification);
                    }
                },
                |path, found| {
                    if fits(found) && choice.prefers(found) {
                        let [y, z] = [path.vertex(path.meeting()), path.photon()];
                        let distance = Some(y.point.position.distance(z.point.position));
                        let verification = path.verify(&weighting);
                        choose(found, distance, path.record(), path.survival(), verification);
                    }
                },
            );
            sample += 1;
            if choice.has_one() {
                end = end.min(sample.saturating_add(FURTHER));
            }
        }
        let samples = self.max_samples;
        chosen.into_inner().map_or(Err(AuditError::NotFound { samples }), |path| Ok(Some(path)))
    }
}

/// The choice among paths that fit, as they come.
#[derive(Debug)]
struct Choice {
    left: Cell<u32>,
    brightest: Cell<Option<f64>>,
}

impl Choice {
    fn among(candidates: u32) -> Self {
        Self { left: Cell::new(candidates.max(1)), brightest: Cell::new(None) }
    }

    /// True if the next path that fits is the brightest so far.
    fn prefers(&self, found: &Contribution) -> bool {
        let Some(left) = self.left.get().checked_sub(1) else { return false };
        self.left.set(left);
        let luminance = (found.value * found.weight).luminance();
        let is_preferred = self.brightest.get().is_none_or(|brightest| luminance > brightest);
        if is_preferred {
            self.brightest.set(Some(luminance));
        }
        is_preferred
    }

    fn has_one(&self) -> bool {
        self.brightest.get().is_some()
    }

    fn is_made(&self) -> bool {
        self.left.get() == 0
    }
}

/// The reason why there is no path to look at.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AuditError {
    /// The pixel is not rendered.
    #[error(
        "pixel {},{} is not on the film of {} x {} pixels, or not in its window",
        pixel.x, pixel.y, resolution.x, resolution.y
    )]
    Pixel {
        /// The pixel.
        pixel: UVec2,
        /// The resolution of the film.
        resolution: UVec2,
    },
    /// There is no such technique.
    #[error("there is no technique {technique}: t ≥ 1, and merges have s ≥ 2 and t ≥ 2")]
    NoTechnique {
        /// The technique.
        technique: Technique,
    },
    /// The technique draws paths of a length that does not count.
    #[error("technique {technique} draws paths with {} bounces, which do not count here", technique.bounces())]
    Length {
        /// The technique.
        technique: Technique,
    },
    /// The technique is not among those that the integrator runs on the scene.
    #[error("technique {technique} draws nothing here: {obstacle}")]
    NotDrawn {
        /// The technique.
        technique: Technique,
        /// The reason.
        obstacle: Obstacle,
    },
    /// The integrator cannot render the scene.
    #[error(transparent)]
    Integrator(#[from] IntegratorError),
    /// No path fits.
    #[error("no path that fits in {samples} samples")]
    NotFound {
        /// The number of samples.
        samples: u32,
    },
}
