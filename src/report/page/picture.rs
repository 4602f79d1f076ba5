//! Images for people: exposure, signed error maps, PNG inside a page.

use crate::film::Image;
use crate::math::Rgb;
use base64::prelude::{BASE64_STANDARD, Engine};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Relative error that gets the full colour in error maps.
pub const ERROR_SCALE: f64 = 0.5;

/// Stops of exposure that make an image's brighter parts, but not its lights, nearly white.
#[must_use]
pub fn exposure(image: &Image) -> f64 {
    let mut luminances: Vec<f64> = image
        .pixels()
        .iter()
        .map(|p| p.luminance())
        .filter(|l| *l > 0.0 && l.is_finite())
        .collect();
    if luminances.is_empty() {
        return 0.0;
    }
    luminances.sort_by(f64::total_cmp);
    let bright = luminances[luminances.len() * 9 / 10];
    (0.7 / bright).log2().clamp(-60.0, 60.0)
}

/// The colour of a relative error: grey is exact, towards yellow too bright, towards dark blue too
/// dark (so that it can be told in black and white, too), all at full colour from ±[`ERROR_SCALE`]
/// on; magenta is not a number. The square root of the error is shown.
#[must_use]
pub fn error_colour(error: f64) -> Rgb {
    if error.is_nan() {
        return Rgb::new(1.0, 0.0, 1.0);
    }
    let amount = (error.abs() / ERROR_SCALE).min(1.0).sqrt();
    let colour = if error > 0.0 { Rgb::new(1.0, 0.87, 0.25) } else { Rgb::new(0.0, 0.003, 0.06) };
    Rgb::splat(0.25 * (1.0 - amount)) + colour * amount
}

/// Signed relative error of luminance, `(I - R) / (R + 0.02 mean(R))`, in [`error_colour`]. Black
/// if the sizes differ.
#[must_use]
pub fn signed_error_map(image: &Image, reference: &Image) -> Image {
    // Where the reference is dark, a relative error has no meaning: it is taken relative to a part
    // of the mean.
    let floor = 0.02 * reference.mean().luminance();
    Image::from_fn(reference.width(), reference.height(), |x, y| {
        let values = image.get(x, y).zip(reference.get(x, y));
        values.map_or(Rgb::BLACK, |(i, r)| {
            error_colour((i.luminance() - r.luminance()) / (r.luminance() + floor))
        })
    })
}

/// Averages blocks of pixels until the image is at most `width` wide.
pub(super) fn shrunk(image: &Image, width: u32) -> Image {
    averaged(image, image.width().div_ceil(width.max(1)).max(1))
}

/// Averages blocks of `factor` × `factor` pixels.
pub(super) fn averaged(image: &Image, factor: u32) -> Image {
    Image::from_fn(image.width().div_ceil(factor), image.height().div_ceil(factor), |x, y| {
        let pixels = (0..factor * factor)
            .filter_map(|i| image.get(x * factor + i % factor, y * factor + i / factor));
        let (sum, n) = pixels.fold((Rgb::BLACK, 0.0), |(sum, n), p| (sum + p, n + 1.0));
        sum / f64::max(n, 1.0)
    })
}

/// The image as `data:image/png;base64,…`; empty if it has no pixels.
pub(super) fn data_uri(image: &Image, exposure: f64) -> String {
    let mut png = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive);
    let bytes = image.to_srgb8(exposure);
    match encoder.write_image(&bytes, image.width(), image.height(), ExtendedColorType::Rgb8) {
        Ok(()) => format!("data:image/png;base64,{}", BASE64_STANDARD.encode(&png)),
        Err(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_colours_are_ordered_in_black_and_white() {
        let luminances =
            [-1.0, -0.3, -0.05, 0.0, 0.05, 0.3, 1.0].map(|e| error_colour(e).luminance());
        assert!(luminances.is_sorted(), "{luminances:?}");
        assert_eq!(error_colour(f64::NAN), Rgb::new(1.0, 0.0, 1.0));
    }

    #[test]
    fn shrinking_keeps_the_mean() {
        let image = Image::from_fn(8, 4, |x, y| Rgb::splat(f64::from(x * y)));
        let small = shrunk(&image, 4);
        assert_eq!((small.width(), small.height(), small.mean()), (4, 2, image.mean()));
    }
}
