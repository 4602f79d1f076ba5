//! Scenes that differ from a described one in the size of their lamps or in their roughness.

use super::error::SceneError;
use super::warning::Warning;
use crate::geometry::{Bounds, Disk, Quad, Shape, Sphere, Triangle};
use crate::material::{Material, Texture};
use crate::math::Rgb;
use glam::DVec3;

/// Changes to a scene while it is put together, by which one difficulty is varied alone: the same
/// scene with a smaller lamp, or with glossier surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// The factor by which emissive surfaces are scaled, each about its centre; their radiance is
    /// divided by its square, so that the power stays. Zones of spheres are no lamps of their own,
    /// and stay as they are. From 0.001 to 1000; default: 1.
    pub light_size: f64,
    /// The roughness α of all materials [that have one](Material::with_roughness), in place of their
    /// own. Default: none.
    pub roughness: Option<f64>,
}

impl Default for Variation {
    fn default() -> Self {
        Self { light_size: 1.0, roughness: None }
    }
}

impl Variation {
    /// The material with the roughness; with its own, and a warning, where a texture forbids it.
    pub(super) fn of_material(
        &self,
        name: &str,
        material: Material,
        warnings: &mut Vec<Warning>,
    ) -> Material {
        let Some(alpha) = self.roughness else { return material };
        material.clone().with_roughness(alpha).unwrap_or_else(|reason| {
            let reason = reason.to_string();
            warnings.push(Warning::Unvaried { object: name.to_owned(), reason });
            material
        })
    }

    /// Scales the shapes of a lamp and its radiance.
    pub(super) fn scale_lamp(
        &self,
        name: &str,
        shapes: &mut [Shape],
        radiance: &mut Texture,
        warnings: &mut Vec<Warning>,
    ) -> Result<(), SceneError> {
        let factor = self.light_size;
        if !(1e-3..=1e3).contains(&factor) {
            return Err(SceneError::Parameter {
                object: name.to_owned(),
                parameter: "light_size",
                value: factor,
                requirement: "from 0.001 to 1000",
            });
        }
        if factor == 1.0 {
            return Ok(());
        }
        let is_zone = |shape: &Shape| matches!(shape, Shape::Sphere(s) if !s.is_whole());
        let scaled = radiance.clone().scaled(Rgb::splat(1.0 / (factor * factor)));
        let mut unvaried = |reason: String| {
            warnings.push(Warning::Unvaried { object: name.to_owned(), reason });
            Ok(())
        };
        *radiance = match scaled {
            _ if shapes.iter().any(is_zone) => {
                return unvaried("it is a zone of a sphere".to_owned());
            }
            Err(reason) => return unvaried(reason.to_string()),
            Ok(scaled) => scaled,
        };
        let bounds =
            shapes.iter().fold(Bounds::EMPTY, |bounds, shape| bounds.union(shape.bounds()));
        let center = bounds.center();
        let place = |x: DVec3| center + (x - center) * factor;
        for shape in shapes {
            *shape = match *shape {
                Shape::Triangle(Triangle { vertices }) => {
                    Shape::Triangle(Triangle { vertices: vertices.map(place) })
                }
                Shape::Quad(Quad { origin, edge_u, edge_v }) => Shape::Quad(Quad {
                    origin: place(origin),
                    edge_u: edge_u * factor,
                    edge_v: edge_v * factor,
                }),
                Shape::Disk(Disk { center, normal, radius }) => {
                    Shape::Disk(Disk { center: place(center), normal, radius: radius * factor })
                }
                Shape::Sphere(sphere) => Shape::Sphere(Sphere {
                    center: place(sphere.center),
                    radius: sphere.radius * factor,
                    ..sphere
                }),
            };
        }
        Ok(())
    }
}
