//! Warnings where a scene asks more of f64 than it has: found when the scene is built, reported,
//! and rendered all the same.

use super::surface::Surface;
use crate::bsdf::{INDEX_MATCHED, LEAST_ALPHA};
use crate::geometry::{Bounds, Quad, Shape, Triangle};
use crate::material::Material;
use crate::tree::Forest;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt;

/// A limit of the arithmetic that a scene goes beyond. docs/numerics.md has the measurements behind
/// the limits.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Triangles without area were left out.
    DroppedTriangles {
        /// The mesh.
        object: String,
        /// Their number.
        dropped: usize,
        /// The number of triangles that the mesh has.
        triangles: usize,
    },
    /// Fewer than [`Warning::LEAST_DIGITS`] decimal digits of an object's coordinates tell its
    /// points apart, because it is small for its distance from the origin. Images have about one
    /// digit less.
    FewDigits {
        /// The surface; `None` if it is the whole scene.
        object: Option<String>,
        /// Its largest extent along an axis.
        size: f64,
        /// Its largest coordinate.
        coordinate: f64,
    },
    /// A part of the scene is smaller than the whole by more than [`Warning::MOST_STRETCH`]. Rays
    /// from far away meet it with fewer digits than that takes, and slowly.
    Stretched {
        /// The surfaces that are not within that part.
        objects: Vec<String>,
        /// The size of the scene over that of the part.
        ratio: f64,
    },
    /// A roughness below 1e-4, where models behave as if it were 0 along both axes, or 1e-4 if the
    /// other one is not as small.
    Roughness {
        /// The material.
        material: String,
        /// Its roughness.
        alpha: DVec2,
    },
    /// Rough glass whose index is so close to 1 that it is rendered as smooth glass: it bends no
    /// ray measurably.
    IndexMatched {
        /// The material.
        material: String,
        /// Its index of refraction.
        relative_ior: f64,
    },
    /// The square of a radiance leaves the range of f64: means are right, but variances and
    /// standard errors are not.
    Radiance {
        /// The surface.
        object: String,
        /// The largest component of its radiance.
        radiance: f64,
    },
    /// A primitive of an emissive surface is there twice, within one surface or two. A ray sees the
    /// first, but connections and uniform-area sampling may end on either, so integrators do not
    /// agree.
    CoincidentEmitter {
        /// The surface that emits.
        object: String,
        /// The surface that has the same primitive.
        other: String,
    },
    /// A lamp or material that a [`Variation`](super::Variation) could not change.
    Unvaried {
        /// The surface, or the material.
        object: String,
        /// The reason, as a clause.
        reason: String,
    },
}

impl Warning {
    /// The digits below which [`Warning::FewDigits`] is given.
    pub const LEAST_DIGITS: f64 = 6.0;
    /// The ratio above which [`Warning::Stretched`] is given.
    pub const MOST_STRETCH: f64 = 1e9;
    /// Radiances in between have squares that are normal numbers.
    const RADIANCE: std::ops::RangeInclusive<f64> = 1e-150..=1e150;

    /// Adds the warnings of what is lost in making the model of a material.
    pub(super) fn of_material(name: &str, material: &Material, warnings: &mut Vec<Self>) {
        let mut rough = |alpha: DVec2| {
            // 0 is a choice.
            if [alpha.x, alpha.y].iter().any(|&a| a > 0.0 && a < LEAST_ALPHA) {
                warnings.push(Self::Roughness { material: name.to_owned(), alpha });
            }
        };
        match *material {
            Material::RoughMirror { alpha, .. } | Material::RoughConductor { alpha, .. } => {
                rough(alpha)
            }
            Material::RoughPlastic { alpha, .. } => rough(DVec2::splat(alpha)),
            Material::RoughDielectric { relative_ior, alpha } => {
                rough(alpha);
                if relative_ior != 1.0 && (relative_ior - 1.0).abs() < INDEX_MATCHED {
                    warnings.push(Self::IndexMatched { material: name.to_owned(), relative_ior });
                }
            }
            Material::Culled { ref front } => Self::of_material(name, front, warnings),
            Material::Mixture { ref components, .. } => {
                components.iter().for_each(|part| Self::of_material(name, part, warnings))
            }
            _ => {}
        }
    }

    /// Adds the warnings of what is lost by where surfaces are and how bright.
    pub(super) fn of_surfaces(
        surfaces: &[Surface],
        shapes: &[Shape],
        scene: &Bounds,
        warnings: &mut Vec<Self>,
    ) {
        let before = warnings.len();
        warnings.extend(Self::of_bounds(None, scene));
        if warnings.len() == before {
            warnings.extend(surfaces.iter().filter_map(|surface| {
                let bounds = surface
                    .range(shapes)
                    .iter()
                    .fold(Bounds::EMPTY, |bounds, shape| bounds.union(shape.bounds()));
                Self::of_bounds(Some(&surface.name), &bounds)
            }));
        }
        for surface in surfaces {
            if let Some(radiance) =
                surface.emission.as_ref().map(|(radiance, _)| radiance.range()[1].max_component())
                && !Self::RADIANCE.contains(&radiance)
            {
                warnings.push(Self::Radiance { object: surface.name.clone(), radiance });
            }
        }
        Self::of_coincidence(surfaces, shapes, warnings);
    }

