//! Shapes, their instances and their light.

use super::super::{Error, Location, ply};
use super::materials::Reference;
use super::object::Object;
use super::textures::{Sort, upside_down};
use super::{Loader, Place};
use crate::geometry::{Disk, Frame, Quad, Sphere};
use crate::material::{Interpolation, Texture, Wrap};
use crate::math::Rgb;
use crate::scene::{MaterialId, Mesh, SceneError, SurfaceId};
use glam::{DAffine2, DAffine3, DMat2, DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::rc::Rc;

/// A shape as it is described, ready to be placed.
pub(super) struct Shape {
    location: Location,
    form: Form,
    /// From its own space to that of the world, or of the object that it is a part of.
    to_world: DAffine3,
    /// True if its back is its front.
    reverse: bool,
    material: Reference,
    /// The texture of opacity and its name.
    opacity: Option<(String, Texture)>,
    /// The absorption coefficient of what is inside.
    absorption: Rgb,
    light: Option<Rc<Object>>,
}

enum Form {
    /// A mesh, and the number of shapes that it is in pbrt: triangles or patches.
    Mesh(Mesh, u64),
    Quad(Quad),
    Round(Round),
}

/// A part of a sphere, a disk or a cylinder around z, whose front is outside or above.
#[derive(Clone, Copy, Debug)]
struct Round {
    kind: Kind,
    radius: f64,
    /// From the one end to the other; of a disk both are its height.
    z: [f64; 2],
    inner_radius: f64,
    /// The angle that it goes around, in radians.
    angle: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Sphere,
    Disk,
    Cylinder,
}

/// Quadrilaterals around and along a round shape that is made of triangles.
const COLUMNS: u32 = 256;
const ROWS: u32 = 64;

impl Loader {
    /// Reads a shape and places it, or adds it to the object that is being defined.
    pub(super) fn shape(&mut self, object: &Object) -> Result<(), Error> {
        let Some(form) = self.form(object)? else { return Ok(()) };
        let opacity = match self.texture(object, "alpha", Sort::Float, DAffine2::IDENTITY)? {
            Some(alpha) if alpha.as_constant() != Some(Rgb::WHITE) => {
                let name =
                    object.get("alpha").map_or_else(String::new, |p| format!("{:?}", p.values));
                Some((name, alpha))
            }
            _ => None,
        };
        object.ignore(&["shadowalpha"]);
        object.finish(&mut self.warnings)?;
        let mut light = self.state.light.clone();
        if self.definition.is_some() && light.is_some() {
            light = None;
            let reason = "lights are not supported in objects that are instanced; it emits nothing";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let reverse = self.state.reverse;
        let shape = Rc::new(Shape {
            location: object.location.clone(),
            form: match form {
                Form::Mesh(mesh, count) => Form::Mesh(turned(mesh, reverse), count),
                other => other,
            },
            to_world: self.state.to_world,
            reverse,
            material: self.state.material.clone(),
            opacity,
            absorption: self.state.absorption,
            light,
        });
        match &mut self.definition {
            Some((_, shapes)) => shapes.push(shape),
            None => self.place(&shape, DAffine3::IDENTITY)?,
        }
        Ok(())
    }

    /// Places an instance of an object.
    pub(super) fn instance(&mut self, name: &str) -> Result<(), Error> {
        if self.definition.is_some() {
            return Err(Error::new(self.location(), "an instance in an object is not supported"));
        }
        let Some(shapes) = self.definitions.get(name).cloned() else {
            return Err(Error::new(self.location(), format!("there is no object {name}")));
        };
        for shape in shapes.iter() {
            if let Form::Mesh(mesh, _) = &shape.form {
                self.spend_triangles(mesh.indices.len() as u64, &shape.location)?;
            }
            let placed = self.place(shape, self.state.to_world);
            self.warnings.rescue_surface(placed, "it is left out")?;
        }
        Ok(())
    }

    fn spend_triangles(&mut self, count: u64, location: &Location) -> Result<(), Error> {
        let left = self.triangles_left.checked_sub(count);
        self.triangles_left = left.ok_or_else(|| {
            let reason = "the meshes have more triangles than the limit admits";
            Error::limit(location.clone(), reason)
        })?;
        Ok(())
    }

    fn form(&mut self, object: &Object) -> Result<Option<Form>, Error> {
        let form = match object.kind.as_str() {
            "trianglemesh" => {
                let mesh = self.triangle_mesh(object)?;
                let count = mesh.indices.len() as u64;
                Form::Mesh(mesh, count)
            }
            "loopsubdiv" => {
                object.ignore(&["levels", "scheme"]);
                let mut mesh = self.triangle_mesh(object)?;
                mesh.normals = Some(vertex_normals(&mesh));
                let reason = "a subdivision surface is not supported: its control mesh is taken, \
                              and shaded smoothly";
                self.warnings.warn(object.location.clone(), reason)?;
                let count = mesh.indices.len() as u64;
                Form::Mesh(mesh, count)
            }
            "plymesh" => {
                object.ignore(&["edgelength"]);
                let name = object
                    .text("filename")?
                    .ok_or_else(|| object.error("the filename is missing"))?;
                let (path, bytes) = self.read(name, &object.location)?;
                let mesh = ply::mesh(&bytes, self.triangles_left)
                    .map_err(|reason| object.error(format!("{}: {reason}", path.display())))?;
                if object.get("displacement").is_some() {
                    let reason = "displacement is not supported: the mesh is as it is in its file";
                    self.warnings.warn(object.location.clone(), reason)?;
                }
                let count = mesh.indices.len() as u64;
                // No texture asks for colours.
                Form::Mesh(checked(object, Mesh { colors: None, ..mesh })?, count)
            }
            "bilinearmesh" => bilinear(object)?,
            "sphere" => Form::Round(round(object, Kind::Sphere)?),
            "disk" => Form::Round(round(object, Kind::Disk)?),
            "cylinder" => Form::Round(round(object, Kind::Cylinder)?),
            other => {
                let reason = format!("shapes of type {other} are not supported; it is left out");
                self.warnings.lose(object.location.clone(), reason)?;
                return Ok(None);
            }
        };
        if let Form::Mesh(mesh, _) = &form {
            self.spend_triangles(mesh.indices.len() as u64, &object.location)?;
        }
        Ok(Some(form))
    }

    fn triangle_mesh(&mut self, object: &Object) -> Result<Mesh, Error> {
        let positions = object.points("P")?.ok_or_else(|| object.error("P is missing"))?;
        let indices = match object.indices("indices")? {
            Some(indices) => indices,
            None if positions.len() == 3 => vec![0, 1, 2],
            None => return Err(object.error("indices are missing")),
        };
        let (triangles, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(object.error("3 does not divide the number of indices"));
        }
        let uvs = ["uv", "st"].into_iter().find(|name| object.get(name).is_some());
        let mesh = Mesh {
            indices: triangles.to_vec(),
            normals: object.points("N")?,
            uvs: uvs.map_or(Ok(None), |name| object.uvs(name))?,
            positions,
            ..Mesh::default()
        };
        object.ignore(&["S", "faceIndices"]);
        checked(object, mesh)
    }

    /// Places the shapes whose material had not been described before.
    pub(super) fn place_pending(&mut self) -> Result<(), Error> {
        for (shape, instance) in std::mem::take(&mut self.pending) {
            let Location { file, element, line, .. } = shape.location.clone();
            self.at = Place { file: Rc::new(file), directive: element, line };
            let placed = self.place_now(&shape, instance);
            self.warnings.rescue_surface(placed, "it is left out")?;
        }
        Ok(())
    }

    /// Places a shape; `instance` goes after its own transform.
    fn place(&mut self, shape: &Rc<Shape>, instance: DAffine3) -> Result<(), Error> {
        if self.is_described(&shape.material) {
            return self.place_now(shape, instance);
        }
        self.pending.push((Rc::clone(shape), instance));
        Ok(())
    }

    fn place_now(&mut self, shape: &Shape, instance: DAffine3) -> Result<(), Error> {
        let to_world = instance * shape.to_world;
        let is_textured = self.is_textured(&shape.material) || shape.opacity.is_some();
        let light = shape.light.as_deref();
        let is_textured = is_textured || light.is_some_and(|l| l.get("filename").is_some());
        // A mirroring transform turns the cross product of edges.
        let is_turned = shape.reverse != (to_world.matrix3.determinant() < 0.0);
        let (mut to_uv, mut exact) = (DAffine2::IDENTITY, None);
        match &shape.form {
            Form::Round(round) => {
                exact = round.exact(&to_world, shape.reverse, is_textured);
                if let Some(Exact::Sphere(sphere)) = &exact {
                    to_uv = round.uv_map(sphere, &to_world);
                }
            }
            Form::Quad(_) if is_turned => to_uv.matrix2 = DMat2::from_cols(DVec2::Y, DVec2::X),
            _ => {}
        }
        let opacity = match &shape.opacity {
            Some((name, opacity)) if opacity.as_constant().is_none() => {
                let opacity = opacity.clone().with_transform(to_uv);
                Some((name.clone(), opacity.map_err(|e| Error::caused(shape.location.clone(), e))?))
            }
            other => other.clone(),
        };
        let material = self.material(&shape.material, to_uv, opacity.as_ref())?;
        self.surfaces += 1;
        let line = shape.location.line.unwrap_or(0);
        let name = format!("{} {} in line {line}", shape.location.element, self.surfaces);
        let caused = |error: SceneError| Error::caused(shape.location.clone(), error);
        let (surface, area, lights) = match (&shape.form, exact) {
            (_, Some(Exact::Sphere(sphere))) => {
                let area = TAU * sphere.radius.powi(2) * (sphere.cos_max - sphere.cos_min);
                (self.builder.add_sphere(name, sphere, material).map_err(caused)?, area, 1)
            }
            (_, Some(Exact::Disk(disk))) => {
                let area = PI * disk.radius.powi(2);
                (self.builder.add_disk(name, disk, material).map_err(caused)?, area, 1)
            }
            (Form::Quad(quad), _) => {
                let quad = quad_in_world(quad, &to_world, is_turned);
                let area = quad.cross().length();
                (self.builder.add_quad(name, quad, material).map_err(caused)?, area, 1)
            }
            (Form::Mesh(mesh, lights), _) => {
                let area = light.map_or(0.0, |_| area(mesh, &to_world));
                (self.mesh(name, mesh, shape, &to_world, material, is_textured)?, area, *lights)
            }
            (Form::Round(round), None) => {
                let mesh = turned(round.mesh(), shape.reverse);
                self.spend_triangles(mesh.indices.len() as u64, &shape.location)?;
                let reason = format!(
                    "a {} of this sort is made of {} triangles",
                    shape.location.element,
                    mesh.indices.len()
                );
                self.warnings.warn(shape.location.clone(), reason)?;
                let area = light.map_or(0.0, |_| area(&mesh, &to_world));
                (self.mesh(name, &mesh, shape, &to_world, material, is_textured)?, area, 1)
            }
        };
        self.builder.set_absorption(surface, shape.absorption).map_err(caused)?;
        if let Some(relief) = self.reliefs.get(&material) {
            self.builder.set_relief(surface, relief.clone()).map_err(caused)?;
        }
        if let Some(light) = &shape.light {
            let emits = self.emit(shape, light, surface, area, lights, to_uv);
            self.warnings.rescue(emits, "it emits nothing")?;
        }
        Ok(())
    }

    fn mesh(
        &mut self,
        name: String,
        mesh: &Mesh,
        shape: &Shape,
        to_world: &DAffine3,
        material: MaterialId,
        is_textured: bool,
    ) -> Result<SurfaceId, Error> {
        let added = if is_textured && mesh.uvs.is_none() {
            self.builder.add_mesh(name, &with_uvs(mesh), *to_world, material)
        } else {
            self.builder.add_mesh(name, mesh, *to_world, material)
        };
        added.map_err(|error| Error::caused(shape.location.clone(), error))
    }

    /// Makes a surface emit. `lights` is the number of lights that it is in pbrt, each of which has
    /// the power that is asked for.
    fn emit(
        &mut self,
        shape: &Shape,
        light: &Object,
        surface: SurfaceId,
        area: f64,
        lights: u64,
        to_uv: DAffine2,
    ) -> Result<(), Error> {
        if !matches!(light.kind.as_str(), "diffuse" | "area") {
            return Err(
                light.error(format!("area lights of type {} are not supported", light.kind))
            );
        }
        let is_two_sided = light.truth("twosided")?.unwrap_or(false);
        let (radiance, luminance) = match light.text("filename")? {
            Some(name) => {
                let image = self.light_image(light, name)?;
                let luminance = image.mean().luminance();
                let radiance = Texture::bitmap(image, Interpolation::Bilinear, [Wrap::Clamp; 2])
                    .and_then(|radiance| radiance.with_transform(upside_down() * to_uv))
                    .map_err(|error| light.caused(error))?;
                (radiance, luminance)
            }
            None => {
                let radiance = self.emitted(light, "L")?;
                (radiance.into(), 1.0)
            }
        };
        let mut scale = self.light_scale(light)?;
        if let Some(power) = light.number("power")?.filter(|power| *power > 0.0) {
            let sides = if is_two_sided { 2.0 } else { 1.0 };
            scale *= power * lights as f64 / (sides * PI * area * luminance);
        }
        light.ignore(&["samples", "nsamples"]);
        light.finish(&mut self.warnings)?;
        if shape.opacity.is_some() {
            let reason = "a light that is not opaque is not supported: it emits everywhere";
            self.warnings.warn(shape.location.clone(), reason)?;
        }
        let radiance = radiance.scaled(scale).map_err(|error| light.caused(error))?;
        self.builder
            .set_textured_emission(surface, radiance, is_two_sided)
            .map_err(|error| light.caused(error))
    }
}

/// A round shape that needs no triangles.
enum Exact {
    Sphere(Sphere),
    Disk(Disk),
}

impl Round {
    /// The shape in the world, if the crate has it there.
    fn exact(&self, to_world: &DAffine3, reverse: bool, is_textured: bool) -> Option<Exact> {
        let matrix = to_world.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let scale = x.length();
        let is_alike = |a: f64| (a - scale).abs() <= 1e-5 * scale;
        let is_right = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-5 * scale * scale;
        if self.angle < TAU || !(scale > 0.0 && is_alike(y.length()) && is_right(x, y)) {
            return None;
        }
        let center = to_world.transform_point3(DVec3::Z * self.z[0]);
        match self.kind {
            Kind::Sphere if is_alike(z.length()) && is_right(y, z) && is_right(z, x) => {
                let [cos_min, cos_max] = self.z.map(|z| (z / self.radius).clamp(-1.0, 1.0));
                Some(Exact::Sphere(Sphere {
                    axis: z,
                    cos_min,
                    cos_max,
                    inward: reverse,
                    ..Sphere::new(to_world.translation, self.radius * scale)
                }))
            }
            // Texture coordinates of disks are other ones here.
            Kind::Disk if self.inner_radius <= 0.0 && !is_textured => {
                // The front is where z goes, whatever becomes of the cross product.
                let normal = x.cross(y);
                let turned = reverse != (normal.dot(z) < 0.0);
                let normal = if turned { -normal } else { normal };
                Some(Exact::Disk(Disk { center, normal, radius: self.radius * scale }))
            }
            _ => None,
        }
    }

    /// The map from the crate's texture coordinates on a sphere to pbrt's: the longitude starts at
    /// x, and v rises to the pole.
    fn uv_map(&self, sphere: &Sphere, to_world: &DAffine3) -> DAffine2 {
        let matrix = to_world.matrix3;
        let frame = Frame::from_normal(sphere.axis.normalize());
        let x = frame.to_local(matrix.x_axis);
        let start = libm::atan2(x.y, x.x) / TAU;
        let direction = if matrix.determinant() < 0.0 { -1.0 } else { 1.0 };
        let [low, high] = [sphere.cos_min, sphere.cos_max].map(|cosine| libm::acos(cosine) / PI);
        let v = -1.0 / (low - high);
        DAffine2::from_mat2_translation(
            DMat2::from_diagonal(DVec2::new(direction, v)),
            DVec2::new(-direction * start, -v * low),
        )
    }

    /// Position and normal at u and v.
    fn at(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let (sin, cos) = libm::sincos(u * self.angle);
        let out = DVec3::new(cos, sin, 0.0);
        let [low, high] = self.z;
        match self.kind {
            Kind::Sphere => {
                let [low, high] =
                    [low, high].map(|z| libm::acos((z / self.radius).clamp(-1.0, 1.0)));
                let (sin, cos) = libm::sincos(low + v * (high - low));
                let normal = out * sin + DVec3::Z * cos;
                (normal * self.radius, normal)
            }
            Kind::Cylinder => (out * self.radius + DVec3::Z * (low + v * (high - low)), out),
            Kind::Disk => {
                let radius = self.radius + v * (self.inner_radius - self.radius);
                (out * radius + DVec3::Z * low, DVec3::Z)
            }
        }
    }

    /// Triangles in the place of the shape.
    fn mesh(&self) -> Mesh {
        let rows = if self.kind == Kind::Sphere { ROWS } else { 1 };
        let mut mesh = Mesh { normals: Some(Vec::new()), uvs: Some(Vec::new()), ..Mesh::default() };
        for j in 0..=rows {
            for i in 0..=COLUMNS {
                let uv =
                    DVec2::new(f64::from(i) / f64::from(COLUMNS), f64::from(j) / f64::from(rows));
                let (position, normal) = self.at(uv.x, uv.y);
                mesh.positions.push(position);
                mesh.normals.iter_mut().for_each(|normals| normals.push(normal));
                mesh.uvs.iter_mut().for_each(|uvs| uvs.push(uv));
            }
        }
        let is_point = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|i| mesh.positions[i as usize]);
            a.distance(b) <= 1e-12 * self.radius
        };
        for j in 0..rows {
            for i in 0..COLUMNS {
                let a = j * (COLUMNS + 1) + i;
                let (b, c, d) = (a + 1, a + COLUMNS + 2, a + COLUMNS + 1);
                let triangles = [([a, b, c], is_point(a, b)), ([a, c, d], is_point(c, d))];
                let kept = triangles.into_iter().filter(|(_, is_point)| !is_point);
                mesh.indices.extend(kept.map(|(triangle, _)| triangle));
            }
        }
        mesh
    }
}

