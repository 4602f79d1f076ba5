//! The command line: what is accepted, and what errors say.

use super::command::complete;
use super::{
    AnyIntegrator, End, FileOptions, MANY, Tuning, WrongArgument, exit_code, parse_count,
    parse_exposure, scene_or_file,
};
use clap::{CommandFactory, Parser};
use std::process::ExitCode;

/// Does something.
///
/// cargo run --release --example something
#[derive(Parser, Debug)]
#[command(name = "something", after_help = "The end.")]
struct Options {
    #[command(flatten)]
    file: FileOptions,
    #[command(flatten)]
    tuning: Tuning,
    #[arg(long, default_value = "pt")]
    integrator: AnyIntegrator,
    #[arg(long, default_value_t = 1, value_parser = parse_count::<u32, 1, MANY>)]
    samples: u32,
    #[arg(long, default_value_t = 1, value_parser = parse_count::<u16, 1, 1024>)]
    threads: u16,
    #[arg(long, default_value = "0", value_parser = parse_exposure)]
    exposure: f64,
}

fn parse(arguments: &str) -> Result<Options, clap::Error> {
    let words = std::iter::once("something").chain(arguments.split_whitespace());
    let matches = complete(Options::command()).try_get_matches_from(words)?;
    clap::FromArgMatches::from_arg_matches(&matches)
}

fn refusal(arguments: &str) -> String {
    let error = parse(arguments).expect_err(arguments);
    assert_eq!(error.exit_code(), 2, "{arguments}");
    error.to_string()
}

#[test]
fn counts_may_be_powers_of_ten() {
    for (text, count) in [("1e6", 1_000_000), ("64", 64), ("2.5e1", 25), ("4294967295", u32::MAX)] {
        assert_eq!(parse(&format!("--samples {text}")).expect(text).samples, count);
    }
    for text in ["0", "1.5", "1e10", "-3", "-1e3", "nan", "inf", "many", "4294967296"] {
        let refusal = refusal(&format!("--samples {text}"));
        assert!(refusal.contains("is not a whole number of at least 1"), "{refusal}");
    }
    assert!(refusal("--threads 1025").contains("is not a whole number from 1 to 1024"));
}

#[test]
fn negative_numbers_are_values() {
    assert_eq!(parse("--exposure -1.5").expect("a number of stops").exposure, -1.5);
    assert!(refusal("--radius -1").contains("a radius is 0 or a positive number"));
}

#[test]
fn integrators_have_short_names() {
    use AnyIntegrator::*;
    for (name, integrator) in [
        ("pt", PathTracing),
        ("lt", LightTracing),
        ("bdpt", Bidirectional),
        ("pm", PhotonMapping),
        ("vcm", Vcm),
        ("ir", InstantRadiosity),
        ("pssmlt", Metropolis),
        ("mmlt", Multiplexed),
    ] {
        let long = integrator.name();
        for name in [name, long] {
            let parsed = parse(&format!("--integrator {name}")).expect(name).integrator;
            assert_eq!(parsed, integrator, "{name}");
        }
    }
}

#[test]
fn integrators_are_called_by_their_names() {
    for integrator in AnyIntegrator::ALL {
        let name = integrator.name();
        assert_eq!(parse(&format!("--integrator {name}")).expect(name).integrator, integrator);
    }
}

#[test]
fn probabilities_are_above_zero() {
    for option in ["large-step", "bsdf-fraction", "epsilon"] {
        assert!(parse(&format!("--{option} 1")).is_ok());
        for text in ["0", "1.01", "-0.1", "nan", "half"] {
            let refusal = refusal(&format!("--{option} {text}"));
            assert!(refusal.contains("is in (0, 1]"), "{refusal}");
        }
    }
}

#[test]
fn help_opens_with_the_example() {
    let help = complete(Options::command()).render_long_help().to_string();
    assert!(help.starts_with("Does something.\n\ncargo run --release"), "{help}");
    assert!(help.contains("Exit status: 0 ") && help.ends_with("The end.\n"), "{help}");
}

#[test]
fn options_of_files_are_refused_for_the_gallery() {
    for option in ["-D spp=16", "--view left", "--environment white", "--back-faces"] {
        let file = parse(option).expect(option).file;
        let error = scene_or_file("cornell-box", None, &file).expect_err(option);
        let name = option.split_whitespace().next().unwrap_or_default();
        assert_eq!(
            error.to_string(),
            format!("{name} is for scenes from files, which cornell-box is not")
        );
        assert_eq!(exit_code(Err(error)), ExitCode::from(2));
    }
}

/// Whatever is wrong with a file, the error names it.
#[test]
fn errors_name_the_file() {
    for name in ["none.obj", "none.gltf", "none.xml", "none.pbrt", "none.pbrt.gz", "none"] {
        let error = scene_or_file(name, None, &FileOptions::default()).expect_err(name);
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn exit_codes_tell_ends_apart() {
    assert_eq!(exit_code(Ok(End::Done)), ExitCode::SUCCESS);
    assert_eq!(exit_code(Ok(End::Wrong)), ExitCode::from(3));
    assert_eq!(exit_code(Ok(End::Interrupted)), ExitCode::from(130));
    assert_eq!(exit_code(Err("a failure".into())), ExitCode::from(1));
    assert_eq!(exit_code(Err(WrongArgument("an argument".to_owned()).into())), ExitCode::from(2));
}
