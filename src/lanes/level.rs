//! The instruction set of lanes.

use fearless_simd::Level;
use std::sync::OnceLock;

/// The instruction set that everything in lanes uses: the best one that the processor has, or a
/// lesser one named by the environment variable `PATHSPACE_SIMD` (`sse2`, `avx2`, `avx512`).
/// Results are the same; it serves to measure what lanes gain.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let best = Level::new();
        let wanted = std::env::var("PATHSPACE_SIMD").unwrap_or_default();
        named(best, &wanted).unwrap_or(best)
    })
}

/// The instruction set of a name, if the processor has it.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn named(best: Level, name: &str) -> Option<Level> {
    match name {
        "sse2" => Some(Level::baseline()),
        "avx2" => best.as_avx2().map(Level::Avx2),
        "avx512" => best.as_avx512().map(Level::Avx512),
        _ => None,
    }
}

/// Other processors have one.
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn named(_: Level, _: &str) -> Option<Level> {
    None
}

/// An expression compiled for AVX-512, AVX2 and SSE2, of which the level's best is run: SSE4.2 has
/// little to add, and each instruction set takes as long to compile as all the rest.
#[cfg(target_arch = "x86_64")]
macro_rules! dispatch {
    ($level:expr, $simd:ident => $op:expr) => {
        match $level {
            fearless_simd::Level::Avx512(set) => crate::lanes::vectorized!(set, $simd => $op),
            fearless_simd::Level::Avx2(set) => crate::lanes::vectorized!(set, $simd => $op),
            level => match level.as_sse2() {
                Some(set) => crate::lanes::vectorized!(set, $simd => $op),
                None => unreachable!("x86-64 has SSE2"),
            },
        }
    };
}

/// The same on other processors, for all that the library has.
#[cfg(not(target_arch = "x86_64"))]
macro_rules! dispatch {
    ($level:expr, $simd:ident => $op:expr) => {
        fearless_simd::dispatch!($level, $simd => $op)
    };
}

/// An expression compiled for an instruction set.
#[cfg(target_arch = "x86_64")]
macro_rules! vectorized {
    ($set:ident, $simd:ident => $op:expr) => {
        fearless_simd::Simd::vectorize(
            $set,
            #[inline(always)]
            || {
                let $simd = $set;
                $op
            },
        )
    };
}

pub(crate) use dispatch;
#[cfg(target_arch = "x86_64")]
pub(crate) use vectorized;
