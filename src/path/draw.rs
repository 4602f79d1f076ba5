//! Paths that join a part of a camera subpath and a part of a light subpath.

use super::{Counters, End, Out, Path, Plan, Site, Vertex, Weighting, sample_lens};
use crate::film::{Contribution, Sample, Technique};
use crate::math::Rgb;
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Site<'_, 's, S, P> {
    /// Samples the points on lights that the vertices of the complete camera subpath connect to,
    /// for [`draw_path`](Self::draw_path) with the same weights.
    #[inline]
    pub fn sample_emitters(&mut self, weighting: &Weighting) {
        let Self { plan, sample, subpaths, pairs, level, .. } = self;
        pairs.sample_emitters(*level, plan, weighting, subpaths, &mut sample.sampler);
    }

    /// Evaluates the connections of the two complete subpaths, and those of the light subpath to
    /// the lens, as far as many can be at a time, for [`draw_path`](Self::draw_path) with the same
    /// weights.
    #[inline]
    pub fn connect_subpaths(&mut self, weighting: &Weighting) {
        self.pairs.connect_subpaths(self.level, self.plan, weighting, self.subpaths);
    }

    /// Draws a path by a technique (s, t) of the plan, given the subpaths, and shows it to `visit`
    /// with what it contributes if its connection is visible. A point on the lens (t = 1) is
    /// sampled for the end of the light subpath.
    #[inline(always)]
    pub fn draw_path(
        &mut self,
        technique: Technique,
        weighting: &Weighting,
        visit: &mut impl FnMut(&mut Out<'_>, &Path<'_, 's, S>, Contribution, &mut Counters),
    ) {
        let Some(pair) = self.pairs.get(technique) else {
            return self.draw_unknown_path(technique, weighting, visit);
        };
        let Self { plan, sample: Sample { film, sampler }, subpaths, out, counters, pairs, .. } =
            self;
        let (stage, Technique { s, t, .. }) = (&plan.stage, technique);
        counters.connections += 1;
        let mut raster = film.raster;
        if t == 1 {
            sampler.stream(Stream::LensSampling(u32::from(s) - 1));
            sampler.skip_1d();
            sampler.skip_2d();
            raster = pairs.raster(s) - film.offset;
        }
        if pair.value.is_black() || (t == 1 && stage.film.pixel_index(raster).is_none()) {
            return;
        }
        let sampled;
        let (camera_part, mut light_part) = (&subpaths.camera[..t.into()], &subpaths.light[..]);
        if s == 1 && t > 1 {
            sampled = pairs.emitter(stage, t);
            light_part = sampled.as_slice();
        }
        let parts = [camera_part, &light_part[..s.into()]];
        if let Some(path) = Path::evaluated(stage, parts, &pair) {
            let value = per_sample(path.value(), plan, technique);
            let contribution = Contribution { raster, value, weight: pair.weight, technique };
            visit(out, &path, contribution, counters);
        }
    }

    /// Draws a path that was not evaluated.
    #[inline(never)]
    fn draw_unknown_path(
        &mut self,
        technique: Technique,
        weighting: &Weighting,
        visit: &mut impl FnMut(&mut Out<'_>, &Path<'_, 's, S>, Contribution, &mut Counters),
    ) {
        let Self { plan, sample: Sample { film, sampler }, subpaths, out, counters, pairs, .. } =
            self;
        let (stage, Technique { s, t, .. }) = (&plan.stage, technique);
        let (from_camera, from_light) = (&subpaths.camera, &subpaths.light);
        let (s_len, t_len) = (usize::from(s), usize::from(t));
        let is_closed = |subpath: &[Vertex<_>], n: usize| n > 1 && !subpath[n - 1].is_connectible();
        if s > 0 && (is_closed(from_light, s_len) || is_closed(from_camera, t_len)) {
            return;
        }
        let sampled;
        let (camera_part, light_part): (&[_], &[_]) = match (s, t) {
            (0, _) => (&from_camera[..t_len], &[]),
            (_, 1) => {
                sampler.stream(Stream::LensSampling(u32::from(s) - 1));
                let lens = sample_lens(stage.camera, &from_light[s_len - 1].point, sampler);
                let Some(lens) = lens else { return };
                sampled = [lens.vertex(stage)];
                (&sampled, &from_light[..s_len])
            }
            (1, _) => {
                let Some(emitter) = pairs.emitter(stage, t) else { return };
                sampled = [emitter];
                (&from_camera[..t_len], &sampled)
            }
            _ => (&from_camera[..t_len], &from_light[..s_len]),
        };
        counters.connections += u64::from(s > 0);
        let Some(path) = Path::new(stage, camera_part, light_part) else { return };
        let seen = || {
            let raster = path.lens_raster()? - film.offset;
            stage.film.pixel_index(raster).is_some().then_some(raster)
        };
        if let Some(raster) = if t == 1 { seen() } else { Some(film.raster) } {
            let value = per_sample(path.value(), plan, technique);
            let weight = weighting.weight(&path);
            visit(out, &path, Contribution { raster, value, weight, technique }, counters);
        }
    }
}

/// An estimate over the number of samples of its technique, which is 1 most of the time.
#[inline]
fn per_sample<S: Scene + ?Sized>(value: Rgb, plan: &Plan<'_, S>, technique: Technique) -> Rgb {
    let count = plan.techniques.count(technique);
    if count == 1.0 { value } else { value / count }
}

/// Adds what a path contributes that was drawn from the sample's subpaths: if its ends were
/// connected, only if they see each other.
// No closure, which would be called where this is inlined.
#[inline(always)]
pub fn offer<S: Scene + ?Sized>(
    out: &mut Out<'_>,
    path: &Path<'_, '_, S>,
    contribution: Contribution,
    counters: &mut Counters,
) {
    match (path.light_part, &path.segment) {
        ([], _) => out.add(&contribution),
        (_, Some(segment)) => {
            counters.shadow_rays += 1;
            out.connect_by(segment, contribution);
        }
        _ => out.connect_ends(path, contribution, counters),
    }
}

impl Out<'_> {
    #[inline(never)]
    fn connect_ends<S: Scene + ?Sized>(
        &mut self,
        path: &Path<'_, '_, S>,
        contribution: Contribution,
        counters: &mut Counters,
    ) {
        let Technique { s, t, .. } = path.technique();
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
