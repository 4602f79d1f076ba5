//! Builds the page into a folder that any web server can publish, and serves it on this machine if
//! asked to.

#[cfg(target_family = "wasm")]
fn main() {}

#[cfg(not(target_family = "wasm"))]
mod build;
#[cfg(not(target_family = "wasm"))]
mod serve;

#[cfg(not(target_family = "wasm"))]
fn main() -> std::process::ExitCode {
    use clap::Parser;
    let options = Options::parse();
    match run(&options) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}

/// Builds the lecture room: a page on which integrators render side by side in a browser.
#[cfg(not(target_family = "wasm"))]
#[derive(clap::Parser)]
struct Options {
    /// The folder that is published
    #[arg(long, default_value = "target/web")]
    out: std::path::PathBuf,
    /// Serve the folder on this machine, at this port of 127.0.0.1 if one is given, until
    /// interrupted
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "8080")]
    serve: Option<u16>,
}

#[cfg(not(target_family = "wasm"))]
fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    build::build(&options.out)?;
    match options.serve {
        Some(port) => serve::serve(&options.out, port),
        None => {
            println!("for any web server, such as --serve: {}", options.out.display());
            Ok(())
        }
    }
}
