//! Images, PNG and JPEG, as textures.

use super::clear_coat::ClearCoat;
use super::document::Document;
use crate::film::{Image, linear_from_srgb};
use crate::import::images::{self, Encoded, Sample, on_all_threads};
use crate::import::{Error, Location};
use crate::material::{Bitmap, Interpolation, Texture, Wrap};
use crate::math::Rgb;
use glam::{DAffine2, DVec2};
use gltf::json::Root;
use gltf::json::material::AlphaMode;
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use image::{DynamicImage, ImageFormat};
use std::collections::{HashMap, HashSet};

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
    /// Those of which nobody has asked yet, and their sizes.
    ahead: HashMap<(usize, Meaning), ([u32; 2], Bitmap)>,
    /// Images that cannot be read.
    unreadable: HashSet<usize>,
    /// Textures without an image.
    empty: HashSet<usize>,
    pixels: u64,
    /// The second set of texture coordinates of the material that is being read, if it has one.
    pub other_set: Option<u32>,
}

impl Textures {
    pub fn new(document: &Document) -> Self {
        Self {
            images: HashMap::new(),
            ahead: HashMap::new(),
            unreadable: HashSet::new(),
            empty: HashSet::new(),
            pixels: document.limits.pixels,
            other_set: None,
        }
    }

    /// Decodes what materials will ask for, on all threads. Who asks gets it, or the warning that
    /// it cannot be read, as if it were decoded then.
    pub fn decode_ahead(&mut self, document: &mut Document, materials: &[usize]) {
        let mut wanted: Vec<(usize, Vec<Meaning>)> = Vec::new();
        let mut places = HashMap::new();
        for (image, meaning) in materials.iter().flat_map(|&index| uses(&document.root, index)) {
            let place = *places.entry(image).or_insert(wanted.len());
            if place == wanted.len() {
                wanted.push((image, Vec::new()));
            }
            let (_, meanings) = &mut wanted[place];
            if !meanings.contains(&meaning) {
                meanings.push(meaning);
            }
        }
        let mut left = self.pixels;
        let mut jobs = Vec::new();
        for (index, meanings) in wanted {
            let location = document.location(format!("image {index}"), None);
            // What cannot be read is tried again when it is asked for.
            let Ok(encoded) = open(document, index, &location) else { continue };
            match left.checked_sub(encoded.pixels.saturating_mul(meanings.len() as u64)) {
                Some(rest) => left = rest,
                None => break,
            }
            jobs.push((index, meanings, encoded, location));
        }
        let decoded = on_all_threads(jobs, |(index, meanings, encoded, location)| {
            let Ok(decoded) = encoded.decode() else { return Vec::new() };
            let bitmap = |meaning| {
                let bitmap = meant(&decoded, meaning, &location).ok()?;
                Some(((index, meaning), (encoded.size, bitmap)))
            };
            meanings.into_iter().filter_map(bitmap).collect()
        });
        self.ahead.extend(decoded.into_iter().flatten());
    }

    /// A texture of a material, times a factor; the factor alone if there is no image to read.
    pub fn texture(
        &mut self,
        document: &mut Document,
        info: &Info,
        meaning: Meaning,
        factor: Rgb,
        at: &Location,
    ) -> Result<Texture, Error> {
        let index = info.index.value();
        let source = source(&document.root.textures[index]);
        if source >= document.root.images.len() {
            if self.empty.insert(index) {
                let name = document.root.textures[index].name.as_ref();
                let location = document.location(format!("texture {index}"), name);
                let reason = match extension(&document.root.textures[index], "KHR_texture_basisu") {
                    Some(_) => {
                        "Basis Universal is not supported (`gltf-transform ktxdecompress` makes \
                         PNG of it): factors hold in place of it"
                    }
                    None => "it has no image that can be read: factors hold in place of it",
                };
                document.warnings.warn(location, reason)?;
            }
            return Ok(factor.into());
        }
        let Some(bitmap) = self.bitmap(document, source, meaning)? else {
            return Ok(factor.into());
        };
        let texture = &document.root.textures[index];
        let sampler = texture.sampler.map(|index| &document.root.samplers[index.value()]);
        let nearest = sampler
            .is_some_and(|sampler| sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let interpolation = if nearest { Interpolation::Nearest } else { Interpolation::Bilinear };
        let wraps = sampler
            .map_or([Wrap::Repeat; 2], |sampler| [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)]);
        let texture = bitmap
            .texture(interpolation, wraps)
            .with_transform(transform(info))
            .and_then(|texture| texture.scaled(factor))
            .map_err(|error| Error::caused(at.clone(), error))?;
        let is_other = self.other_set == Some(coordinate_set(info));
        Ok(if is_other { texture.with_other_coordinates() } else { texture })
    }

    /// An image of the file; `None` if it cannot be read.
    fn bitmap(
        &mut self,
        document: &mut Document,
        index: usize,
        meaning: Meaning,
    ) -> Result<Option<Bitmap>, Error> {
        if let Some(bitmap) = self.images.get(&(index, meaning)) {
            return Ok(Some(bitmap.clone()));
        }
        if self.unreadable.contains(&index) {
            return Ok(None);
        }
        let name = document.root.images[index].name.as_ref();
        let location = document.location(format!("image {index}"), name);
        let bitmap = match self.ahead.remove(&(index, meaning)) {
            Some((size, bitmap)) => {
                self.spend(size, &location)?;
                Ok(bitmap)
            }
            None => match open(document, index, &location) {
                Ok(encoded) => {
                    self.spend(encoded.size, &location)?;
                    encoded
                        .decode()
                        .map_err(|error| Error::caused(location.clone(), error))
                        .and_then(|decoded| meant(&decoded, meaning, &location))
                }
                Err(error) => Err(error),
            },
        };
        match bitmap {
            Ok(bitmap) => {
                self.images.insert((index, meaning), bitmap.clone());
                Ok(Some(bitmap))
            }
            Err(error) => {
                self.unreadable.insert(index);
                let reason = format!("{}: factors hold in place of it", error.reason);
                document.warnings.warn(location, reason)?;
                Ok(None)
            }
        }
    }

