//! The points that vertices are connected to: on lights, and on the lens.

use super::Batch;
use crate::bsdf::{LaneForm, TransportMode, on_same_side};
use crate::endpoint::{FLAT, FlatLanes, FlatLight, Light, LightId};
use crate::lanes::{Group, LANES, Lane, Mask, Rows, Vector, load, store};
use crate::math::{PerArea, Rgb};
use crate::path::connect::{emitter_at, next_event_at};
use crate::path::edge::{self, Edge};
use crate::path::steps::Drawn;
use crate::path::{NextEvent, Plan, SampledEndpoint, Steps, Visit, sample_lens_connection};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;
use std::ops::ControlFlow;

/// Connections of Lambertian vertices to flat lights.
#[derive(Debug, Default)]
pub(in crate::path) struct FlatConnections<'s> {
    list: Vec<FlatConnection<'s>>,
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

/// The state of an estimate that is black; of another one it is 1.
const BLACK: f64 = 0.0;
/// The state where the edge is too short or too long for the formula of lanes.
const INEXACT: f64 = 2.0;

impl<'s, S: Scene + ?Sized + 's, P: Sampler> Batch<'_, 's, S, P> {
    /// Samples a point on a light for each vertex of a camera walk, and one on the lens for each of
    /// a light walk, where a connection can carry light and paths of that length count, and shows
    /// it to the steps.
    #[inline]
    pub(super) fn connect(&mut self, steps: &impl Steps<'s, S>) {
        let mut flat = std::mem::take(&mut self.scratch.flat_connections);
        flat.list.clear();
        flat.given.clear();
        let plan = self.plan;
        let Plan { stage, techniques, depth, .. } = plan;
        self.visit(|i, visit| {
            *visit.drawn = Drawn::Nothing;
            let (mode, bounces) = (visit.walk.mode(), visit.walk.bounces() + 1);
            let is_drawn = match mode {
                TransportMode::Radiance => techniques.next_event,
                TransportMode::Importance => techniques.lens_sampling,
            };
            if !(is_drawn
                && depth.contains(bounces)
                && visit.vertex.is_connectible()
                && steps.samples_point(visit))
            {
                return ControlFlow::Continue(());
            }
            let (vertex, out, counters) = (&*visit.vertex, &mut visit.out, &mut *visit.counters);
            if mode == TransportMode::Importance {
                let from = (vertex, Some(visit.end));
                *visit.drawn =
                    sample_lens_connection(stage, from, bounces, visit.sample, out, counters)
                        .map_or(Drawn::Nothing, Drawn::LensConnection);
                return ControlFlow::Continue(());
            }
            let sampler = &mut visit.sample.sampler;
            sampler.stream(Stream::NextEvent(bounces));
            // All numbers are drawn first, so that later dimensions do not depend on the outcome.
            let (u0, u1, u2) = (sampler.next_1d(), sampler.next_1d(), sampler.next_2d());
            let Some((light, pmf)) = stage.pick_light_for(&vertex.point, u0) else {
                return ControlFlow::Continue(());
            };
            let flat_light = stage.scene.light(light).as_flat();
            if let Some(flat_light) = flat_light.filter(|flat| !flat.is_near(vertex.point.position))
                && let Some(bsdf) = &vertex.bsdf
                && let Some(LaneForm::Lambert(lambert)) = bsdf.lane_form(vertex.to_previous)
            {
                let (x, n, w) =
                    (vertex.point.position, vertex.point.geometric_normal, vertex.to_previous);
                let ([t0, t1, t2], [a0, a1, a2]) = (vertex.throughput.0, lambert.albedo().0);
                let pdf = flat_light.pdf * pmf;
                flat.list.push(FlatConnection { walk: i as u32, light, flat: flat_light, pdf });
                flat.given.push([
                    x.x,
                    x.y,
                    x.z,
                    n.x,
                    n.y,
                    n.z,
                    w.x,
                    w.y,
                    w.z,
                    t0,
                    t1,
                    t2,
                    a0,
                    a1,
                    a2,
                    u2.x,
                    u2.y,
                    pdf.value(),
                ]);
                return ControlFlow::Continue(());
            }
            let found = emitter_at(stage, &vertex.point, (light, pmf), u1, u2)
                .and_then(|emitter| next_event_at(plan, vertex, &emitter, out, counters));
            *visit.drawn = found.map_or(Drawn::Nothing, Drawn::NextEvent);
            ControlFlow::Continue(())
        });
        flat.connect(self.scratch.level);
        let mut rest = flat.list.iter().enumerate().peekable();
        self.visit(|i, visit| {
            if let Some((k, connection)) = rest.next_if(|(_, found)| found.walk as usize == i) {
                let found = flat.next_event(k, connection, visit);
                *visit.drawn = found.map_or(Drawn::Nothing, Drawn::NextEvent);
            }
            steps.connect(visit);
            ControlFlow::Continue(())
        });
        self.scratch.flat_connections = flat;
    }
}

