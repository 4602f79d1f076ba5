//! Merges with weights: the photons of a pass with what is known of the subpaths behind them.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::{Merging, PhotonMaps};
use crate::bsdf::TransportMode::{Importance, Radiance};
use crate::film::{Contribution, Technique};
use crate::integrator::{Crew, IntegratorError};
use crate::path::{MergeSide, MergedPath, Out, Plan, Roulette, Site, Vertex, Weighting};
use crate::photon_map::Photon;
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::sync::Arc;

/// The photons of a pass, and the weights of merges with them.
pub struct Merges<'a, S: Scene + ?Sized> {
    pub maps: PhotonMaps<WeightedPhoton<'a, S>>,
    /// True if whole light subpaths are kept, whether or not weights need them.
    pub keeps_subpaths: bool,
}

/// A photon, and what the weights of its merges need of the subpath behind it.
pub struct WeightedPhoton<'a, S: Scene + ?Sized + 'a> {
    photon: Photon,
    side: MergeSide,
    subpath: Option<Arc<Vec<Vertex<S::Bsdf<'a>>>>>,
}

impl<S: Scene + ?Sized> AsRef<Photon> for WeightedPhoton<'_, S> {
    fn as_ref(&self) -> &Photon {
        &self.photon
    }
}

impl<'a, S: Scene + ?Sized + 'a> Merges<'a, S> {
    pub fn new(
        settings: Merging,
        plan: &Plan<'a, S>,
        integrator: &'static str,
    ) -> Result<Self, IntegratorError> {
        Ok(Self { maps: PhotonMaps::new(settings, plan, integrator)?, keeps_subpaths: false })
    }

    /// Makes the map of a pass; `weighting` gets to know its radius.
    pub fn begin_pass(
        &mut self,
        pass: u32,
        crew: &dyn Crew,
        (plan, roulette): (&Plan<'a, S>, &Roulette),
        weighting: &mut Weighting,
    ) -> Result<(), IntegratorError> {
        *weighting = weighting.with_merge_radius(self.maps.radius(pass));
        let (scene, weighting) = (plan.stage.scene, *weighting);
        let keeps_subpath = self.keeps_subpaths || weighting.needs_sweep();
        self.maps.begin_pass(pass, crew, (plan, roulette), |subpath, photons| {
            weighting.complete_light_subpath(subpath, &plan.stage);
            let first = photons.len();
            photons.extend(Photon::of(subpath).map(|photon| {
                let side = weighting.light_side(&subpath[..photon.s.into()], scene);
                WeightedPhoton { photon, side, subpath: None }
            }));
            if keeps_subpath {
                let subpath = Arc::new(std::mem::take(subpath));
                photons[first..].iter_mut().for_each(|p| p.subpath = Some(Arc::clone(&subpath)));
            }
        })
    }

    /// Merges the vertices of a camera subpath with the photons in reach, and shows `visit` each
    /// contribution; with its path if light subpaths are kept.
    pub fn for_each<P: Sampler>(
        &self,
        weighting: &Weighting,
        Site { plan, subpaths, sample, out, counters, .. }: &mut Site<'_, 'a, S, P>,
        mut visit: impl FnMut(Option<&MergedPath<'_, 'a, S>>, Contribution, &mut Out<'_>),
    ) {
        let scale = 1.0 / (f64::from(plan.techniques.merges) * weighting.merge_area());
        for t in 2..=subpaths.camera.len() {
            let (subpath, y) = (&subpaths.camera[..t], &subpaths.camera[t - 1]);
            let Some(bsdf) = y.finite_bsdf() else { continue };
            let camera_side = weighting.camera_side(subpath);
            self.maps.within(&y.point, counters, |weighted, counters| {
                let WeightedPhoton { photon, side, subpath: from_light } = weighted;
                let technique = Technique::merge(photon.s, t as u16);
                if !plan.draws(technique) {
                    return;
                }
                counters.merges += 1;
                let (to_light, to_camera) = (photon.to_previous, y.to_previous);
                let value = y.throughput * bsdf.eval(to_light, to_camera) * photon.flux * scale;
                if value.is_black() {
                    return;
                }
                let path = from_light.as_ref().and_then(|from_light| {
                    MergedPath::new(&plan.stage, subpath, &from_light[..photon.s.into()])
                });
                let weight = match &path {
                    Some(path) if weighting.needs_sweep() => path.weight(weighting),
                    _ => weighting.merge_weight([
                        (&camera_side, bsdf.pdf(to_light, to_camera, Importance).value()),
                        (side, bsdf.pdf(to_camera, to_light, Radiance).value()),
                    ]),
                };
                let raster = sample.film.raster;
                visit(path.as_ref(), Contribution { raster, value, weight, technique }, out);
            });
        }
    }
}
