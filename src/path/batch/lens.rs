//! Connections of light walks to a pinhole.

use crate::bsdf::{Bsdf, LaneForm};
use crate::endpoint::View;
use crate::film::{Contribution, Technique};
use crate::geometry::SurfacePoint;
use crate::lanes::{Rows, dispatch, load, store};
use crate::math::{PerArea, Rgb};
use crate::path::connect::lens_connection_at;
use crate::path::diffuse::{BLACK, Diffuse, INEXACT, Pinhole, UNSEEN};
use crate::path::{LensConnection, SampledEndpoint, Vertex, Visit};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use fearless_simd::{Level, Simd};
use glam::{DVec2, DVec3};

/// Connections of Lambertian vertices to a pinhole.
#[derive(Debug, Default)]
pub(super) struct PinholeConnections {
    walks: Vec<u32>,
    /// The number of those handed out.
    taken: usize,
    /// Position, normal, direction to the previous vertex, throughput, albedo.
    given: Rows<15>,
    /// Place on the film, estimate, state.
    found: Rows<6>,
}

impl PinholeConnections {
    pub(super) fn clear(&mut self) {
        self.walks.clear();
        self.given.clear();
        self.taken = 0;
    }

    /// Accepts a vertex that lanes can connect, with the numbers that its connection takes. Returns
    /// true if it is one.
    #[inline(always)]
    pub(super) fn accept<B: Bsdf, P: Sampler>(
        &mut self,
        walk: usize,
        vertex: &Vertex<B>,
        sampler: &mut P,
        bounces: u32,
    ) -> bool {
        let Some(LaneForm::Lambert(lambert)) = vertex.lane_form() else { return false };
        sampler.stream(Stream::LensSampling(bounces));
        sampler.skip_1d();
        sampler.skip_2d();
        let (x, colours) = (&vertex.point, [vertex.throughput, lambert.albedo()]);
        let [throughput, albedo] = colours.map(|colour| DVec3::from_array(colour.0));
        let vectors = [x.position, x.geometric_normal, vertex.to_previous, throughput, albedo];
        self.walks.push(walk as u32);
        self.given.push(vectors, []);
        true
    }

    /// Evaluates all that was accepted.
    #[inline(never)]
    pub(super) fn connect(&mut self, level: Level, view: &View) {
        self.found.resize(self.walks.len());
        dispatch!(level, simd => connect(simd, view, &self.given, &mut self.found));
    }

    /// The connection of a walk, if it is the next one that was accepted.
    #[inline(always)]
    pub(super) fn take<'s, S: Scene + ?Sized + 's, P>(
        &mut self,
        walk: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) -> Option<Option<LensConnection>> {
        let k = self.taken;
        self.walks.get(k).filter(|next| **next as usize == walk)?;
        self.taken += 1;
        Some(self.connection(k, visit))
    }

    #[inline(always)]
    fn connection<'s, S: Scene + ?Sized + 's, P>(
        &self,
        k: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) -> Option<LensConnection> {
        let Visit { plan, walk, vertex, end, sample, out, counters, .. } = visit;
        let (stage, bounces) = (&plan.stage, walk.bounces() + 1);
        let [x, y, red, green, blue, state] = self.found.get(k);
        let lens = SurfacePoint::dirac(stage.camera.as_pinhole()?.position);
        if state == INEXACT {
            let lens =
                SampledEndpoint { point: lens, light: None, pdf: PerArea(1.0), radiance: None };
            let from = (&**vertex, Some(*end));
            return lens_connection_at(stage, from, bounces, &sample.film, &lens, out, counters);
        }
        if state == UNSEEN {
            return None;
        }
        let raster = DVec2::new(x, y) - sample.film.offset;
        stage.film.pixel_index(raster)?;
        counters.connections += 1;
        if state == BLACK {
            return None;
        }
        counters.shadow_rays += 1;
        let (value, technique) =
            (Rgb::new(red, green, blue), Technique::new(bounces as u16 + 1, 1));
        let contribution = Contribution { raster, value, weight: 1.0, technique };
        Some(LensConnection { ends: [out.keep(&lens), *end], contribution })
    }
}

#[inline(always)]
fn connect<S: Simd>(simd: S, view: &View, given: &Rows<15>, found: &mut Rows<6>) {
    for (given, found) in given.groups().iter().zip(found.groups_mut()) {
        let Pinhole { raster: [x, y], value, state } =
            Diffuse::new(load(simd, given)).lens_connection(view);
        store(found, [x, y, value.x, value.y, value.z, state]);
    }
}
