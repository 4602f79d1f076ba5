//! Textures, and numbers and colours in their place.

use super::super::Error;
use super::super::images::{decode, linear_colours};
use super::Loader;
use super::object::{Object, Parameter, Values};
use crate::film::Image;
use crate::material::{Bitmap, Interpolation, Texture, Wrap};
use crate::math::Rgb;
use glam::{DAffine2, DMat2, DVec2};

/// The sort of values that a texture has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Sort {
    /// Numbers, as grey.
    Float,
    /// Colours between black and white.
    Spectrum,
}

/// The meaning of the numbers in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Srgb,
    /// The power that makes them linear; 1 for numbers that are linear.
    Gamma(f64),
}

impl Loader {
    /// Adds the texture that the directive `Texture` describes.
    pub(super) fn add_texture(
        &mut self,
        name: String,
        sort: Sort,
        object: &Object,
    ) -> Result<(), Error> {
        let texture = self.described(sort, object);
        let instead = "it is 0.5 everywhere";
        let texture = self.warnings.rescue(texture, instead)?.unwrap_or(Rgb::splat(0.5).into());
        self.textures.insert((sort, name), texture);
        Ok(())
    }

    /// The number, colour or texture of a parameter, for texture coordinates that `to_uv` makes
    /// pbrt's; `None` if there is none.
    pub(super) fn texture(
        &mut self,
        object: &Object,
        name: &str,
        sort: Sort,
        to_uv: DAffine2,
    ) -> Result<Option<Texture>, Error> {
        let Some(parameter) = object.get(name) else { return Ok(None) };
        let texture = self.value(object, parameter, sort).and_then(|texture| {
            if texture.as_constant().is_some() {
                return Ok(texture);
            }
            texture.with_transform(to_uv).map_err(|error| object.caused(error))
        });
        self.warnings.rescue(texture, &format!("the {name} is as if it were not given"))
    }

    fn value(
        &mut self,
        object: &Object,
        parameter: &Parameter,
        sort: Sort,
    ) -> Result<Texture, Error> {
        if parameter.kind == "texture" {
            let Values::Texts(names) = &parameter.values else {
                return Err(object.error(format!("{} must name a texture", parameter.name)));
            };
            let name = names.first().map_or("", String::as_str);
            let found = self.textures.get(&(sort, name.to_owned())).cloned();
            return found.ok_or_else(|| object.error(format!("there is no texture {name}")));
        }
        let spectrum = self.spectrum(object, parameter)?;
        Ok(match sort {
            Sort::Float => Rgb::splat(spectrum.as_index()).into(),
            Sort::Spectrum => spectrum.as_reflectance().into(),
        })
    }

    /// A number that must not vary; of a texture its mean.
    pub(super) fn scalar(
        &mut self,
        object: &Object,
        name: &str,
        to_uv: DAffine2,
    ) -> Result<Option<f64>, Error> {
        let Some(texture) = self.texture(object, name, Sort::Float, to_uv)? else {
            return Ok(None);
        };
        if texture.as_constant().is_none() {
            let reason = format!("the {name} varies, which is not supported: its mean is taken");
            self.warnings.warn(object.location.clone(), reason)?;
        }
        Ok(Some(mean(&texture).r()))
    }

