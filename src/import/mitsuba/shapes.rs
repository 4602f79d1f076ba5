//! Shapes and what belongs to them.

use super::super::Error;
use super::document::Element;
use super::values::Object;
use super::{Loader, meshes};
use crate::geometry::{Disk, Quad, Sphere};
use crate::material::Texture;
use crate::scene::{MaterialId, Mesh, SurfaceId};
use glam::{DAffine3, DMat3, DVec2, DVec3};

impl<'a> Loader<'a> {
    /// Adds a shape with its material and its light.
    pub(super) fn shape(&mut self, element: &'a Element) -> Result<(), Error> {
        let object = Object::new(element);
        let to_world = object.transform("to_world")?;
        let flip = object.boolean("flip_normals")?.unwrap_or(false);
        let (mut material, mut radiance) = (None, None);
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
                    self.warn(child, "participating media are not supported, and left out")?
                }
                other => self
                    .warn(child, format!("a {other} in a shape is not supported, and left out"))?,
            }
        }
        let material = match material {
            Some(material) => material,
            None => self.default_material(element, radiance.is_some())?,
        };
        let name = self.name(element);
        let caused = |error| element.caused(error);
        let surface = match element.kind() {
            "rectangle" => self.rectangle(&name, element, &to_world, flip, material)?,
            "sphere" => {
                let local = Sphere::new(
                    object.vector("center")?.unwrap_or(DVec3::ZERO),
                    object.float_or("radius", 1.0)?,
                );
                match placed_sphere(local, &to_world, flip) {
                    Some(sphere) => {
                        Some(self.builder.add_sphere(name, sphere, material).map_err(caused)?)
                    }
                    None => self.left_out(
                        element,
                        "a sphere that is not scaled uniformly is not supported",
                    )?,
                }
            }
            "disk" => match placed_disk(&to_world, flip) {
                Some(disk) => Some(self.builder.add_disk(name, disk, material).map_err(caused)?),
                None => {
                    self.left_out(element, "a disk that is not scaled uniformly is not supported")?
                }
            },
            "cube" => {
                let mesh = meshes::placed(cube(), &to_world, flip);
                Some(
                    self.builder
                        .add_mesh(name, &mesh, DAffine3::IDENTITY, material)
                        .map_err(caused)?,
                )
            }
            "obj" | "ply" | "serialized" => {
                let mesh = self.mesh_file(&object, &to_world, flip)?;
                Some(
                    self.builder
                        .add_mesh(name, &mesh, DAffine3::IDENTITY, material)
                        .map_err(caused)?,
                )
            }
            other => {
                self.warn(
                    element,
                    format!("shapes of type {other} are not supported; it is left out"),
                )?;
                return Ok(());
            }
        };
        if let (Some(surface), Some(relief)) = (surface, self.reliefs.get(&material)) {
            self.builder.set_relief(surface, relief.clone()).map_err(caused)?;
        }
        if let (Some(surface), Some(radiance)) = (surface, radiance.filter(|_| self.sees)) {
            self.check_uv(element, &radiance)?;
            let emits = self.builder.set_textured_emission(surface, radiance, false);
            self.warnings.rescue(emits.map_err(caused), "it emits nothing")?;
        }
        object.ignore(&["silhouette_sampling_weight"]);
        object.finish(&mut self.warnings)
    }

    fn left_out(&mut self, element: &'a Element, reason: &str) -> Result<Option<SurfaceId>, Error> {
        self.warn(element, format!("{reason}; it is left out"))?;
        Ok(None)
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

    /// The square from (-1, -1) to (1, 1) in its plane, its front towards z. Its normal is
    /// transformed as normals are, whatever becomes of its winding.
    fn rectangle(
        &mut self,
        name: &str,
        element: &'a Element,
        to_world: &DAffine3,
        flip: bool,
        material: MaterialId,
    ) -> Result<Option<SurfaceId>, Error> {
        let caused = |error| element.caused(error);
        let (edge_u, edge_v) = (
            to_world.transform_vector3(DVec3::X * 2.0),
            to_world.transform_vector3(DVec3::Y * 2.0),
        );
        // A mirroring transform turns the winding, not the normal.
        if flip == (to_world.matrix3.determinant() < 0.0) {
            let quad = Quad {
                origin: to_world.transform_point3(DVec3::new(-1.0, -1.0, 0.0)),
                edge_u,
                edge_v,
            };
            return self.builder.add_quad(name, quad, material).map(Some).map_err(caused);
        }
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let mesh = Mesh {
            positions: corners
                .iter()
                .map(|&(x, y)| to_world.transform_point3(DVec3::new(x, y, 0.0)))
                .collect(),
            uvs: Some(
                corners.iter().map(|&(x, y)| DVec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y)).collect(),
            ),
            indices: vec![[0, 2, 1], [0, 3, 2]],
            ..Mesh::default()
        };
        self.builder.add_mesh(name, &mesh, DAffine3::IDENTITY, material).map(Some).map_err(caused)
    }
}

/// The scale of a transform that scales all directions alike.
fn uniform_scale(matrix: &DMat3) -> Option<f64> {
    let squared = matrix.transpose() * *matrix;
    let scale = (squared.x_axis.x + squared.y_axis.y + squared.z_axis.z) / 3.0;
    let error = squared - DMat3::from_diagonal(DVec3::splat(scale));
    (scale > 0.0 && error.to_cols_array().iter().all(|e| e.abs() <= 1e-5 * scale))
        .then(|| scale.sqrt())
}

/// A mirroring transform turns a sphere inside out.
fn placed_sphere(local: Sphere, to_world: &DAffine3, flip: bool) -> Option<Sphere> {
    let scale = uniform_scale(&to_world.matrix3)?;
    let mirrored = to_world.matrix3.determinant() < 0.0;
    let axis = to_world.transform_vector3(DVec3::Z);
    Some(Sphere {
        axis,
        inward: flip != mirrored,
        ..Sphere::new(to_world.transform_point3(local.center), local.radius * scale)
    })
}

/// The unit disk in the plane of x and y, its front towards z.
fn placed_disk(to_world: &DAffine3, flip: bool) -> Option<Disk> {
    let (x, y) = (to_world.transform_vector3(DVec3::X), to_world.transform_vector3(DVec3::Y));
    let radius = x.length();
    if (y.length() - radius).abs() > 1e-5 * radius || x.dot(y).abs() > 1e-5 * radius * radius {
        return None;
    }
    // The cofactor matrix takes normals along, up to the determinant's sign.
    let mirrored = to_world.matrix3.determinant() < 0.0;
    let normal = if mirrored { y.cross(x) } else { x.cross(y) };
    Some(Disk { center: to_world.translation, normal: if flip { -normal } else { normal }, radius })
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
