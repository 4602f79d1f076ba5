//! Progress on the terminal.

use indicatif::{ProgressBar, ProgressStyle};
use pathspace::render::Progress;
use std::ops::ControlFlow;

/// Positions of the bar.
pub const STEPS: u64 = 1000;

/// A bar with a label in front and the time left behind; hidden when standard error is no terminal.
pub fn progress_bar(label: &str) -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    let template = "{prefix:16} {bar:32} {percent:>3} %  {msg}  {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.with_prefix(label.to_owned())
}

/// Shows the state of a rendering on the bar; the callback of a rendering that runs to its end.
pub fn show(bar: &ProgressBar, progress: &Progress<'_>) -> ControlFlow<()> {
    bar.set_position((progress.fraction * STEPS as f64) as u64);
    bar.set_message(format!("{} samples per pixel", progress.passes));
    ControlFlow::Continue(())
}
