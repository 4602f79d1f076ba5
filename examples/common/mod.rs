//! The shared parts of the command-line examples: reading arguments, finding a scene, choosing an
//! integrator, showing progress.

// Every example uses a part of it.
#![allow(dead_code, unused_imports)]

mod arguments;
#[macro_use]
mod command;
mod imported;
mod info;
mod integrators;
mod interrupt;
mod progress;
mod scenes;
#[cfg(test)]
mod tests;

pub use arguments::{
    FilterName, MANY, SamplerName, parse_count, parse_duration, parse_error, parse_exposure,
    parse_image_path, parse_radius, parse_size,
};
pub use command::{CARGO_COMMAND, End, WrongArgument, exit_code, options};
pub use integrators::{AnyIntegrator, Tuning};
pub use interrupt::{INTERRUPTED, interrupt_flag};
pub use progress::{STEPS, progress_bar, show};
pub use scenes::{AnyCamera, FileOptions, NamedScene, scene_info, scene_list, scene_or_file};
