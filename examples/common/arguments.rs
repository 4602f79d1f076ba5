//! Values of command-line arguments.

use clap::ValueEnum;
use pathspace::film::Filter;
use pathspace::glam::UVec2;
use pathspace::import::Environment;
use pathspace::math::Rgb;
use pathspace::sampler::SamplerKind;
use std::path::PathBuf;
use std::time::Duration;

/// More pixels than this are taken for a typing mistake: 2²⁸ pixels need 20 GiB.
const MOST_PIXELS: u64 = 1 << 28;

/// An image size, `WIDTHxHEIGHT` or one number for a square.
pub fn parse_size(text: &str) -> Result<UVec2, String> {
    let (width, height) = text.split_once(['x', 'X', '×']).unwrap_or((text, text));
    let side = |side: &str| match side.trim().parse::<u32>() {
        Ok(0) | Err(_) => {
            Err(format!("{side:?} is not a number of pixels; a size looks like 512x512"))
        }
        Ok(pixels) => Ok(pixels),
    };
    let size = UVec2::new(side(width)?, side(height)?);
    let pixels = u64::from(size.x) * u64::from(size.y);
    if pixels > MOST_PIXELS {
        Err(format!("{pixels} pixels are too many, the limit is {MOST_PIXELS}"))
    } else {
        Ok(size)
    }
}

/// The largest count where nothing smaller limits it.
pub const MANY: u64 = u32::MAX as u64;

/// A whole number within limits, such as 64 or 1e6.
pub fn parse_count<T: TryFrom<u64>, const LEAST: u64, const MOST: u64>(
    text: &str,
) -> Result<T, String> {
    // Up to here floating-point numbers have all whole ones.
    let is_whole = |x: &f64| x.fract() == 0.0 && (0.0..=9e15).contains(x);
    let whole = |text: &str| text.parse::<f64>().ok().filter(is_whole).map(|x| x as u64);
    let number = text.parse().ok().or_else(|| whole(text));
    number.filter(|n| (LEAST..=MOST).contains(n)).and_then(|n| T::try_from(n).ok()).ok_or_else(
        || match LEAST..=MOST {
            _ if MOST >= MANY => {
                format!("{text:?} is not a whole number of at least {LEAST}, such as 64 or 1e6")
            }
            _ => format!("{text:?} is not a whole number from {LEAST} to {MOST}"),
        },
    )
}

/// A time such as `500ms`, `10s`, `1.5m` or `2h`; a bare number means seconds.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let digits = text.find(|c: char| c.is_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let unit = match unit {
        "ms" => 0.001,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("{unit:?} is not a unit of time; use ms, s, m or h")),
    };
    let number: f64 = number
        .trim()
        .parse()
        .map_err(|_| format!("{text:?} is not a time; a time looks like 10s, 500ms or 2m"))?;
    match Duration::try_from_secs_f64(number * unit) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        _ => Err(format!("{text:?} must be positive and finite")),
    }
}

/// A relative mean squared error.
pub fn parse_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error.is_finite() => Ok(error),
        _ => Err("an error is a positive number, such as 0.01".to_owned()),
    }
}

/// A radius within which subpaths merge.
pub fn parse_radius(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(radius) if radius >= 0.0 && radius.is_finite() => Ok(radius),
        _ => Err("a radius is 0 or a positive number".to_owned()),
    }
}

/// The radius of a mollifier.
pub fn parse_mollifier(text: &str) -> Result<f64, String> {
    parse_positive(text, "a radius of mollified lobes")
}

/// A probability that is not 0.
pub fn parse_probability(text: &str) -> Result<f64, String> {
    parse_positive(text, "this probability")
}

fn parse_positive(text: &str, subject: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err(format!("{subject} is in (0, 1]")),
    }
}

/// A bound on geometry terms.
pub fn parse_bound(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(bound) if bound >= 0.0 => Ok(bound),
        _ => Err("a bound is 0 or a positive number, or inf".to_owned()),
    }
}

/// An exposure in stops.
pub fn parse_exposure(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(stops) if stops.abs() <= 64.0 => Ok(stops),
        _ => Err("an exposure is a number of stops between -64 and 64".to_owned()),
    }
}

/// A path whose extension names a format that images can be written in.
pub fn parse_image_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("png" | "exr" | "hdr") => Ok(path),
        _ => Err("the file must end in .png, .exr or .hdr".to_owned()),
    }
}

/// An environment: `none`, a colour, or an image.
pub fn parse_environment(text: &str) -> Result<Environment, String> {
    if text == "none" {
        return Ok(Environment::None);
    }
    if let Some(colour) = parse_colour(text) {
        return Ok(Environment::Colour(colour));
    }
    parse_image_path(text).map(Environment::File).map_err(|_| {
        "an environment is none, a colour such as white, 0.5 or 0.4,0.6,1, or an image that ends \
         in .png, .hdr or .exr"
            .to_owned()
    })
}

/// A name, or one or three radiances.
fn parse_colour(text: &str) -> Option<Rgb> {
    if text == "white" {
        return Some(Rgb::WHITE);
    }
    let radiance =
        |text: &str| text.trim().parse::<f64>().ok().filter(|c| *c >= 0.0 && c.is_finite());
    match text.split(',').map(radiance).collect::<Option<Vec<f64>>>()?[..] {
        [grey] => Some(Rgb::splat(grey)),
        [r, g, b] => Some(Rgb::new(r, g, b)),
        _ => None,
    }
}

/// Names of the samplers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SamplerName {
    /// Plain Monte Carlo.
    Independent,
    /// Stratified over the samples of a pixel.
    Stratified,
    /// Scrambled Sobol' points: randomised quasi-Monte Carlo.
    #[default]
    Sobol,
}

impl From<SamplerName> for SamplerKind {
    fn from(name: SamplerName) -> Self {
        match name {
            SamplerName::Independent => Self::Independent,
            SamplerName::Stratified => Self::Stratified,
            SamplerName::Sobol => Self::Sobol,
        }
    }
}

/// Names of the pixel filters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    /// The average over the pixel.
    #[default]
    Box,
    /// Tent of radius 1 pixel.
    Tent,
    /// Gaussian with a standard deviation of half a pixel.
    Gaussian,
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Box => Self::Box,
            FilterName::Tent => Self::Tent,
            FilterName::Gaussian => Self::Gaussian { standard_deviation: 0.5 },
        }
    }
}
