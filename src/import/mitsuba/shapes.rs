//! Shapes and what belongs to them.

use super::super::Error;
use super::document::Element;
use super::meshes::placed;
use super::values::Object;
use super::{Loader, revolved};
use crate::geometry::{Disk, Quad, Sphere};
use crate::material::Texture;
use crate::math::{Rgb, has_exact_length};
use crate::scene::{MaterialId, Mesh};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::borrow::Cow;

/// The square from (-1, -1) to (1, 1) in its plane, its front towards z.
const SQUARE: Quad = Quad {
    origin: DVec3::new(-1.0, -1.0, 0.0),
    edge_u: DVec3::new(2.0, 0.0, 0.0),
    edge_v: DVec3::new(0.0, 2.0, 0.0),
};

/// A shape with its material and its light.
pub(super) struct Part<'a> {
    element: &'a Element,
    geometry: Geometry,
    material: MaterialId,
    radiance: Option<Texture>,
    absorption: Option<Rgb>,
}

/// A shape in world space, or in the space of its group.
enum Geometry {
    Sphere(Sphere),
    Disk(Disk),
    Quad(Quad),
    Mesh(Mesh),
}

impl<'a> Loader<'a> {
    /// Adds a shape, or those that it stands for.
    pub(super) fn shape(&mut self, element: &'a Element) -> Result<(), Error> {
        match element.kind() {
            // It is seen where its instances are.
            "shapegroup" => Ok(()),
            "instance" => self.instance(element),
            "merge" => self.merged(element),
            _ => match self.part(element)? {
                Some(part) => self.add_part(&part, &DAffine3::IDENTITY),
                None => Ok(()),
            },
        }
    }

