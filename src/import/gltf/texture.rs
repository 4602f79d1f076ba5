//! Images, PNG and JPEG, as textures.

use super::document::Document;
use crate::film::{Image, linear_from_srgb};
use crate::import::{Error, Location};
use crate::material::{Interpolation, Texture, Wrap};
use crate::math::Rgb;
use glam::{DAffine2, DVec2};
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use image::{ImageFormat, ImageReader};
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

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
    images: HashMap<(usize, Meaning), Arc<Image>>,
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
        let image = self.image(document, source, meaning)?;
        let texture = &document.root.textures[info.index.value()];
        let sampler = texture.sampler.map(|index| &document.root.samplers[index.value()]);
        let nearest = sampler
            .is_some_and(|sampler| sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let interpolation = if nearest { Interpolation::Nearest } else { Interpolation::Bilinear };
        let wraps = sampler
            .map_or([Wrap::Repeat; 2], |sampler| [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)]);
        let texture = Texture::bitmap(image, interpolation, wraps)
            .and_then(|texture| texture.with_transform(transform(info)));
        texture
            .and_then(|texture| texture.scaled(factor))
            .map_err(|error| Error::caused(at.clone(), error))
    }

    fn image(
        &mut self,
        document: &mut Document,
        index: usize,
        meaning: Meaning,
    ) -> Result<Arc<Image>, Error> {
        if let Some(image) = self.images.get(&(index, meaning)) {
            return Ok(Arc::clone(image));
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
        let image = Arc::new(image);
        self.images.insert((index, meaning), Arc::clone(&image));
        Ok(image)
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
        let decoded = reader.decode().map_err(caused)?.into_rgba16();
        let unit = |channel: u16| f64::from(channel) / 65535.0;
        let value = |[r, g, b, a]: [u16; 4]| match meaning {
            Meaning::Colour => Rgb::new(unit(r), unit(g), unit(b)).map(linear_from_srgb),
            Meaning::Data => Rgb::new(unit(r), unit(g), unit(b)),
            Meaning::Alpha => Rgb::splat(unit(a)),
        };
        let (width, height) = decoded.dimensions();
        let image =
            Image::new(width, height, decoded.pixels().map(|pixel| value(pixel.0)).collect());
        image.ok_or_else(|| refuse("the number of pixels does not match the size".to_owned()))
    }
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