    fn described(&mut self, sort: Sort, object: &Object) -> Result<Texture, Error> {
        let mut part = |name: &str, default: f64| -> Result<Texture, Error> {
            let texture = self.texture(object, name, sort, DAffine2::IDENTITY)?;
            Ok(texture.unwrap_or(Rgb::splat(default).into()))
        };
        let texture = match object.kind.as_str() {
            "constant" => part("value", 1.0)?,
            "scale" => {
                let first = if object.get("tex").is_some() { "tex" } else { "tex1" };
                let texture = part(first, 1.0)?;
                let second = if object.get("scale").is_some() { "scale" } else { "tex2" };
                // The factor is a number unless version 3 says otherwise.
                let is_spectrum = second == "tex2" && sort == Sort::Spectrum;
                let sort = if is_spectrum { Sort::Spectrum } else { Sort::Float };
                let factor = self.texture(object, second, sort, DAffine2::IDENTITY)?;
                self.product(object, texture, factor.unwrap_or(Rgb::WHITE.into()))?
            }
            "mix" => {
                let (first, second) = (part("tex1", 0.0)?, part("tex2", 1.0)?);
                let amount = self.texture(object, "amount", Sort::Float, DAffine2::IDENTITY)?;
                let amount = amount.unwrap_or(Rgb::splat(0.5).into());
                let share = amount.as_constant().map(Rgb::r);
                match (first.as_constant(), second.as_constant(), share) {
                    (_, _, Some(0.0)) => first,
                    (_, _, Some(1.0)) => second,
                    (Some(a), Some(b), _) => self.recoloured(object, &amount, |amount| {
                        a * (1.0 - amount.r()) + b * amount.r()
                    })?,
                    (None, Some(b), Some(t)) => {
                        self.recoloured(object, &first, |a| a * (1.0 - t) + b * t)?
                    }
                    (Some(a), None, Some(t)) => {
                        self.recoloured(object, &second, |b| a * (1.0 - t) + b * t)?
                    }
                    _ => {
                        self.is_mean(object)?;
                        let t = mean(&amount).r();
                        (mean(&first) * (1.0 - t) + mean(&second) * t).into()
                    }
                }
            }
            "checkerboard" if object.number_or("dimension", 2.0)? == 2.0 => {
                let (first, second) = (part("tex1", 1.0)?, part("tex2", 0.0)?);
                match (first.as_constant(), second.as_constant(), self.mapping(object)?) {
                    // A square is a half of the crate's unit.
                    (Some(first), Some(second), Some(to_st)) => {
                        Texture::checkerboard(first, second)
                            .with_transform(DAffine2::from_scale(DVec2::splat(0.5)) * to_st)
                            .map_err(|error| object.caused(error))?
                    }
                    _ => {
                        self.is_mean(object)?;
                        (mean(&first) * 0.5 + mean(&second) * 0.5).into()
                    }
                }
            }
            "imagemap" => self.image_map(sort, object)?,
            kind => {
                let mean_of = |colours: Vec<Texture>| {
                    let sum: Rgb = colours.iter().map(mean).sum();
                    sum * (1.0 / colours.len() as f64)
                };
                let value = match kind {
                    "bilerp" => {
                        let corners = [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)];
                        let values = corners.map(|(name, default)| part(name, default));
                        mean_of(values.into_iter().collect::<Result<_, _>>()?)
                    }
                    "checkerboard" => mean_of(vec![part("tex1", 1.0)?, part("tex2", 0.0)?]),
                    "directionmix" => mean_of(vec![part("tex1", 0.0)?, part("tex2", 1.0)?]),
                    "dots" => mean(&part("outside", 0.0)?),
                    _ => Rgb::splat(0.5),
                };
                self.is_mean(object)?;
                return Ok(value.into());
            }
        };
        object.finish(&mut self.warnings)?;
        Ok(texture)
    }

    /// A texture in other colours.
    pub(super) fn recoloured(
        &mut self,
        object: &Object,
        texture: &Texture,
        change: impl Fn(Rgb) -> Rgb,
    ) -> Result<Texture, Error> {
        if let Some(image) = texture.image() {
            self.spend_pixels(object, u64::from(image.width()) * u64::from(image.height()))?;
        }
        texture.recoloured(change).map_err(|error| object.caused(error))
    }

    fn is_mean(&mut self, object: &Object) -> Result<(), Error> {
        let reason = format!(
            "a {} texture of this sort is not supported: a mean is taken everywhere",
            object.kind
        );
        self.warnings.warn(object.location.clone(), reason)
    }

    /// A texture times another one, of which one must be constant.
    fn product(&mut self, object: &Object, a: Texture, b: Texture) -> Result<Texture, Error> {
        let (texture, factor) = match (a.as_constant(), b.as_constant()) {
            (Some(factor), _) => (b, factor),
            (None, Some(factor)) => (a, factor),
            (None, None) => {
                let reason = "a product of two textures is not supported: of the second one its \
                              mean is taken";
                self.warnings.warn(object.location.clone(), reason)?;
                let factor = mean(&b);
                (a, factor)
            }
        };
        texture.scaled(factor).map_err(|error| object.caused(error))
    }

    /// The map from texture coordinates to those of a texture; `None` if it is none of uv.
    fn mapping(&mut self, object: &Object) -> Result<Option<DAffine2>, Error> {
        if !matches!(object.text("mapping")?, None | Some("uv")) {
            return Ok(None);
        }
        let pair = |u: &str, v: &str, default: f64| -> Result<DVec2, Error> {
            Ok(DVec2::new(object.number_or(u, default)?, object.number_or(v, default)?))
        };
        let scale = pair("uscale", "vscale", 1.0)?;
        let offset = pair("udelta", "vdelta", 0.0)?;
        let matrix = DMat2::from_diagonal(scale);
        Ok(Some(DAffine2::from_mat2_translation(matrix, offset)))
    }

    fn image_map(&mut self, sort: Sort, object: &Object) -> Result<Texture, Error> {
        object.ignore(&["maxanisotropy", "trilinear"]);
        let interpolation = match object.text("filter")? {
            Some("point") => Interpolation::Nearest,
            _ => Interpolation::Bilinear,
        };
        let wrap = match object.text("wrap")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                let reason = format!("the wrap mode \"{other}\" is clamp instead");
                self.warnings.warn(object.location.clone(), reason)?;
                Wrap::Clamp
            }
        };
        let encoding = match object.text("encoding")? {
            None => object.truth("gamma").unwrap_or(None).map_or(Encoding::Srgb, |is| {
                if is { Encoding::Srgb } else { Encoding::Gamma(1.0) }
            }),
            Some("sRGB") => Encoding::Srgb,
            Some("linear") => Encoding::Gamma(1.0),
            Some(other) => {
                let gamma = other.strip_prefix("gamma").and_then(|gamma| gamma.trim().parse().ok());
                Encoding::Gamma(gamma.filter(|gamma: &f64| *gamma > 0.0).ok_or_else(|| {
                    object.error(format!("the encoding \"{other}\" is not known"))
                })?)
            }
        };
        let scale = object.number_or("scale", 1.0)?;
        let is_inverted = object.truth("invert")?.unwrap_or(false);
        let name =
            object.text("filename")?.ok_or_else(|| object.error("the filename is missing"))?;
        let key = format!("{sort:?} {encoding:?} {scale} {is_inverted} {name}");
        let bitmap = match self.images.get(&key) {
            Some(bitmap) => bitmap.clone(),
            None => {
                let mut image = self.image(object, name, encoding)?;
                for pixel in image.pixels_mut() {
                    let value = *pixel * scale;
                    let value = if is_inverted { Rgb::WHITE - value } else { value };
                    *pixel = match sort {
                        Sort::Float => Rgb::splat(value.mean().max(0.0)),
                        Sort::Spectrum => value.map(|c| c.clamp(0.0, 1.0)),
                    };
                }
                let bitmap = Bitmap::new(image).map_err(|error| object.caused(error))?;
                self.images.insert(key, bitmap.clone());
                bitmap
            }
        };
        let texture = bitmap.texture(interpolation, [wrap; 2]);
        match self.mapping(object)? {
            Some(to_st) => {
                texture.with_transform(upside_down() * to_st).map_err(|error| object.caused(error))
            }
            None => {
                self.is_mean(object)?;
                Ok(mean(&texture).into())
            }
        }
    }

    /// The image of a light, as linear RGB.
    pub(super) fn light_image(&mut self, object: &Object, name: &str) -> Result<Image, Error> {
        let mut image = self.image(object, name, Encoding::Srgb)?;
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = pixel.map(|c| c.max(0.0)));
        Ok(image)
    }

    /// An image of normals, as the numbers that it holds.
    pub(super) fn normals(&mut self, object: &Object, name: &str) -> Result<Texture, Error> {
        let image = self.image(object, name, Encoding::Gamma(1.0))?;
        Texture::bitmap(image, Interpolation::Bilinear, [Wrap::Repeat; 2])
            .map_err(|error| object.caused(error))
    }

    /// An image as linear RGB.
    fn image(&mut self, object: &Object, name: &str, encoding: Encoding) -> Result<Image, Error> {
        let (path, bytes) = self.files.read(name, object.location.clone())?;
        let decoded = decode(&path, bytes, &mut self.pixels_left, &object.location)?;
        let (width, height) = (decoded.width(), decoded.height());
        let mut colours = linear_colours(&decoded, encoding != Encoding::Srgb);
        if let Encoding::Gamma(gamma) = encoding
            && gamma != 1.0
        {
            colours.iter_mut().for_each(|colour| *colour = colour.map(|c| libm::pow(c, gamma)));
        }
        Image::new(width, height, colours)
            .ok_or_else(|| object.error("the image has another size than it says"))
    }

    /// Counts pixels of images.
    pub(super) fn spend_pixels(&mut self, object: &Object, pixels: u64) -> Result<(), Error> {
        let left = self.pixels_left.checked_sub(pixels);
        self.pixels_left =
            left.ok_or_else(|| object.limit("the images have more pixels than the limit admits"))?;
        Ok(())
    }
}

/// The turn between pbrt's texture coordinates, whose v goes upwards, and those of an image.
pub(super) fn upside_down() -> DAffine2 {
    DAffine2::from_mat2_translation(DMat2::from_diagonal(DVec2::new(1.0, -1.0)), DVec2::Y)
}

/// The mean colour of a texture over the unit square, from samples.
pub(super) fn mean(texture: &Texture) -> Rgb {
    if let Some(colour) = texture.as_constant() {
        return colour;
    }
    const SIDE: u32 = 64;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let all = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| DVec2::new(at(x), at(y))));
    all.map(|uv| texture.at(uv)).sum::<Rgb>() * (1.0 / f64::from(SIDE * SIDE))
}
