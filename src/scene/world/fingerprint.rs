//! All that a world is made of, as one number.

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

/// The values of a BSDF for pairs of directions, on the same side and on different ones.
fn values(bsdf: &CustomBsdf) -> Vec<Rgb> {
    let direction = |index: u32| {
        let index = f64::from(index % 16);
        square_to_sphere(DVec2::new((index + 0.5) / 16.0, (index * 0.618).fract()))
    };
    (0..64).map(|index| bsdf.eval(direction(index), direction(index * 7 + index / 16))).collect()
}

#[cfg(test)]
mod tests {
    use crate::bsdf::{Bsdf, BsdfSample, Lambert, Lobes, TransportMode};
    use crate::endpoint::PointLight;
    use crate::film::Image;
    use crate::geometry::Sphere;
    use crate::material::{Interpolation, Texture, Wrap};
    use crate::math::{PerProjected, Rgb};
    use crate::scene::{Material, Mesh, Scene, WorldBuilder};
    use glam::{DAffine3, DVec2, DVec3};
    use std::collections::BTreeSet;

    struct Own(Lambert);

    impl Bsdf for Own {
        fn lobes(&self) -> Lobes {
            self.0.lobes()
        }
        fn eval(&self, a: DVec3, b: DVec3) -> Rgb {
            self.0.eval(a, b)
        }
        fn pdf(&self, a: DVec3, b: DVec3, mode: TransportMode) -> PerProjected {
            self.0.pdf(a, b, mode)
        }
        fn sample(&self, a: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
            self.0.sample(a, mode, u1, u2)
        }
    }

    /// A world whose number `change` differs in something small.
    fn print(change: u32) -> u64 {
        let is = |number: u32| if change == number { 1e-9 } else { 0.0 };
        let mut world = WorldBuilder::new();
        let grey = |plus| Rgb::splat(0.5 + plus);
        let plain = Material::Lambert { albedo: grey(is(1)) };
        let plain = world.add_material("plain", plain).unwrap();
        let pixels = Image::from_fn(2, 2, |x, y| grey(if x + y == 2 { is(2) } else { 0.0 }));
        let texture = Texture::bitmap(pixels, Interpolation::Nearest, [Wrap::Repeat; 2]).unwrap();
        let picture = Material::Plastic {
            albedo: texture,
            specular: Rgb::WHITE,
            relative_ior: 1.5,
            colour_shift: true,
        };
        let picture = world.add_material("picture", picture).unwrap();
        let own = Material::custom(Own(Lambert::new(grey(is(3))).unwrap()));
        let own = world.add_material("own", own).unwrap();
        let mut mesh = Mesh::icosphere(1);
        mesh.positions[3].x += is(4);
        mesh.normals = Some(mesh.positions.iter().map(|p| p.normalize()).collect());
        if change == 5 {
            mesh.normals.as_mut().unwrap()[0] = DVec3::new(0.1, 0.2, 0.3).normalize();
        }
        world.add_mesh("mesh", &mesh, DAffine3::IDENTITY, picture).unwrap();
        let ball = Sphere::new(DVec3::splat(3.0), 1.0 + is(6));
        let ball = world.add_sphere("ball", ball, if change == 7 { plain } else { own }).unwrap();
        world.set_absorption(ball, Rgb::splat(0.1 + is(8))).unwrap();
        let light = PointLight::new(DVec3::new(0.0, 9.0, is(9)), grey(is(10))).unwrap();
        world.add_light("light", light).unwrap();
        world.build().unwrap().fingerprint().unwrap()
    }

    #[test]
    fn every_small_change_changes_the_fingerprint() {
        assert_eq!(print(0), print(0));
        let prints: BTreeSet<u64> = (0..=10).map(print).collect();
        assert_eq!(prints.len(), 11);
    }
}
