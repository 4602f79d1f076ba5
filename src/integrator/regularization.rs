//! Regularisation: an integrator in the scene whose Dirac lobes are
//! [mollified](crate::scene::Regularized), by a radius that shrinks from pass to pass (Kaplanyan and
//! Dachsbacher 2013).
//!
//! ```text
//! ε_i² = ε_1² i^(α-1),    i = 1, 2, …        bias ∝ ε²,    variance ∝ 1/ε²
//! ```
//!
//! Unlike its samples alone, an integrator then sees a Dirac light through a mirror or water on both
//! of its sides, which no technique could draw. With α = 2/3 the error of the mean of J passes falls
//! the fastest: its square as `J^(-2/3)`. What is seen in a mirror directly is blurred, too.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::any_run::StartOnWorld;
use super::viewed;
use super::{Crew, Estimator, Integrator, IntegratorError, Notes, Run, Stage, Started};
use crate::film::{Sample, Sink};
use crate::path::{Counters, Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::{Needs, Regularized, Scene, checked_radius};

/// An integrator in the regularised scene; in one without Dirac lobes the integrator itself, to the
/// bit. The integrator's samples must share nothing: photon maps are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regularization<I> {
    /// The integrator.
    pub integrator: I,
    /// ε_1, the mollifiers' radius in the first pass, in radians near the normal, at most 1. By
    /// default 0.1, where noise and blur of the gallery's `pool` balance at some 10⁴ passes.
    pub epsilon: f64,
    /// α, in (0, 1]. With 1 the radius is fixed, and so is the bias.
    pub alpha: f64,
}

impl<I> Regularization<I> {
    /// An integrator in the regularised scene, with the radii of the default.
    pub const fn new(integrator: I) -> Self {
        Self { integrator, epsilon: 0.1, alpha: 2.0 / 3.0 }
    }

    /// An integrator in the scene of one radius.
    pub const fn fixed(integrator: I, epsilon: f64) -> Self {
        Self { integrator, epsilon, alpha: 1.0 }
    }

    // ANCHOR: radius
    /// ε of a pass; passes are numbered from 0.
    fn radius(&self, pass: u32) -> f64 {
        self.epsilon * libm::pow(f64::from(pass) + 1.0, 0.5 * (self.alpha - 1.0))
    }
    // ANCHOR_END: radius
}

impl<I: Default> Default for Regularization<I> {
    fn default() -> Self {
        Self::new(I::default())
    }
}

/// A rendering of an integrator in regularised scenes.
pub struct RegularizedPasses<'a, S: Scene + ?Sized + 'a, I: Integrator<S> + 'a> {
    settings: &'a Regularization<I>,
    /// With the needs of the regularised scene.
    stage: Stage<'a, S>,
    kind: Kind<I::Run<'a>>,
}

enum Kind<R> {
    /// There is nothing to regularise.
    Unchanged(R),
    /// Techniques and notes of the integrator in the regularised scene, and ε of the pass.
    Regularized { techniques: TechniqueSet, notes: Box<Notes>, radius: f64 },
}

impl<S, I> Integrator<S> for Regularization<I>
where
    S: Scene + ?Sized,
    I: Integrator<S> + for<'v> Integrator<Regularized<'v, S>>,
{
    type Run<'a>
        = RegularizedPasses<'a, S, I>
    where
        Self: 'a,
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = <I as Integrator<S>>::REGULARIZED_ON_WORLD;

    fn name(&self) -> &'static str {
        "regularized"
    }

    fn chooses_lights(&self) -> bool {
        Integrator::<S>::chooses_lights(&self.integrator)
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Self::Run<'a>> {
        let refused = |reason: String| {
            Err(IntegratorError { integrator: Integrator::<S>::name(self), reason })
        };
        if let Err(error) = checked_radius(self.epsilon) {
            return refused(error.to_string());
        }
        if !(self.alpha > 0.0 && self.alpha <= 1.0) {
            return refused(format!("alpha must be in (0, 1], but is {}", self.alpha));
        }
        let has_dirac_lobes = stage.needs.contains(Needs::DIRAC_LOBES);
        let (settings, stage) = (self, Stage { needs: stage.needs.regularized(), ..stage });
        let kind = if has_dirac_lobes {
            let radius = self.radius(0);
            let scene = Regularized::of_valid(stage.scene, radius);
            let view = stage.viewed(&scene, stage.needs);
            let (techniques, mut notes) = viewed::look(&self.integrator, view, crew)?;
            let shrinks = self.alpha < 1.0;
            notes.estimator = if shrinks { Estimator::Consistent } else { Estimator::Biased };
            Kind::Regularized { techniques, notes: Box::new(notes), radius }
        } else {
            Kind::Unchanged(self.integrator.start(stage, crew)?)
        };
        Ok(RegularizedPasses { settings, stage, kind })
    }
}

impl<'a, S, I> Run<'a, S> for RegularizedPasses<'a, S, I>
where
    S: Scene + ?Sized + 'a,
    I: Integrator<S> + for<'v> Integrator<Regularized<'v, S>> + 'a,
{
    type Chunk = <<I as Integrator<S>>::Run<'a> as Run<'a, S>>::Chunk;

    fn techniques(&self) -> TechniqueSet {
        match &self.kind {
            Kind::Unchanged(run) => run.techniques(),
            Kind::Regularized { techniques, .. } => *techniques,
        }
    }

    fn notes(&self) -> Notes {
        match &self.kind {
            Kind::Unchanged(run) => run.notes(),
            Kind::Regularized { notes, .. } => (**notes).clone(),
        }
    }

    fn prepares(&self) -> bool {
        match &self.kind {
            Kind::Unchanged(run) => run.prepares(),
            Kind::Regularized { .. } => true,
        }
    }

    fn learns(&self) -> bool {
        matches!(&self.kind, Kind::Unchanged(run) if run.learns())
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        match &mut self.kind {
            Kind::Unchanged(run) => run.begin_pass(pass, crew),
            Kind::Regularized { radius, .. } => {
                *radius = self.settings.radius(pass);
                Ok(())
            }
        }
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: &mut Self::Chunk,
        scratch: &mut Scratch<'a, S>,
    ) {
        match &self.kind {
            Kind::Unchanged(run) => run.draw(samples, sink, chunk, scratch),
            Kind::Regularized { radius, .. } => {
                let scene = Regularized::of_valid(self.stage.scene, *radius);
                let view = self.stage.viewed(&scene, self.stage.needs);
                let integrator = &self.settings.integrator;
                viewed::draw(integrator, view, samples, sink, &mut scratch.counters);
            }
        }
    }

    fn collect(&mut self, chunk: &mut Self::Chunk) {
        if let Kind::Unchanged(run) = &mut self.kind {
            run.collect(chunk);
        }
    }

    fn take_preparation(&mut self) -> Counters {
        match &mut self.kind {
            Kind::Unchanged(run) => run.take_preparation(),
            Kind::Regularized { .. } => Counters::default(),
        }
    }
}
