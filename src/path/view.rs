//! A path as a view of the camera part and the light part that it was drawn from.

use super::connect::are_joinable;
use super::mis::{Ends, PathDensities};
use super::pairs::Pair;
use super::walk::{emission_density, emission_pdf};
use super::{Counters, Edge, Stage, StartDensity, Vertex, Weighting};
use crate::bsdf::TransportMode;
use crate::endpoint::{Endpoint, Light, LightId};
use crate::film::Technique;
use crate::geometry::{Place, SurfacePoint};
use crate::math::Rgb;
use crate::scene::Scene;
use crate::tree::Segment;
use glam::DVec2;
use std::f64::consts::PI;
use std::fmt;

/// A complete path `x_0 … x_k`: the first t vertices from the camera, the last s from the light.
/// Copies nothing.
pub struct Path<'v, 's, S: Scene + ?Sized + 's> {
    pub(super) stage: &'v Stage<'s, S>,
    pub(super) camera_part: &'v [Vertex<S::Bsdf<'s>>],
    pub(super) light_part: &'v [Vertex<S::Bsdf<'s>>],
    pub(super) light: LightId,
    /// The connecting edge, from the camera part to the light part; `None` if s = 0.
    pub(super) joint: Option<Edge>,
    /// The shadow ray along it, if it is known and the scene has [flat
    /// surfaces](Scene::flat_surfaces).
    pub(super) segment: Option<Segment>,
    value: Rgb,
}

impl<'s, S: Scene + ?Sized + 's> Clone for Path<'_, 's, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<'s, S: Scene + ?Sized + 's> Copy for Path<'_, 's, S> {}

impl<'s, S: Scene + ?Sized + 's> fmt::Debug for Path<'_, 's, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Path")
            .field("technique", &self.technique())
            .field("value", &self.value)
            .finish()
    }
}

