//! Next event estimation from Lambertian surfaces to flat lights.

use crate::bsdf::{Bsdf, LaneForm};
use crate::endpoint::{FlatLanes, FlatLight, LightId};
use crate::lanes::{LANES, Rows, Vector, dispatch, load, store};
use crate::math::{PerArea, Rgb};
use crate::path::connect::next_event_at;
use crate::path::diffuse::{BLACK, Diffuse, INEXACT, LightPoints};
use crate::path::{Edge, NextEvent, SampledEndpoint, Vertex, Visit};
use crate::scene::Scene;
use fearless_simd::{Level, Simd};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// Connections of Lambertian vertices to flat lights.
#[derive(Debug, Default)]
pub(super) struct FlatConnections<'s> {
    list: Vec<FlatConnection<'s>>,
    /// The number of those handed out.
    taken: usize,
    /// Position, normal, direction to the previous vertex, throughput, albedo; two random numbers
    /// and the density of the point.
    given: Rows<18>,
    /// Position, error bound and surface parameters of the point; direction and geometry term of
    /// the edge; estimate; state.
    found: Rows<14>,
}

#[derive(Debug)]
struct FlatConnection<'s> {
    walk: u32,
    light: LightId,
    flat: &'s FlatLight,
    pdf: PerArea,
}

impl<'s> FlatConnections<'s> {
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.given.clear();
        self.taken = 0;
    }

    /// Accepts a vertex that lanes can connect to a light, which was chosen with some probability.
    /// Returns true if it is one.
    #[inline(always)]
    pub(super) fn accept<B: Bsdf>(
        &mut self,
        walk: usize,
        vertex: &Vertex<B>,
        (light, pmf, flat): (LightId, f64, &'s FlatLight),
        u: DVec2,
    ) -> bool {
        let Some(LaneForm::Lambert(lambert)) = vertex.lane_form() else { return false };
        let x = &vertex.point;
        if flat.is_near(x.position) {
            return false;
        }
        let (pdf, colours) = (flat.pdf * pmf, [vertex.throughput, lambert.albedo()]);
        let [throughput, albedo] = colours.map(|colour| DVec3::from_array(colour.0));
        let vectors = [x.position, x.geometric_normal, vertex.to_previous, throughput, albedo];
        self.list.push(FlatConnection { walk: walk as u32, light, flat, pdf });
        self.given.push(vectors, [u.x, u.y, pdf.value()]);
        true
    }

    /// Evaluates all that was accepted.
    #[inline(never)]
    pub(super) fn connect(&mut self, level: Level) {
        self.found.resize(self.list.len());
        dispatch!(level, simd => connect(simd, self));
    }

    /// The connection of a walk, if it is the next one that was accepted.
    #[inline(always)]
    pub(super) fn take<S: Scene + ?Sized + 's, P>(
        &mut self,
        walk: usize,
        visit: &mut Visit<'_, 's, S, P>,
    ) -> Option<Option<NextEvent>> {
        let k = self.taken;
        let connection = self.list.get(k).filter(|next| next.walk as usize == walk)?;
        self.taken += 1;
        Some(self.next_event(k, connection, visit))
    }

    #[inline(always)]
    fn next_event<S: Scene + ?Sized + 's, P>(
        &self,
        k: usize,
        connection: &FlatConnection<'_>,
        visit: &mut Visit<'_, 's, S, P>,
    ) -> Option<NextEvent> {
        let Visit { plan, vertex, out, counters, .. } = visit;
        let &FlatConnection { light, flat, pdf, .. } = connection;
        let [px, py, pz, error, u, v, x, y, z, geometry, red, green, blue, state] =
            self.found.get(k);
        let point = flat.point(DVec3::new(px, py, pz), error, DVec2::new(u, v));
        if state == INEXACT {
            let emitter = SampledEndpoint { point, light: Some(light), pdf, radiance: None };
            return next_event_at(plan, vertex, &emitter, out, counters);
        }
        counters.connections += 1;
        if state == BLACK {
            return None;
        }
        let hit = if plan.techniques.bsdf_sampling { FRAC_1_PI * geometry } else { 0.0 };
        Some(NextEvent {
            end: out.keep(&point),
            pdf,
            light,
            edge: Edge { direction: DVec3::new(x, y, z), geometry },
            value: Rgb::new(red, green, blue),
            pdf_of_hit: PerArea(hit),
        })
    }
}

#[inline(always)]
fn connect<S: Simd>(simd: S, FlatConnections { list, given, found, .. }: &mut FlatConnections<'_>) {
    let groups = list.chunks(LANES).zip(given.groups()).zip(found.groups_mut());
    for ((list, given), found) in groups {
        let light = FlatLanes::gather(simd, list.iter().map(|connection| Some(connection.flat)));
        let [vertices @ .., u1, u2, pdf] = load(simd, given);
        let LightPoints { position, error, uv: [u, v], direction, geometry, value, state } =
            Diffuse::new(vertices).next_event(&light, [u1, u2], pdf);
        let (Vector { x, y, z }, Vector { x: dx, y: dy, z: dz }) = (position, direction);
        let Vector { x: v0, y: v1, z: v2 } = value;
        store(found, [x, y, z, error, u, v, dx, dy, dz, geometry, v0, v1, v2, state]);
    }
}
