//! Paths that join a part of a camera subpath and a part of a light subpath.

use super::pairs::Pair;
use super::{
    Counters, End, Out, Path, Site, Stage, Vertex, Weighting, sample_emitter, sample_lens,
};
use crate::film::{Contribution, Sample, Technique};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use glam::DVec2;

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Site<'_, 's, S, P> {
    /// Evaluates the connections of the two complete subpaths, as far as many can be at a time, for
    /// [`draw_path`](Self::draw_path) with the same weights.
    #[inline]
    pub fn connect_subpaths(&mut self, weighting: &Weighting) {
        self.pairs.evaluate(self.level, self.plan, weighting, self.subpaths);
    }

    /// Draws a path by a technique (s, t), given the subpaths, and shows it to `visit` with its
    /// weight and its place on the film if it may contribute there. A point on a light (s = 1,
    /// t ≥ 2) or on the lens (t = 1) is sampled for the end of the other subpath.
    #[inline]
    pub fn draw_path(
        &mut self,
        technique: Technique,
        weighting: &Weighting,
        visit: impl FnOnce(&Path<'_, 's, S>, f64, DVec2, &mut Out<'_>, &mut Counters),
    ) {
        let Self { plan, sample: Sample { film, sampler }, subpaths, out, counters, .. } = self;
        let Technique { s, t, .. } = technique;
        if let Some(Pair { edge, value, weight }) = self.pairs.get(technique) {
            counters.connections += 1;
            if !value.is_black() {
                let camera_part = &subpaths.camera[..t.into()];
                let light_part = &subpaths.light[..s.into()];
                let path = Path::evaluated(&plan.stage, camera_part, light_part, edge, value);
                if let Some(path) = path {
                    visit(&path, weight, film.raster, out, counters);
                }
            }
            return;
        }
        let Stage { camera, film: region, .. } = plan.stage;
        let (s, t) = (usize::from(s), usize::from(t));
        let (from_camera, from_light) = (&subpaths.camera, &subpaths.light);
        let is_closed = |subpath: &[Vertex<_>], n: usize| n > 1 && !subpath[n - 1].is_connectible();
        if s > 0 && (is_closed(from_light, s) || is_closed(from_camera, t)) {
            return;
        }
        let sampled;
        let (camera_part, light_part): (&[_], &[_]) = match (s, t) {
            (0, _) => (&from_camera[..t], &[]),
            (_, 1) => {
                sampler.stream(Stream::LensSampling(s as u32 - 1));
                let lens = sample_lens(camera, &from_light[s - 1].point, sampler);
                let Some(lens) = lens else { return };
                sampled = [lens.vertex(&plan.stage)];
                (&sampled, &from_light[..s])
            }
            (1, _) => {
                sampler.stream(Stream::NextEvent(t as u32 - 1));
                let emitter = sample_emitter(&plan.stage, &from_camera[t - 1].point, sampler);
                let Some(emitter) = emitter else { return };
                sampled = [emitter.vertex(&plan.stage)];
                (&from_camera[..t], &sampled)
            }
            _ => (&from_camera[..t], &from_light[..s]),
        };
        counters.connections += u64::from(s > 0);
        let Some(path) = Path::new(&plan.stage, camera_part, light_part) else { return };
        let seen = || {
            let raster = path.lens_raster()? - film.offset;
            region.pixel_index(raster).is_some().then_some(raster)
        };
        if let Some(raster) = if t == 1 { seen() } else { Some(film.raster) } {
            visit(&path, weighting.weight(&path), raster, out, counters);
        }
    }
}

impl Out<'_> {
    /// Adds what a path contributes that was drawn from the sample's subpaths: if its ends were
    /// connected, only if they see each other.
    #[inline]
    pub fn offer<S: Scene + ?Sized>(
        &mut self,
        path: &Path<'_, '_, S>,
        contribution: Contribution,
        counters: &mut Counters,
    ) {
        let Technique { s, t, .. } = path.technique();
        if s == 0 {
            return self.add(&contribution);
        }
        counters.shadow_rays += 1;
        let near =
            if t == 1 { self.keep(&path.vertex(0).point) } else { End::Camera(u32::from(t) - 1) };
        let far = match path.facing() {
            Some(facing) => self.keep(&facing),
            // The light subpath knows nothing of a sampled point.
            None if s == 1 => self.keep(&path.vertex(t.into()).point),
            None => End::Light(u32::from(s) - 1),
        };
        self.connect([near, far], contribution);
    }
}