impl<'v, 's, S: Scene + ?Sized + 's> Path<'v, 's, S> {
    /// The path of two parts: [hit](Self::hit) if there is none from the light, else
    /// [connected](Self::connect).
    #[inline]
    #[must_use]
    pub fn new(
        stage: &'v Stage<'s, S>,
        camera_part: &'v [Vertex<S::Bsdf<'s>>],
        light_part: &'v [Vertex<S::Bsdf<'s>>],
    ) -> Option<Self> {
        if light_part.is_empty() {
            Self::hit(stage, camera_part)
        } else {
            Self::connect(stage, camera_part, light_part)
        }
    }

    /// The path of a camera walk whose last vertex is on a light (s = 0). `None` if it is not, or
    /// emits nothing this way.
    #[inline]
    #[must_use]
    pub fn hit(stage: &'v Stage<'s, S>, camera_part: &'v [Vertex<S::Bsdf<'s>>]) -> Option<Self> {
        let end = camera_part.last()?;
        let (light, radiance) = end.emission(stage.scene)?;
        if camera_part.len() < 2 {
            return None;
        }
        let value = end.throughput * radiance;
        Some(Self { stage, camera_part, light_part: &[], light, joint: None, segment: None, value })
    }

    /// The path that joins the last vertices of a camera part and a light part, neither of them
    /// empty. Everything but visibility is evaluated; `None` if that is already zero, or if the
    /// connection is of a kind that cannot carry light.
    #[inline]
    #[must_use]
    pub fn connect(
        stage: &'v Stage<'s, S>,
        camera_part: &'v [Vertex<S::Bsdf<'s>>],
        light_part: &'v [Vertex<S::Bsdf<'s>>],
    ) -> Option<Self> {
        let (y, z) = (camera_part.last()?, light_part.last()?);
        let light = light_part[0].light?;
        let edge = Edge::between(&y.point, &z.point)?;
        if edge.geometry == 0.0 {
            return None;
        }
        let at_camera = match &y.bsdf {
            None => stage.camera.emit(&y.point, edge.direction),
            Some(bsdf) => bsdf.eval(edge.direction, y.to_previous),
        };
        if at_camera.is_black() {
            return None;
        }
        let at_light = match &z.bsdf {
            None => stage.scene.light(light).emit(&z.point, -edge.direction),
            Some(bsdf) => bsdf.eval(z.to_previous, -edge.direction),
        };
        if at_light.is_black() {
            return None;
        }
        let passing = stage.scene.transmittance(&y.point, &z.point);
        let arriving = edge.geometry * (at_light * z.throughput);
        let value = (y.throughput * at_camera) * arriving * passing;
        let joint = Some(edge);
        let path = Self { stage, camera_part, light_part, light, joint, segment: None, value };
        let lens_to_light = camera_part.len() == 1 && light_part.len() == 1;
        (!value.is_black() && (!lens_to_light || path.ends_are_joinable())).then_some(path)
    }

    /// A path of two parts whose connection was evaluated.
    #[inline(always)]
    pub(super) fn evaluated(
        stage: &'v Stage<'s, S>,
        [camera_part, light_part]: [&'v [Vertex<S::Bsdf<'s>>]; 2],
        &Pair { edge, value, segment, .. }: &Pair,
    ) -> Option<Self> {
        let (light, joint) = (light_part.first()?.light?, Some(edge));
        let segment = stage.scene.flat_surfaces().map(|_| segment);
        Some(Self { stage, camera_part, light_part, light, joint, segment, value })
    }

    /// The subject of the rendering that drew it.
    #[must_use]
    pub fn stage(&self) -> &'v Stage<'s, S> {
        self.stage
    }

    /// The technique that drew the path.
    #[must_use]
    pub fn technique(&self) -> Technique {
        Technique::new(self.light_part.len() as u16, self.camera_part.len() as u16)
    }

    /// Unweighted estimate `f(x)/p(x)`, without the visibility of the connecting edge.
    #[must_use]
    pub fn value(&self) -> Rgb {
        self.value
    }

    /// Position on the film, in pixels of the full film, at which the lens records the connecting
    /// edge; `None` if it cannot. Meant for a camera part that is the lens alone.
    #[inline]
    #[must_use]
    pub fn lens_raster(&self) -> Option<DVec2> {
        self.stage.camera.raster(&self.camera_part.first()?.point, self.joint?.direction)
    }

    /// Number of scattering events, k - 1.
    #[must_use]
    pub fn bounces(&self) -> usize {
        self.edges() - 1
    }

    /// Number of edges k.
    #[must_use]
    pub fn edges(&self) -> usize {
        self.camera_part.len() + self.light_part.len() - 1
    }

    /// The connecting edge, from the camera's side; `None` if the camera walk hit the light.
    #[must_use]
    pub fn joint(&self) -> Option<&Edge> {
        self.joint.as_ref()
    }

    /// The light at the end.
    #[must_use]
    pub fn light(&self) -> LightId {
        self.light
    }

    /// Vertex `x_i`, as the walk that found it knows it.
    #[must_use]
    pub fn vertex(&self, i: usize) -> &Vertex<S::Bsdf<'s>> {
        let t = self.camera_part.len();
        if i < t { &self.camera_part[i] } else { &self.light_part[self.edges() - i] }
    }

    /// Tests the connecting edge, if there is one.
    #[inline]
    #[must_use]
    pub fn is_visible(&self, counters: &mut Counters) -> bool {
        let (Some(y), Some(z)) = (self.camera_part.last(), self.light_part.last()) else {
            return true;
        };
        counters.shadow_rays += 1;
        match self.facing() {
            Some(facing) => self.stage.scene.visible(&y.point, &facing),
            None => self.stage.scene.visible(&y.point, &z.point),
        }
    }

    /// The point of a light that the lens connects to, if the light walk was not placed for it.
    #[inline]
    #[must_use]
    pub fn facing(&self) -> Option<SurfacePoint> {
        let ([lens], [start]) = (self.camera_part, self.light_part) else { return None };
        Some(self.stage.scene.light(self.light).facing(&start.point, &lens.point))
    }

    /// The multiple importance sampling weight of the technique that drew the path, within a set
    /// that contains it; by a sweep over all techniques.
    #[inline]
    #[must_use]
    pub fn weight(&self, weighting: &Weighting) -> f64 {
        self.densities().weight(self.technique(), weighting)
    }

    /// Product of the probabilities 1 - q with which the walks survived Russian roulette; `value`
    /// contains its inverse.
    #[must_use]
    pub fn survival(&self) -> f64 {
        self.camera_part.last().map_or(1.0, |v| v.survival)
            * self.light_part.last().map_or(1.0, |v| v.survival)
    }

    /// The densities along the path, from what the walks cached and what only the connection
    /// decides.
    #[must_use]
    pub fn densities(&self) -> impl PathDensities {
        CachedDensities { path: self, joint: self.joint_densities(), ends: self.ends() }
    }

    /// Densities of the point on the light.
    pub(super) fn light_start(&self) -> StartDensity {
        match (self.light_part, self.camera_part) {
            ([start, ..], _) => start.start,
            ([], [.., receiver, end]) => {
                emission_density(self.stage, self.light, &receiver.point, &end.point)
            }
            _ => StartDensity::default(),
        }
    }

    pub(super) fn ends_are_joinable(&self) -> bool {
        let hittable = self.stage.scene.light(self.light).can_be_hit();
        let lens = self.vertex(0).point.place;
        let light = self.vertex(self.edges()).point.place;
        are_joinable(lens, light, hittable)
    }

    fn ends(&self) -> Ends {
        let [lens, first, end] = [0, 1, self.edges()].map(|i| self.vertex(i));
        let points = [&lens.point, &first.point, &end.point];
        ends(self.stage.scene.light(self.light), points, [lens.start, self.light_start()])
    }

    /// Densities at the two vertices that the connection joins; they depend on both parts.
    pub(super) fn joint_densities(&self) -> JointDensities {
        let mut joint = JointDensities::default();
        let Some(y) = self.camera_part.last() else { return joint };
        let Some(edge) = &self.joint else {
            joint.towards_camera =
                self.stage.scene.light(self.light).direction_pdf(&y.point, y.to_previous).value();
            return joint;
        };
        let z = self.vertex(self.camera_part.len());
        match &y.bsdf {
            None => {
                joint.towards_light =
                    self.stage.camera.direction_pdf(&y.point, edge.direction).value()
            }
            Some(bsdf) => {
                joint.towards_light =
                    bsdf.pdf(y.to_previous, edge.direction, TransportMode::Radiance).value();
                joint.before =
                    bsdf.pdf(edge.direction, y.to_previous, TransportMode::Importance).value();
            }
        }
        match &z.bsdf {
            None => {
                let light = self.stage.scene.light(self.light);
                joint.towards_camera = emission_pdf(light, &z.point, &y.point, -edge.direction);
            }
            Some(bsdf) => {
                joint.towards_camera =
                    bsdf.pdf(z.to_previous, -edge.direction, TransportMode::Importance).value();
                joint.behind =
                    bsdf.pdf(-edge.direction, z.to_previous, TransportMode::Radiance).value();
            }
        }
        joint
    }
}

