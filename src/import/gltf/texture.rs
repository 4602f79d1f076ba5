//! Images, PNG and JPEG, as textures.

use super::document::Document;
use crate::film::{Image, linear_from_srgb};
use crate::import::{Error, Location};
use crate::material::{Bitmap, Interpolation, Texture, Wrap};
use crate::math::Rgb;
use glam::{DAffine2, DVec2};
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use image::{DynamicImage, ImageFormat, ImageReader};
use std::collections::HashMap;
use std::io::Cursor;

/// The meaning of the numbers of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Meaning {
    /// Colour in the transfer function of sRGB.
    Colour,
    /// The alpha channel, linear, as grey.
    Alpha,
    /// Three linear numbers.
    Data,
}

/// Images that have been decoded, each once for every meaning.
pub(super) struct Textures {
    images: HashMap<(usize, Meaning), Bitmap>,
    pixels: u64,
}

impl Textures {
    pub fn new(document: &Document) -> Self {
        Self { images: HashMap::new(), pixels: document.limits.pixels }
    }

    /// A texture of a material, times a factor.
    pub fn texture(
        &mut self,
        document: &mut Document,
        info: &Info,
        meaning: Meaning,
        factor: Rgb,
        at: &Location,
    ) -> Result<Texture, Error> {
        let source = document.root.textures[info.index.value()].source.value();
        let bitmap = self.bitmap(document, source, meaning)?;
        let texture = &document.root.textures[info.index.value()];
        let sampler = texture.sampler.map(|index| &document.root.samplers[index.value()]);
        let nearest = sampler
            .is_some_and(|sampler| sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let interpolation = if nearest { Interpolation::Nearest } else { Interpolation::Bilinear };
        let wraps = sampler
            .map_or([Wrap::Repeat; 2], |sampler| [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)]);
        bitmap
            .texture(interpolation, wraps)
            .with_transform(transform(info))
            .and_then(|texture| texture.scaled(factor))
            .map_err(|error| Error::caused(at.clone(), error))
    }

    fn bitmap(
        &mut self,
        document: &mut Document,
        index: usize,
        meaning: Meaning,
    ) -> Result<Bitmap, Error> {
        if let Some(bitmap) = self.images.get(&(index, meaning)) {
            return Ok(bitmap.clone());
        }
        let source = &document.root.images[index];
        let location = document.location(format!("image {index}"), source.name.as_ref());
        let fetched;
        let bytes = match (source.uri.clone(), source.buffer_view) {
            (Some(uri), None) => {
                fetched = document.fetch(&uri, &location)?;
                &fetched[..]
            }
            (None, Some(view)) => document.view(view.value(), &location)?,
            _ => return Err(Error::new(location, "it needs either a uri or a buffer view")),
        };
        let image = self.decode(bytes, meaning, &location)?;
        let bitmap = Bitmap::new(image).map_err(|error| Error::caused(location, error))?;
        self.images.insert((index, meaning), bitmap.clone());
        Ok(bitmap)
    }

    fn decode(
        &mut self,
        bytes: &[u8],
        meaning: Meaning,
        location: &Location,
    ) -> Result<Image, Error> {
        let refuse = |reason: String| Error::new(location.clone(), reason);
        let format = image::guess_format(bytes)
            .ok()
            .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg));
        let format = format.ok_or_else(|| refuse("it is neither PNG nor JPEG".to_owned()))?;
        let caused = |error: image::ImageError| Error::caused(location.clone(), error);
        // Its size before its pixels: a small file may stand for a huge image.
        let (width, height) = ImageReader::with_format(Cursor::new(bytes), format)
            .into_dimensions()
            .map_err(caused)?;
        let pixels = u64::from(width) * u64::from(height);
        if pixels > self.pixels {
            return Err(refuse(format!(
                "{width} × {height} pixels exceed the limit, which leaves {} for all images",
                self.pixels
            )));
        }
        self.pixels -= pixels;
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = image::Limits::no_limits();
        limits.max_alloc = Some(pixels.saturating_mul(32).saturating_add(1 << 20));
        reader.limits(limits);
        let decoded = reader.decode().map_err(caused)?;
        Image::new(width, height, colours(decoded, meaning))
            .ok_or_else(|| refuse("the number of pixels does not match the size".to_owned()))
    }
}