fn round(object: &Object, kind: Kind) -> Result<Round, Error> {
    let radius = object.number_or("radius", 1.0)?;
    if radius <= 0.0 {
        return Err(object.error("the radius must be positive"));
    }
    let end = if kind == Kind::Sphere { radius } else { 1.0 };
    let mut z = match kind {
        Kind::Disk => [object.number_or("height", 0.0)?; 2],
        _ => [object.number_or("zmin", -end)?, object.number_or("zmax", end)?],
    };
    z.sort_by(f64::total_cmp);
    if kind == Kind::Sphere {
        z = z.map(|z| z.clamp(-radius, radius));
    }
    let angle = object.number_or("phimax", 360.0)?.clamp(0.0, 360.0).to_radians();
    if angle == 0.0 || (kind != Kind::Disk && z[0] == z[1]) {
        return Err(object.error("the shape has no area"));
    }
    let inner_radius = object.number_or("innerradius", 0.0)?.clamp(0.0, radius);
    Ok(Round { kind, radius, z, inner_radius, angle })
}

/// The patches of a bilinear mesh as two triangles each, or as a parallelogram where it is one.
fn bilinear(object: &Object) -> Result<Form, Error> {
    let positions = object.points("P")?.ok_or_else(|| object.error("P is missing"))?;
    let indices = match object.indices("indices")? {
        Some(indices) => indices,
        None if positions.len() == 4 => vec![0, 1, 2, 3],
        None => return Err(object.error("indices are missing")),
    };
    let (patches, rest) = indices.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(object.error("4 does not divide the number of indices"));
    }
    let (normals, uvs) = (object.points("N")?, object.uvs("uv")?);
    object.ignore(&["faceIndices"]);
    if let ([[a, b, c, d]], None, None) = (patches, &normals, &uvs) {
        let corner = |i: &u32| positions.get(*i as usize).copied();
        if let (Some(a), Some(b), Some(c), Some(d)) = (corner(a), corner(b), corner(c), corner(d)) {
            let quad = Quad { origin: a, edge_u: b - a, edge_v: c - a };
            if (b + c - a - d).length() <= 1e-6 * (quad.edge_u + quad.edge_v).length() {
                return Ok(Form::Quad(quad));
            }
        }
    }
    let mut mesh = Mesh { positions, normals, uvs, ..Mesh::default() };
    if mesh.uvs.is_none() && indices.iter().all(|i| (*i as usize) < mesh.positions.len()) {
        // Each patch has the unit square.
        let corner = |i: &u32| mesh.positions[*i as usize];
        let positions = indices.iter().map(corner).collect();
        let corner = |normals: &Vec<DVec3>, i: &u32| normals.get(*i as usize).copied();
        let of_corners =
            |normals: &Vec<DVec3>| indices.iter().map(|i| corner(normals, i)).collect();
        let normals = mesh.normals.as_ref().and_then(of_corners);
        let square = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        let uvs = Some(patches.iter().flat_map(|_| square).collect());
        mesh = Mesh { positions, normals, uvs, ..Mesh::default() };
        let own = (0..indices.len() as u32).step_by(4);
        mesh.indices = own.flat_map(|a| [[a, a + 1, a + 3], [a, a + 3, a + 2]]).collect();
    } else {
        mesh.indices = patches.iter().flat_map(|&[a, b, c, d]| [[a, b, d], [a, d, c]]).collect();
    }
    let count = patches.len() as u64;
    Ok(Form::Mesh(checked(object, mesh)?, count))
}