    /// A shape by itself; `None`, after a warning, if it is left out.
    pub(super) fn part(&mut self, element: &'a Element) -> Result<Option<Part<'a>>, Error> {
        let object = Object::new(element);
        let to_world = object.transform("to_world")?;
        let flip = object.boolean("flip_normals")?.unwrap_or(false);
        let (mut material, mut radiance, mut absorption) = (None, None, None);
        for child in object.objects() {
            let target = self.resolved(child);
            let Some(target) = self.warnings.rescue(target, "it is left out")? else { continue };
            match target.tag.as_str() {
                "bsdf" => material = Some(self.material(target)?),
                "emitter" => {
                    let light = self.area_light(target);
                    radiance = self.warnings.rescue(light, "it emits nothing")?.flatten();
                }
                "medium" => {
                    let medium = self.absorption(child, target);
                    absorption = self.warnings.rescue(medium, "it is left out")?.flatten();
                }
                other => self
                    .warn(child, format!("a {other} in a shape is not supported, and left out"))?,
            }
        }
        let material = match material {
            Some(material) => material,
            None => self.default_material(element, radiance.is_some())?,
        };
        let geometry = match element.kind() {
            "rectangle" if flip => Geometry::Mesh(placed(quad_mesh(&SQUARE), &to_world, true)),
            "rectangle" => Geometry::Quad(SQUARE).placed(&to_world),
            "sphere" => {
                let center = object.vector("center")?.unwrap_or(DVec3::ZERO);
                let sphere = Sphere::new(center, object.float_or("radius", 1.0)?);
                // A mirroring transform turns a sphere inside out.
                let inward = flip != mirrors(&to_world);
                let placed = Geometry::Sphere(Sphere { inward, ..sphere }).placed(&to_world);
                if let Geometry::Mesh(_) = placed {
                    let reason = "it is not scaled uniformly, and shown as an ellipsoid";
                    self.warn(element, reason)?;
                }
                placed
            }
            "disk" => {
                let normal = if flip { -DVec3::Z } else { DVec3::Z };
                let disk = Disk { center: DVec3::ZERO, normal, radius: 1.0 };
                Geometry::Disk(disk).placed(&to_world)
            }
            "cylinder" => {
                let from = object.vector("p0")?.unwrap_or(DVec3::ZERO);
                let axis = object.vector("p1")?.unwrap_or(DVec3::Z) - from;
                let radius = object.float_or("radius", 1.0)?;
                if !has_exact_length(axis) || radius.is_nan() || radius <= 0.0 {
                    return Err(
                        element.error("p0 and p1 are the same, or its radius is not positive")
                    );
                }
                let mesh = revolved::cylinder(from, axis, radius);
                self.spend_triangles(element, mesh.indices.len())?;
                Geometry::Mesh(placed(mesh, &to_world, flip))
            }
            "cube" => Geometry::Mesh(placed(cube(), &to_world, flip)),
            "obj" | "ply" | "serialized" => {
                Geometry::Mesh(self.mesh_file(&object, &to_world, flip)?)
            }
            other => {
                let reason = format!("shapes of type {other} are not supported; it is left out");
                self.warnings.lose(element.location(), reason)?;
                return Ok(None);
            }
        };
        object.ignore(&["silhouette_sampling_weight"]);
        object.finish(&mut self.warnings)?;
        Ok(Some(Part { element, geometry, material, radiance, absorption }))
    }

    /// Adds a shape to the scene. The image of its front is the front.
    pub(super) fn add_part(&mut self, part: &Part<'a>, transform: &DAffine3) -> Result<(), Error> {
        let (element, material) = (part.element, part.material);
        let caused = |error| element.caused(error);
        let name = self.name(element);
        let surface = match part.geometry.moved(transform) {
            Some(Geometry::Sphere(sphere)) => self.builder.add_sphere(name, sphere, material),
            Some(Geometry::Disk(disk)) => self.builder.add_disk(name, disk, material),
            Some(Geometry::Quad(quad)) => self.builder.add_quad(name, quad, material),
            Some(Geometry::Mesh(_)) | None => {
                self.builder.add_mesh(name, &part.geometry.to_mesh(), *transform, material)
            }
        };
        let surface = surface.map_err(caused)?;
        if let Some(relief) = self.reliefs.get(&material) {
            self.builder.set_relief(surface, relief.clone()).map_err(caused)?;
        }
        if let Some(absorption) = part.absorption {
            let filled = self.builder.set_absorption(surface, absorption);
            self.warnings.rescue(filled.map_err(caused), "its medium is left out")?;
        }
        if let Some(radiance) = part.radiance.as_ref().filter(|_| self.sees) {
            self.check_uv(element, radiance)?;
            let emits = self.builder.set_textured_emission(surface, radiance.clone(), false);
            self.warnings.rescue(emits.map_err(caused), "it emits nothing")?;
        }
        Ok(())
    }

    /// Counts triangles that are added to the scene.
    pub(super) fn spend_triangles(&mut self, element: &Element, count: usize) -> Result<(), Error> {
        let left = self.triangles_left.checked_sub(count as u64);
        self.triangles_left = left
            .ok_or_else(|| element.limit("the scene has more triangles than the limit admits"))?;
        Ok(())
    }

    /// Warns where this crate's texture coordinates are others than Mitsuba's.
    pub(super) fn check_uv(
        &mut self,
        element: &'a Element,
        texture: &Texture,
    ) -> Result<(), Error> {
        if texture.as_constant().is_none() && matches!(element.kind(), "disk" | "sphere") {
            self.warn(element, "texture coordinates of spheres and disks have another origin here; the texture lies differently")?;
        }
        Ok(())
    }
}

impl Part<'_> {
    /// Triangles of the shape, at least one.
    pub fn triangles(&self) -> usize {
        match &self.geometry {
            Geometry::Mesh(mesh) => mesh.indices.len().max(mesh.positions.len() / 3).max(1),
            // Some transforms make triangles of them.
            Geometry::Sphere(_) | Geometry::Disk(_) | Geometry::Quad(_) => revolved::MOST_TRIANGLES,
        }
    }
}

impl Geometry {
    /// The shape in world space: its image, or triangles where that is no shape of its kind.
    fn placed(self, to_world: &DAffine3) -> Self {
        self.moved(to_world)
            .unwrap_or_else(|| Self::Mesh(placed(self.to_mesh().into_owned(), to_world, false)))
    }

