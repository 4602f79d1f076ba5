//! A world under construction whose objects need no names, for tests and examples.

use pathspace::endpoint::Light;
use pathspace::geometry::{Disk, Quad, Sphere};
use pathspace::glam::{DAffine3, DVec3};
use pathspace::math::Rgb;
use pathspace::scene::{Emission, Material, MaterialId, Mesh, SurfaceId, World, WorldBuilder};

/// A builder that is given nothing but what is valid.
#[derive(Default)]
pub struct Stage {
    pub builder: WorldBuilder,
    objects: u32,
}

impl Stage {
    fn name(&mut self) -> String {
        self.objects += 1;
        self.objects.to_string()
    }

    fn material(&mut self, material: Material) -> MaterialId {
        let name = self.name();
        self.builder.add_material(name, material).expect("valid material")
    }

    pub fn quad(
        &mut self,
        origin: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
        material: Material,
    ) -> SurfaceId {
        self.face(Quad { origin, edge_u, edge_v }, material)
    }

    pub fn face(&mut self, quad: Quad, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_quad(name, quad, material).expect("valid quad")
    }

    /// A square in the plane of a height, its front side up or down.
    pub fn square(&mut self, z: f64, half: f64, up: bool, material: Material) -> SurfaceId {
        let (u, v) = (DVec3::X * (2.0 * half), DVec3::Y * (2.0 * half));
        let (edge_u, edge_v) = if up { (u, v) } else { (v, u) };
        self.quad(DVec3::new(-half, -half, z), edge_u, edge_v, material)
    }

    pub fn sphere(&mut self, sphere: Sphere, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_sphere(name, sphere, material).expect("valid sphere")
    }

    pub fn disk(
        &mut self,
        center: DVec3,
        normal: DVec3,
        radius: f64,
        material: Material,
    ) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_disk(name, Disk { center, normal, radius }, material).expect("valid disk")
    }

    pub fn mesh(&mut self, mesh: &Mesh, transform: DAffine3, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_mesh(name, mesh, transform, material).expect("valid mesh")
    }

    pub fn emit(&mut self, surface: SurfaceId, radiance: Rgb, two_sided: bool) {
        self.builder
            .set_emission(surface, Emission { radiance, two_sided })
            .expect("valid emission");
    }

    /// Makes the front side of a surface emit.
    pub fn glow(&mut self, surface: SurfaceId, radiance: f64) {
        self.emit(surface, Rgb::splat(radiance), false);
    }

    /// Fills the body behind a surface.
    pub fn absorb(&mut self, surface: SurfaceId, absorption: Rgb) {
        self.builder.set_absorption(surface, absorption).expect("valid absorption");
    }

    pub fn light(&mut self, light: impl Light + Send + 'static) {
        let name = self.name();
        self.builder.add_light(name, light).expect("valid light");
    }

    pub fn environment(&mut self, light: impl Light + Send + 'static) {
        self.builder.set_environment("sky", light).expect("one environment");
    }

    pub fn build(self) -> World {
        self.builder.build().expect("valid world")
    }
}