/// The colours of an image whose channels have 8 or 16 bits.
fn colours(decoded: DynamicImage, meaning: Meaning) -> Vec<Rgb> {
    let value = |share: f64| match meaning {
        Meaning::Colour => linear_from_srgb(share),
        Meaning::Alpha | Meaning::Data => share,
    };
    let colour = |[r, g, b, a]: [f64; 4]| match meaning {
        Meaning::Colour | Meaning::Data => Rgb::new(r, g, b),
        Meaning::Alpha => Rgb::splat(a),
    };
    let format = decoded.color();
    if format.bytes_per_pixel() == format.channel_count() {
        let table: [f64; 256] = std::array::from_fn(|code| value(code as f64 / 255.0));
        let pixel = |codes: [u8; 4]| colour(codes.map(|code| table[usize::from(code)]));
        return decoded.into_rgba8().pixels().map(|codes| pixel(codes.0)).collect();
    }
    let pixel = |codes: [u16; 4]| colour(codes.map(|code| value(f64::from(code) / 65535.0)));
    decoded.into_rgba16().pixels().map(|codes| pixel(codes.0)).collect()
}

/// The set of texture coordinates that a texture is looked up with.
pub(super) fn coordinate_set(info: &Info) -> u32 {
    let transform =
        info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
    transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord)
}

fn wrap(mode: &Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// Scale, rotation, offset. The rotation is counter-clockwise with v downwards, as in the
/// specification's example.
fn transform(info: &Info) -> DAffine2 {
    let Some(transform) =
        info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref())
    else {
        return DAffine2::IDENTITY;
    };
    let vector = |v: [f32; 2]| DVec2::from_array(v.map(f64::from));
    let (scale, offset) = (vector(transform.scale.0), vector(transform.offset.0));
    let (sin, cos) = f64::from(transform.rotation.0).sin_cos();
    DAffine2::from_cols(DVec2::new(cos, -sin) * scale.x, DVec2::new(sin, cos) * scale.y, offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayAlphaImage, GrayImage, RgbImage, RgbaImage};

    #[test]
    fn tables_hold_what_the_formula_gives() {
        let codes = |channels: usize| (0..=255).flat_map(|code| vec![code; channels]).collect();
        let images: [DynamicImage; 4] = [
            GrayImage::from_raw(256, 1, codes(1)).expect("256 pixels").into(),
            GrayAlphaImage::from_raw(256, 1, codes(2)).expect("256 pixels").into(),
            RgbImage::from_raw(256, 1, codes(3)).expect("256 pixels").into(),
            RgbaImage::from_raw(256, 1, codes(4)).expect("256 pixels").into(),
        ];
        for image in images {
            for meaning in [Meaning::Colour, Meaning::Alpha, Meaning::Data] {
                // All images of 16 bits are converted without a table.
                let precise = DynamicImage::from(image.to_rgba16());
                let expected = colours(precise, meaning);
                for (code, pixel) in colours(image.clone(), meaning).into_iter().enumerate() {
                    let share = code as f64 / 255.0;
                    let formula = match meaning {
                        Meaning::Colour => linear_from_srgb(share),
                        Meaning::Data => share,
                        Meaning::Alpha if image.color().has_alpha() => share,
                        Meaning::Alpha => 1.0,
                    };
                    assert_eq!(pixel, Rgb::splat(formula), "{meaning:?} {code}");
                    assert_eq!(pixel, expected[code], "{meaning:?} {code}");
                }
            }
        }
    }
}
