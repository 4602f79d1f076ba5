//! Parameters of an object: numbers, vectors, colours and transforms, each read once, so that what
//! nobody has asked for can be told.

use super::super::{Error, Warnings};
use super::document::Element;
use super::spectrum::{self, Illuminant};
use crate::film::linear_from_srgb;
use crate::math::{Rgb, unit};
use glam::{DAffine3, DMat4, DVec3, DVec4};
use std::cell::RefCell;

/// An element with parameters.
pub(super) struct Object<'a> {
    pub element: &'a Element,
    used: RefCell<Vec<bool>>,
}

/// Elements that are values, not objects of their own.
const VALUES: [&str; 12] = [
    "float",
    "integer",
    "boolean",
    "string",
    "point",
    "vector",
    "transform",
    "rgb",
    "spectrum",
    "srgb",
    "blackbody",
    "translate",
];

impl<'a> Object<'a> {
    pub fn new(element: &'a Element) -> Self {
        Self { element, used: RefCell::new(vec![false; element.children.len()]) }
    }

    /// The child of a name.
    pub fn get(&self, name: &str) -> Option<&'a Element> {
        let index =
            self.element.children.iter().position(|child| child.attribute("name") == Some(name))?;
        self.used.borrow_mut()[index] = true;
        Some(&self.element.children[index])
    }

    /// Children that are objects of their own: plug-ins and references. They count as read.
    pub fn objects(&self) -> Vec<&'a Element> {
        self.children(|child| !VALUES.contains(&child.tag.as_str()))
    }

    /// Those children that nobody has asked for and that are wanted. They count as read.
    pub fn children(&self, is_wanted: impl Fn(&'a Element) -> bool) -> Vec<&'a Element> {
        let mut found = Vec::new();
        for (index, child) in self.element.children.iter().enumerate() {
            if !self.used.borrow()[index] && is_wanted(child) {
                self.used.borrow_mut()[index] = true;
                found.push(child);
            }
        }
        found
    }

    /// Warns of parameters that nobody has asked for.
    pub fn finish(&self, warnings: &mut Warnings) -> Result<(), Error> {
        for (child, used) in self.element.children.iter().zip(self.used.borrow().iter()) {
            if !used {
                let name = child.attribute("name").unwrap_or(&child.tag);
                warnings.warn(
                    self.element.location(),
                    format!(
                        "the parameter {name} (line {}) is not supported here and left out",
                        child.line()
                    ),
                )?;
            }
        }
        Ok(())
    }

    /// Takes note of parameters that change nothing in this crate.
    pub fn ignore(&self, names: &[&str]) {
        for name in names {
            let _ = self.get(name);
        }
    }

    fn typed(&self, name: &str, tags: &[&str]) -> Result<Option<&'a str>, Error> {
        let Some(child) = self.get(name) else { return Ok(None) };
        if !tags.contains(&child.tag.as_str()) {
            return Err(child.error(format!("must be a {}", tags[0])));
        }
        child.required("value").map(Some)
    }

    pub fn string(&self, name: &str) -> Result<Option<&'a str>, Error> {
        self.typed(name, &["string"])
    }

    pub fn boolean(&self, name: &str) -> Result<Option<bool>, Error> {
        let Some(text) = self.typed(name, &["boolean"])? else { return Ok(None) };
        match text.trim() {
            value if value.eq_ignore_ascii_case("true") => Ok(Some(true)),
            value if value.eq_ignore_ascii_case("false") => Ok(Some(false)),
            other => {
                Err(self.element.error(format!("{name} is \"{other}\", but must be true or false")))
            }
        }
    }

    pub fn integer(&self, name: &str) -> Result<Option<i64>, Error> {
        let Some(text) = self.typed(name, &["integer"])? else { return Ok(None) };
        text.trim().parse().map(Some).map_err(|_| {
            self.element.error(format!("{name} is \"{text}\", but must be an integer"))
        })
    }

    pub fn float(&self, name: &str) -> Result<Option<f64>, Error> {
        let Some(text) = self.typed(name, &["float", "integer"])? else { return Ok(None) };
        number(self.element, text).map(Some)
    }

    pub fn float_or(&self, name: &str, default: f64) -> Result<f64, Error> {
        Ok(self.float(name)?.unwrap_or(default))
    }

    /// A point or vector.
    pub fn vector(&self, name: &str) -> Result<Option<DVec3>, Error> {
        let Some(child) = self.get(name) else { return Ok(None) };
        if !matches!(child.tag.as_str(), "point" | "vector") {
            return Err(child.error("must be a point or a vector"));
        }
        components(child, 0.0).map(Some)
    }

    /// The transform of a name, the identity if there is none. Its last row must be that of an
    /// affine one.
    pub fn transform(&self, name: &str) -> Result<DAffine3, Error> {
        let Some(child) = self.get(name) else { return Ok(DAffine3::IDENTITY) };
        if child.tag != "transform" {
            return Err(child.error("must be a transform"));
        }
        transform(child)
    }
}

