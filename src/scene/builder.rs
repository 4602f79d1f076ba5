//! Puts a [`World`] together and refuses what cannot be rendered.

use super::error::{SceneError, check, check_point, check_radiance};
use super::lights;
use super::mesh::{Attributes, Mesh};
use super::surface::{Emission, MaterialId, Surface, SurfaceId};
use super::variation::Variation;
use super::warning::Warning;
use super::world::{Media, World};
use crate::endpoint::{AnyLight, AreaLight, Light, LightId, SceneExtent};
use crate::geometry::{Bounds, Disk, Facing, Quad, Shape, Sphere};
use crate::material::{Finish, Material, Relief, Texture};
use crate::math::{Rgb, has_exact_length, unit};
use crate::tree::Forest;
use glam::DAffine3;
use std::collections::{HashMap, HashSet};

/// Collects materials, surfaces and lights for a [`World`].
///
/// ```
/// use pathspace::geometry::{Quad, Sphere};
/// use pathspace::glam::DVec3;
/// use pathspace::math::Rgb;
/// use pathspace::scene::{Emission, Material, SceneError, WorldBuilder};
///
/// # fn main() -> Result<(), SceneError> {
/// let mut builder = WorldBuilder::new();
/// let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
/// builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), grey)?;
/// let origin = DVec3::new(-1.0, -1.0, 3.0);
/// let lamp = Quad { origin, edge_u: DVec3::Y * 2.0, edge_v: DVec3::X * 2.0 };
/// let lamp = builder.add_quad("lamp", lamp, grey)?;
/// builder.set_emission(lamp, Emission { radiance: Rgb::splat(4.0), two_sided: false })?;
/// let world = builder.build()?;
/// assert_eq!(world.light_count(), 1);
/// # Ok(())
/// # }
/// ```
#[derive(Default)]
pub struct WorldBuilder {
    materials: Vec<Finish>,
    material_ids: HashMap<String, MaterialId>,
    names: HashSet<String>,
    surfaces: Vec<Surface>,
    shapes: Vec<Shape>,
    lights: Vec<(String, AnyLight)>,
    /// Index in `lights`.
    environment: Option<usize>,
    warnings: Vec<Warning>,
    variation: Variation,
}

impl WorldBuilder {
    /// An empty scene.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty scene, in which what is added is changed.
    #[must_use]
    pub fn varied(variation: Variation) -> Self {
        Self { variation, ..Self::default() }
    }

    /// Adds a material.
    ///
    /// # Errors
    /// The name is taken, or a parameter is outside its range.
    pub fn add_material(
        &mut self,
        name: impl Into<String>,
        material: Material,
    ) -> Result<MaterialId, SceneError> {
        let name = name.into();
        let material = self.variation.of_material(&name, material, &mut self.warnings);
        let finish = material
            .finish()
            .map_err(|reason| SceneError::Material { name: name.clone(), reason })?;
        if self.material_ids.contains_key(&name) {
            return Err(SceneError::DuplicateName { name });
        }
        Warning::of_material(&name, &material, &mut self.warnings);
        let id = MaterialId(self.materials.len() as u32);
        self.materials.push(finish);
        self.material_ids.insert(name, id);
        Ok(id)
    }

    /// The material of a name.
    ///
    /// # Errors
    /// There is none.
    pub fn material(&self, name: &str) -> Result<MaterialId, SceneError> {
        self.material_ids
            .get(name)
            .copied()
            .ok_or_else(|| SceneError::Missing { kind: "material", name: name.to_owned() })
    }

    /// Adds an instance of a mesh, brought to world space. Triangles without area are dropped and
    /// counted.
    ///
    /// # Errors
    /// The name is taken, the material missing, the transform singular, or the mesh itself
    /// inconsistent or not finite.
    pub fn add_mesh(
        &mut self,
        name: impl Into<String>,
        mesh: &Mesh,
        transform: DAffine3,
        material: MaterialId,
    ) -> Result<SurfaceId, SceneError> {
        let name = self.check_surface(name.into(), material)?;
        let placed = mesh.place(&name, &transform)?;
        let (dropped, object) = (placed.dropped, name.clone());
        let id = self.add_surface(name, material, placed.triangles, placed.attributes)?;
        if dropped > 0 {
            self.warnings.push(Warning::DroppedTriangles {
                object,
                dropped,
                triangles: mesh.indices.len(),
            });
        }
        Ok(id)
    }

