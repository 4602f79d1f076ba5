//! A weighted sum of models: `f = Σ w_k f_k`, sampled by choosing one of them with its probability.
//! Weights may be coloured.

use super::{Bsdf, BsdfError, BsdfSample, DiracValue, Lobes, Walk};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// `N` models of one type with weights, for example a [`SimpleModel`](super::SimpleModel) of any
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

    /// The sum over the components of `own` for the sampled one and `other` for the rest, in index
    /// order so that it equals `pdf` to the bit.
    fn sum(
        &self,
        sampled: usize,
        own: PerProjected,
        other: impl Fn(&B) -> PerProjected,
    ) -> PerProjected {
        let terms = self.components.iter().zip(&self.probabilities).enumerate();
        let sum = terms.map(|(k, (component, probability))| {
            let term = if k == sampled { own } else { other(component) };
            term.value() * probability
        });
        PerProjected(sum.sum())
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
    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected {
        self.sum(N, PerProjected::ZERO, |component| component.pdf(fixed, next, walk))
    }

    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let (k, u1) = self.choose(u1)?;
        let sample = self.components[k].sample(fixed, walk, u1, u2)?;
        let next = sample.next;
        let (to_light, to_camera) = walk.label(fixed, next);
        // what the component has sampled is taken as it is; the others are asked about the same
        // directions
        let others =
            || self.components.iter().zip(&self.weights).enumerate().filter(|(j, _)| *j != k);
        let own_value = sample.weight * sample.pdf.value() * self.weights[k];
        let (value, pdf, pdf_reverse) = if sample.dirac {
            let dirac = |component: &B| component.eval_dirac(to_light, to_camera);
            let along = |value: DiracValue, walk: Walk| match walk {
                Walk::Camera => value.pdf_to_light,
                Walk::Light => value.pdf_to_camera,
            };
            (
                own_value
                    + others()
                        .map(|(_, (component, &weight))| dirac(component).value * weight)
                        .sum(),
                self.sum(k, sample.pdf, |component| along(dirac(component), walk)),
                self.sum(k, sample.pdf_reverse, |component| {
                    along(dirac(component), walk.reversed())
                }),
            )
        } else {
            (
                own_value
                    + others()
                        .map(|(_, (component, &weight))| {
                            component.eval(to_light, to_camera) * weight
                        })
                        .sum(),
                self.sum(k, sample.pdf, |component| component.pdf(fixed, next, walk)),
                self.sum(k, sample.pdf_reverse, |component| {
                    component.pdf(next, fixed, walk.reversed())
                }),
            )
        };
        (pdf.value() > 0.0).then(|| BsdfSample {
            weight: value / pdf.value(),
            pdf,
            pdf_reverse,
            ..sample
        })
    }

    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let components = self.components.iter().zip(&self.weights).zip(&self.probabilities);
        components.fold(DiracValue::default(), |sum, ((component, &weight), &probability)| {
            let term = component.eval_dirac(to_light, to_camera);
            DiracValue {
                value: sum.value + term.value * weight,
                pdf_to_light: PerProjected(
                    sum.pdf_to_light.value() + term.pdf_to_light.value() * probability,
                ),
                pdf_to_camera: PerProjected(
                    sum.pdf_to_camera.value() + term.pdf_to_camera.value() * probability,
                ),
            }
        })
    }
}