    /// Counts pixels.
    fn spend(&mut self, [width, height]: [u32; 2], location: &Location) -> Result<(), Error> {
        let pixels = u64::from(width) * u64::from(height);
        let left = self.pixels.checked_sub(pixels);
        self.pixels = left.ok_or_else(|| {
            let reason = format!(
                "{width} × {height} pixels exceed the limit, which leaves {} for all images",
                self.pixels
            );
            Error::new(location.clone(), reason)
        })?;
        Ok(())
    }
}

/// An image of the file.
fn open(document: &mut Document, index: usize, location: &Location) -> Result<Encoded, Error> {
    let refuse = |reason: &str| Error::new(location.clone(), reason);
    let source = &document.root.images[index];
    let bytes = match (source.uri.clone(), source.buffer_view) {
        (Some(uri), None) => document.fetch(&uri, location)?,
        (None, Some(view)) => document.view(view.value(), location)?.to_vec(),
        _ => return Err(refuse("it needs either a uri or a buffer view")),
    };
    let format = image::guess_format(&bytes).ok().filter(|format| {
        matches!(format, ImageFormat::Png | ImageFormat::Jpeg)
            || (cfg!(feature = "webp") && *format == ImageFormat::WebP)
    });
    let format = format.ok_or_else(|| refuse("it is neither PNG nor JPEG"))?;
    Encoded::new(bytes, format).map_err(|error| Error::caused(location.clone(), error))
}

/// A decoded image as what its numbers mean.
fn meant(decoded: &DynamicImage, meaning: Meaning, location: &Location) -> Result<Bitmap, Error> {
    let colours = colours(decoded, meaning);
    let image = Image::new(decoded.width(), decoded.height(), colours).ok_or_else(|| {
        let reason = "the number of pixels does not match the size";
        Error::new(location.clone(), reason)
    })?;
    Bitmap::new(image).map_err(|error| Error::caused(location.clone(), error))
}

/// The image of a texture: in WebP where that can be read.
fn source(texture: &gltf::json::Texture) -> usize {
    let webp = extension(texture, "EXT_texture_webp").filter(|_| cfg!(feature = "webp"));
    webp.unwrap_or_else(|| texture.source.value())
}

/// The image that an extension names.
fn extension(texture: &gltf::json::Texture, name: &str) -> Option<usize> {
    let extension = texture.extensions.as_ref()?.others.get(name)?;
    extension.get("source")?.as_u64().map(|source| source as usize)
}

/// The images that a material asks for.
fn uses(root: &Root, material: usize) -> Vec<(usize, Meaning)> {
    let material = &root.materials[material];
    let pbr = &material.pbr_metallic_roughness;
    let base = pbr.base_color_texture.as_ref().map(|info| info.index);
    let surface = pbr.metallic_roughness_texture.as_ref().map(|info| info.index);
    let emission = material.emissive_texture.as_ref().map(|info| info.index);
    let emits = material.emissive_factor.0 != [0.0; 3];
    let is_opaque = material.alpha_mode == Checked::Valid(AlphaMode::Opaque);
    let coat = ClearCoat::of(root, material).ok().flatten();
    let coat = coat.iter().flat_map(ClearCoat::infos).map(|info| (Some(info.index), Meaning::Data));
    [
        (base, Meaning::Colour),
        (base.filter(|_| !is_opaque), Meaning::Alpha),
        (surface, Meaning::Data),
        (emission.filter(|_| emits), Meaning::Colour),
        (material.normal_texture.as_ref().map(|normals| normals.index), Meaning::Data),
    ]
    .into_iter()
    .chain(coat)
    .filter_map(|(texture, meaning)| Some((texture?.value(), meaning)))
    .map(|(texture, meaning)| (source(&root.textures[texture]), meaning))
    .filter(|(image, _)| *image < root.images.len())
    .collect()
}

/// The colours of an image whose channels have 8 or 16 bits.
fn colours(decoded: &DynamicImage, meaning: Meaning) -> Vec<Rgb> {
    let value = |sample: Sample| {
        let share = match sample {
            Sample::Byte(code) => f64::from(code) / 255.0,
            Sample::Short(code) => f64::from(code) / 65535.0,
            Sample::Float(number) => f64::from(number),
        };
        if meaning == Meaning::Colour { linear_from_srgb(share) } else { share }
    };
    images::colours(decoded, value, |[r, g, b, a]| match meaning {
        Meaning::Colour | Meaning::Data => Rgb::new(r, g, b),
        Meaning::Alpha => Rgb::splat(a),
    })
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
pub(super) fn transform(info: &Info) -> DAffine2 {
    let Some(transform) =
        info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref())
    else {
        return DAffine2::IDENTITY;
    };
    let vector = |v: [f32; 2]| DVec2::from_array(v.map(f64::from));
    let (scale, offset) = (vector(transform.scale.0), vector(transform.offset.0));
    let (sin, cos) = libm::sincos(f64::from(transform.rotation.0));
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
                let expected = colours(&precise, meaning);
                for (code, pixel) in colours(&image, meaning).into_iter().enumerate() {
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