    /// Adds a sphere or a zone of one; its axis is made unit length.
    ///
    /// # Errors
    /// The name is taken, the material missing, the radius not positive, the axis zero, or `cos_min
    /// < cos_max` in [-1, 1] violated.
    pub fn add_sphere(
        &mut self,
        name: impl Into<String>,
        sphere: Sphere,
        material: MaterialId,
    ) -> Result<SurfaceId, SceneError> {
        let name = self.check_surface(name.into(), material)?;
        check_point(&name, "center", sphere.center)?;
        check_radius(&name, sphere.radius)?;
        check(&name, "cos_min", sphere.cos_min, "at least -1 and less than cos_max", |c| {
            c >= -1.0 && c < sphere.cos_max
        })?;
        check(&name, "cos_max", sphere.cos_max, "at most 1", |c| c <= 1.0)?;
        let axis = check_direction(&name, "axis", sphere.axis)?;
        self.add_surface(name, material, vec![Shape::Sphere(Sphere { axis, ..sphere })], None)
    }

    /// Adds a parallelogram.
    ///
    /// # Errors
    /// The name is taken, the material missing, a number not finite, or no area: parallel edges, or
    /// a product of their lengths below 1e-153.
    pub fn add_quad(
        &mut self,
        name: impl Into<String>,
        quad: Quad,
        material: MaterialId,
    ) -> Result<SurfaceId, SceneError> {
        let name = self.check_surface(name.into(), material)?;
        check_point(&name, "origin", quad.origin)?;
        check_point(&name, "edge_u", quad.edge_u)?;
        check_point(&name, "edge_v", quad.edge_v)?;
        if !has_exact_length(quad.cross()) {
            return Err(SceneError::Degenerate { object: name });
        }
        self.add_surface(name, material, vec![Shape::Quad(quad)], None)
    }

    /// Adds the six faces of a box as one surface. Its front sides, which emit and bound a solid, face
    /// outward or inward.
    ///
    /// ```
    /// use pathspace::geometry::{Bounds, Facing};
    /// use pathspace::glam::DVec3;
    /// use pathspace::math::Rgb;
    /// use pathspace::scene::{Material, SceneError, WorldBuilder};
    ///
    /// # fn main() -> Result<(), SceneError> {
    /// let mut scene = WorldBuilder::new();
    /// let white = scene.add_material("white", Material::Lambert { albedo: Rgb::from(0.8) })?;
    /// let room = Bounds { min: -DVec3::ONE, max: DVec3::ONE };
    /// scene.add_box("room", room, Facing::Inward, white)?;
    /// let block = Bounds { min: DVec3::new(-0.3, -0.3, -1.0), max: DVec3::new(0.3, 0.3, 0.0) };
    /// scene.add_box("block", block, Facing::Outward, white)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The name is taken, the material missing, a number not finite, or an edge without length.
    pub fn add_box(
        &mut self,
        name: impl Into<String>,
        bounds: Bounds,
        facing: Facing,
        material: MaterialId,
    ) -> Result<SurfaceId, SceneError> {
        let name = self.check_surface(name.into(), material)?;
        check_point(&name, "min", bounds.min)?;
        check_point(&name, "max", bounds.max)?;
        let quads = Quad::faces_of(&bounds, facing);
        let has_area = |quad: &Quad| has_exact_length(quad.cross());
        if bounds.is_empty() || !quads.iter().all(has_area) {
            return Err(SceneError::Degenerate { object: name });
        }
        self.add_surface(name, material, quads.map(Shape::Quad).into(), None)
    }

    /// Adds a disk; its normal is made unit length.
    ///
    /// # Errors
    /// The name is taken, the material missing, the radius not positive, or the normal zero.
    pub fn add_disk(
        &mut self,
        name: impl Into<String>,
        disk: Disk,
        material: MaterialId,
    ) -> Result<SurfaceId, SceneError> {
        let name = self.check_surface(name.into(), material)?;
        check_point(&name, "center", disk.center)?;
        check_radius(&name, disk.radius)?;
        let normal = check_direction(&name, "normal", disk.normal)?;
        self.add_surface(name, material, vec![Shape::Disk(Disk { normal, ..disk })], None)
    }

    /// Makes a surface a light, which gets the name of the surface; black radiance makes it no
    /// light. The last call counts.
    ///
    /// # Errors
    /// The surface is missing or has no area, or the radiance is negative or not finite.
    pub fn set_emission(
        &mut self,
        surface: SurfaceId,
        emission: Emission,
    ) -> Result<(), SceneError> {
        self.set_textured_emission(surface, emission.radiance.into(), emission.two_sided)
    }

