//! Vertex connection and merging: bidirectional path tracing with merges as further techniques
//! (Georgiev, Křivánek, Davidovič and Slusallek 2012; Hachisuka, Pantaleoni and Jensen 2012).
//!
//! ```text
//! connect (s, t):   T_s T_t f f G V                      p = p_s p_t
//! merge   (s, t):   T_t f Φ_s / (N π r²)                 p = p_s p_t π r²,  n = N
//! ```
//!
//! All weights are those of one sum over both kinds. Where connections can draw a path, the weight
//! of a merge vanishes with the radius, and so does its bias; a path that no connection can draw,
//! such as a caustic seen through water, is left to the merges.

#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::bidirectional::Pairs;
use super::merging::{Merging, PhotonMaps};
use super::{Bidirectional, Crew, Integrator, IntegratorError, Notes, Run, Stage, Started};
use crate::bsdf::TransportMode::{Importance, Radiance};
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::path::{
    Counters, MergeSide, MergedPath, Out, Path, Scratch, Site, TechniqueSet, Vertex, Weighting,
};
use crate::photon_map::Photon;
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::sync::Arc;

/// Vertex connection and merging.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexConnectionMerging {
    /// Connections, path lengths, termination and heuristic.
    pub bidirectional: Bidirectional,
    /// Radius and light walks of the merges.
    pub merging: Merging,
    /// True if weights count the light walks of a merge by how independent they are
    /// ([`PathDensities::correlation`](crate::path::PathDensities::correlation)); takes time in
    /// proportion to the length of a path, and some 400 bytes more for each vertex of a light walk.
    pub correlation_aware: bool,
}

/// A rendering by pairs of subpaths and by the photon maps of passes.
pub struct MergingPairs<'a, S: Scene + ?Sized> {
    pairs: Pairs<'a, S>,
    maps: PhotonMaps<WeightedPhoton<'a, S>>,
    keeps_subpaths: bool,
}

/// A photon, and what the weights of its merges need of the subpath behind it.
struct WeightedPhoton<'a, S: Scene + ?Sized + 'a> {
    photon: Photon,
    side: MergeSide,
    subpath: Option<Arc<Vec<Vertex<S::Bsdf<'a>>>>>,
}

impl<S: Scene + ?Sized> AsRef<Photon> for WeightedPhoton<'_, S> {
    fn as_ref(&self) -> &Photon {
        &self.photon
    }
}

impl<S: Scene + ?Sized> Integrator<S> for VertexConnectionMerging {
    type Run<'a>
        = MergingPairs<'a, S>
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "vcm"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<MergingPairs<'a, S>> {
        let merges = self.merging.light_walks(stage.film.pixels());
        let techniques = TechniqueSet { merges, ..self.bidirectional.techniques };
        let mut pairs = Bidirectional { techniques, ..self.bidirectional }.run(stage);
        if self.correlation_aware {
            pairs.weighting = pairs.weighting.correlation_aware();
        }
        let maps = PhotonMaps::new(self.merging, &pairs.plan, Integrator::<S>::name(self))?;
        Ok(MergingPairs { pairs, maps, keeps_subpaths: false })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for MergingPairs<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.pairs.plan.techniques
    }

    fn notes(&self) -> Notes {
        self.maps.notes(&self.pairs.plan)
    }

    fn learns(&self) -> bool {
        self.pairs.plan.techniques.merges > 0
    }

    fn preparation(&self) -> Counters {
        self.maps.counters
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        let Self { pairs, maps, .. } = self;
        pairs.weighting = pairs.weighting.with_merge_radius(maps.radius(pass));
        let (scene, weighting) = (pairs.plan.stage.scene, pairs.weighting);
        let keeps_subpath = self.keeps_subpaths || weighting.needs_sweep();
        maps.begin_pass(pass, crew, (&pairs.plan, &pairs.roulette), |subpath, photons| {
            weighting.complete_light_subpath(subpath, scene);
            let side = |s: u16| weighting.light_side(&subpath[..s.into()], scene);
            let found: Vec<_> = Photon::of(subpath).map(|found| (found, side(found.s))).collect();
            let subpath = keeps_subpath.then(|| Arc::new(std::mem::take(subpath)));
            photons.extend(found.into_iter().map(|(photon, side)| WeightedPhoton {
                photon,
                side,
                subpath: subpath.clone(),
            }));
        })
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        self.pairs.draw_and_merge(samples, sink, scratch, |site| {
            self.merge(site, |_, contribution, out| out.add(&contribution));
        });
    }
}

impl<'a, S: Scene + ?Sized + 'a> MergingPairs<'a, S> {
    /// Draws one sample and shows every path with a nonzero contribution, connected or merged, as an
    /// audit looks at them; merged ones of a pass that [keeps](Self::keep_subpaths) light subpaths.
    pub fn for_each_path<P: Sampler>(
        &self,
        sample: Sample<P>,
        scratch: &mut Scratch<'a, S>,
        connected: impl FnMut(&Path<'_, 'a, S>, &Contribution),
        mut merged: impl FnMut(&MergedPath<'_, 'a, S>, &Contribution),
    ) {
        self.pairs.for_each_path(sample, scratch, connected, |site| {
            self.merge(site, |path, contribution, _| {
                if let Some(path) = path {
                    merged(path, &contribution);
                }
            });
        });
    }

    /// The weights of the pass under way.
    pub fn weighting(&self) -> &Weighting {
        &self.pairs.weighting
    }

    /// Keeps whole light subpaths in the passes to come.
    pub fn keep_subpaths(&mut self) {
        self.keeps_subpaths = true;
    }

    /// Merges the vertices of a camera subpath with the photons in reach.
    fn merge<P: Sampler>(
        &self,
        site: &mut Site<'_, 'a, S, P>,
        mut visit: impl FnMut(Option<&MergedPath<'_, 'a, S>>, Contribution, &mut Out<'_>),
    ) {
        let Site { plan, subpaths, sample, out, counters, .. } = site;
        let weighting = &self.pairs.weighting;
        let scale = 1.0 / (f64::from(plan.techniques.merges) * weighting.merge_area());
        for t in 2..=subpaths.camera.len() {
            let (subpath, y) = (&subpaths.camera[..t], &subpaths.camera[t - 1]);
            let Some(bsdf) = y.bsdf.as_ref().filter(|_| y.is_connectible()) else { continue };
            let camera_side = weighting.camera_side(subpath);
            self.maps.within(
                &y.point,
                counters,
                |WeightedPhoton { photon, side, subpath: light }, counters| {
                    let technique = Technique::merge(photon.s, t as u16);
                    if !plan.depth.contains(technique.bounces().into()) {
                        return;
                    }
                    counters.merges += 1;
                    let (to_light, to_camera) = (photon.to_previous, y.to_previous);
                    let value = y.throughput * bsdf.eval(to_light, to_camera) * photon.flux * scale;
                    if value.is_black() {
                        return;
                    }
                    let path = light.as_ref().and_then(|light| {
                        let (scene, camera) = (plan.stage.scene, plan.stage.camera);
                        MergedPath::new(scene, camera, subpath, &light[..photon.s.into()])
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
                },
            );
        }
    }
}
