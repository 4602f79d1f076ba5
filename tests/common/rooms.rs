//! Tiny scenes: a coloured room that is open towards the camera and, if wanted, above, with a tilted blocker in it.

use glam::{DAffine3, DVec3, UVec2};
use pathspace::endpoint::{OrthographicCamera, PinholeCamera, ThinLensCamera};
use pathspace::geometry::{Disk, Quad, Sphere};
use pathspace::math::Rgb;
use pathspace::scene::{Emission, Material, MaterialId, Mesh, SurfaceId, World, WorldBuilder};

pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

pub fn lambert(r: f64, g: f64, b: f64) -> Material {
    Material::Lambert { albedo: Rgb::new(r, g, b) }
}

/// A builder of scenes that are known to be valid.
pub struct Room {
    pub builder: WorldBuilder,
    count: usize,
}

impl Room {
    pub fn empty() -> Self {
        Self { builder: WorldBuilder::new(), count: 0 }
    }

    /// [-1, 1]² × [0, 2]: a floor of the given material, a grey back wall, a red and a green side, and a blocker. Nothing above, nothing in front.
    pub fn open(floor: Material) -> Self {
        let mut room = Self::empty();
        room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), floor);
        room.quad(v(-1.0, 1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0), lambert(0.7, 0.7, 0.6));
        room.quad(v(-1.0, -1.0, 0.0), v(0.0, 2.0, 0.0), v(0.0, 0.0, 2.0), lambert(0.7, 0.2, 0.1));
        room.quad(v(1.0, -1.0, 0.0), v(0.0, 0.0, 2.0), v(0.0, 2.0, 0.0), lambert(0.1, 0.6, 0.2));
        room.quad(v(-0.5, -0.3, 0.5), v(0.7, 0.0, 0.2), v(0.0, 0.6, 0.1), lambert(0.4, 0.5, 0.8));
        room
    }

    /// The same with a ceiling.
    pub fn closed_above(floor: Material) -> Self {
        let mut room = Self::open(floor);
        room.quad(v(-1.0, -1.0, 2.0), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0), lambert(0.6, 0.6, 0.6));
        room
    }

    fn name(&mut self) -> String {
        self.count += 1;
        self.count.to_string()
    }

    pub fn material(&mut self, material: Material) -> MaterialId {
        let name = self.name();
        self.builder.add_material(name, material).expect("valid material")
    }

    pub fn quad(&mut self, origin: DVec3, edge_u: DVec3, edge_v: DVec3, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_quad(name, Quad { origin, edge_u, edge_v }, material).expect("valid quad")
    }

    pub fn sphere(&mut self, sphere: Sphere, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_sphere(name, sphere, material).expect("valid sphere")
    }

    pub fn disk(&mut self, center: DVec3, normal: DVec3, radius: f64, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_disk(name, Disk { center, normal, radius }, material).expect("valid disk")
    }

    pub fn mesh(&mut self, mesh: &Mesh, transform: DAffine3, material: Material) -> SurfaceId {
        let (material, name) = (self.material(material), self.name());
        self.builder.add_mesh(name, mesh, transform, material).expect("valid mesh")
    }

    pub fn emit(&mut self, surface: SurfaceId, radiance: Rgb, two_sided: bool) {
        self.builder.set_emission(surface, Emission { radiance, two_sided }).expect("valid emission");
    }

    /// A square lamp just below the ceiling that shines down.
    pub fn lamp(&mut self, half: f64, radiance: f64) {
        let lamp = self.quad(v(-half, -half, 1.95), v(0.0, 2.0 * half, 0.0), v(2.0 * half, 0.0, 0.0), lambert(0.3, 0.3, 0.3));
        self.emit(lamp, Rgb::new(1.0, 0.9, 0.7) * radiance, false);
    }

    pub fn light(&mut self, light: impl pathspace::endpoint::Light + Send + 'static) {
        let name = self.name();
        self.builder.add_light(name, light).expect("new name");
    }

    pub fn environment(&mut self, light: impl pathspace::endpoint::Light + Send + 'static) {
        self.builder.set_environment("sky", light).expect("the only one");
    }

    pub fn build(self) -> World {
        self.builder.build().expect("valid scene")
    }
}

pub const FILM: UVec2 = UVec2::splat(16);

/// Looks into the room from the front, below z = 1.7; the film is filled by it.
pub fn camera() -> PinholeCamera {
    PinholeCamera::new(v(0.1, -2.9, 1.1), v(0.0, 0.0, 0.7), DVec3::Z, 32.0, FILM).expect("valid camera")
}

/// The same with a large lens, focused on the blocker.
pub fn lens_camera() -> ThinLensCamera {
    ThinLensCamera::new(v(0.1, -2.9, 1.1), v(0.0, 0.0, 0.7), DVec3::Z, 32.0, 0.3, 2.7, FILM).expect("valid camera")
}

/// Parallel rays into the room, slightly from above.
pub fn parallel_camera() -> OrthographicCamera {
    OrthographicCamera::new(v(0.0, -3.0, 1.6), v(0.0, 0.0, 0.8), DVec3::Z, 1.7, FILM).expect("valid camera")
}
