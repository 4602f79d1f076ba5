//! Both ends of a path: a light emits radiance, a camera emits importance, and both are an
//! [`Endpoint`].
//!
//! An endpoint is sampled in two steps, point then direction. The measures of both follow the
//! [`Place`] of the point, and with them the emitted quantity, radiance Le or importance We:
//!
//! | place | density of the point | density of the direction | emitted quantity |
//! |---|---|---|---|
//! | `Area` | per area | per projected solid angle | per area and projected solid angle |
//! | `Dirac` | probability | per solid angle | per solid angle |
//! | `Dirac`, Dirac direction | probability | probability | flux |
//! | `Infinite` | per solid angle | per area perpendicular to the ray | radiance |
//! | `Infinite`, Dirac direction | probability | the same | irradiance on a perpendicular plane |
//!
//! With these, `p(x_0) · p⊥(x_0 → x_1) · G(x_0, x_1)` is the density of the first edge in every
//! case.
//!
//! Lights: [`AreaLight`], [`PointLight`], [`SpotLight`], [`DirectionalLight`],
//! [`ConstantEnvironment`], [`EnvironmentMap`], [`FunctionEnvironment`]; any of them, [`AnyLight`].
//! Cameras: [`PinholeCamera`], [`ThinLensCamera`], [`OrthographicCamera`], and the meters
//! [`IrradianceMeter`] and [`RadianceMeter`]. Importance is normalised over the film, so all
//! integrators normalise alike.
//!
//! # A light of one's own: a laser
//!
//! A beam that has no width is Dirac in position and in direction. A sample then carries the whole
//! flux: both densities are probabilities, 1 if there is but one choice, and the weight is flux over
//! probability. Whoever asks for a *given* direction, as connections do, has no chance of having the
//! right one: `direction_pdf` and `emit` are 0, and `can_be_connected` says so beforehand, since
//! integrators must know which techniques can draw its light (light walks alone: what is seen of a
//! laser are light walks that connect to the lens or to a camera walk).
//!
//! ```
//! use pathspace::endpoint::{
//!     DirectionSample, Endpoint, IrradianceMeter, Light, PointSample,
//! };
//! use pathspace::geometry::{Disk, SurfacePoint};
//! use pathspace::glam::{DVec2, DVec3};
//! use pathspace::integrator::{LightTracer, PathTracer};
//! use pathspace::math::{PerArea, PerProjected, Rgb};
//! use pathspace::render::{Render, Settings, measure};
//! use pathspace::scene::{Material, WorldBuilder};
//!
//! struct Laser {
//!     position: DVec3,
//!     /// Unit vector.
//!     direction: DVec3,
//!     /// W per channel.
//!     flux: Rgb,
//! }
//!
//! impl Endpoint for Laser {
//!     fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
//!         // The place Dirac: no cosine, and the density is a probability.
//!         Some(PointSample { point: SurfacePoint::dirac(self.position), pdf: PerArea(1.0) })
//!     }
//!     fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
//!         PerArea(1.0)
//!     }
//!     fn sample_direction(&self, point: &SurfacePoint, _: DVec2) -> Option<DirectionSample> {
//!         let (direction, pdf) = (self.direction, PerProjected(1.0));
//!         Some(DirectionSample { from: *point, direction, pdf, weight: self.flux })
//!     }
//!     // A given direction has no density and gets no light: both are Dirac distributions.
//!     fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
//!         PerProjected::ZERO
//!     }
//!     fn emit(&self, _: &SurfacePoint, _: DVec3) -> Rgb {
//!         Rgb::BLACK
//!     }
//! }
//!
//! impl Light for Laser {
//!     fn power(&self) -> Rgb {
//!         self.flux
//!     }
//!     fn can_be_hit(&self) -> bool {
//!         false
//!     }
//!     fn can_be_connected(&self) -> bool {
//!         false
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut scene = WorldBuilder::new();
//! let white = scene.add_material("white", Material::Lambert { albedo: Rgb::from(0.9) })?;
//! scene.add_disk("wall", Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 5.0 }, white)?;
//! let (position, direction) = (DVec3::new(1.0, 0.0, 1.0), -DVec3::Z);
//! scene.add_light("laser", Laser { position, direction, flux: Rgb::from(2.0) })?;
//! let scene = scene.build()?;
//! // The spot scatters Φ ρ/π cos θ per solid angle to a meter at a distance of √2 and 45°.
//! let meter = IrradianceMeter::new(DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 0.0, -1.0))?;
//! let light = measure(&scene, &meter, &LightTracer::up_to(1), &Settings::default())?;
//! let expected = 2.0 * 0.9 / std::f64::consts::PI * 0.5f64.sqrt() / 2.0;
//! assert!((light.mean().r() / expected - 1.0).abs() < 1e-6);
//! // A path tracer cannot draw any of it, and says so.
//! assert!(!PathTracer::up_to(1).blind_spots(&scene, &meter)?.is_empty());
//! # Ok(())
//! # }
//! ```
//!
//! Source: Veach 1997, chapter 4, for importance as the dual of radiance.