/// A finite number.
pub(super) fn number(element: &Element, text: &str) -> Result<f64, Error> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| element.error(format!("\"{text}\" is not a finite number")))
}

/// Finite numbers, separated by commas or blanks.
pub(super) fn numbers(element: &Element, text: &str) -> Result<Vec<f64>, Error> {
    let parts = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|part| !part.is_empty());
    parts.map(|part| number(element, part)).collect()
}

/// Three numbers in `value`, or x, y and z.
fn components(element: &Element, default: f64) -> Result<DVec3, Error> {
    if let Some(text) = element.attribute("value") {
        return three(element, text);
    }
    let component =
        |name: &str| element.attribute(name).map_or(Ok(default), |text| number(element, text));
    Ok(DVec3::new(component("x")?, component("y")?, component("z")?))
}

/// Three numbers, or one for all.
fn three(element: &Element, text: &str) -> Result<DVec3, Error> {
    match numbers(element, text)?[..] {
        [x] => Ok(DVec3::splat(x)),
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(element.error(format!("\"{text}\" is not one number or three"))),
    }
}

/// The transforms in an element, the first of them applied first.
fn transform(element: &Element) -> Result<DAffine3, Error> {
    let mut total = DMat4::IDENTITY;
    for step in &element.children {
        let matrix = match step.tag.as_str() {
            "translate" => DMat4::from_translation(components(step, 0.0)?),
            "scale" => DMat4::from_scale(components(step, 1.0)?),
            "rotate" => {
                let axis = components(step, 0.0)?;
                let angle = number(step, step.required("angle")?)?;
                match unit(axis) {
                    Some(axis) => DMat4::from_axis_angle(axis, angle.to_radians()),
                    // Nothing is turned, about whatever axis.
                    None if angle == 0.0 => DMat4::IDENTITY,
                    None => return Err(step.error("the axis has length zero")),
                }
            }
            "lookat" => look_at(step)?,
            "matrix" => matrix(step)?,
            other => return Err(step.error(format!("{other} is not a transform"))),
        };
        total = matrix * total;
    }
    let last = total.row(3);
    if !total.is_finite() || last.truncate() != DVec3::ZERO || last.w == 0.0 {
        return Err(element.error("the transform is not finite or not affine"));
    }
    Ok(DAffine3::from_mat4(total * (1.0 / last.w)))
}

/// Row by row; 3 × 3 matrices have no translation.
fn matrix(element: &Element) -> Result<DMat4, Error> {
    let values = numbers(element, element.required("value")?)?;
    match values.len() {
        16 => Ok(DMat4::from_cols_slice(&values).transpose()),
        9 => {
            let row =
                |i: usize| DVec4::new(values[3 * i], values[3 * i + 1], values[3 * i + 2], 0.0);
            Ok(DMat4::from_cols(row(0), row(1), row(2), DVec4::W).transpose())
        }
        n => Err(element.error(format!("a matrix has 16 or 9 numbers, but this one has {n}"))),
    }
}

