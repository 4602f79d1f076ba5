//! Tiny scenes: a coloured room that is open towards the camera and, if wanted, above, with a
//! tilted blocker in it.

#[path = "stage.rs"]
#[allow(dead_code, reason = "shared by several programs")]
mod stage;

use glam::{DVec3, UVec2};
use pathspace::endpoint::{OrthographicCamera, PinholeCamera, ThinLensCamera};
use pathspace::math::Rgb;
use pathspace::scene::Material;
pub use stage::Stage as Room;

pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

pub fn lambert(r: f64, g: f64, b: f64) -> Material {
    Material::Lambert { albedo: Rgb::new(r, g, b) }
}

impl Room {
    /// [-1, 1]² × [0, 2]: a floor of the given material, a grey back wall, a red and a green side,
    /// and a blocker. Nothing above, nothing in front.
    pub fn open(floor: Material) -> Self {
        let mut room = Self::default();
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

    /// A square lamp just below the ceiling that shines down.
    pub fn lamp(&mut self, half: f64, radiance: f64) {
        let lamp = self.quad(
            v(-half, -half, 1.95),
            v(0.0, 2.0 * half, 0.0),
            v(2.0 * half, 0.0, 0.0),
            lambert(0.3, 0.3, 0.3),
        );
        self.emit(lamp, Rgb::new(1.0, 0.9, 0.7) * radiance, false);
    }
}

pub const FILM: UVec2 = UVec2::splat(16);

/// Looks into the room from the front, below z = 1.7; the film is filled by it.
pub fn camera() -> PinholeCamera {
    PinholeCamera::new(v(0.1, -2.9, 1.1), v(0.0, 0.0, 0.7), DVec3::Z, 32.0, FILM)
        .expect("valid camera")
}

/// The same with a large lens, focused on the blocker.
pub fn lens_camera() -> ThinLensCamera {
    ThinLensCamera::new(v(0.1, -2.9, 1.1), v(0.0, 0.0, 0.7), DVec3::Z, 32.0, 0.3, 2.7, FILM)
        .expect("valid camera")
}

/// Parallel rays into the room, slightly from above.
pub fn parallel_camera() -> OrthographicCamera {
    OrthographicCamera::new(v(0.0, -3.0, 1.6), v(0.0, 0.0, 0.8), DVec3::Z, 1.7, FILM)
        .expect("valid camera")
}
