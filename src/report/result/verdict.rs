//! Verdicts: findings and limits of the numbers, in sentences.

use super::method::MethodReport;
use super::report::Report;
use crate::integrator::Estimator;
use crate::report::stats::{Interval, Pair, REFERENCE_SHARE, ratio};

impl Report {
    /// True if no test found a disagreement, a bias or a contribution that is not finite.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.pairs.iter().all(Pair::agrees)
            && self.methods.iter().all(|m| !m.bias.flagged && m.non_finite_contributions == 0)
    }

    /// The findings of the tests, and the limits of the numbers; a sentence or two each.
    #[must_use]
    pub fn verdicts(&self) -> Vec<String> {
        let mut verdicts = Vec::new();
        if self.stopped {
            verdicts.push(
                "Stopped before its end: what follows is from the runs that were finished."
                    .to_owned(),
            );
        }
        if self.setup.debug_build {
            verdicts.push("Built without optimisation: times mean nothing.".to_owned());
        }
        verdicts.push(self.agreement());
        for method in &self.methods {
            verdicts.extend(self.of_method(method));
        }
        let (own, target) = (self.reference.own_relative_mse, self.setup.target);
        if self.setup.until_target && own > REFERENCE_SHARE * target {
            verdicts.push(format!(
                "The reference's own relMSE of {own:.2e} is more than {} % of the target \
                 {target}: when the target is reached is known no better than that.",
                100.0 * REFERENCE_SHARE
            ));
        }
        verdicts.extend(
            self.left_out
                .iter()
                .map(|m| format!("{} has no technique for this scene and is left out.", m.name)),
        );
        verdicts
    }

    fn agreement(&self) -> String {
        let disagreeing: Vec<String> = self
            .pairs
            .iter()
            .filter(|p| !p.agrees())
            .map(|p| format!("{} and {}", p.names[0], p.names[1]))
            .collect();
        match self.pairs.len() {
            0 => {
                "Fewer than two unbiased integrators see every path of this scene: agreement is not \
                 tested."
                    .to_owned()
            }
            n if disagreeing.is_empty() => {
                let noisy: Vec<&str> = self
                    .methods
                    .iter()
                    .filter(|m| m.is_tested() && m.long_tails)
                    .map(|m| m.name.as_str())
                    .collect();
                let caveat = if noisy.is_empty() {
                    String::new()
                } else {
                    format!(", as far as the noise of {} shows", noisy.join(", "))
                };
                format!("The integrators agree{caveat} ({n} pairs tested).")
            }
            _ => format!("INTEGRATORS DISAGREE: {}.", disagreeing.join("; ")),
        }
    }

    fn of_method(&self, method: &MethodReport) -> Vec<String> {
        let name = &method.name;
        let mut verdicts = Vec::new();
        if method.bias.flagged {
            let (b, e) =
                (100.0 * method.bias.relative, 100.0 * method.bias.relative_standard_error);
            verdicts.push(format!("BIAS: {name} is off by {b:+.3} % ± {e:.3} %."));
        }
        verdicts.extend(self.stated_bias(method));
        if method.non_finite_contributions + method.non_finite_pixels > 0 {
            let first = method
                .first_non_finite
                .as_ref()
                .map_or_else(String::new, |f| format!(", the first at {f}"));
            let n = method.non_finite_contributions;
            verdicts.push(format!(
                "NOT FINITE: {n} contributions of {name}{first}; {} pixels.",
                method.non_finite_pixels
            ));
        }
        if method.infinite_variance {
            verdicts.push(format!(
                "Heavy tail: the variance of {name} is infinite as far as its samples \
                 show. Its MSE and variance do not settle; read SMAPE, MedSE and median of means."
            ));
        }
        if !method.complete {
            verdicts.push(format!(
                "{name} cannot draw every path of this scene; it is shown, but not tested."
            ));
        } else if self.setup.until_target {
            let errors = method.last().map_or(&[][..], |end| &end.runs);
            let reached = errors.iter().filter(|e| e.relative_mse <= self.setup.target).count();
            if reached < errors.len() {
                verdicts.push(format!(
                    "Target: relMSE {} is reached by {reached} of {} runs of {name}, \
                     with {} samples per pixel.",
                    self.setup.target, method.runs, method.samples_per_pixel
                ));
            }
        }
        verdicts
    }

    /// The bias of an integrator that sees everything and does not claim to have none.
    fn stated_bias(&self, method: &MethodReport) -> Option<String> {
        let [kind, prospect] = match method.estimator {
            Estimator::Unbiased => return None,
            Estimator::Consistent => ["consistent", "It vanishes as passes are added"],
            Estimator::Biased => ["biased", "It stays, however many passes are added"],
        };
        let end = method.last().filter(|_| method.complete)?;
        let percent = |x: f64| 100.0 * ratio(x, self.reference.mean);
        let Interval { value, low, high } = method.bias.mean_interval;
        let interval = |i: &Interval| format!("{:.2e} ({:.1e} … {:.1e})", i.value, i.low, i.high);
        let own = self.reference.own_mse;
        let limit = if end.reference_limited {
            format!(", less the reference's own variance of {own:.2e},")
        } else {
            String::new()
        };
        let fall = method.fall_of_bias().map_or_else(String::new, |f| format!(": here as {f}"));
        Some(format!(
            "{} is {kind}: with {} samples per pixel the bias of its mean is {:+.3} % ({:+.3} … \
             {:+.3}), the squared bias of its pixels{limit} {} beside a variance of {}. \
             {prospect}{fall}.",
            method.name,
            end.samples,
            percent(value),
            percent(low),
            percent(high),
            interval(&end.squared_bias),
            interval(&end.variance),
        ))
    }
}
