//! Decoded images as colours.

use crate::math::Rgb;
use image::{DynamicImage, ImageBuffer, Pixel};
use std::ops::Deref;

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

    #[test]
    fn results_keep_their_order() {
        let items: Vec<u32> = (0..1000).collect();
        let expected: Vec<u32> = items.iter().map(|item| item * item).collect();
        assert_eq!(on_all_threads(items, |item| item * item), expected);
    }
}
