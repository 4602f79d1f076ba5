//! What a world is made of, as one number.

use super::World;
use crate::endpoint::{Light, answers};
use crate::material::CustomBsdf;
use crate::math::warp::square_to_sphere;
use crate::math::{Fingerprint, Rgb};
use glam::DVec2;

impl World {
    /// A number that differs between worlds with different shapes, materials, textures, media or
    /// lights. BSDFs and lights of a user's own are told apart by what they answer to a few
    /// questions.
    pub(super) fn print(&self) -> u64 {
        let mut print = Fingerprint::default()
            .with(self.forest.shapes())
            .with(&self.surfaces)
            .with(&self.media)
            .with(&self.materials);
        for custom in self.materials.iter().filter_map(|finish| finish.as_custom()) {
            print = print.with(values(custom));
        }
        for (name, light) in &self.lights {
            print = print.with(name).with(light.power()).with(answers(light));
        }
        print.get()
    }
}

/// The values of a BSDF for pairs of directions.
fn values(bsdf: &CustomBsdf) -> Vec<Rgb> {
    let direction = |index: u32, of: f64| {
        square_to_sphere(DVec2::new(
            (f64::from(index) + 0.5) / 16.0,
            (f64::from(index) * of).fract(),
        ))
    };
    (0..16).map(|index| bsdf.eval(direction(index, 0.618), direction(15 - index, 0.414))).collect()
}
