//! The lights of a world and the choice among them.

use super::error::{SceneError, check, check_point};
use crate::endpoint::{AnyLight, Endpoint, Light, SceneExtent};
use crate::geometry::{Bounds, SurfacePoint};
use crate::light_tree::{LightBounds, LightTree, with_floor};
use crate::math::distribution::{AliasTable, relative};
use glam::{DVec2, Vec2Swizzles};
use std::f64::consts::PI;

/// The part that counts of the power of lights that can be seen, but illuminate nothing.
const SEEN_DIRECTLY: f64 = 1e-3;

/// Rays by which a light without power is found to shine.
const TRIES: u32 = 64;

/// Tells all lights how large the scene is and builds the tree to choose among them.
///
/// Without a receiver, where light walks start, lights are chosen by the flux that they can send
/// into the scene, and a little by number.
pub(crate) fn prepare(
    lights: &mut [(String, AnyLight)],
    extent: &SceneExtent,
) -> Result<LightTree, SceneError> {
    let mut all = Vec::with_capacity(lights.len());
    for (name, light) in lights.iter_mut() {
        light.set_scene_extent(extent);
        let power = light.power();
        power
            .0
            .iter()
            .try_for_each(|&p| check(name, "power", p, "finite and not negative", |p| p >= 0.0))?;
        let power = if light.is_black() { 0.0 } else { power.mean() };
        // The crate's own lights know their power; it is 0 where it is too small for an f64.
        let is_hosts = matches!(light, AnyLight::Custom(_));
        if is_hosts && power == 0.0 && extent.cross_section() > 0.0 && shines(light, extent) {
            return Err(SceneError::PowerlessLight { name: name.clone() });
        }
        let around = light.bounds();
        if let Some(around) = around {
            check_bounds(name, &around)?;
        }
        all.push((power, around.unwrap_or_else(|| unbounded(power, extent))));
    }
    let bounds = extent.bounds();
    // A light may shine although it does not know how much.
    let known: Vec<f64> = all.iter().map(|(power, _)| *power).filter(|p| *p > 0.0).collect();
    let usual = known.iter().map(|power| power / known.len() as f64).sum::<f64>();
    let usual = if usual > 0.0 { usual } else { 1.0 };
    for ((power, around), (_, light)) in all.iter_mut().zip(&*lights) {
        let shines = !light.is_black() && light.can_illuminate(&bounds);
        if shines && *power == 0.0 && extent.cross_section() > 0.0 {
            *power = usual;
        }
        if *power > 0.0 && around.intensity == 0.0 {
            let intensity = *power / (4.0 * PI);
            *around = match around.is_bounded() {
                true => LightBounds { intensity, ..*around },
                false => unbounded(*power, extent),
            };
        }
        *power = power.min(around.intensity * solid_angle(around, extent));
        if !light.can_illuminate(&bounds) {
            *power *= SEEN_DIRECTLY;
        }
    }
    let (powers, bounds): (Vec<f64>, Vec<LightBounds>) = all.into_iter().unzip();
    Ok(LightTree::new(&bounds, &with_floor(&powers)))
}

/// True if some of a few rays from a light carry something, or if it emits to the middle of a box.
fn shines(light: &AnyLight, extent: &SceneExtent) -> bool {
    if light.is_black() {
        return false;
    }
    // Points of the R₃ sequence (Roberts 2018), far apart from one another.
    let number = |i: u32, step: f64| (0.5 + f64::from(i) * step).fract();
    (0..TRIES).any(|i| {
        let u1 = number(i, 0.819_172_513_396_164_5);
        let u2 = DVec2::new(number(i, 0.671_043_606_703_789_3), number(i, 0.549_700_477_901_970_3));
        let leaves = light
            .sample_point(u1, u2)
            .and_then(|start| light.sample_direction(&start.point, u2.yx()))
            .is_some_and(|ray| !ray.weight.is_black());
        leaves
            || extent.boxes().iter().any(|bounds| {
                let receiver = SurfacePoint::dirac(bounds.center());
                light.sample_from(&receiver, u1, u2).is_some_and(|sample| {
                    let to_receiver = receiver.position - sample.point.position;
                    !light.emit(&sample.point, to_receiver.normalize_or_zero()).is_black()
                })
            })
    })
}

/// The bounds of a light at infinity that sends a flux into the scene: the mean irradiance on a
/// surface of any direction is a quarter of that on a plane that it falls on.
fn unbounded(power: f64, scene: &SceneExtent) -> LightBounds {
    let area = 4.0 * scene.cross_section();
    LightBounds::unbounded(if area > 0.0 { power / area } else { 0.0 })
}

/// The solid angle under which a light sees the spheres around the boxes; infinite for one at
/// infinity.
fn solid_angle(light: &LightBounds, scene: &SceneExtent) -> f64 {
    if !light.is_bounded() {
        return f64::INFINITY;
    }
    let of_box = |around: &Bounds| {
        let reach = around.radius() + light.bounds.radius();
        let sine = reach / light.bounds.center().distance(around.center());
        if sine < 1.0 {
            // 1 - cos
            2.0 * PI * sine * sine / (1.0 + (1.0 - sine * sine).sqrt())
        } else {
            4.0 * PI
        }
    };
    scene.boxes().iter().map(of_box).sum()
}

/// Refuses bounds that say nothing.
fn check_bounds(name: &str, light: &LightBounds) -> Result<(), SceneError> {
    let is_angle = |angle: f64| (0.0..=PI).contains(&angle);
    check(name, "intensity", light.intensity, "finite and not negative", |i| i >= 0.0)?;
    check(name, "theta_o", light.theta_o, "an angle from 0 to pi", is_angle)?;
    check(name, "theta_e", light.theta_e, "an angle from 0 to pi", is_angle)?;
    check(name, "axis", light.axis.length(), "a unit vector", |l| (l - 1.0).abs() < 1e-3)?;
    check_point(name, "bounds", light.bounds.min)?;
    check_point(name, "bounds", light.bounds.max)
}

/// A choice among numbered things with given weights; those of weight 0 are never chosen, and
/// nothing is if all are 0.
#[derive(Debug)]
pub(crate) struct Choice(Option<AliasTable>);

impl Choice {
    /// A choice by finite weights that are not negative.
    pub fn new(weights: &[f64]) -> Self {
        Self(AliasTable::new(&relative(weights)))
    }

    /// Chooses with a number in [0, 1).
    #[inline]
    pub fn sample(&self, u: f64) -> Option<(u32, f64)> {
        let (index, pmf) = self.0.as_ref()?.sample(u);
        Some((index as u32, pmf))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_zero_are_never_chosen() {
        let choice = Choice::new(&[0.0, 1.0, 0.0, 3.0, 0.0]);
        for u in [0.0, 0.2, 0.25, 0.5, 0.999, 1.0f64.next_down()] {
            let (index, pmf) = choice.sample(u).unwrap();
            assert_eq!(pmf, if index == 1 { 0.25 } else { 0.75 });
            assert!(index == 1 || index == 3);
        }
        assert_eq!(Choice::new(&[0.0, 0.0]).sample(0.5), None);
        assert_eq!(Choice::new(&[]).sample(0.5), None);
        assert_eq!(Choice::new(&[1e308, 1e308]).sample(0.7).map(|(_, pmf)| pmf), Some(0.5));
    }
}
