//! Scenes: the [`Scene`] trait, the one seam for other renderers, and the ready-made [`World`].
//!
//! Integrators know of a scene what the path integral asks for:
//!
//! | quantity | item |
//! |---|---|
//! | next vertex along a ray | [`Scene::intersect`] |
//! | visibility V of the geometry term (shadow rays) | [`Scene::visible`] |
//! | what media leave of the light along an edge | [`Scene::transmittance`] |
//! | f at a point | [`Scene::bsdf`] |
//! | Le, and the light that a point belongs to | [`Scene::light`], [`Scene::light_at`] |
//! | choice of a light to start at, and its probability | [`Scene::pick_light`], [`Scene::pick_pmf`] |
//! | the same for a receiver | [`Scene::pick_light_for`], [`Scene::pick_pmf_for`] |
//! | features that the scene has at all | [`Needs`] |
//!
//! [`Regularized`] is a scene with glossy lobes in place of Dirac ones.
//!
//! A [`WorldBuilder`] makes a [`World`] of shapes, [`Mesh`]es, [`Material`]s and lights. It refuses
//! what cannot be rendered with a [`SceneError`]; a [`Warning`] tells where f64 gets short.

mod builder;
mod error;
mod lights;
mod mesh;
mod needs;
mod regularized;
mod surface;
mod variation;
mod view;
mod warning;
mod world;

pub use crate::material::Material;
pub use crate::tree::TreeStatistics;
pub use builder::WorldBuilder;
pub use error::SceneError;
pub use mesh::Mesh;
pub use needs::Needs;
pub(crate) use regularized::checked_radius;
pub use regularized::{Regularized, RegularizedBsdf};
pub use surface::{Emission, MaterialId, SurfaceId};
pub use variation::Variation;
pub(crate) use view::answers_of_scene;
pub use warning::Warning;
pub(crate) use world::{DIFFUSE, Diffuse, FlatHit, Meeting};
pub use world::{FlatSurfaces, World};

use crate::bsdf::Bsdf;
use crate::endpoint::{Light, LightId, LightKind};
use crate::geometry::SurfacePoint;
use crate::light_tree::LightTree;
use crate::math::Rgb;
use glam::{DVec2, DVec3};

/// The questions of integrators about a scene. A host renderer implements it over its own geometry
/// and materials.
///
/// Points go in, not rays: the scene owns robustness, so a surface never shadows itself and no
/// epsilon leaks into integrators.
pub trait Scene: Sync {
    /// The BSDF of a point: an enum, one concrete model, or `&dyn Bsdf`; the host decides.
    type Bsdf<'a>: Bsdf
    where
        Self: 'a;
    /// The type of lights; may be `dyn Light`.
    type Light: Light + ?Sized;

    /// The scene as the [`World`] that it is: of no other type.
    #[doc(hidden)]
    const AS_WORLD: Option<fn(&Self) -> &World> = None;

    /// The nearest surface point that the ray from `from` into the unit vector `direction` meets,
    /// never `from` itself.
    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint>;

    /// True if a shadow ray between two points meets nothing: the open segment between them is
    /// free. For a point at infinity the position tells where it ends.
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool;

    /// The answers of [`intersect`](Self::intersect) for many rays. `found` gets each answer once,
    /// with the ray's place in the iterator, in any order.
    ///
    /// A scene overrides this where it gains from seeing rays that do not depend on one another:
    /// while one waits for memory, others go on.
    fn intersect_many<'a>(
        &self,
        rays: impl Iterator<Item = (&'a SurfacePoint, DVec3)>,
        mut found: impl FnMut(usize, Option<SurfacePoint>),
    ) {
        for (index, (from, direction)) in rays.enumerate() {
            found(index, self.intersect(from, direction));
        }
    }

    /// The answers of [`visible`](Self::visible) for many shadow rays. `answer` gets each answer
    /// once, with the ray's place in the iterator, in any order.
    fn visible_many<'a>(
        &self,
        segments: impl Iterator<Item = (&'a SurfacePoint, &'a SurfacePoint)>,
        mut answer: impl FnMut(usize, bool),
    ) {
        for (index, (a, b)) in segments.enumerate() {
            answer(index, self.visible(a, b));
        }
    }

    /// The share of light that passes between two points which see each other; the rest is absorbed
    /// on the way. The same in both directions.
    fn transmittance(&self, _a: &SurfacePoint, _b: &SurfacePoint) -> Rgb {
        Rgb::WHITE
    }

    /// The medium into which the direction leads from a point, as this scene numbers them. A walk
    /// notes it in the [next point](SurfacePoint::medium).
    fn medium_towards(&self, _x: &SurfacePoint, _direction: DVec3) -> u16 {
        0
    }

    /// The medium around a point where a walk starts.
    fn medium_at(&self, _x: &SurfacePoint) -> u16 {
        0
    }

    /// The scattering function at a surface point that this scene returned.
    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_>;

    /// The light that a surface point belongs to, if it emits.
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId>;

    /// The light that rays which leave the scene reach: an environment.
    fn environment(&self) -> Option<LightId> {
        None
    }

    /// A light by its id.
    fn light(&self, id: LightId) -> &Self::Light;

    /// Chooses the light at which a walk starts, with a number in `[0, 1)`; returns its probability
    /// too. `None` if there is no light.
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)>;

    /// The probability with which `pick_light` chooses a light.
    fn pick_pmf(&self, id: LightId) -> f64;

    /// Chooses a light to connect `receiver` to; returns its probability too. `None` if no light
    /// can reach it. The default does not look at the receiver.
    fn pick_light_for(&self, _receiver: &SurfacePoint, u: f64) -> Option<(LightId, f64)> {
        self.pick_light(u)
    }

    /// The probability with which `pick_light_for` chooses a light for the same receiver; to the
    /// bit the one that it returns.
    fn pick_pmf_for(&self, _receiver: &SurfacePoint, id: LightId) -> f64 {
        self.pick_pmf(id)
    }

    /// The tree that all four choose by, items being the numbers of lights, if they do: a rendering
    /// then [scales](crate::light_tree::Arrival) their choice by what arrives in its picture.
    fn light_tree(&self) -> Option<&LightTree> {
        None
    }

    /// The names of the lights of a kind, by which a run tells what its image lacks; `None` if the
    /// scene does not name its lights.
    fn light_names(&self, _kind: LightKind) -> Option<Vec<&str>> {
        None
    }

    /// The flat diffuse surfaces of the world that this scene is made of, if it is: walks between
    /// them then advance eight at a time. For speed alone: whoever hands them on gets the same image
    /// sooner.
    fn flat_surfaces(&self) -> Option<FlatSurfaces<'_>> {
        None
    }

    /// A number that differs between scenes that look different, by which a rendering that goes on
    /// from a [`Checkpoint`](crate::render::Checkpoint) knows its scene again; `None` if the scene
    /// has none, and is then not told apart from others. [`Fingerprint`](crate::math::Fingerprint)
    /// makes one.
    fn fingerprint(&self) -> Option<u64> {
        None
    }

    /// The features that rendering this scene takes; integrators leave out the rest.
    fn needs(&self) -> Needs {
        Needs::ALL
    }
}

/// A scene whose surfaces can be sampled uniformly by area; only uniform-area path sampling asks
/// for it.
pub trait SurfaceArea: Scene {
    /// Total area of all surfaces.
    fn total_area(&self) -> f64;

    /// A point uniform on the total area, density `1 / total_area`.
    fn sample_surface(&self, u1: f64, u2: DVec2) -> SurfacePoint;
}
