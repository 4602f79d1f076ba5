//! The answer to what a study asks: who wins, by how much, and how sure that is.

use super::method::MethodReport;
use super::report::Report;
use crate::integrator::Estimator;
use crate::report::stats::{CONFIDENCE, Interval, Price, Ranking};
use crate::report::text::{number, percent};

impl Report {
    /// The answers in a sentence each: which integrator wins, how far behind each other one is, and
    /// why the rest is not ranked. By time, or by rays in a report
    /// [without clocks](super::Study::without_clocks).
    #[must_use]
    pub fn answers(&self) -> Vec<String> {
        let mut answers = Vec::new();
        if let Some(ranking) = self.rankings.first() {
            answers.push(winner(ranking));
            answers.extend(ranking.others.iter().map(|other| {
                let (cost, best) = (ranking.price.cost(), &ranking.best);
                let doubt = match other.p_value < 1.0 - CONFIDENCE {
                    true => "",
                    false => ", a difference that these runs cannot tell from none",
                };
                let times = with_interval(&other.ratio, &format!("times the {cost} of {best}"));
                format!("{} takes {times}{doubt}.", other.name)
            }));
        } else {
            answers.push("No integrator is ranked.".to_owned());
        }
        answers.extend(self.methods.iter().filter_map(|m| self.apart(m)));
        answers
    }

    /// The sentence on an integrator that is not ranked.
    fn apart(&self, method: &MethodReport) -> Option<String> {
        let name = &method.name;
        let best = self.rankings.first().map(|ranking| (&ranking.best, &ranking.others));
        if best.is_some_and(|(best, others)| best == name || others.iter().any(|o| o.name == *name))
        {
            return None;
        }
        let reason = if !method.complete {
            "it cannot draw every path of this scene"
        } else if method.undecided.is_some() {
            "it has met too little to tell its error"
        } else if method.infinite_variance {
            "its variance is infinite, as far as its samples show"
        } else if method.estimator != Estimator::Unbiased {
            let Some((best, ratio)) =
                best.and_then(|(best, _)| Some((best, self.error(name, best)?)))
            else {
                return Some(format!("{name} is not ranked: it is not unbiased."));
            };
            let times = with_interval(&ratio, &format!("times that of {best}"));
            return Some(format!(
                "{name} is not unbiased; at the end of a run its relMSE is {times}."
            ));
        } else {
            "its variance could not be measured"
        };
        Some(format!("{name} is not ranked: {reason}."))
    }

    /// The ratio of the relMSEs of two integrators at the end of their runs, which had the same
    /// budget.
    fn error(&self, name: &str, over: &str) -> Option<Interval> {
        if self.setup.until_target {
            return None;
        }
        let runs = |name: &str| {
            let end = self.methods.iter().find(|m| m.name == name)?.last()?;
            Some(end.runs.iter().map(|errors| errors.relative_mse))
        };
        let pairs = runs(name)?.zip(runs(over)?);
        Interval::of_ratios(&pairs.map(|(a, b)| a / b).collect::<Vec<_>>())
    }
}

/// A factor of something, and its interval.
fn with_interval(Interval { value, low, high }: &Interval, of: &str) -> String {
    let [value, low, high] = [value, low, high].map(|x| number(*x));
    format!("{value} {of} ({low} … {high} with {} % confidence)", 100.0 * CONFIDENCE)
}

fn winner(ranking: &Ranking) -> String {
    let (best, cost) = (&ranking.best, ranking.price.cost());
    if ranking.others.is_empty() {
        return format!("{best} is the only integrator that can be ranked.");
    }
    let confidence = match ranking.confidence() {
        sure if sure >= 0.9995 => "above 99.9 %".to_owned(),
        sure => percent(sure),
    };
    if ranking.confidence() >= CONFIDENCE {
        format!("{best} wins: the same error takes it the least {cost} (confidence {confidence}).")
    } else {
        format!("No winner is certain: {best} takes the least {cost} (confidence {confidence}).")
    }
}

impl Price {
    fn cost(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Rays => "rays",
        }
    }
}
