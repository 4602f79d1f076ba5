//! Makes one image of the shards of a rendering: to the bit that of one process.
//!
//! ```text
//! cargo run --release --example merge -- --out target/box.exr target/cornell-box-*-of-8.npz
//! ```

#[macro_use]
mod common;

use clap::Parser;
use pathspace::film::{ImageFile, check_replaceable};
use pathspace::render::{Checkpoint, Merger};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Makes one image of the shards of a rendering, to the bit that of one process.
///
/// cargo run --release --example merge -- --out target/box.exr target/cornell-box-*-of-8.npz
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Files that `render --shard` wrote, in any order; each shard once
    #[arg(required = true, value_name = "SHARD.npz")]
    shards: Vec<PathBuf>,
    /// Image file to write, .exr, .hdr or .png
    #[arg(long, value_parser = common::parse_image_path)]
    out: PathBuf,
    /// Checkpoint of the whole rendering to write as well
    #[arg(long, value_name = "FILE.npz")]
    checkpoint: Option<PathBuf>,
    /// Leave out of files what a clock decides: the same rendering makes the same bytes
    #[arg(long)]
    no_clocks: bool,
}

fn main() -> ExitCode {
    match run(&common::options()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    for file in [Some(&arguments.out), arguments.checkpoint.as_ref()].into_iter().flatten() {
        check_replaceable(file).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    let mut merger = Merger::default();
    for path in &arguments.shards {
        merger.add(&path.display().to_string(), Checkpoint::load(path)?)?;
    }
    let whole = merger.finish()?;
    let mut file = whole.to_file();
    file.exposure =
        whole.metadata.get("exposure").and_then(|stops| stops.parse().ok()).unwrap_or_default();
    if arguments.no_clocks {
        file.metadata.remove(ImageFile::CLOCK);
    }
    file.save(&arguments.out)?;
    say!("shards      {}", arguments.shards.len());
    say!("samples     {} per pixel", whole.passes().len());
    if !whole.wall().is_zero() {
        let seconds = whole.wall().as_secs_f64();
        say!("time        {seconds:.3} s on the wall, one shard after the other");
    }
    say!("image       {}", arguments.out.display());
    if let Some(path) = &arguments.checkpoint {
        let whole = if arguments.no_clocks { whole.without_clocks() } else { whole };
        whole.save(path)?;
        say!("checkpoint  {}", path.display());
    }
    Ok(())
}