mod answers;
mod any_light;
mod area;
mod check;
mod cover;
mod directional;
mod environment;
mod environment_map;
mod error;
mod extent;
mod flat;
mod function_environment;
mod irradiance_meter;
mod orthographic;
mod pinhole;
mod point;
mod pointers;
mod radiance_meter;
mod solid_angle;
mod spot;
mod thin_lens;
mod view;

pub(crate) use answers::answers;
pub use any_light::AnyLight;
pub use area::AreaLight;
pub use directional::DirectionalLight;
pub use environment::ConstantEnvironment;
pub use environment_map::{EnvironmentMap, Lookup};
pub use error::EndpointError;
pub use extent::SceneExtent;
pub(crate) use flat::FlatLanes;
pub use flat::FlatLight;
pub use function_environment::FunctionEnvironment;
pub use irradiance_meter::IrradianceMeter;
pub use orthographic::OrthographicCamera;
pub use pinhole::PinholeCamera;
pub use point::PointLight;
pub use radiance_meter::RadianceMeter;
pub use spot::SpotLight;
pub use thin_lens::ThinLensCamera;
pub use view::View;

use crate::film::FilmRegion;
use crate::geometry::{Bounds, Place, SurfacePoint};
use crate::light_tree::LightBounds;
use crate::math::{PerArea, PerProjected, Rgb, unit};
use glam::{DVec2, DVec3};
use std::fmt;

/// A sampled point of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSample {
    /// The point; its primitive and surface ids are those that the scene's intersections report.
    pub point: SurfacePoint,
    /// Its density in the measure of its place.
    pub pdf: PerArea,
}

/// A sampled direction of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionSample {
    /// The point to start the ray from: the given one, except at infinity, where the position is
    /// sampled with the "direction".
    pub from: SurfacePoint,
    /// Unit direction of the ray, away from the endpoint.
    pub direction: DVec3,
    /// Density of the direction.
    pub pdf: PerProjected,
    /// Emitted radiance or importance divided by `pdf`.
    pub weight: Rgb,
}

/// An end of a path: the interface that cameras and lights share. Open for users to implement.
pub trait Endpoint: Sync {
    /// Samples a point to start a walk from. `None` if there is nothing to emit.
    fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample>;

    /// The density with which `sample_point` chooses `point`, which must be on this endpoint.
    fn point_pdf(&self, point: &SurfacePoint) -> PerArea;

    /// Samples the direction of a walk that starts at `point`. For a camera, `u` is the position in
    /// the film's window, from (0, 0) at the upper left to (1, 1) at the lower right; values
    /// slightly outside are valid (pixel filters reach there).
    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample>;

    /// The density with which `sample_direction` chooses `direction`. At infinity the direction is
    /// that of `point`, and the density is that of the ray through the position of `point`.
    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected;

    /// Emitted radiance or importance at `point` into `direction` (away from the endpoint).
    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb;

    /// Samples a point to connect `receiver` to. The default is `sample_point`.
    fn sample_from(&self, receiver: &SurfacePoint, u1: f64, u2: DVec2) -> Option<PointSample> {
        let mut sample = self.sample_point(u1, u2)?;
        sample.point = self.facing(&sample.point, receiver);
        Some(sample)
    }

    /// The density with which `sample_from` chooses `point`, which must be on this endpoint.
    fn pdf_from(&self, _receiver: &SurfacePoint, point: &SurfacePoint) -> PerArea {
        self.point_pdf(point)
    }

    /// The same point, positioned so that the shadow ray between it and `receiver` tests the
    /// visibility of the two. Only points at infinity, which have a direction but no
    /// position of their own, need to move.
    fn facing(&self, point: &SurfacePoint, _receiver: &SurfacePoint) -> SurfacePoint {
        *point
    }
}

/// Identifies a light of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub u32);

/// The kind of a light, as far as it decides which techniques draw its light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightKind {
    /// The kind of its points.
    pub place: Place,
    /// True if a ray can reach it by chance; if not, it is a Dirac light.
    pub hittable: bool,
    /// True if it can be connected to.
    pub connectible: bool,
}

impl fmt::Display for LightKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.hittable, self.connectible, self.place) {
            (true, _, Place::Infinite) => "environment",
            (true, ..) => "area light",
            (false, false, _) => "beam",
            (false, true, Place::Infinite) => "directional light",
            (false, true, _) => "point light",
        })
    }
}

/// An endpoint that emits radiance.
pub trait Light: Endpoint {
    /// Emitted flux (W per channel), or an estimate of it; decides how often the light is chosen,
    /// never the image's mean. A light whose power is 0 must be [black](Self::is_black) or emit
    /// nothing; else building a scene with it is an error.
    fn power(&self) -> Rgb;

    /// True if a ray can reach it by chance: area lights and environments, not Dirac lights.
    fn can_be_hit(&self) -> bool;