    /// Makes a surface a light whose radiance (W/(m² sr)) varies over it. Otherwise like
    /// [`WorldBuilder::set_emission`].
    ///
    /// # Errors
    /// The surface is missing or has no area, or the radiance is negative or not finite.
    pub fn set_textured_emission(
        &mut self,
        surface: SurfaceId,
        radiance: Texture,
        two_sided: bool,
    ) -> Result<(), SceneError> {
        let surface = surface_of(&mut self.surfaces, surface)?;
        let [least, greatest] = radiance.range();
        check_radiance(&surface.name, least)?;
        check_radiance(&surface.name, greatest)?;
        let area: f64 = surface.range(&self.shapes).iter().map(Shape::area).sum();
        if area.is_nan() || area <= 0.0 {
            return Err(SceneError::LightWithoutArea { object: surface.name.clone() });
        }
        surface.emission = (!greatest.is_black()).then_some((radiance, two_sided));
        Ok(())
    }

    /// Lays a normal or bump map on a surface. The last call counts.
    ///
    /// # Errors
    /// The surface is missing, or the scale of the relief infinite or not a number.
    pub fn set_relief(&mut self, surface: SurfaceId, relief: Relief) -> Result<(), SceneError> {
        let surface = surface_of(&mut self.surfaces, surface)?;
        check(&surface.name, "scale", relief.scale(), "finite", |_| true)?;
        surface.relief = Some(Box::new(relief));
        Ok(())
    }

    /// Fills the body behind a surface with a medium that absorbs and does not scatter, as coloured
    /// glass does: after a distance d `exp(-σ d)` of the light is left, σ the absorption coefficient
    /// per unit of the scene's length. All surfaces around a body need the same σ; a body that is
    /// not closed does not end. What lies inside of it and bounds nothing is in it, too. The last
    /// call counts.
    ///
    /// # Errors
    /// The surface is missing, or a component is negative or not finite.
    pub fn set_absorption(
        &mut self,
        surface: SurfaceId,
        absorption: Rgb,
    ) -> Result<(), SceneError> {
        let surface = surface_of(&mut self.surfaces, surface)?;
        for sigma in absorption.0 {
            check(&surface.name, "absorption", sigma, "at least 0", |sigma| sigma >= 0.0)?;
        }
        surface.absorption = absorption;
        Ok(())
    }

    /// Cuts a surface out: where the texture is black there is nothing, and rays pass without an
    /// event. Whatever the surface emits must be black there, too. The last call counts.
    ///
    /// # Errors
    /// The surface is missing.
    pub fn set_cutout(&mut self, surface: SurfaceId, there: Texture) -> Result<(), SceneError> {
        let surface = surface_of(&mut self.surfaces, surface)?;
        surface.cutout = Some(there);
        Ok(())
    }

    /// Adds a light that is not a surface of the scene: a point light, a spot light, a directional
    /// light.
    ///
    /// # Errors
    /// The name is taken.
    pub fn add_light(
        &mut self,
        name: impl Into<String>,
        light: impl Light + Send + 'static,
    ) -> Result<(), SceneError> {
        let name = self.check_name(name.into())?;
        self.names.insert(name.clone());
        self.lights.push((name, light.into_any()));
        Ok(())
    }

    /// Adds the light that rays which leave the scene reach.
    ///
    /// # Errors
    /// The name is taken, or there is an environment already.
    pub fn set_environment(
        &mut self,
        name: impl Into<String>,
        light: impl Light + Send + 'static,
    ) -> Result<(), SceneError> {
        let name = name.into();
        if self.environment.is_some() {
            return Err(SceneError::SecondEnvironment { name });
        }
        self.add_light(name, light)?;
        self.environment = Some(self.lights.len() - 1);
        Ok(())
    }

