//! Textures, and colours in their place.

use super::super::Error;
use super::Loader;
use super::document::Element;
use super::spectrum::{self, FIRST_VISIBLE, Illuminant, LAST_VISIBLE, planck};
use super::values::{Object, colour, listed_colour, number, numbers, wavelengths};
use crate::material::{Interpolation, Texture, VertexFactor, Wrap};
use crate::math::Rgb;
use glam::{DAffine2, DMat2, DVec2};

impl<'a> Loader<'a> {
    /// The colour or texture of a name; `None` if there is none.
    pub(super) fn texture(
        &mut self,
        object: &Object<'a>,
        name: &str,
        illuminant: Illuminant,
    ) -> Result<Option<Texture>, Error> {
        let Some(element) = object.get(name) else { return Ok(None) };
        let texture = self.texture_of(element, illuminant);
        let instead = format!("the {name} is as if it were not given");
        let texture = self.warnings.rescue(texture, &instead)?;
        if !is_share(name) {
            return Ok(texture);
        }
        texture.map(|texture| self.share(object.element, name, texture)).transpose()
    }

    /// A texture whose colours are parts of a whole.
    fn share(
        &mut self,
        element: &'a Element,
        name: &str,
        texture: Texture,
    ) -> Result<Texture, Error> {
        if texture.is_within(0.0, 1.0) {
            return Ok(texture);
        }
        let [least, greatest] =
            texture.range().map(|colour| colour.0.map(|c| c.to_string()).join(", "));
        let is_above = texture.is_within(0.0, f64::INFINITY);
        let shown = if is_above { greatest } else { least };
        self.warn(element, format!("{name} must be in [0, 1], but is {shown}: it is clamped"))?;
        texture.clamped(0.0, 1.0).map_err(|error| element.caused(error))
    }

    /// The colour of a name, which must not vary; `None` if there is none.
    pub(super) fn colour(
        &mut self,
        object: &Object<'a>,
        name: &str,
        illuminant: Illuminant,
    ) -> Result<Option<Rgb>, Error> {
        let Some(element) = object.get(name) else { return Ok(None) };
        let Some(texture) = self.texture(object, name, illuminant)? else { return Ok(None) };
        let colour =
            texture.as_constant().ok_or_else(|| element.error("must not be a texture here"));
        self.warnings.rescue(colour, &format!("the {name} is as if it were not given"))
    }

    pub(super) fn texture_of(
        &mut self,
        element: &'a Element,
        illuminant: Illuminant,
    ) -> Result<Texture, Error> {
        let element = self.resolved(element)?;
        if let Some(spectrum) = self.spectrum(element)? {
            return listed_colour(element, &spectrum, illuminant, &mut self.warnings)
                .map(Texture::from);
        }
        if element.tag != "texture" && !is_spectrum_plug_in(element) {
            return colour(element, illuminant).map(Texture::from);
        }
        let key = (std::ptr::from_ref(element), illuminant == Illuminant::Equal);
        if let Some(texture) = self.textures.get(&key) {
            return Ok(texture.clone());
        }
        let object = Object::new(element);
        let texture = match element.kind() {
            // The latter in scene versions before 0.4.
            "bitmap" | "ldrtexture" | "exrtexture" => self.bitmap(&object)?,
            "checkerboard" => {
                let mut square = |name: &str, default: f64| -> Result<Rgb, Error> {
                    Ok(self.colour(&object, name, illuminant)?.unwrap_or(Rgb::splat(default)))
                };
                Texture::checkerboard(square("color0", 0.4)?, square("color1", 0.2)?)
            }
            "mesh_attribute" => {
                let scale = object.float_or("scale", 1.0)?;
                if object.string("name")? != Some("vertex_color") {
                    self.warn(element, "of attributes only vertex_color is known; it is 0.5")?;
                    return Ok(Rgb::splat(0.5).into());
                }
                Texture::from(Rgb::splat(scale)).with_vertex_factor(VertexFactor::Color)
            }
            // White is the colour of daylight.
            "d65" | "srgb_d65" => {
                let colour = self.colour(&object, "color", Illuminant::D65)?;
                let scale = object.float_or("scale", 1.0)?;
                (colour.unwrap_or(Rgb::WHITE) * scale).into()
            }
            "uniform" => Rgb::splat(object.float_or("value", 1.0)?).into(),
            "srgb" => self.colour(&object, "color", Illuminant::D65)?.unwrap_or(Rgb::WHITE).into(),
            "rawconstant" => match object.vector("value") {
                Ok(Some(value)) => Rgb(value.to_array()).into(),
                _ => self.colour(&object, "value", Illuminant::D65)?.unwrap_or(Rgb::WHITE).into(),
            },
            other => {
                self.warn(
                    element,
                    format!("textures of type {other} are not supported; it is 0.5 everywhere"),
                )?;
                return Ok(Rgb::splat(0.5).into());
            }
        };
        let texture = if texture.as_constant().is_some() {
            texture
        } else {
            texture.with_transform(to_uv(&object)?).map_err(|error| element.caused(error))?
        };
        object.finish(&mut self.warnings)?;
        self.textures.insert(key, texture.clone());
        Ok(texture)
    }