/// The map to the world from a camera's space, which looks along z with y up and x to the *left* in
/// the image.
fn look_at(element: &Element) -> Result<DMat4, Error> {
    let point = |name: &str| three(element, element.required(name)?);
    let (origin, target) = (point("origin")?, point("target")?);
    let forward =
        unit(target - origin).ok_or_else(|| element.error("origin and target are the same"))?;
    let up = match element.attribute("up") {
        Some(text) => three(element, text)?,
        // Any direction that is not along the view.
        None => forward.any_orthonormal_vector(),
    };
    let left =
        unit(up.cross(forward)).ok_or_else(|| element.error("up is zero or along the view"))?;
    Ok(DMat4::from_cols(
        left.extend(0.0),
        forward.cross(left).extend(0.0),
        forward.extend(0.0),
        origin.extend(1.0),
    ))
}

/// The colour of an `<rgb>`, an `<srgb>`, a `<float>`, or a `<spectrum>` that is the same
/// everywhere.
pub(super) fn colour(element: &Element, illuminant: Illuminant) -> Result<Rgb, Error> {
    let text = element.required("value")?;
    match element.tag.as_str() {
        "float" | "integer" => number(element, text).map(Rgb::splat),
        "rgb" => three(element, text).map(|v| Rgb(v.to_array())),
        "srgb" => {
            let encoded = match text.trim().strip_prefix('#').map(|text| (text.len(), text)) {
                Some((6, text)) => {
                    let code = u32::from_str_radix(text, 16).map_err(|e| element.caused(e))?;
                    let [_, levels @ ..] = code.to_be_bytes();
                    levels.map(|level| f64::from(level) / 255.0)
                }
                _ => three(element, text)?.to_array(),
            };
            Ok(Rgb(encoded.map(linear_from_srgb)))
        }
        "spectrum" => {
            let value = number(element, text)?;
            let constant = [(360.0, value), (830.0, value)];
            Ok(if illuminant == Illuminant::Equal {
                spectrum::to_rgb(&constant, illuminant)
            } else {
                Rgb::splat(value)
            })
        }
        other => Err(element.error(format!("a {other} is not a colour"))),
    }
}

/// The colour of a spectrum's values.
pub(super) fn listed_colour(
    element: &Element,
    spectrum: &[(f64, f64)],
    illuminant: Illuminant,
    warnings: &mut Warnings,
) -> Result<Rgb, Error> {
    let colour = spectrum::to_rgb(spectrum, illuminant);
    let greatest =
        if illuminant == Illuminant::D65 && spectrum.iter().all(|(_, value)| *value <= 1.0) {
            1.0
        } else {
            f64::INFINITY
        };
    let inside = colour.map(|c| c.clamp(0.0, greatest));
    if (0..3).any(|i| (colour[i] - inside[i]).abs() > 1e-3 * colour.max_component().max(1e-3)) {
        warnings.warn(
            element.location(),
            format!("the spectrum is outside of the colours of sRGB: {:?} is clipped", colour.0),
        )?;
    }
    Ok(inside)
}

/// Wavelengths in nanometres with values: "400:0.1, 500:0.2" in an attribute, or lines of a file
/// with two numbers each, where # begins a comment.
pub(super) fn wavelengths(
    element: &Element,
    text: &str,
    in_file: bool,
) -> Result<Vec<(f64, f64)>, Error> {
    let pairs: Vec<(&str, &str)> = if in_file {
        let lines = text
            .lines()
            .map(|line| line.split('#').next().unwrap_or("").trim())
            .filter(|line| !line.is_empty());
        lines.map(|line| line.split_once(char::is_whitespace).unwrap_or((line, ""))).collect()
    } else {
        let parts =
            text.split(|c: char| c == ',' || c.is_whitespace()).filter(|part| !part.is_empty());
        let wrong = |part: &str| element.error(format!("\"{part}\" is not wavelength:value"));
        parts
            .map(|part| part.split_once(':').ok_or_else(|| wrong(part)))
            .collect::<Result<_, _>>()?
    };
    let mut spectrum: Vec<(f64, f64)> = Vec::with_capacity(pairs.len());
    for (wavelength, value) in pairs {
        let (wavelength, value) = (number(element, wavelength)?, number(element, value)?);
        if spectrum.last().is_some_and(|(before, _)| *before >= wavelength) {
            return Err(element.error("wavelengths must rise"));
        }
        spectrum.push((wavelength, value));
    }
    Ok(spectrum)
}
