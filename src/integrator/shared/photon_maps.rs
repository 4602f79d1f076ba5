//! The photon maps of a run, one for each pass.

use super::{Merging, SharedWalks};
use crate::bsdf::Bsdf;
use crate::film::Technique;
use crate::geometry::SurfacePoint;
use crate::integrator::{Crew, Estimator, IntegratorError, Notes};
use crate::math::Rgb;
use crate::path::{Counters, Plan, Roulette, Vertex, Visit};
use crate::photon_map::{Photon, PhotonMap, has_area};
use crate::scene::Scene;

/// The photon maps of a run, one at a time.
#[derive(Debug)]
pub struct PhotonMaps<P = Photon> {
    integrator: &'static str,
    settings: Merging,
    first_radius: f64,
    map: Option<PhotonMap<P>>,
    /// Counts of the work for maps.
    pub counters: Counters,
}

impl<P: AsRef<Photon> + Send + Sync> PhotonMaps<P> {
    /// The maps of a run that merges, as its plan says.
    ///
    /// # Errors
    /// If the settings are none of a radius.
    pub fn new<S: Scene + ?Sized>(
        settings: Merging,
        plan: &Plan<'_, S>,
        integrator: &'static str,
    ) -> Result<Self, IntegratorError> {
        let merges = plan.techniques.merges > 0;
        let first_radius =
            if merges { settings.first_radius(plan.stage, integrator)? } else { 0.0 };
        let (map, counters) = (None, Counters::default());
        Ok(Self { integrator, settings, first_radius, map, counters })
    }

    /// The radius in a pass; passes are numbered from 0.
    pub fn radius(&self, pass: u32) -> f64 {
        self.settings.radius_in(pass, self.first_radius)
    }

    /// Makes the map of a pass of the photons that `photons` takes from each light subpath; none if
    /// the radius is too small to meet any.
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
        let radius = self.radius(pass);
        if !has_area(radius) {
            return Ok(());
        }
        let walks = SharedWalks { plan, roulette, count: plan.techniques.merges, shortest: 1 };
        let (photons, counters) = walks.draw(pass, crew, self.integrator, photons)?;
        self.counters += counters;
        self.counters.photons += photons.len() as u64;
        let map = PhotonMap::build(photons, radius).map_err(|error| IntegratorError {
            integrator: self.integrator,
            reason: error.to_string(),
        })?;
        self.counters.share(map.bytes());
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
        let (Some(map), Some(bsdf)) = (&self.map, vertex.finite_bsdf()) else { return sums };
        let scale = 1.0 / (f64::from(plan.techniques.merges) * map.area());
        self.within(&vertex.point, counters, |photon, counters| {
            let photon = photon.as_ref();
            let technique = Technique::merge(photon.s, t);
            if !plan.draws(technique) {
                return;
            }
            counters.merges += 1;
            // ANCHOR: estimate
            let f = bsdf.eval(photon.to_previous, vertex.to_previous);
            let value = vertex.throughput * f * photon.flux * scale;
            // ANCHOR_END: estimate
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
        Notes { estimator, is_correlated: plan.techniques.merges > 0, ..Notes::of(plan) }
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