    /// The image, with the image of the front for its front, if that is a shape of the same kind.
    fn moved(&self, transform: &DAffine3) -> Option<Self> {
        let vector = |v| transform.transform_vector3(v);
        let point = |p| transform.transform_point3(p);
        match *self {
            Self::Sphere(Sphere { center, radius, axis, inward, .. }) => {
                let radius = radius * uniform_scale(&transform.matrix3)?;
                let sphere = Sphere::new(point(center), radius);
                Some(Self::Sphere(Sphere { axis: vector(axis), inward, ..sphere }))
            }
            Self::Disk(Disk { center, normal, radius }) => {
                let (x, y) = normal.any_orthonormal_pair();
                let (x, y) = (vector(x), vector(y));
                let scale = x.length();
                let is_round = (y.length() - scale).abs() <= 1e-5 * scale
                    && x.dot(y).abs() <= 1e-5 * scale * scale;
                let normal = if mirrors(transform) { y.cross(x) } else { x.cross(y) };
                let disk = Disk { center: point(center), normal, radius: radius * scale };
                is_round.then_some(Self::Disk(disk))
            }
            Self::Quad(Quad { origin, edge_u, edge_v }) => {
                let (edge_u, edge_v) = (vector(edge_u), vector(edge_v));
                let quad = Quad { origin: point(origin), edge_u, edge_v };
                (!mirrors(transform)).then_some(Self::Quad(quad))
            }
            Self::Mesh(_) => None,
        }
    }

    fn to_mesh(&self) -> Cow<'_, Mesh> {
        match self {
            Self::Sphere(sphere) => Cow::Owned(revolved::sphere(sphere)),
            Self::Disk(disk) => Cow::Owned(revolved::disk(disk)),
            Self::Quad(quad) => Cow::Owned(quad_mesh(quad)),
            Self::Mesh(mesh) => Cow::Borrowed(mesh),
        }
    }
}

fn mirrors(transform: &DAffine3) -> bool {
    transform.matrix3.determinant() < 0.0
}

/// The scale of a transform that scales all directions alike.
fn uniform_scale(matrix: &DMat3) -> Option<f64> {
    let squared = matrix.transpose() * *matrix;
    let scale = (squared.x_axis.x + squared.y_axis.y + squared.z_axis.z) / 3.0;
    let error = squared - DMat3::from_diagonal(DVec3::splat(scale));
    (scale > 0.0 && error.to_cols_array().iter().all(|e| e.abs() <= 1e-5 * scale))
        .then(|| scale.sqrt())
}

fn quad_mesh(quad: &Quad) -> Mesh {
    let Quad { origin, edge_u, edge_v } = *quad;
    let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    Mesh {
        positions: uvs.iter().map(|uv| origin + edge_u * uv.x + edge_v * uv.y).collect(),
        normals: Some(vec![edge_u.cross(edge_v); 4]),
        uvs: Some(uvs.to_vec()),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// The cube from (-1, -1, -1) to (1, 1, 1). Each face is a unit square of texture coordinates.
fn cube() -> Mesh {
    // For each face the corners at uv = (0, 1), (1, 1), (1, 0) and (0, 0), counter-clockwise seen
    // from outside.
    const FACES: [[[i8; 3]; 4]; 6] = [
        [[1, -1, -1], [1, -1, 1], [-1, -1, 1], [-1, -1, -1]],
        [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]],
        [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]],
        [[1, -1, 1], [1, 1, 1], [-1, 1, 1], [-1, -1, 1]],
        [[-1, -1, 1], [-1, 1, 1], [-1, 1, -1], [-1, -1, -1]],
        [[1, 1, -1], [1, -1, -1], [-1, -1, -1], [-1, 1, -1]],
    ];
    let positions: Vec<DVec3> =
        FACES.iter().flatten().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let uvs = (0..6).flat_map(|_| [DVec2::Y, DVec2::ONE, DVec2::X, DVec2::ZERO]).collect();
    let indices: Vec<[u32; 3]> = (0..6)
        .flat_map(|face| {
            [[4 * face, 4 * face + 1, 4 * face + 2], [4 * face + 3, 4 * face, 4 * face + 2]]
        })
        .collect();
    // The sum of a face's corners points outwards.
    let normals = FACES.iter().flat_map(|face| {
        let sum: DVec3 = face.iter().map(|p| DVec3::from_array(p.map(f64::from))).sum();
        [0.25 * sum; 4]
    });
    Mesh { normals: Some(normals.collect()), positions, uvs: Some(uvs), indices, ..Mesh::default() }
}
