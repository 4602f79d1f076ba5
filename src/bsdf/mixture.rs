//! A weighted sum of models: `f = Σ w_k f_k`, sampled by choosing one of them with its probability.
//! Weights may be coloured.

use super::{Bsdf, BsdfError, BsdfSample, Lobes, TransportMode};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// `N` models of one type with weights, for example a [`Model`](super::Model) of any
/// kind.
///
/// A sampled direction's density is that of all finite lobes together, and its weight is the sum's
/// `f / p⊥`. A sampled Dirac lobe carries the probability of its component, together with those of
/// other components whose Dirac lobes map the same directions into each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture<B, const N: usize> {
    components: [B; N],
    weights: [Rgb; N],
    probabilities: [f64; N],
}

impl<B: Bsdf, const N: usize> Mixture<B, N> {
    /// A sum of models, each with its weight and chosen in proportion to it.
    ///
    /// Weights that sum to at most 1 keep energy conserved; this is not enforced, because the
    /// components may be dark.
    ///
    /// # Errors
    /// If a weight is negative or not finite, or all are 0.
    pub fn new(components: [B; N], weights: [f64; N]) -> Result<Self, BsdfError> {
        Self::with_probabilities(components, weights, weights)
    }

    /// A sum of models, each with a coloured weight and chosen in proportion to its `probabilities`
    /// (which need not sum to 1).
    ///
    /// # Errors
    /// As for [`Mixture::with_probabilities`], except that all weights may be 0.
    pub fn tinted(
        components: [B; N],
        weights: [Rgb; N],
        probabilities: [f64; N],
    ) -> Result<Self, BsdfError> {
        let total: f64 = probabilities.iter().sum();
        for (weight, &probability) in weights.iter().zip(&probabilities) {
            let valid = |x: f64| x.is_finite() && x >= 0.0;
            if let Some(&channel) = weight.0.iter().find(|channel| !valid(**channel)) {
                return Err(BsdfError::MixtureWeight(channel));
            }
            if !valid(probability) || (!weight.is_black() && probability == 0.0) {
                return Err(BsdfError::MixtureWeight(probability));
            }
        }
        if !(total.is_finite() && total > 0.0) {
            return Err(BsdfError::MixtureWeight(total));
        }
        Ok(Self {
            components,
            weights,
            probabilities: probabilities.map(|probability| probability / total),
        })
    }

    /// A sum of models, each with its weight and chosen in proportion to its `probabilities` (which
    /// need not sum to 1).
    ///
    /// # Errors
    /// If a number is negative or not finite, if all of a kind are 0, or if a component has a
    /// weight but no probability.
    pub fn with_probabilities(
        components: [B; N],
        weights: [f64; N],
        probabilities: [f64; N],
    ) -> Result<Self, BsdfError> {
        if weights.iter().all(|&weight| weight == 0.0) {
            return Err(BsdfError::MixtureWeight(0.0));
        }
        Self::tinted(components, weights.map(Rgb::splat), probabilities)
    }

    /// A sum whose numbers are known to be valid and whose probabilities sum to 1.
    pub(crate) const fn of_valid(
        components: [B; N],
        weights: [Rgb; N],
        probabilities: [f64; N],
    ) -> Self {
        Self { components, weights, probabilities }
    }

    /// The component that `u` chooses, and `u` stretched back to [0, 1) for the component's own
    /// use.
    fn choose(&self, u: f64) -> Option<(usize, f64)> {
        let mut below = 0.0;
        let mut last = None;
        for (k, &probability) in
            self.probabilities.iter().enumerate().filter(|(_, probability)| **probability > 0.0)
        {
            let stretched = ((u - below) / probability).clamp(0.0, 1.0f64.next_down());
            if u < below + probability {
                return Some((k, stretched));
            }
            below += probability;
            last = Some((k, stretched));
        }
        // the probabilities sum to 1 only up to rounding
        last
    }

    /// The mean of the components' densities by their probabilities; in index order, so that a
    /// sample's is that of `pdf` to the bit.
    fn mean(&self, density: impl Fn(usize) -> PerProjected) -> PerProjected {
        let terms = self.probabilities.iter().enumerate();
        PerProjected(terms.map(|(k, probability)| density(k).value() * probability).sum())
    }

    /// The sample of component `k` as one of the sum: the others are asked about the same
    /// directions.
    fn with_others(
        &self,
        k: usize,
        sample: BsdfSample,
        fixed: DVec3,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        if self.probabilities[k] == 1.0 {
            return Some(BsdfSample { weight: sample.weight * self.weights[k], ..sample });
        }
        let next = sample.next;
        let (to_light, to_camera) = mode.label(fixed, next);
        let of_sample = |own: BsdfSample| (own.weight * own.pdf.value(), own.pdf, own.pdf_reverse);
        // Value and both densities of each component.
        let terms: [_; N] = std::array::from_fn(|j| {
            let component = &self.components[j];
            if j == k {
                of_sample(sample)
            } else if sample.dirac {
                image_at(component, fixed, next, mode).map_or_else(Default::default, of_sample)
            } else {
                let pdf = component.pdf(fixed, next, mode);
                let pdf_reverse = component.pdf(next, fixed, mode.reversed());
                (component.eval(to_light, to_camera), pdf, pdf_reverse)
            }
        });
        let value: Rgb = terms.iter().zip(&self.weights).map(|(term, &w)| term.0 * w).sum();
        let pdf = self.mean(|j| terms[j].1);
        let pdf_reverse = self.mean(|j| terms[j].2);
        (pdf.value() > 0.0).then(|| BsdfSample {
            weight: value / pdf.value(),
            pdf,
            pdf_reverse,
            ..sample
        })
    }
}

impl<B: Bsdf, const N: usize> Bsdf for Mixture<B, N> {
    #[inline]
    fn lobes(&self) -> Lobes {
        let present = self
            .components
            .iter()
            .zip(&self.probabilities)
            .filter(|(_, probability)| **probability > 0.0);
        present.fold(Lobes::NONE, |lobes, (component, _)| lobes | component.lobes())
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.components
            .iter()
            .zip(&self.weights)
            .map(|(component, &weight)| component.eval(to_light, to_camera) * weight)
            .sum()
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        self.mean(|k| self.components[k].pdf(fixed, next, mode))
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let terms = self.components.each_ref().map(|b| b.eval_and_pdf(to_light, to_camera));
        let value = terms.iter().zip(&self.weights).map(|(term, &weight)| term.0 * weight).sum();
        (value, self.mean(|k| terms[k].1))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let (k, u1) = self.choose(u1)?;
        let sample = self.components[k].sample(fixed, mode, u1, u2)?;
        self.with_others(k, sample, fixed, mode)
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        for k in (0..N).filter(|&k| self.probabilities[k] > 0.0) {
            self.components[k].dirac_images(fixed, mode, &mut |own| {
                let is_listed = (0..k).any(|j| {
                    self.probabilities[j] > 0.0
                        && image_at(&self.components[j], fixed, own.next, mode).is_some()
                });
                if !is_listed {
                    self.with_others(k, own, fixed, mode).into_iter().for_each(&mut *image);
                }
            });
        }
    }
}

/// The image of a direction that is exactly `next`.
fn image_at<B: Bsdf>(
    bsdf: &B,
    fixed: DVec3,
    next: DVec3,
    mode: TransportMode,
) -> Option<BsdfSample> {
    let mut found = None;
    bsdf.dirac_images(fixed, mode, &mut |image| {
        if image.next == next {
            found = Some(image);
        }
    });
    found
}
