//! A vertex of a subpath, with everything that the walk which found it knows about it.

use crate::bsdf::shading::ShadedBsdf;
use crate::bsdf::{Bsdf, LaneForm, Lobes};
use crate::endpoint::{Endpoint, LightId};
use crate::geometry::SurfacePoint;
use crate::math::{PerArea, PerProjected, Rgb};
use crate::scene::Scene;
use glam::DVec3;

/// A vertex of a walk. "Next" and "previous" are meant in the direction of the walk.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<B> {
    /// The point in the scene.
    pub point: SurfacePoint,
    /// The BSDF; `None` at an endpoint (lens, start of a light subpath, environment).
    pub bsdf: Option<ShadedBsdf<B>>,
    /// The light that the point belongs to, if it emits.
    pub light: Option<LightId>,
    /// Estimate `f/p` of the walk up to here: everything before this vertex's own scattering or
    /// emission.
    pub throughput: Rgb,
    /// Product of the probabilities of surviving Russian roulette on the way here; `throughput`
    /// contains its inverse.
    pub survival: f64,
    /// Unit direction to the previous vertex; zero at the start.
    pub to_previous: DVec3,
    /// Density of the direction to the next vertex, given the previous one; of an endpoint, given
    /// its point.
    pub pdf_next: PerProjected,
    /// Density with which the opposite walk would choose the direction to the previous vertex,
    /// given the next one.
    pub pdf_back: PerProjected,
    /// Geometry term of the edge to the previous vertex.
    pub geometry: f64,
    /// True if a Dirac lobe was sampled here.
    pub dirac: bool,
    /// Densities of an endpoint as a starting point; zero elsewhere.
    pub start: StartDensity,
    /// The partial sum of [`Weighting`](super::Weighting), once the subpath is complete.
    pub(super) partial: f64,
}

/// The two densities of an endpoint's position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StartDensity {
    /// The density as the start of a walk, probability of choosing the light included.
    pub walk: PerArea,
    /// The density as the point that the neighbouring vertex connects to, probability of choosing
    /// the light included.
    pub connection: PerArea,
}

impl StartDensity {
    /// The ratio of the density of a connection's point to that of a walk's.
    #[inline]
    pub(super) fn bias(&self) -> f64 {
        self.connection.value() / self.walk.value()
    }
}

impl<B: Bsdf> Vertex<B> {
    /// The start of a walk. Everything that the walk has yet to find out is zero, the throughput
    /// one.
    #[must_use]
    pub fn endpoint(point: SurfacePoint, light: Option<LightId>, start: StartDensity) -> Self {
        Self {
            point,
            bsdf: None,
            light,
            throughput: Rgb::WHITE,
            survival: 1.0,
            to_previous: DVec3::ZERO,
            pdf_next: PerProjected::ZERO,
            pdf_back: PerProjected::ZERO,
            geometry: 0.0,
            dirac: false,
            start,
            partial: 0.0,
        }
    }

    /// The light that the point belongs to, and the radiance that it emits to the previous vertex;
    /// `None` if that is nothing.
    #[inline]
    #[must_use]
    pub fn emission<S: Scene + ?Sized>(&self, scene: &S) -> Option<(LightId, Rgb)> {
        let light = self.light?;
        let radiance = scene.light(light).emit(&self.point, self.to_previous);
        (!radiance.is_black()).then_some((light, radiance))
    }

    /// A vertex that nothing has been entered in.
    pub(super) fn blank() -> Self {
        Self::endpoint(SurfacePoint::dirac(DVec3::ZERO), None, StartDensity::default())
    }

    /// The form in which lanes can scatter what comes from or goes to the previous vertex; they know
    /// of no media.
    #[inline(always)]
    pub(super) fn lane_form(&self) -> Option<LaneForm> {
        if self.point.medium != 0 {
            return None;
        }
        self.bsdf.as_ref()?.lane_form(self.to_previous)
    }

    /// True if the surface has lobes that are functions, so that a connection can carry light.
    #[inline]
    #[must_use]
    pub fn is_connectible(&self) -> bool {
        self.finite_bsdf().is_some()
    }

    /// The BSDF, if it has lobes that are functions.
    #[inline]
    #[must_use]
    pub fn finite_bsdf(&self) -> Option<&ShadedBsdf<B>> {
        self.bsdf.as_ref().filter(|bsdf| bsdf.lobes().intersects(Lobes::FINITE))
    }
}
