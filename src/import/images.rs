//! Images that scenes refer to.

use crate::math::Rgb;
use exr::math::Vec2;
use image::error::{DecodingError, ImageError};
use image::{DynamicImage, ImageBuffer, ImageFormat, ImageReader, ImageResult, Pixel};
use std::io::Cursor;
use std::ops::Deref;
#[cfg(any(feature = "mitsuba", feature = "obj", feature = "pbrt"))]
use {
    super::{Error, Location},
    crate::film::linear_from_srgb,
    std::path::Path,
};

/// An image before its pixels are decoded: a small file may stand for a huge image.
pub(super) struct Encoded {
    bytes: Vec<u8>,
    format: ImageFormat,
    pub size: [u32; 2],
    /// The number of pixels that decoding takes, at least those of the size.
    pub pixels: u64,
}

impl Encoded {
    /// An image in a format, of which only the size is read.
    pub fn new(bytes: Vec<u8>, format: ImageFormat) -> ImageResult<Self> {
        let reader = ImageReader::with_format(Cursor::new(&bytes), format);
        let size: [u32; 2] = reader.into_dimensions()?.into();
        let seen = size.map(u64::from).iter().product();
        let pixels = match format {
            ImageFormat::OpenExr => stored_pixels(&bytes)?.max(seen),
            _ => seen,
        };
        Ok(Self { bytes, format, size, pixels })
    }

    /// The same in the format that is known by the first bytes, or else by the extension of the
    /// path.
    #[cfg(any(feature = "mitsuba", feature = "obj", feature = "pbrt"))]
    pub fn guess(path: &Path, bytes: Vec<u8>) -> ImageResult<Self> {
        let format = image::guess_format(&bytes).or_else(|_| ImageFormat::from_path(path))?;
        Self::new(bytes, format)
    }

    /// Decodes it in no more memory than its pixels need.
    pub fn decode(&self) -> ImageResult<DynamicImage> {
        let mut reader = ImageReader::with_format(Cursor::new(&self.bytes), self.format);
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(self.pixels.saturating_mul(32).saturating_add(1 << 20));
        reader.limits(limits);
        reader.decode()
    }
}

/// The pixels of the layers of an OpenEXR file, which may lie outside of the window that is shown,
/// or those of 16 bytes that its largest block of pixels would fill, if these are more.
fn stored_pixels(bytes: &[u8]) -> ImageResult<u64> {
    let file = exr::block::read(Cursor::new(bytes), false).map_err(|error| {
        ImageError::Decoding(DecodingError::new(ImageFormat::OpenExr.into(), error))
    })?;
    let area = |size: Vec2<usize>| (size.width() as u64).saturating_mul(size.height() as u64);
    let layers = file.headers().iter().map(|header| {
        let layer = area(header.layer_size);
        let block = layer.min(area(header.max_block_pixel_size()));
        layer.max(block.saturating_mul(header.channels.bytes_per_pixel as u64) / 16)
    });
    Ok(layers.max().unwrap_or(0))
}

/// Decodes an image if it has no more than `pixels_left`, which become less.
#[cfg(any(feature = "mitsuba", feature = "obj", feature = "pbrt"))]
pub(super) fn decode(
    path: &Path,
    bytes: Vec<u8>,
    pixels_left: &mut u64,
    location: &Location,
) -> Result<DynamicImage, Error> {
    let fail = |error: ImageError| Error {
        reason: format!("{}: {error}", path.display()),
        ..Error::caused(location.clone(), error)
    };
    let encoded = Encoded::guess(path, bytes).map_err(fail)?;
    if encoded.pixels == 0 {
        return Err(Error::new(location.clone(), format!("{}: it has no pixels", path.display())));
    }
    spend(encoded.pixels, pixels_left, location)?;
    encoded.decode().map_err(fail)
}

/// Counts pixels.
#[cfg(any(feature = "mitsuba", feature = "obj", feature = "pbrt"))]
pub(super) fn spend(pixels: u64, left: &mut u64, location: &Location) -> Result<(), Error> {
    *left = left.checked_sub(pixels).ok_or_else(|| {
        let reason = "the images have more pixels than the limit admits";
        Error::limit(location.clone(), reason)
    })?;
    Ok(())
}

/// A number of a pixel as a file holds it.
#[derive(Clone, Copy)]
pub(super) enum Sample {
    Byte(u8),
    Short(u16),
    Float(f32),
}

/// The colours of an image, made of red, green, blue and alpha; grey is all three colours, and
/// alpha 1 where there is none. `value` says what a number stands for; it is asked once for each
/// code of 8 bits.
pub(super) fn colours(
    image: &DynamicImage,
    value: impl Fn(Sample) -> f64,
    colour: impl Fn([f64; 4]) -> Rgb,
) -> Vec<Rgb> {
    let table: [f64; 256] = std::array::from_fn(|code| value(Sample::Byte(code as u8)));
    let byte = |code: u8| table[usize::from(code)];
    let short = |code: u16| value(Sample::Short(code));
    let float = |number: f32| value(Sample::Float(number));
    match image {
        DynamicImage::ImageLuma8(image) => pixels::<1, _>(image, byte, colour),
        DynamicImage::ImageLumaA8(image) => pixels::<2, _>(image, byte, colour),
        DynamicImage::ImageRgb8(image) => pixels::<3, _>(image, byte, colour),
        DynamicImage::ImageRgba8(image) => pixels::<4, _>(image, byte, colour),
        DynamicImage::ImageLuma16(image) => pixels::<1, _>(image, short, colour),
        DynamicImage::ImageLumaA16(image) => pixels::<2, _>(image, short, colour),
        DynamicImage::ImageRgb16(image) => pixels::<3, _>(image, short, colour),
        DynamicImage::ImageRgba16(image) => pixels::<4, _>(image, short, colour),
        DynamicImage::ImageRgb32F(image) => pixels::<3, _>(image, float, colour),
        DynamicImage::ImageRgba32F(image) => pixels::<4, _>(image, float, colour),
        other => pixels::<4, _>(&other.to_rgba32f(), float, colour),
    }
}