    /// The values of a spectrum that has a list or a file of them or follows a law, wavelength by
    /// wavelength.
    pub(super) fn spectrum(
        &mut self,
        element: &'a Element,
    ) -> Result<Option<Vec<(f64, f64)>>, Error> {
        let element = self.resolved(element)?;
        if is_spectrum_plug_in(element) {
            return self.spectrum_plug_in(element);
        }
        if element.tag == "blackbody" {
            let text = element.required("temperature")?.trim();
            let temperature = number(element, text.trim_end_matches(['k', 'K']))?;
            let scale = element.attribute("scale").map_or(Ok(1.0), |text| number(element, text))?;
            let visible = [FIRST_VISIBLE, LAST_VISIBLE];
            return black_body(element, temperature, scale, visible).map(Some);
        }
        if element.tag != "spectrum" {
            return Ok(None);
        }
        if let Some(name) = element.attribute("filename") {
            let (_, bytes) = self.files.read(name, element.location())?;
            let text = std::str::from_utf8(&bytes).map_err(|error| element.caused(error))?;
            return wavelengths(element, text, true).map(Some);
        }
        element
            .attribute("value")
            .filter(|text| text.contains(':'))
            .map(|text| wavelengths(element, text, false))
            .transpose()
    }

    /// The same of the plug-ins that tell more than a colour.
    fn spectrum_plug_in(&mut self, element: &'a Element) -> Result<Option<Vec<(f64, f64)>>, Error> {
        let object = Object::new(element);
        let listed = |name: &str| {
            let text =
                object.string(name)?.ok_or_else(|| element.error(format!("{name} is missing")))?;
            numbers(element, text)
        };
        let bound = |name: &str, old_name: &str, default: f64| -> Result<f64, Error> {
            Ok(object.float(name)?.or(object.float(old_name)?).unwrap_or(default))
        };
        let bounds = || -> Result<[f64; 2], Error> {
            let first = bound("wavelength_min", "lambda_min", FIRST_VISIBLE)?;
            let last = bound("wavelength_max", "lambda_max", LAST_VISIBLE)?;
            if first < last {
                Ok([first, last])
            } else {
                Err(element.error("wavelength_min must be less than wavelength_max"))
            }
        };
        let spectrum: Vec<(f64, f64)> = match element.kind() {
            "regular" => {
                let (values, [first, last]) = (listed("values")?, bounds()?);
                let steps = values.len().saturating_sub(1).max(1) as f64;
                let at = |i: usize| first + (last - first) * i as f64 / steps;
                values.into_iter().enumerate().map(|(i, value)| (at(i), value)).collect()
            }
            "irregular" => {
                let (wavelengths, values) = (listed("wavelengths")?, listed("values")?);
                if wavelengths.len() != values.len() {
                    return Err(element.error("there must be as many values as wavelengths"));
                }
                wavelengths.into_iter().zip(values).collect()
            }
            "blackbody" => {
                black_body(element, object.float_or("temperature", 0.0)?, 1.0, bounds()?)?
            }
            _ => return Ok(None),
        };
        if !spectrum.is_sorted_by(|(a, _), (b, _)| a < b) {
            return Err(element.error("wavelengths must rise"));
        }
        object.finish(&mut self.warnings)?;
        Ok(Some(spectrum))
    }

    fn bitmap(&mut self, object: &Object<'a>) -> Result<Texture, Error> {
        let element = object.element;
        let interpolation = match object.string("filter_type")? {
            None | Some("bilinear") => Interpolation::Bilinear,
            Some("nearest") => Interpolation::Nearest,
            Some(other) => {
                self.warn(element, format!("the filter_type \"{other}\" is bilinear instead"))?;
                Interpolation::Bilinear
            }
        };
        let wrap = match object.string("wrap_mode")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("mirror") => Wrap::Mirror,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                self.warn(element, format!("the wrap_mode \"{other}\" is repeat instead"))?;
                Wrap::Repeat
            }
        };
        let raw = object.boolean("raw")?.unwrap_or(false);
        object.ignore(&["format", "accel"]);
        let name =
            object.string("filename")?.ok_or_else(|| element.error("the filename is missing"))?;
        Ok(self.bitmap_of(name, element, raw)?.texture(interpolation, [wrap; 2]))
    }
}

/// True for parameters whose colours are parts of a whole.
fn is_share(name: &str) -> bool {
    name.ends_with("reflectance")
        || name.ends_with("transmittance")
        || matches!(name, "opacity" | "weight" | "base_color")
}

/// The spectrum of a black body between two wavelengths, times a factor.
fn black_body(
    element: &Element,
    temperature: f64,
    scale: f64,
    [first, last]: [f64; 2],
) -> Result<Vec<(f64, f64)>, Error> {
    if temperature <= 0.0 {
        return Err(element.error("the temperature must be positive"));
    }
    let inside = spectrum::wavelengths().filter(|at| (first..=last).contains(at));
    Ok(inside.map(|at| (at, scale * planck(at, temperature))).collect())
}

/// A `<spectrum>` with a type is the same as a `<texture>` with it.
fn is_spectrum_plug_in(element: &Element) -> bool {
    matches!(element.tag.as_str(), "spectrum" | "texture") && element.attribute("type").is_some()
}

/// The transform of texture coordinates: rows and columns x, y and translation of the one in space.
fn to_uv(object: &Object<'_>) -> Result<DAffine2, Error> {
    let t = object.transform("to_uv")?;
    let linear = DMat2::from_cols(t.matrix3.x_axis.truncate(), t.matrix3.y_axis.truncate());
    Ok(DAffine2::from_mat2_translation(linear, DVec2::new(t.translation.x, t.translation.y)))
}
