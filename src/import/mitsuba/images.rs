//! Images of textures and environments.

use super::super::Error;
use super::super::images::{self, Sample, on_all_threads};
use super::Loader;
use super::document::Element;
use super::values::Object;
use crate::film::{Image, linear_from_srgb};
use crate::material::Bitmap;
use crate::math::Rgb;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader};
use std::collections::HashSet;
use std::io::Cursor;
use std::path::PathBuf;

/// An image before its pixels are decoded.
struct Encoded {
    path: PathBuf,
    bytes: Vec<u8>,
    format: Option<ImageFormat>,
    size: [u32; 2],
}

/// An image of which nobody has asked yet.
pub(super) struct Ahead {
    pixels: u64,
    bitmap: Bitmap,
}

impl<'a> Loader<'a> {
    /// Decodes the textures that shapes and emitters refer to, on all threads. What cannot be read
    /// is tried again, and warned about, when it is asked for.
    pub(super) fn decode_ahead(&mut self) {
        let (mut known, mut wanted) = (HashSet::new(), Vec::new());
        let mut open: Vec<&Element> = self.document.scene.iter().rev().collect();
        open.retain(|element| matches!(element.tag.as_str(), "shape" | "emitter"));
        while let Some(element) = open.pop() {
            let Ok(element) = self.resolved(element) else { continue };
            if !known.insert(std::ptr::from_ref(element)) {
                continue;
            }
            open.extend(element.children.iter().rev());
            if element.tag == "texture" && element.kind() == "bitmap" {
                let object = Object::new(element);
                if let (Ok(Some(name)), Ok(raw)) =
                    (object.string("filename"), object.boolean("raw"))
                {
                    wanted.push((name, raw.unwrap_or(false), element));
                }
            }
        }
        let mut left = self.pixels_left;
        let mut names = HashSet::new();
        let mut jobs = Vec::new();
        for (name, raw, element) in wanted {
            if !names.insert((name, raw)) {
                continue;
            }
            let Ok(encoded) = self.open_image(name, element) else { continue };
            match left.checked_sub(encoded.pixels()) {
                Some(rest) => left = rest,
                None => break,
            }
            jobs.push(((name.to_owned(), raw), encoded));
        }
        let decoded = on_all_threads(jobs, |(key, encoded)| {
            let decoded = encoded.decode().ok()?;
            let bitmap = Bitmap::new(encoded.image(&decoded, key.1)?).ok()?;
            Some((key, Ahead { pixels: encoded.pixels(), bitmap }))
        });
        self.ahead.extend(decoded.into_iter().flatten());
    }

    /// The image file of a texture.
    pub(super) fn bitmap_of(
        &mut self,
        name: &str,
        element: &Element,
        raw: bool,
    ) -> Result<Bitmap, Error> {
        if let Some(Ahead { pixels, bitmap }) = self.ahead.get(&(name.to_owned(), raw)) {
            let (pixels, bitmap) = (*pixels, bitmap.clone());
            self.spend_pixels(pixels, element)?;
            return Ok(bitmap);
        }
        let image = self.image(name, element, raw)?;
        Bitmap::new(image).map_err(|error| element.caused(error))
    }

    /// Reads an image file as linear RGB, or, if `raw`, as the numbers that it holds.
    pub(super) fn image(
        &mut self,
        name: &str,
        element: &Element,
        raw: bool,
    ) -> Result<Image, Error> {
        let encoded = self.open_image(name, element)?;
        self.spend_pixels(encoded.pixels(), element)?;
        let decoded = encoded.decode().map_err(|error| encoded.error(element, error))?;
        let wrong = || element.error("the image has another size than it says");
        encoded.image(&decoded, raw).ok_or_else(wrong)
    }

    fn open_image(&mut self, name: &str, element: &Element) -> Result<Encoded, Error> {
        let (path, bytes) = self.files.read(name, element.location())?;
        let mut encoded = Encoded { path, bytes, format: None, size: [0; 2] };
        let reader = ImageReader::new(Cursor::new(&encoded.bytes)).with_guessed_format();
        let reader = reader.map_err(|error| element.caused(error))?;
        let format = reader.format();
        let size = reader.into_dimensions().map_err(|error| encoded.error(element, error))?;
        (encoded.format, encoded.size) = (format, size.into());
        Ok(encoded)
    }

    fn spend_pixels(&mut self, pixels: u64, element: &Element) -> Result<(), Error> {
        let left = self.pixels_left.checked_sub(pixels);
        self.pixels_left =
            left.ok_or_else(|| element.limit("the images have more pixels than the limit admits"))?;
        Ok(())
    }
}

impl Encoded {
    fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    fn error(&self, element: &Element, error: ImageError) -> Error {
        Error { reason: format!("{}: {error}", self.path.display()), ..element.caused(error) }
    }

    fn decode(&self) -> Result<DynamicImage, ImageError> {
        let mut decoder = ImageReader::new(Cursor::new(&self.bytes));
        if let Some(format) = self.format {
            decoder.set_format(format);
        }
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(self.pixels().saturating_mul(32).saturating_add(1 << 20));
        decoder.limits(limits);
        decoder.decode()
    }

    fn image(&self, decoded: &DynamicImage, raw: bool) -> Option<Image> {
        let [width, height] = self.size;
        Image::new(width, height, colours(decoded, raw))
    }
}

/// The colours of an image as linear RGB, or, if `raw`, the numbers that it holds.
fn colours(decoded: &DynamicImage, raw: bool) -> Vec<Rgb> {
    let linear = |c: f32| if raw { f64::from(c) } else { linear_from_srgb(f64::from(c)) };
    let value = |sample: Sample| match sample {
        Sample::Byte(code) => linear(f32::from(code) / 255.0),
        Sample::Short(code) => linear(f32::from(code) / 65535.0),
        Sample::Float(number) => f64::from(number),
    };
    images::colours(decoded, value, |[r, g, b, _]| Rgb::new(r, g, b))
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
                assert_eq!(colours(&image, raw), expected, "raw: {raw}");
            }
        }
    }
}
