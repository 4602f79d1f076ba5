//! Images that scenes refer to.

use super::{Error, Location};
use crate::film::linear_from_srgb;
use crate::math::Rgb;
use image::{DynamicImage, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::Path;

/// Decodes an image if it has no more than `pixels_left`, which become less: a small file may stand
/// for a huge image. The format is known by its first bytes, or else by the extension of the path.
pub(crate) fn decode(
    path: &Path,
    bytes: &[u8],
    pixels_left: &mut u64,
    location: &Location,
) -> Result<DynamicImage, Error> {
    let fail = |error: image::ImageError| Error {
        reason: format!("{}: {error}", path.display()),
        ..Error::caused(location.clone(), error)
    };
    let format = image::guess_format(bytes).or_else(|_| ImageFormat::from_path(path));
    let format = format.map_err(fail)?;
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(fail)?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(Error::new(location.clone(), format!("{}: it has no pixels", path.display())));
    }
    *pixels_left = pixels_left.checked_sub(pixels).ok_or_else(|| {
        let reason = "the images have more pixels than the limit admits";
        Error::limit(location.clone(), reason)
    })?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(pixels.saturating_mul(32).saturating_add(1 << 20));
    let mut decoder = reader();
    decoder.limits(limits);
    decoder.decode().map_err(fail)
}

/// The colours of an image as linear RGB, or, if `raw`, the numbers that it holds.
pub(crate) fn colours(decoded: DynamicImage, raw: bool) -> Vec<Rgb> {
    let is_linear = matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let linear =
        |c: f32| if raw || is_linear { f64::from(c) } else { linear_from_srgb(f64::from(c)) };
    if matches!(decoded, DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_)) {
        let table: [f64; 256] = std::array::from_fn(|code| linear(code as f32 / 255.0));
        let pixel = |codes: [u8; 3]| Rgb(codes.map(|code| table[usize::from(code)]));
        return decoded.into_rgb8().pixels().map(|codes| pixel(codes.0)).collect();
    }
    decoded.into_rgb32f().pixels().map(|pixel| Rgb(pixel.0.map(linear))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{RgbImage, RgbaImage};

    #[test]
    fn tables_hold_what_the_formula_gives() {
        let codes = |channels: usize| (0..=255).flat_map(|code| vec![code; channels]).collect();
        let images: [DynamicImage; 2] = [
            RgbImage::from_raw(256, 1, codes(3)).expect("256 pixels").into(),
            RgbaImage::from_raw(256, 1, codes(4)).expect("256 pixels").into(),
        ];
        for image in images {
            let floats = image.to_rgb32f();
            for (raw, linear) in
                [(true, f64::from as fn(f32) -> f64), (false, |c| linear_from_srgb(f64::from(c)))]
            {
                let expected: Vec<Rgb> = floats.pixels().map(|c| Rgb(c.0.map(linear))).collect();
                assert_eq!(colours(image.clone(), raw), expected, "raw: {raw}");
            }
        }
    }
}