    /// A point for `receiver` as [`sample_from`](Endpoint::sample_from) draws it, and what it emits to
    /// the receiver ([`emit`](Endpoint::emit)) if that is found on the way. Optional, for speed
    /// alone.
    fn sample_emission(
        &self,
        receiver: &SurfacePoint,
        u1: f64,
        u2: DVec2,
    ) -> Option<(PointSample, Option<Rgb>)> {
        Some((self.sample_from(receiver, u1, u2)?, None))
    }

    /// Radiance that `point` emits into `direction`, with the density with which `receiver` would
    /// have been connected to it: [`emit`](Endpoint::emit) and [`pdf_from`](Endpoint::pdf_from). A
    /// point that emits nothing needs no density. Optional, for speed alone, where the two have
    /// work in common.
    fn emission_and_pdf(
        &self,
        receiver: &SurfacePoint,
        point: &SurfacePoint,
        direction: DVec3,
    ) -> (Rgb, PerArea) {
        let radiance = self.emit(point, direction);
        let is_lit = !radiance.is_black();
        (radiance, if is_lit { self.pdf_from(receiver, point) } else { PerArea::ZERO })
    }

    /// Bounds on where it is and where it shines, by which it is chosen for a receiver. `None` if
    /// it has none, as lights at infinity: then it is chosen by its power.
    fn bounds(&self) -> Option<LightBounds> {
        None
    }

    /// True if it can be connected to: everything but a light with both Dirac position and Dirac
    /// direction.
    fn can_be_connected(&self) -> bool {
        true
    }

    /// Its kind.
    fn kind(&self) -> LightKind {
        let point = self.sample_point(0.5, DVec2::splat(0.5));
        LightKind {
            place: point.map_or(Place::Area, |sample| sample.point.place),
            hittable: self.can_be_hit(),
            connectible: self.can_be_connected(),
        }
    }

    /// True if it emits nothing at all. `false` is always safe.
    fn is_black(&self) -> bool {
        false
    }

    /// True if its light can reach anything inside the box, the bounds of all surfaces. `true` is
    /// always safe.
    fn can_illuminate(&self, bounds: &Bounds) -> bool {
        !bounds.is_empty()
    }

    /// This light as one flat shape, if it is that and nothing else: `emit` is its radiance on its
    /// front, and for a receiver that is not near, `sample_from` and `pdf_from` are its points and
    /// its density. Optional, for speed alone: such lights are sampled for many receivers at a time.
    fn as_flat(&self) -> Option<&FlatLight> {
        None
    }

    /// Tells lights at infinity the extent of the scene that they must illuminate. Called by a
    /// scene once, before rendering.
    fn set_scene_extent(&mut self, _extent: &SceneExtent) {}

    /// This light as one of any kind, as which a [`World`](crate::scene::World) keeps it. Provided
    /// for all lights but those of this crate.
    fn into_any(self) -> AnyLight
    where
        Self: Sized + Send + 'static,
    {
        AnyLight::Custom(Box::new(self))
    }
}

/// An endpoint that emits importance, normalised such that its integral over the film's window, all
/// directions and the lens is 1.
pub trait Camera: Endpoint {
    /// The film's resolution and the window of it that is rendered.
    fn film(&self) -> FilmRegion;

    /// The kind of point that the lens is made of. Asked at every connection to the lens: where it
    /// is a point ([`Place::Dirac`]) no numbers are drawn for it, and [`Endpoint::sample_point`]
    /// and [`Endpoint::sample_from`] get zeros.
    fn place(&self) -> Place {
        self.sample_point(0.5, DVec2::splat(0.5)).map_or(Place::Area, |sample| sample.point.place)
    }

    /// The position on the film (in pixels of the full film) at which the ray from `point` into
    /// `direction` is recorded; `None` if it cannot be, as behind the camera. The result may lie
    /// outside the window.
    fn raster(&self, point: &SurfacePoint, direction: DVec3) -> Option<DVec2>;

    /// The position on the film (in pixels of the full film) at which the middle of the lens sees a
    /// point of the scene, whatever is in between; `None` if it does not, as behind the camera. The
    /// result may lie outside the window. Out of focus it is the middle of the point's blurred
    /// image.
    fn project(&self, position: DVec3) -> Option<DVec2> {
        let receiver = SurfacePoint::dirac(position);
        let lens = self.sample_from(&receiver, 0.5, DVec2::splat(0.5))?.point;
        let direction = match lens.place {
            Place::Infinite => lens.geometric_normal,
            _ => unit(position - lens.position)?,
        };
        self.raster(&lens, direction)
    }

    /// True if light walks can be connected to it: everything but a camera with both Dirac position
    /// and Dirac direction, to which no other technique than t ≥ 2 leads.
    fn can_be_connected(&self) -> bool {
        true
    }

    /// The quantity that [`measure`](crate::render::measure()) gives, over the mean radiance of the
    /// film's window: π for an [`IrradianceMeter`].
    fn response(&self) -> f64 {
        1.0
    }

    /// The view of this camera, if it is a pinhole and nothing else: then importance, density and
    /// raster position are those of [`PinholeCamera`]. Optional, for speed alone: such a camera is
    /// connected to many points at a time.
    fn as_pinhole(&self) -> Option<&View> {
        None
    }
}
