//! Verdicts: findings and limits of the numbers, in sentences.

use super::method::MethodReport;
use super::missing::MissingReport;
use super::report::Report;
use crate::integrator::Estimator;
use crate::path::DrawnBy;
use crate::report::stats::{Interval, Outcome, REFERENCE_SHARE, ratio};
use crate::report::text::{number, percent, percent_with_error, signed, with_error};

impl Report {
    /// True if no test found a disagreement, a bias or a contribution that is not finite. What is
    /// undecided is no finding: see [`is_decided`](Self::is_decided).
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.pairs.iter().all(|pair| pair.outcome() != Outcome::Disagree)
            && self.methods.iter().all(|m| !m.bias.flagged && m.non_finite_contributions == 0)
    }

    /// True if the reference and every integrator that draws every path have met enough to be
    /// tested.
    #[must_use]
    pub fn is_decided(&self) -> bool {
        self.reference.undecided.is_none()
            && self.methods.iter().all(|m| !m.complete || m.undecided.is_none())
    }

    /// The findings of the tests, and the limits of the numbers; a sentence or two each.
    #[must_use]
    pub fn verdicts(&self) -> Vec<String> {
        let mut verdicts = Vec::new();
        if self.stopped {
            verdicts
                .push("Incomplete: what follows is from the runs that were finished.".to_owned());
        }
        if self.setup.debug_build {
            verdicts.push("Built without optimisation: times mean nothing.".to_owned());
        }
        verdicts.push(self.agreement());
        if let Some(reason) = &self.reference.undecided {
            verdicts.push(format!(
                "UNDECIDED: the reference {reason}. So no bias is tested against it."
            ));
        }
        for method in &self.methods {
            verdicts.extend(self.of_method(method));
        }
        verdicts.extend(self.in_no_image());
        let (own, target) = (self.reference.own_relative_mse, self.setup.target);
        if self.setup.until_target && own > REFERENCE_SHARE * target {
            verdicts.push(format!(
                "The reference's own relMSE of {} is more than {} % of the target {target}: when \
                 the target is reached is known no better than that.",
                number(own),
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
        let of = |outcome: Outcome| self.pairs.iter().filter(move |p| p.outcome() == outcome);
        let disagreeing: Vec<String> =
            of(Outcome::Disagree).map(|p| format!("{} and {}", p.names[0], p.names[1])).collect();
        if !disagreeing.is_empty() {
            return format!("INTEGRATORS DISAGREE: {}.", disagreeing.join("; "));
        }
        if self.pairs.is_empty() {
            return "Fewer than two unbiased integrators see every path of this scene: agreement is \
                    not tested."
                .to_owned();
        }
        let named = |is: &dyn Fn(&MethodReport) -> bool| {
            let names = self.methods.iter().filter(|m| m.is_tested() && is(m));
            names.map(|m| m.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let undecided = named(&|m| m.undecided.is_some());
        let decided = of(Outcome::Agree).count();
        if decided == 0 {
            return format!("Whether the integrators agree is undecided, because of {undecided}.");
        }
        let noisy = named(&|m| m.long_tails && m.undecided.is_none());
        let mut sentence = "The integrators agree".to_owned();
        if !noisy.is_empty() {
            sentence += &format!(", as far as the noise of {noisy} shows");
        }
        if !undecided.is_empty() {
            let verb = if undecided.contains(", ") { "are" } else { "is" };
            sentence += &format!(", but for {undecided}, which {verb} undecided");
        }
        let dark = of(Outcome::Agree).map(|p| p.undecided_light).fold(0.0, f64::max);
        let dark = match dark {
            0.0 => String::new(),
            share => {
                format!("; blocks with up to {} of the light are undecided", percent(share))
            }
        };
        let pairs = if decided == 1 { "pair" } else { "pairs" };
        sentence + &format!(" ({decided} {pairs} tested{dark}).")
    }

    /// The paths that no integrator draws.
    fn in_no_image(&self) -> Option<String> {
        let missing = self.methods.iter().flat_map(|m| &m.missing);
        let mut all: Vec<&str> = Vec::new();
        for paths in missing.filter(|paths| paths.drawn_by == DrawnBy::Nothing) {
            if !all.contains(&paths.what.as_str()) {
                all.push(&paths.what);
            }
        }
        (!all.is_empty()).then(|| format!("In no image: {}.", all.join("; ")))
    }

    fn of_method(&self, method: &MethodReport) -> Vec<String> {
        let name = &method.name;
        let mut verdicts = Vec::new();
        if method.bias.flagged {
            let (bias, error) = (method.bias.relative, method.bias.relative_standard_error);
            verdicts.push(if self.reference.mean == 0.0 {
                format!(
                    "BIAS: {name} has a mean of {}, and the reference is black.",
                    with_error(method.mean, method.mean_standard_error)
                )
            } else {
                format!("BIAS: {name} is off by {}.", percent_with_error(bias, error))
            });
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
        let runs = format!("{} runs of {} per pixel", method.runs, method.samples_per_pixel);
        let undecided = method.undecided.as_ref().map(|reason| format!("{reason} ({runs})"));
        let missing = MissingReport::sentence(&method.missing);
        if !method.complete {
            let what = match missing {
                Some(missing) => format!(": {missing}"),
                None => " every path of this scene".to_owned(),
            };
            let met = undecided.as_ref().map_or_else(String::new, |u| format!(" It {u}."));
            verdicts
                .push(format!("{name} is shown, but not tested, since it cannot draw{what}.{met}"));
            return verdicts;
        }
        if let Some(missing) = missing {
            verdicts.push(format!("Not in the image of {name}: {missing}."));
        }
        if let Some(undecided) = undecided {
            verdicts.push(format!(
                "UNDECIDED: {name} {undecided}: no evidence, neither for agreement nor against it. \
                 Its light may be hard to meet, or it may be wrong: more samples tell."
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
        let is_known = method.complete && method.undecided.is_none();
        let end = method.last().filter(|_| is_known && self.reference.undecided.is_none())?;
        let percent = |x: f64| format!("{} %", signed(100.0 * ratio(x, self.reference.mean)));
        let Interval { value, low, high } = method.bias.mean_interval;
        let limit = if end.reference_limited {
            let own = number(self.reference.own_mse);
            format!(", less the reference's own variance of {own},")
        } else {
            String::new()
        };
        let fall = method.fall_of_bias().map_or_else(String::new, |f| format!(": here as {f}"));
        let drawn = |what: &&String| method.missing.iter().all(|paths| paths.what != **what);
        let more: Vec<&str> =
            self.reference.missing.iter().filter(drawn).map(String::as_str).collect();
        let more = match more.is_empty() {
            true => String::new(),
            false => format!(" Counted as bias is what the reference misses: {}.", more.join("; ")),
        };
        Some(format!(
            "{} is {kind}: with {} samples per pixel the bias of its mean is {} ({} … {}), the \
             squared bias of its pixels{limit} {} beside a variance of {}. {prospect}{fall}.{more}",
            method.name,
            end.samples,
            percent(value),
            percent(low),
            percent(high),
            end.squared_bias,
            end.variance,
        ))
    }
}
