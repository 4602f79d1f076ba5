//! The choice among lights: exact probabilities, variances in closed form, and extremes.
#![allow(missing_debug_implementations, missing_docs, reason = "a test program")]

#[path = "light_tree/choice.rs"]
mod choice;
#[path = "light_tree/extremes.rs"]
mod extremes;
#[path = "light_tree/variance.rs"]
mod variance;

use pathspace::geometry::{Bounds, SurfacePoint};
use pathspace::glam::{DVec2, DVec3};
use pathspace::light_tree::{Arrival, LightBounds, LightTree, Trials};
use pathspace::math::warp::square_to_sphere;
use pathspace::sampler::{Independent, IndependentSampler, SampleSource, Sampler};
use std::f64::consts::{FRAC_PI_2, PI};

/// Numbers in [0, 1).
pub struct Random(IndependentSampler);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Independent { seed }.sampler(0, 0))
    }

    pub fn number(&mut self) -> f64 {
        self.0.next_1d()
    }

    pub fn in_cube(&mut self, half: f64) -> DVec3 {
        DVec3::from([0.0; 3].map(|_| half * (2.0 * self.number() - 1.0)))
    }

    pub fn direction(&mut self) -> DVec3 {
        square_to_sphere(DVec2::new(self.number(), self.number()))
    }

    pub fn receiver(&mut self, half: f64) -> SurfacePoint {
        let (position, normal) = (self.in_cube(half), self.direction());
        SurfacePoint::on_surface(position, 0.0, normal)
    }
}

/// A point light.
pub fn point(position: DVec3, intensity: f64) -> LightBounds {
    LightBounds::isotropic(Bounds::of_points([position]), intensity)
}

/// Points, flat and round lights, narrow and wide spots of powers over six decades, and a sky; with
/// weights by intensity, of which some are 0.
pub fn mixed(count: usize, seed: u64) -> (Vec<LightBounds>, Vec<f64>) {
    let mut random = Random::new(seed);
    let lights: Vec<LightBounds> = (0..count)
        .map(|i| {
            let (a, b) = (random.in_cube(10.0), random.in_cube(0.3));
            let (axis, intensity) = (random.direction(), 10f64.powf(6.0 * random.number() - 3.0));
            let bounds = Bounds::of_points([a, a + b]);
            match i % 5 {
                0 => point(a, intensity),
                1 => LightBounds::lambertian(bounds, intensity, axis),
                2 => LightBounds::isotropic(bounds, intensity),
                3 => LightBounds {
                    axis,
                    theta_o: 0.3 * random.number(),
                    theta_e: 0.01 + random.number() * (FRAC_PI_2 - 0.01),
                    ..point(a, intensity)
                },
                _ if i == 4 => LightBounds::unbounded(intensity),
                _ => LightBounds { axis, theta_o: PI * random.number(), ..point(a, intensity) },
            }
        })
        .collect();
    let weights = lights.iter().enumerate();
    let weights = weights.map(|(i, l)| if i % 17 == 16 { 0.0 } else { l.intensity }).collect();
    (lights, weights)
}

/// The outcome of some trials that favour every third item, and never met most.
pub fn some_arrival(tree: &LightTree, count: u32) -> Arrival {
    let (mut connections, mut walks, mut random) =
        (Trials::default(), Trials::default(), Random::new(9));
    for _ in 0..200 {
        let item = (random.number() * f64::from(count)) as u32;
        connections.push(item, 0.5 + random.number(), f64::from(u8::from(item.is_multiple_of(3))));
        walks.push(item, 0.5 + random.number(), f64::from(u8::from(item.is_multiple_of(2))));
    }
    Arrival::new(tree, &connections, &walks)
}
