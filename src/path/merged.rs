//! A path whose subpaths meet at a vertex that both have found.

use super::mis::{Ends, PathDensities};
use super::view::ends;
use super::{Stage, Vertex, Weighting};
use crate::bsdf::TransportMode;
use crate::endpoint::LightId;
use crate::film::Technique;
use crate::math::Rgb;
use crate::scene::Scene;
use std::fmt;

/// A path of a camera subpath and a light subpath whose last vertices are near each other and are
/// taken as one: x_m, with the position and the BSDF of the camera's, and the direction to the
/// light of the photon. Copies nothing.
pub struct MergedPath<'v, 's, S: Scene + ?Sized + 's> {
    pub(super) stage: &'v Stage<'s, S>,
    camera_part: &'v [Vertex<S::Bsdf<'s>>],
    light_part: &'v [Vertex<S::Bsdf<'s>>],
    light: LightId,
    /// `T f Φ`, which a density per area makes a contribution.
    flux: Rgb,
    /// Densities at x_m, towards the light and towards the camera.
    onwards: [f64; 2],
}

impl<'s, S: Scene + ?Sized + 's> fmt::Debug for MergedPath<'_, 's, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MergedPath")
            .field("technique", &self.technique())
            .field("flux", &self.flux)
            .finish()
    }
}

impl<'v, 's, S: Scene + ?Sized + 's> MergedPath<'v, 's, S> {
    /// The path that takes the last vertices of two subpaths, neither of them at its start, as one.
    /// `None` if it carries nothing.
    #[must_use]
    pub fn new(
        stage: &'v Stage<'s, S>,
        camera_part: &'v [Vertex<S::Bsdf<'s>>],
        light_part: &'v [Vertex<S::Bsdf<'s>>],
    ) -> Option<Self> {
        let ([_, .., y], [start, .., z]) = (camera_part, light_part) else { return None };
        let (light, bsdf) = (start.light?, y.bsdf.as_ref()?);
        let (to_light, to_camera) = (z.to_previous, y.to_previous);
        let flux = y.throughput * bsdf.eval(to_light, to_camera) * z.throughput;
        if flux.is_black() {
            return None;
        }
        let onwards = [
            bsdf.pdf(to_camera, to_light, TransportMode::Radiance).value(),
            bsdf.pdf(to_light, to_camera, TransportMode::Importance).value(),
        ];
        Some(Self { stage, camera_part, light_part, light, flux, onwards })
    }

    /// The technique that drew the path.
    #[must_use]
    pub fn technique(&self) -> Technique {
        Technique::merge(self.light_part.len() as u16, self.camera_part.len() as u16)
    }

    /// Unweighted estimate `f(x)/(N p(x))` within the disc of a weighting and with its number of
    /// light walks.
    #[must_use]
    pub fn value(&self, weighting: &Weighting) -> Rgb {
        self.flux * (1.0 / (f64::from(weighting.set().merges) * weighting.merge_area()))
    }

    /// The light at the end.
    #[must_use]
    pub fn light(&self) -> LightId {
        self.light
    }

    /// m, the index of the vertex where the subpaths meet.
    #[must_use]
    pub fn meeting(&self) -> usize {
        self.camera_part.len() - 1
    }

    /// Vertex `x_i`, as the walk that found it knows it; x_m as the camera's.
    #[must_use]
    pub fn vertex(&self, i: usize) -> &Vertex<S::Bsdf<'s>> {
        self.camera_part.get(i).unwrap_or_else(|| self.light_vertex(i))
    }

    /// Vertex x_m as the light walk knows it.
    #[must_use]
    pub fn photon(&self) -> &Vertex<S::Bsdf<'s>> {
        self.light_vertex(self.meeting())
    }

    /// Vertex `x_i`, i ≥ m, of the light subpath.
    fn light_vertex(&self, i: usize) -> &Vertex<S::Bsdf<'s>> {
        &self.light_part[self.edges() - i]
    }

    /// Product of the probabilities 1 - q with which the walks survived Russian roulette; the value
    /// contains its inverse.
    #[must_use]
    pub fn survival(&self) -> f64 {
        self.vertex(self.meeting()).survival * self.photon().survival
    }

    /// The multiple importance sampling weight of the merge, within a set that contains it; by a
    /// sweep over all techniques.
    #[must_use]
    pub fn weight(&self, weighting: &Weighting) -> f64 {
        PathDensities::weight(self, self.technique(), weighting)
    }

    /// The same from the partial sums of complete subpaths.
    #[must_use]
    pub fn weight_of_sides(&self, weighting: &Weighting) -> f64 {
        let camera = weighting.camera_side(self.camera_part);
        let light = weighting.light_side(self.light_part, self.stage.scene);
        let [to_light, to_camera] = self.onwards;
        weighting.merge_weight([(&camera, to_camera), (&light, to_light)])
    }
}

impl<'s, S: Scene + ?Sized + 's> PathDensities for MergedPath<'_, 's, S> {
    fn edges(&self) -> usize {
        self.camera_part.len() + self.light_part.len() - 2
    }

    fn towards_light(&self, i: usize) -> f64 {
        let m = self.meeting();
        match i {
            _ if i < m => self.camera_part[i].pdf_next.value(),
            _ if i == m => self.onwards[0],
            _ => self.light_vertex(i).pdf_back.value(),
        }
    }

    fn towards_camera(&self, i: usize) -> f64 {
        let m = self.meeting();
        match i {
            _ if i < m => self.camera_part[i].pdf_back.value(),
            _ if i == m => self.onwards[1],
            _ => self.light_vertex(i).pdf_next.value(),
        }
    }

    fn geometry(&self, i: usize) -> f64 {
        if i < self.meeting() {
            self.camera_part[i + 1].geometry
        } else {
            self.light_vertex(i).geometry
        }
    }

    fn is_dirac(&self, i: usize) -> bool {
        i != self.meeting() && self.vertex(i).dirac
    }

    fn ends(&self) -> Ends {
        let [lens, first, end] = [0, 1, self.edges()].map(|i| self.vertex(i));
        let points = [&lens.point, &first.point, &end.point];
        ends(self.stage.scene.light(self.light), points, [lens.start, end.start])
    }
}