/// The ends of a path by its light, its points x_0, x_1 and x_k, and the densities of x_0 and x_k.
pub(super) fn ends(
    light: &(impl Light + ?Sized),
    [lens, first, end]: [&SurfacePoint; 3],
    [camera_start, light_start]: [StartDensity; 2],
) -> Ends {
    let footprint = if lens.place == Place::Infinite || first.place == Place::Infinite {
        1.0
    } else {
        let radius = lens.position.distance(first.position) * libm::tan(1f64.to_radians());
        PI * radius * radius
    };
    let area = if end.place == Place::Area { footprint } else { 1.0 };
    let hittable = light.can_be_hit();
    Ends {
        camera: camera_start.walk.value(),
        camera_connection: camera_start.connection.value(),
        light: light_start.walk.value(),
        light_connection: light_start.connection.value(),
        hittable,
        connectible: light.can_be_connected(),
        joinable: are_joinable(lens.place, end.place, hittable),
        footprint,
        light_footprint: light_start.walk.value() * area,
    }
}

/// Densities per projected solid angle around the connecting edge.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct JointDensities {
    /// x_{t-1} → x_t.
    pub towards_light: f64,
    /// x_t → x_{t-1}; with s = 0, of the emission at x_k.
    pub towards_camera: f64,
    /// x_{t-1} → x_{t-2}.
    pub before: f64,
    /// x_t → x_{t+1}.
    pub behind: f64,
}

struct CachedDensities<'p, 'v, 's, S: Scene + ?Sized + 's> {
    path: &'p Path<'v, 's, S>,
    joint: JointDensities,
    ends: Ends,
}

impl<'s, S: Scene + ?Sized + 's> PathDensities for CachedDensities<'_, '_, 's, S> {
    fn edges(&self) -> usize {
        self.path.edges()
    }

    #[inline]
    fn towards_light(&self, i: usize) -> f64 {
        let (t, s) = (self.path.camera_part.len(), self.path.light_part.len());
        if i + 1 < t {
            self.path.camera_part[i].pdf_next.value()
        } else if i + 1 == t {
            self.joint.towards_light
        } else if i == t {
            self.joint.behind
        } else {
            self.path.light_part[s + t - 1 - i].pdf_back.value()
        }
    }

    #[inline]
    fn towards_camera(&self, i: usize) -> f64 {
        let (t, s) = (self.path.camera_part.len(), self.path.light_part.len());
        if i > t {
            self.path.light_part[s + t - 1 - i].pdf_next.value()
        } else if i == t || (s == 0 && i + 1 == t) {
            self.joint.towards_camera
        } else if i + 1 == t {
            self.joint.before
        } else {
            self.path.camera_part[i].pdf_back.value()
        }
    }

    #[inline]
    fn geometry(&self, i: usize) -> f64 {
        let t = self.path.camera_part.len();
        if i + 1 < t {
            self.path.camera_part[i + 1].geometry
        } else if i + 1 == t {
            self.path.joint.map_or(0.0, |edge| edge.geometry)
        } else {
            self.path.vertex(i).geometry
        }
    }

    #[inline]
    fn is_dirac(&self, i: usize) -> bool {
        let t = self.path.camera_part.len();
        let at_joint = self.path.joint.is_some() && (i + 1 == t || i == t);
        !at_joint && self.path.vertex(i).dirac
    }

    fn ends(&self) -> Ends {
        self.ends
    }
}
