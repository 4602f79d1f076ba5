//! The settings of photon maps, the radius within which photons count as met, from pass to pass,
//! and the maps themselves.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::shared_walks::SharedWalks;
use super::{Crew, Estimator, IntegratorError, Notes};
use crate::bsdf::Bsdf;
use crate::film::{Contribution, FilmSample, Sample, Technique};
use crate::geometry::{Place, SurfacePoint};
use crate::math::Rgb;
use crate::path::{
    Counters, Depth, Plan, RandomWalk, Roulette, Scratch, Site, Stage, Steps, TechniqueSet, Vertex,
    Visit, advance, join,
};
use crate::photon_map::{Photon, PhotonMap};
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
    /// sees, the square root of the area that it covers.
    pub radius: Option<f64>,
    /// α, in (0, 1].
    pub alpha: f64,
    /// Light walks of a pass; `None` for as many as there are pixels, up to 2¹⁸, whose photons take
    /// some hundred megabytes.
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
        first * (f64::from(pass) + 1.0).powf(0.5 * (self.alpha - 1.0))
    }

    /// The first radius on a stage.
    fn first_radius<S: Scene + ?Sized>(
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
            None => match pixel_footprint(stage) {
                Some(footprint) => Ok(2.0 * footprint),
                None => refuse(format!(
                    "none of {MOST_SAMPLES} camera samples met a surface that the radius could be \
                     taken from; give one"
                )),
            },
        }
    }
}

/// The photon maps of a run, one at a time.
#[derive(Debug)]
pub struct PhotonMaps<P = Photon> {
    integrator: &'static str,
    settings: Merging,
    first_radius: f64,
    map: Option<PhotonMap<P>>,
    /// Counts of the work for all maps so far.
    pub counters: Counters,
    /// Bytes of the largest map so far.
    pub most_bytes: usize,
}

impl<P: AsRef<Photon> + Send + Sync> PhotonMaps<P> {
    /// The maps of a run that merges, as its plan says.
    ///
    /// # Errors
    /// If the settings are none of a radius, or if the camera sees no surface that it could be
    /// taken from.
    pub fn new<S: Scene + ?Sized>(
        settings: Merging,
        plan: &Plan<'_, S>,
        integrator: &'static str,
    ) -> Result<Self, IntegratorError> {
        let merges = plan.techniques.merges > 0;
        let first_radius =
            if merges { settings.first_radius(plan.stage, integrator)? } else { 0.0 };
        let (map, counters) = (None, Counters::default());
        Ok(Self { integrator, settings, first_radius, map, counters, most_bytes: 0 })
    }

    /// The radius in a pass; passes are numbered from 0.
    pub fn radius(&self, pass: u32) -> f64 {
        self.settings.radius_in(pass, self.first_radius)
    }