    /// Adds the warning that a scene has parts of too different sizes.
    pub(super) fn of_stretch(surfaces: &[Surface], forest: &Forest, warnings: &mut Vec<Self>) {
        let Some((part, ratio)) = forest.stretched(Self::MOST_STRETCH) else { return };
        let is_inside = |primitive: u32| {
            forest.shape(primitive).is_some_and(|shape| part.union(shape.bounds()) == part)
        };
        let objects = surfaces
            .iter()
            .filter(|s| !(s.first_primitive..s.first_primitive + s.primitives).all(is_inside))
            .map(|surface| surface.name.clone())
            .collect();
        warnings.push(Self::Stretched { objects, ratio });
    }

    fn of_bounds(object: Option<&str>, bounds: &Bounds) -> Option<Self> {
        let size = (bounds.max - bounds.min).max_element();
        let coordinate = bounds.min.abs().max(bounds.max.abs()).max_element();
        let warning = Self::FewDigits { object: object.map(str::to_owned), size, coordinate };
        (!bounds.is_empty() && digits(size, coordinate) < Self::LEAST_DIGITS).then_some(warning)
    }

    fn of_coincidence(surfaces: &[Surface], shapes: &[Shape], warnings: &mut Vec<Self>) {
        let (emitters, others): (Vec<&Surface>, Vec<&Surface>) =
            surfaces.iter().partition(|surface| surface.emission.is_some());
        if emitters.is_empty() {
            return;
        }
        let mut first: HashMap<[u64; 12], &str> = HashMap::new();
        for surface in emitters.into_iter().chain(others) {
            let mut coincident = None;
            for shape in surface.range(shapes) {
                match first.entry(key(shape)) {
                    Entry::Occupied(entry) => coincident = Some(*entry.get()),
                    Entry::Vacant(entry) if surface.emission.is_some() => {
                        _ = entry.insert(&surface.name)
                    }
                    Entry::Vacant(_) => {}
                }
            }
            let name = |name: &str| name.to_owned();
            warnings.extend(coincident.map(|object| Self::CoincidentEmitter {
                object: name(object),
                other: name(&surface.name),
            }));
        }
    }
}

/// Decimal digits of coordinates up to `coordinate` that tell points apart within `size`.
fn digits(size: f64, coordinate: f64) -> f64 {
    (size / coordinate / (0.5 * f64::EPSILON)).log10().max(0.0)
}

/// The same for shapes that are the same set of points.
fn key(shape: &Shape) -> [u64; 12] {
    let mut points = match *shape {
        Shape::Triangle(Triangle { vertices: [a, b, c] }) => [a, b, c, DVec3::INFINITY],
        Shape::Quad(Quad { origin, edge_u, edge_v }) => {
            [origin, origin + edge_u, origin + edge_v, origin + edge_u + edge_v]
        }
        Shape::Sphere(sphere) => [
            sphere.center,
            DVec3::new(sphere.radius, sphere.cos_min, sphere.cos_max),
            sphere.axis,
            DVec3::ZERO,
        ],
        Shape::Disk(disk) => {
            [disk.center, DVec3::splat(disk.radius), disk.normal.abs(), DVec3::ZERO]
        }
    };
    if matches!(shape, Shape::Triangle(_) | Shape::Quad(_)) {
        points.sort_by(|p, q| {
            p.to_array().partial_cmp(&q.to_array()).unwrap_or(std::cmp::Ordering::Equal)
        });
    }
    // -0 is 0.
    std::array::from_fn(|i| (points[i / 3][i % 3] + 0.0).to_bits())
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DroppedTriangles { object, dropped, triangles } => {
                write!(
                    f,
                    "\"{object}\": {dropped} of {triangles} triangles have no area and were left out"
                )
            }
            Self::FewDigits { object, size, coordinate } => {
                match object {
                    Some(object) => write!(f, "\"{object}\"")?,
                    None => write!(f, "the scene")?,
                }
                let digits = digits(*size, *coordinate);
                write!(
                    f,
                    " is {size:.1e} large at coordinates of {coordinate:.1e}: {digits:.1} digits are left; move it closer to the origin"
                )
            }
            Self::Stretched { objects, ratio } => {
                let names: Vec<String> =
                    objects.iter().take(3).map(|name| format!("\"{name}\"")).collect();
                let others = if objects.len() > 3 { " and others" } else { "" };
                write!(
                    f,
                    "the scene is {ratio:.1e} times as large as a part of it because of {}{others}: rays from afar are slow and lose digits; move them closer",
                    names.join(", ")
                )
            }
            Self::Roughness { material, alpha } => {
                let as_what =
                    if alpha.max_element() < LEAST_ALPHA { "a smooth surface" } else { "1e-4" };
                write!(
                    f,
                    "material \"{material}\": roughness {:e}, {:e} is below 1e-4 and rendered as {as_what}",
                    alpha.x, alpha.y
                )
            }
            Self::IndexMatched { material, relative_ior } => {
                write!(
                    f,
                    "material \"{material}\": the index of refraction {relative_ior} is so close to 1 that its roughness is left out"
                )
            }
            Self::Radiance { object, radiance } => {
                write!(
                    f,
                    "\"{object}\": radiance {radiance:.1e} has a square out of range: standard errors will be wrong"
                )
            }
            Self::Unvaried { object, reason } => {
                write!(f, "\"{object}\" is not varied: {reason}")
            }
            Self::CoincidentEmitter { object, other } if object == other => {
                write!(
                    f,
                    "\"{object}\": a primitive of this emitter is there twice; integrators will not agree"
                )
            }
            Self::CoincidentEmitter { object, other } => {
                write!(
                    f,
                    "\"{object}\": a primitive of this emitter coincides with one of \"{other}\"; integrators will not agree"
                )
            }
        }
    }
}
