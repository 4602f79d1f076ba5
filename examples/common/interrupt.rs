//! Ends that are asked for from outside.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of a program that was asked to end early.
pub const INTERRUPTED: u8 = 130;

/// A flag that the first interrupt (Ctrl-C) or termination of the process sets, so that it can write
/// what it has; the second one ends it at once.
pub fn interrupt_flag() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    let handler = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        eprintln!("\nending; what is done will be written (Ctrl-C again to quit at once)");
    });
    if let Err(error) = handler {
        eprintln!("Ctrl-C will not end cleanly: {error}");
    }
    interrupted
}