/// A parallelogram in the world, its edges exchanged if its other side is the front.
fn quad_in_world(quad: &Quad, to_world: &DAffine3, is_turned: bool) -> Quad {
    let origin = to_world.transform_point3(quad.origin);
    let [edge_u, edge_v] = [quad.edge_u, quad.edge_v].map(|edge| to_world.transform_vector3(edge));
    if is_turned {
        Quad { origin, edge_u: edge_v, edge_v: edge_u }
    } else {
        Quad { origin, edge_u, edge_v }
    }
}

/// Checks indices and the numbers of attributes; normals without a direction become those of the
/// triangles around.
fn checked(object: &Object, mut mesh: Mesh) -> Result<Mesh, Error> {
    let count = mesh.positions.len();
    if let Some(index) = mesh.indices.iter().flatten().find(|&&index| index as usize >= count) {
        return Err(object.error(format!("a triangle refers to vertex {index} of {count}")));
    }
    let counts = [mesh.normals.as_ref().map(Vec::len), mesh.uvs.as_ref().map(Vec::len)];
    if let Some(other) = counts.into_iter().flatten().find(|other| *other != count) {
        return Err(object.error(format!("there are {other} attributes of {count} vertices")));
    }
    if mesh.normals.iter().flatten().any(|normal| normal.try_normalize().is_none()) {
        let others = vertex_normals(&mesh);
        for (normal, other) in mesh.normals.iter_mut().flatten().zip(others) {
            *normal = normal.try_normalize().unwrap_or(other);
        }
    }
    Ok(mesh)
}