impl FlatConnections<'_> {
    /// Evaluates all that is given.
    #[inline(never)]
    fn connect(&mut self, level: Level) {
        self.found.resize(self.list.len());
        dispatch!(level, simd => connect(simd, self));
    }

    /// A connection that was evaluated.
    #[inline(always)]
    fn next_event<'s, S: Scene + ?Sized + 's, P>(
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
            let emitter = SampledEndpoint { point, light: Some(light), pdf };
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
fn connect<S: Simd>(simd: S, FlatConnections { list, given, found }: &mut FlatConnections<'_>) {
    let groups = list.chunks(LANES).zip(given.groups()).zip(found.groups_mut());
    for ((list, given), found) in groups {
        let first = list[0].flat;
        let light = if list.iter().all(|connection| std::ptr::eq(connection.flat, first)) {
            first.numbers().map(|number| f64x8::splat(simd, number))
        } else {
            let mut numbers = [[0.0; LANES]; FLAT];
            for (lane, connection) in list.iter().enumerate() {
                for (row, number) in numbers.iter_mut().zip(connection.flat.numbers()) {
                    row[lane] = number;
                }
            }
            load(simd, &numbers)
        };
        connect_group(simd, &FlatLanes::new(light), given, found);
    }
}

/// [`next_event_at`] in lanes.
#[inline(always)]
fn connect_group<S: Simd>(
    simd: S,
    light: &FlatLanes<f64x8<S>>,
    given: &Group<18>,
    found: &mut Group<14>,
) {
    let [px, py, pz, nx, ny, nz, wx, wy, wz, t0, t1, t2, a0, a1, a2, u1, u2, pdf] =
        load(simd, given);
    let (x, normal) = (Vector::new(px, py, pz), Vector::new(nx, ny, nz));
    let to_previous = Vector::new(wx, wy, wz);
    let (y, error, [u, v]) = light.point_at([u1, u2]);
    let (direction, geometry, is_exact) = edge::between_surfaces((x, normal), (y, light.normal));
    let emits = light.normal.dot(-direction).is_positive();
    let reflects = on_same_side(normal.dot(direction), normal.dot(to_previous));
    let throughput = pdf.constant(1.0) / pdf;
    let value = |t: f64x8<S>, albedo: f64x8<S>, radiance: f64x8<S>| {
        t * (albedo * FRAC_1_PI) * (geometry * (radiance * throughput))
    };
    let [r0, r1, r2] = light.radiance;
    let value = [value(t0, a0, r0), value(t1, a1, r1), value(t2, a2, r2)];
    let zero = pdf.constant(0.0);
    let is_black = value[0].equals(zero) & value[1].equals(zero) & value[2].equals(zero);
    let is_lit = (emits & reflects & !is_black).indicator(zero);
    let state = is_exact.choose(is_lit, zero.constant(INEXACT));
    let [v0, v1, v2] = value;
    let Vector { x, y: dy, z } = direction;
    store(found, [y.x, y.y, y.z, error, u, v, x, dy, z, geometry, v0, v1, v2, state]);
}