    /// True if a surface emits.
    #[cfg(feature = "import")]
    pub(crate) fn has_emission(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.emission.is_some())
    }

    /// True if a light that is no surface shines.
    #[cfg(feature = "import")]
    pub(crate) fn has_lights(&self) -> bool {
        self.lights.iter().any(|(_, light)| !light.is_black())
    }

    /// Builds the acceleration structure and the tables.
    ///
    /// Emissive surfaces become the first lights, in their order; then come the others in theirs.
    /// Surfaces that ask more of the arithmetic than it can give are no error;
    /// [`World::warnings`] tells of them.
    ///
    /// # Errors
    /// The scene is empty, or the power of a light is negative, not finite, or 0 although it shines.
    pub fn build(mut self) -> Result<World, SceneError> {
        if self.shapes.is_empty() && self.lights.is_empty() {
            return Err(SceneError::Empty);
        }
        let mut lights: Vec<(String, AnyLight)> = Vec::new();
        for (id, surface) in self.surfaces.iter_mut().enumerate() {
            let Some((radiance, two_sided)) = &mut surface.emission else { continue };
            let first = surface.first_primitive as usize;
            let shapes = &mut self.shapes[first..first + surface.primitives as usize];
            let name = &surface.name;
            self.variation.scale_lamp(name, shapes, radiance, &mut self.warnings)?;
            let (shapes, radiance, two_sided) = (shapes.to_vec(), radiance.clone(), *two_sided);
            surface.light = Some(LightId(lights.len() as u32));
            let uvs = surface
                .attributes
                .as_ref()
                .and_then(Attributes::corner_uvs)
                .filter(|_| radiance.as_constant().is_none());
            let light = AreaLight::textured(
                shapes,
                uvs,
                surface.first_primitive,
                id as u32,
                radiance,
                two_sided,
            )
            .map_err(|reason| SceneError::Light { name: surface.name.clone(), reason })?;
            lights.push((surface.name.clone(), light.into_any()));
        }
        let environment = self.environment.map(|index| LightId((lights.len() + index) as u32));
        lights.append(&mut self.lights);
        let bounds =
            self.shapes.iter().fold(Bounds::EMPTY, |bounds, shape| bounds.union(shape.bounds()));
        let extent = SceneExtent::covering(self.shapes.iter().map(Shape::bounds));
        let light_tree = lights::prepare(&mut lights, &extent)?;
        Warning::of_surfaces(&self.surfaces, &self.shapes, &bounds, &mut self.warnings);
        let areas: Vec<f64> = self.shapes.iter().map(Shape::area).collect();
        let media = Media::of(&mut self.surfaces)?;
        let forest = Forest::new(self.shapes, &bounds);
        Warning::of_stretch(&self.surfaces, &forest, &mut self.warnings);
        let mut material_names = vec![String::new(); self.materials.len()];
        for (name, id) in self.material_ids {
            material_names[id.0 as usize] = name;
        }
        Ok(World::assemble(
            forest,
            bounds,
            (self.materials, material_names),
            (self.surfaces, media),
            lights,
            environment,
            light_tree,
            &areas,
            self.warnings,
        ))
    }

    fn check_name(&self, name: String) -> Result<String, SceneError> {
        if self.names.contains(&name) { Err(SceneError::DuplicateName { name }) } else { Ok(name) }
    }

    fn check_surface(&self, name: String, material: MaterialId) -> Result<String, SceneError> {
        if material.0 as usize >= self.materials.len() {
            return Err(SceneError::Missing { kind: "material", name: material.0.to_string() });
        }
        self.check_name(name)
    }

    fn add_surface(
        &mut self,
        name: String,
        material: MaterialId,
        mut shapes: Vec<Shape>,
        attributes: Option<Attributes>,
    ) -> Result<SurfaceId, SceneError> {
        if self.shapes.len() + shapes.len() >= i32::MAX as usize {
            return Err(SceneError::TooManyPrimitives);
        }
        let (first_primitive, primitives) = (self.shapes.len() as u32, shapes.len() as u32);
        self.names.insert(name.clone());
        self.shapes.append(&mut shapes);
        let id = SurfaceId(self.surfaces.len() as u32);
        self.surfaces.push(Surface {
            name,
            material,
            emission: None,
            light: None,
            cutout: None,
            first_primitive,
            primitives,
            attributes,
            relief: None,
            absorption: Rgb::BLACK,
            medium: 0,
        });
        Ok(id)
    }
}

fn check_radius(name: &str, radius: f64) -> Result<(), SceneError> {
    // Squares must neither lose digits nor overflow.
    let fits = |r: f64| (1e-150..=SceneError::MAX_COORDINATE).contains(&r);
    check(name, "radius", radius, "from 1e-150 to 1e50", fits)
}

fn check_direction(
    name: &str,
    parameter: &'static str,
    direction: glam::DVec3,
) -> Result<glam::DVec3, SceneError> {
    check_point(name, parameter, direction)?;
    let zero = || SceneError::Parameter {
        object: name.to_owned(),
        parameter,
        value: direction.length(),
        requirement: "a vector of positive length",
    };
    unit(direction).ok_or_else(zero)
}

/// The surface of an id.
fn surface_of(surfaces: &mut [Surface], id: SurfaceId) -> Result<&mut Surface, SceneError> {
    let missing = || SceneError::Missing { kind: "surface", name: id.0.to_string() };
    surfaces.get_mut(id.0 as usize).ok_or_else(missing)
}

impl std::fmt::Debug for WorldBuilder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WorldBuilder")
            .field("materials", &self.materials.len())
            .field("surfaces", &self.surfaces.len())
            .field("primitives", &self.shapes.len())
            .field("lights", &self.lights.len())
            .finish_non_exhaustive()
    }
}
