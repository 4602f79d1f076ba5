//! The watch on a run: checkpoints at powers of two and at the end, batches, images.
//! Looking does not count as time.

use crate::film::Image;
use crate::render::Progress;
use crate::report::result::SNAPSHOTS;
use crate::report::stats::{Batch, Cost, Layout};
use std::time::Duration;

/// Batches that each run is cut into for the test of bias, where its passes are independent and
/// alike.
const BATCHES_PER_RUN: u32 = 4;

pub(super) struct Watch {
    /// Samples per pixel of the whole run, and the batches that they are cut into.
    samples: u32,
    cuts: u32,
    takes_snapshots: bool,
    /// Samples per pixel, cost and image at each checkpoint.
    pub checkpoints: Vec<(u32, Cost, Image)>,
    pub batches: Vec<Batch>,
    pub snapshots: Vec<Shot>,
    /// Samples per pixel, and sums over them of each block, up to the last cut.
    cut: (u32, Vec<f64>),
    /// Processor seconds, and the processor time when the clock was started, if the system tells.
    cpu: f64,
    started: Option<Duration>,
}

/// An image on the way, after a part of the budget.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shot {
    pub part: f64,
    /// Samples per pixel.
    pub samples: u32,
    /// Wall-clock seconds.
    pub wall: f64,
    pub image: Image,
}

/// The processor time of this process so far; WebAssembly does not tell.
#[cfg(not(target_family = "wasm"))]
fn processor_time() -> Option<Duration> {
    cpu_time::ProcessTime::try_now().ok().map(|time| time.as_duration())
}

#[cfg(target_family = "wasm")]
fn processor_time() -> Option<Duration> {
    None
}

impl Watch {
    pub fn new(layout: Layout, samples: u32, has_batches: bool, takes_snapshots: bool) -> Self {
        Self {
            samples,
            cuts: if has_batches { BATCHES_PER_RUN.min(samples) } else { 1 },
            takes_snapshots,
            checkpoints: Vec::new(),
            batches: Vec::new(),
            snapshots: Vec::new(),
            cut: (0, vec![0.0; layout.blocks()]),
            cpu: 0.0,
            started: processor_time(),
        }
    }

    pub fn start_clock(&mut self) {
        self.started = processor_time();
    }

    pub fn stop_clock(&mut self) {
        if let Some((now, before)) = processor_time().zip(self.started) {
            self.cpu += now.saturating_sub(before).as_secs_f64();
        }
    }

    pub fn look(&mut self, p: &Progress<'_>) {
        let next = u64::from(self.samples) * (self.batches.len() as u64 + 1);
        let is_cut = p.passes == (next / u64::from(self.cuts)) as u32;
        let is_checkpoint = p.passes.is_power_of_two() || p.passes == self.samples;
        // A long pass may go beyond several of them: then the image belongs to the last.
        let kept = self.snapshots.last().map_or(0.0, |shot| shot.part);
        let due = |part: &f64| self.takes_snapshots && *part > kept && p.fraction >= *part;
        let part = SNAPSHOTS.into_iter().rfind(due);
        if !(is_checkpoint || is_cut || part.is_some()) {
            return;
        }
        let (image, wall) = (p.image(), p.wall.as_secs_f64());
        if is_cut {
            self.end_batch(p.passes, &image);
        }
        if let Some(part) = part {
            let (samples, image) = (p.passes, image.clone());
            self.snapshots.push(Shot { part, samples, wall, image });
        }
        if is_checkpoint {
            let (rays, scattered) = (p.counters.rays() as f64, p.counters.scattered as f64);
            let cost = Cost { wall, cpu: self.cpu, rays, scattered };
            self.checkpoints.push((p.passes, cost, image));
        }
    }

    fn end_batch(&mut self, passes: u32, image: &Image) {
        let means = Layout::of(image).block_means(image);
        let sums: Vec<f64> = means.iter().map(|mean| mean * f64::from(passes)).collect();
        let (before, sums_before) = std::mem::replace(&mut self.cut, (passes, sums));
        let samples = f64::from(passes - before);
        let blocks = self.cut.1.iter().zip(&sums_before).map(|(a, b)| (a - b) / samples).collect();
        self.batches.push(Batch { samples, blocks });
    }
}