    /// Makes the map of a pass of the photons that `photons` takes from each light subpath.
    ///
    /// # Errors
    /// If there is no memory for the map.
    pub fn begin_pass<'a, S: Scene + ?Sized + 'a>(
        &mut self,
        pass: u32,
        crew: &dyn Crew,
        (plan, roulette): (&Plan<'a, S>, &Roulette),
        photons: impl Fn(&mut Vec<Vertex<S::Bsdf<'a>>>, &mut Vec<P>) + Sync,
    ) -> Result<(), IntegratorError> {
        // Not two maps at a time.
        self.map = None;
        let walks = SharedWalks { plan, roulette, count: plan.techniques.merges, shortest: 1 };
        let (photons, counters) = walks.draw(pass, crew, self.integrator, photons)?;
        self.counters += counters;
        self.counters.photons += photons.len() as u64;
        let map = PhotonMap::build(photons, self.radius(pass)).map_err(|error| {
            IntegratorError { integrator: self.integrator, reason: error.to_string() }
        })?;
        self.most_bytes = self.most_bytes.max(map.bytes());
        self.map = Some(map);
        Ok(())
    }

    /// Shows `visit` the photons in reach of a vertex of a camera subpath.
    #[inline]
    pub fn within(
        &self,
        point: &SurfacePoint,
        counters: &mut Counters,
        mut visit: impl FnMut(&P, &mut Counters),
    ) {
        counters.queries += 1;
        if let Some(map) = &self.map {
            map.within(point, |photon| visit(photon, counters));
        }
    }

    /// The photons in reach of a vertex of a camera subpath that make paths of the lengths that
    /// count, summed up to one estimate `T f Φ/(N π r²)` for each number s of light vertices.
    pub fn estimates<S: Scene + ?Sized, R>(
        &self,
        Visit { plan, vertex, walk, counters, .. }: &mut Visit<'_, '_, S, R>,
    ) -> Vec<(Technique, Rgb)> {
        let (mut sums, t) = (Vec::<(Technique, Rgb)>::new(), walk.bounces() as u16 + 2);
        let (Some(map), Some(bsdf)) = (&self.map, &vertex.bsdf) else { return sums };
        let scale = 1.0 / (f64::from(plan.techniques.merges) * map.area());
        self.within(&vertex.point, counters, |photon, counters| {
            let photon = photon.as_ref();
            let technique = Technique::merge(photon.s, t);
            if !plan.depth.contains(technique.bounces().into()) {
                return;
            }
            counters.merges += 1;
            let f = bsdf.eval(photon.to_previous, vertex.to_previous);
            let value = vertex.throughput * f * photon.flux * scale;
            match sums.iter_mut().find(|(of, _)| *of == technique) {
                Some((_, sum)) => *sum += value,
                None => sums.push((technique, value)),
            }
        });
        sums
    }

    /// The notes of a run that merges with the maps.
    pub fn notes<S: Scene + ?Sized>(&self, plan: &Plan<'_, S>) -> Notes {
        let estimator = match plan.techniques.merges {
            0 => Estimator::Unbiased,
            _ if self.settings.alpha < 1.0 => Estimator::Consistent,
            _ => Estimator::Biased,
        };
        let shared_bytes = self.most_bytes as u64;
        Notes { left_out: plan.left_out, estimator, shared_bytes, ..Notes::default() }
    }
}

impl Photon {
    /// The photons of a light subpath: the vertices that a camera walk can meet, on surfaces with a
    /// finite lobe.
    pub fn of<B: Bsdf>(subpath: &[Vertex<B>]) -> impl Iterator<Item = Self> {
        let surfaces = (1..).zip(subpath).skip(1).filter(|(_, vertex)| vertex.is_connectible());
        surfaces.map(|(s, vertex)| Self {
            position: vertex.point.position,
            normal: vertex.point.geometric_normal,
            to_previous: vertex.to_previous,
            flux: vertex.throughput,
            s,
        })
    }
}

/// Camera samples that are drawn for a footprint, and at most while they meet nothing.
const SAMPLES: u32 = 512;
const MOST_SAMPLES: u32 = 1 << 16;

/// √ of the area that a pixel covers on the surfaces that a camera sees, directly or through Dirac
/// lobes: the median over a few hundred samples. `None` if they see none.
pub(super) fn pixel_footprint<S: Scene + ?Sized>(stage: Stage<'_, S>) -> Option<f64> {
    let plan = Plan::new(stage, TechniqueSet::NONE, Depth::default());
    let (source, mut scratch) = (Independent { seed: stage.seed }, Scratch::default());
    let nowhere = &mut |_: usize, _: &Contribution| {};
    let mut found = Vec::new();
    for first in (0..MOST_SAMPLES).step_by(SAMPLES as usize) {
        let draw = |number| {
            let mut sampler = source.sampler(number, u32::MAX);
            let raster = stage.film.from_window(sampler.next_2d());
            Sample { film: FilmSample { raster, ..FilmSample::default() }, sampler }
        };
        let mut samples: Vec<_> = (first..first + SAMPLES).map(draw).collect();
        advance(&plan, &DiracChains, &mut samples, nowhere, &mut scratch);
        join(&plan, &mut samples, nowhere, &mut scratch, |site| {
            found.extend(footprint_at_end(&site.subpaths.camera, stage.film.pixels()));
        });
        if !found.is_empty() {
            break;
        }
    }
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied()
}

/// Behind Dirac lobes the product of the walk's densities is none per area, so the footprint is
/// that of the first direction at the length of the whole way.
fn footprint_at_end<B: Bsdf>(subpath: &[Vertex<B>], pixels: u32) -> Option<f64> {
    let ([lens, first, ..], [.., end]) = (subpath, subpath) else { return None };
    if !end.is_connectible() {
        return None;
    }
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

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        if visit.vertex.is_connectible() {
            return ControlFlow::Break(());
        }
        visit.scatter(&Roulette::default()).flow()
    }
}