/// Normals of vertices: those of the triangles around, weighted by their areas.
fn vertex_normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        triangle.iter().for_each(|i| normals[*i as usize] += (b - a).cross(c - a));
    }
    // Any direction will do for a vertex of no triangle.
    normals.iter_mut().for_each(|normal| *normal = normal.try_normalize().unwrap_or(DVec3::Z));
    normals
}

/// The mesh with the fronts of its triangles where its normals point, or where the winding says if
/// there are none; with `reverse` everything is turned around.
fn turned(mut mesh: Mesh, reverse: bool) -> Mesh {
    if reverse {
        mesh.normals.iter_mut().flatten().for_each(|normal| *normal = -*normal);
    }
    for triangle in &mut mesh.indices {
        let [a, b, c] = triangle.map(|i| i as usize);
        let p = &mesh.positions;
        let is_turned = match &mesh.normals {
            Some(n) => (n[a] + n[b] + n[c]).dot((p[b] - p[a]).cross(p[c] - p[a])) < 0.0,
            None => reverse,
        };
        if is_turned {
            triangle.swap(1, 2);
        }
    }
    mesh
}

/// The mesh with the texture coordinates of triangles that have none: (0, 0), (1, 0) and (1, 1).
fn with_uvs(mesh: &Mesh) -> Mesh {
    let all = || mesh.indices.iter().flatten().map(|i| *i as usize);
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE];
    Mesh {
        positions: all().map(|i| mesh.positions[i]).collect(),
        normals: mesh.normals.as_ref().map(|normals| all().map(|i| normals[i]).collect()),
        uvs: Some(mesh.indices.iter().flat_map(|_| corners).collect()),
        indices: (0..mesh.indices.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

/// The area of a mesh in the world.
fn area(mesh: &Mesh, to_world: &DAffine3) -> f64 {
    let doubled = mesh.indices.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|i| to_world.transform_point3(mesh.positions[i as usize]));
        (b - a).cross(c - a).length()
    });
    0.5 * doubled.sum::<f64>()
}
