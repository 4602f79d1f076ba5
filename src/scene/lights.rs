//! The lights of a world and the choice among them by their power.

use super::error::{SceneError, check};
use crate::endpoint::{Light, LightId, SceneExtent};
use crate::math::distribution::AliasTable;

/// A light that a world can own.
pub(crate) type BoxedLight = Box<dyn Light + Send>;

/// Tells all lights how large the scene is and builds the table to choose among them.
pub(crate) fn prepare(
    lights: &mut [(String, BoxedLight)],
    extent: &SceneExtent,
) -> Result<Choice, SceneError> {
    let mut powers = Vec::with_capacity(lights.len());
    for (name, light) in lights {
        light.set_scene_extent(extent);
        let power = light.power();
        power
            .0
            .iter()
            .try_for_each(|&p| check(name, "power", p, "finite and not negative", |p| p >= 0.0))?;
        powers.push(power.mean());
    }
    Ok(Choice::new(&powers))
}

/// A choice among numbered things with given weights; those of weight 0 are never chosen, and
/// nothing is if all are 0.
#[derive(Debug)]
pub(crate) struct Choice(Option<AliasTable>);

impl Choice {
    /// A choice by finite weights that are not negative.
    pub fn new(weights: &[f64]) -> Self {
        // Scaled first: the sum of large weights must not overflow.
        let largest = weights.iter().copied().fold(0.0, f64::max);
        let scaled: Vec<f64> = weights.iter().map(|weight| weight / largest).collect();
        Self(AliasTable::new(&scaled))
    }

    /// Chooses with a number in [0, 1).
    #[inline]
    pub fn sample(&self, u: f64) -> Option<(u32, f64)> {
        let (index, pmf) = self.0.as_ref()?.sample(u);
        Some((index as u32, pmf))
    }

    /// The probability of one of the things; 0 for a number that is none of them.
    #[inline]
    pub fn pmf(&self, index: u32) -> f64 {
        self.0.as_ref().map_or(0.0, |table| {
            if (index as usize) < table.len() { table.pmf(index as usize) } else { 0.0 }
        })
    }

    /// The id of a light chosen by this table.
    #[inline]
    pub fn sample_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.sample(u).map(|(index, pmf)| (LightId(index), pmf))
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
            assert_eq!(pmf, choice.pmf(index));
            assert!(pmf > 0.0);
        }
        assert_eq!(
            (choice.pmf(0), choice.pmf(1), choice.pmf(3), choice.pmf(9)),
            (0.0, 0.25, 0.75, 0.0)
        );
        assert_eq!(Choice::new(&[0.0, 0.0]).sample(0.5), None);
        assert_eq!(Choice::new(&[]).sample(0.5), None);
        assert_eq!(Choice::new(&[1e308, 1e308]).sample(0.7).map(|(_, pmf)| pmf), Some(0.5));
    }
}
