//! The command line as a whole, and how programs end.

use clap::{Command, Parser};
use std::error::Error;
use std::process::ExitCode;

use super::interrupt::INTERRUPTED;

/// Prints a line. Whoever has stopped reading, such as `head`, misses it, and the work goes on.
#[cfg(not(test))]
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}
/// Prints a line where tests show what they print if they fail.
#[cfg(test)]
macro_rules! say {
    ($($text:tt)*) => { println!($($text)*) };
}

const EXIT_STATUS: &str = "Exit status: 0 if all is done, 1 if it failed, 2 for wrong arguments, \
    3 if it is done and what was measured is wrong, 130 if it was interrupted (what it had is \
    written).";

/// The options of the command line. Ends the program if they are wrong or ask for help.
pub fn options<T: Parser>() -> T {
    T::from_arg_matches(&complete(T::command()).get_matches()).unwrap_or_else(|error| error.exit())
}

/// The command with what all examples have in common: the help on exit codes, and negative numbers
/// as values, so that an error is about the number.
pub fn complete(command: Command) -> Command {
    let help = match command.get_after_help() {
        Some(own) => format!("{EXIT_STATUS}\n\n{own}"),
        None => EXIT_STATUS.to_owned(),
    };
    command.after_help(help).mut_args(|argument| {
        let takes_values = argument.get_action().takes_values();
        if takes_values { argument.allow_negative_numbers(true) } else { argument }
    })
}

/// The end of a program that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All is done.
    Done,
    /// All is done, and something that was measured is wrong.
    Wrong,
    /// Done is what could be until the program was asked to end.
    Interrupted,
}

/// Prints the error, if there is one, and returns the exit code.
pub fn exit_code(end: Result<End, Box<dyn Error>>) -> ExitCode {
    match end {
        Ok(End::Done) => ExitCode::SUCCESS,
        // Told apart from errors, so that scripts can use the verdict.
        Ok(End::Wrong) => ExitCode::from(3),
        Ok(End::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if error.is::<WrongArgument>() { 2 } else { 1 })
        }
    }
}

/// An argument that turned out to be wrong after all had been read.
#[derive(Debug)]
pub struct WrongArgument(pub String);

impl std::fmt::Display for WrongArgument {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for WrongArgument {}

/// The command that runs this example, up to its arguments.
pub const CARGO_COMMAND: &str = concat!("cargo run --release --example ", env!("CARGO_CRATE_NAME"));
