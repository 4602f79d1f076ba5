//! Reports without clocks, which two runs of one seed have the same to the bit.

use super::study::Study;
use crate::report::stats::{Interval, Price};

impl Study {
    /// The study without anything that a clock told, and without the machine: times are NaN,
    /// rankings are by rays alone, and what is measured in seconds is left out of the page. With a
    /// budget in samples two runs of one seed give the same study then, and the same files to the
    /// byte.
    #[must_use]
    pub fn without_clocks(mut self) -> Self {
        const UNKNOWN: Interval = Interval { value: f64::NAN, low: f64::NAN, high: f64::NAN };
        let report = &mut self.report;
        report.setup.machine = None;
        report.rankings.retain(|ranking| ranking.price != Price::Time);
        for method in &mut report.methods {
            method.total = method.total.without_clocks();
            method.cpu_per_sample = f64::NAN;
            for point in &mut method.checkpoints {
                let costs = point.costs.iter_mut().chain([&mut point.cost]);
                costs.for_each(|cost| *cost = cost.without_clocks());
            }
            method.variance_times_wall = UNKNOWN;
            method.variance_times_cpu = UNKNOWN;
            if let Some(speed_up) = &mut method.speed_up {
                (speed_up.wall, speed_up.cpu) = (UNKNOWN, UNKNOWN);
            }
            method.time_to_target = None;
        }
        let snapshots = self.images.iter_mut().flat_map(|images| &mut images.snapshots);
        snapshots.for_each(|shot| shot.wall = f64::NAN);
        self
    }
}

impl super::Report {
    /// True if the report has times and the machine that they were measured on.
    #[must_use]
    pub fn has_clocks(&self) -> bool {
        self.setup.machine.is_some()
    }
}