/// The colours of an image as linear RGB, or, if `raw`, the numbers that it holds.
#[cfg(any(feature = "mitsuba", feature = "obj", feature = "pbrt"))]
pub(super) fn linear_colours(image: &DynamicImage, raw: bool) -> Vec<Rgb> {
    let linear = |c: f32| if raw { f64::from(c) } else { linear_from_srgb(f64::from(c)) };
    let value = |sample: Sample| match sample {
        Sample::Byte(code) => linear(f32::from(code) / 255.0),
        Sample::Short(code) => linear(f32::from(code) / 65535.0),
        Sample::Float(number) => f64::from(number),
    };
    colours(image, value, |[r, g, b, _]| Rgb::new(r, g, b))
}

fn pixels<const N: usize, P: Pixel>(
    image: &ImageBuffer<P, impl Deref<Target = [P::Subpixel]>>,
    value: impl Fn(P::Subpixel) -> f64,
    colour: impl Fn([f64; 4]) -> Rgb,
) -> Vec<Rgb> {
    let channels = |values: [f64; N]| match values[..] {
        [grey] => [grey, grey, grey, 1.0],
        [grey, alpha] => [grey, grey, grey, alpha],
        [r, g, b] => [r, g, b, 1.0],
        [r, g, b, alpha, ..] => [r, g, b, alpha],
        [] => [0.0; 4],
    };
    let (pixels, _) = image.as_raw().as_chunks::<N>();
    pixels.iter().map(|pixel| colour(channels(pixel.map(&value)))).collect()
}

/// The results for all items, in their order, found on all threads.
#[cfg(any(feature = "gltf", feature = "mitsuba"))]
pub(super) fn on_all_threads<T: Send, R: Send>(
    items: Vec<T>,
    result: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::iter::{IntoParallelIterator, ParallelIterator};
        items.into_par_iter().map(result).collect()
    }
    #[cfg(not(feature = "parallel"))]
    items.into_iter().map(result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayAlphaImage, GrayImage, RgbImage, RgbaImage};

    /// Grey and coloured images of both depths mean the same, with alpha and without.
    #[test]
    fn all_kinds_of_pixels_have_their_colours() {
        let codes = |channels: usize| (0..=255).flat_map(|code| vec![code; channels]).collect();
        let images: [(DynamicImage, bool); 4] = [
            (GrayImage::from_raw(256, 1, codes(1)).expect("256 pixels").into(), false),
            (GrayAlphaImage::from_raw(256, 1, codes(2)).expect("256 pixels").into(), true),
            (RgbImage::from_raw(256, 1, codes(3)).expect("256 pixels").into(), false),
            (RgbaImage::from_raw(256, 1, codes(4)).expect("256 pixels").into(), true),
        ];
        let value = |sample: Sample| match sample {
            Sample::Byte(code) => f64::from(code) / 255.0,
            Sample::Short(code) => f64::from(code) / 65535.0,
            Sample::Float(number) => f64::from(number),
        };
        for (image, has_alpha) in images {
            let deep = [
                DynamicImage::from(image.to_luma_alpha16()),
                DynamicImage::from(image.to_rgba16()),
                DynamicImage::from(image.to_rgba32f()),
            ];
            for (kind, image) in [image].iter().chain(&deep).enumerate() {
                let seen = colours(image, value, |[r, g, b, a]| Rgb::new(r, 0.5 * (g + b), a));
                assert_eq!(seen.len(), 256);
                for (code, pixel) in seen.into_iter().enumerate() {
                    let share = code as f64 / 255.0;
                    let alpha = if has_alpha { share } else { 1.0 };
                    let expected = Rgb::new(share, share, alpha);
                    let error = (0..3).fold(0.0f64, |e, c| e.max((pixel[c] - expected[c]).abs()));
                    assert!(error < 1e-6, "{kind} {code}: {pixel:?} {expected:?}");
                }
            }
        }
    }

    #[cfg(any(feature = "mitsuba", feature = "obj", feature = "pbrt"))]
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
                assert_eq!(linear_colours(&image, raw), expected, "raw: {raw}");
            }
        }
    }

    #[cfg(any(feature = "gltf", feature = "mitsuba"))]
    #[test]
    fn results_keep_their_order() {
        let items: Vec<u32> = (0..1000).collect();
        let expected: Vec<u32> = items.iter().map(|item| item * item).collect();
        assert_eq!(on_all_threads(items, |item| item * item), expected);
    }
}
