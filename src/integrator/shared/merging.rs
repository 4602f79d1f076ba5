//! The settings of merging: a radius that shrinks from pass to pass, and where it begins.

use crate::film::{Contribution, FilmSample, Sample};
use crate::geometry::Place;
use crate::integrator::IntegratorError;
use crate::path::{
    Depth, Plan, RandomWalk, Scratch, Site, Stage, Steps, TechniqueSet, Vertex, Visit, advance,
    join,
};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::Scene;
use std::ops::ControlFlow;

/// The merging of camera subpaths with the light subpaths of a pass, which all pixels share, within
/// a radius that shrinks from pass to pass:
///
/// ```text
/// r_i² = r_1² i^(α-1),    i = 1, 2, …
/// ```
///
/// The image is the mean of the passes. After J of them its bias is proportional to `r_1² J^(α-1)`
/// and its variance to `J^(-α) / r_1²`, so that with α = 2/3 both bias and standard deviation fall
/// as J^(-1/3) (Knaus and Zwicker 2011; Kaplanyan and Dachsbacher 2013). With α = 1 the radius is
/// fixed, and so is the bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merging {
    /// r_1, in units of the scene; `None` for twice the footprint of a pixel on what the camera
    /// sees, the square root of the area that it covers, or 1 if it sees no surface.
    pub radius: Option<f64>,
    /// α, in (0, 1].
    pub alpha: f64,
    /// Light walks of a pass; `None` for as many as there are pixels, up to 2¹⁸, whose photons take
    /// some hundred megabytes. Without any, nothing is merged.
    pub light_walks: Option<u32>,
}

/// A radius that shrinks from twice the footprint of a pixel.
impl Default for Merging {
    fn default() -> Self {
        Self { radius: None, alpha: 2.0 / 3.0, light_walks: None }
    }
}

impl Merging {
    /// A radius that shrinks from this one.
    #[must_use]
    pub fn from_radius(radius: f64) -> Self {
        Self { radius: Some(radius), ..Self::default() }
    }

    /// The same radius in all passes.
    #[must_use]
    pub fn fixed(radius: f64) -> Self {
        Self { alpha: 1.0, ..Self::from_radius(radius) }
    }

    /// Light walks of a pass over a number of pixels.
    #[must_use]
    pub fn light_walks(&self, pixels: u32) -> u32 {
        self.light_walks.unwrap_or(pixels.min(1 << 18))
    }

    /// The radius in a pass, given the first one; passes are numbered from 0.
    #[must_use]
    pub fn radius_in(&self, pass: u32, first: f64) -> f64 {
        first * libm::pow(f64::from(pass) + 1.0, 0.5 * (self.alpha - 1.0))
    }

    /// The first radius on a stage.
    pub(super) fn first_radius<S: Scene + ?Sized>(
        &self,
        stage: Stage<'_, S>,
        integrator: &'static str,
    ) -> Result<f64, IntegratorError> {
        let refuse = |reason: String| Err(IntegratorError { integrator, reason });
        if !(self.alpha > 0.0 && self.alpha <= 1.0) {
            return refuse(format!("alpha is {}, but must be above 0 and at most 1", self.alpha));
        }
        match self.radius {
            Some(radius) if radius >= 0.0 && radius.is_finite() => Ok(radius),
            Some(radius) => refuse(format!("the radius is {radius}, but must be 0 or positive")),
            // Any radius tends to 0 where nothing is seen that it could be taken from.
            None => Ok(pixel_footprint(stage).map_or(1.0, |footprint| 2.0 * footprint)),
        }
    }
}

/// Camera samples that are drawn for a footprint, and at most while they meet no finite lobe.
const SAMPLES: u32 = 512;
const MOST_SAMPLES: u32 = 1 << 14;
/// Scattering events of a chain of Dirac lobes that is followed.
const CHAIN: u32 = 64;

/// √ of the area that a pixel covers on the surfaces that a camera sees, directly or through Dirac
/// lobes: the median over a few hundred samples. If these end at Dirac lobes alone, on those; `None`
/// if they meet no surface.
pub(super) fn pixel_footprint<S: Scene + ?Sized>(stage: Stage<'_, S>) -> Option<f64> {
    let plan = Plan::new(stage, TechniqueSet::NONE, Depth::up_to(CHAIN));
    let (source, mut scratch) = (Independent { seed: stage.seed }, Scratch::default());
    let nowhere = &mut |_: usize, _: &Contribution| {};
    let (mut finite, mut dirac) = (Vec::new(), Vec::new());
    for first in (0..MOST_SAMPLES).step_by(SAMPLES as usize) {
        let draw = |number| {
            let mut sampler = source.sampler(number, u32::MAX);
            let raster = stage.film.from_window(sampler.next_2d());
            Sample { film: FilmSample { raster, ..FilmSample::default() }, sampler }
        };
        let mut samples: Vec<_> = (first..first + SAMPLES).map(draw).collect();
        advance(&plan, &DiracChains, &mut samples, nowhere, &mut scratch);
        join(&plan, &mut samples, nowhere, &mut scratch, |site| {
            let camera = &site.subpaths.camera;
            let surfaces = camera.iter().rposition(|vertex| vertex.bsdf.is_some()).unwrap_or(0);
            let is_finite = camera.get(surfaces).is_some_and(Vertex::is_connectible);
            let found = if is_finite { &mut finite } else { &mut dirac };
            let subpath = camera.get(..=surfaces).unwrap_or_default();
            found.extend(footprint_at_end(subpath, stage.film.pixels()));
        });
        if !finite.is_empty() {
            break;
        }
    }
    let found = if finite.is_empty() { &mut dirac } else { &mut finite };
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied()
}

/// Behind Dirac lobes the product of the walk's densities is none per area, so the footprint is
/// that of the first direction at the length of the whole way.
fn footprint_at_end<B>(subpath: &[Vertex<B>], pixels: u32) -> Option<f64> {
    let [lens, first, ..] = subpath else { return None };
    let position = |vertex: &Vertex<B>| vertex.point.position;
    let distance = match lens.point.place {
        Place::Infinite => 1.0,
        _ => subpath.windows(2).map(|edge| position(&edge[0]).distance(position(&edge[1]))).sum(),
    };
    let density = lens.pdf_next.value() * lens.point.cosine(first.to_previous);
    let footprint = distance / (f64::from(pixels) * density).sqrt();
    (footprint > 0.0 && footprint.is_finite()).then_some(footprint)
}

/// Camera walks up to the first vertex that takes finite lobes.
struct DiracChains;

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for DiracChains {
    const KEEPS: bool = true;

    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        site.subpaths.camera.clear();
        let (walk, lens) = site.plan.stage.camera_walk(site.sample)?;
        site.subpaths.camera.push(lens);
        Some(walk)
    }

    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        if visit.vertex.is_connectible() {
            return ControlFlow::Break(());
        }
        visit.limit(visit.plan.depth.limit())
    }
}
