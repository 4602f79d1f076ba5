//! Colours: the forms that pbrt has for spectra, and what they are as linear sRGB.

use super::super::spectrum::{
    FIRST_VISIBLE, Illuminant, LAST_VISIBLE, extended, from_xyz, planck, to_rgb, wavelengths,
};
use super::super::{Error, conductors};
use super::Loader;
use super::object::{Object, Parameter, Values, number};
use crate::math::Rgb;
use glam::{DMat3, DVec3};

/// A space that RGB colours are in, with linear values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ColourSpace {
    #[default]
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

impl ColourSpace {
    pub fn by_name(name: &str) -> Option<Self> {
        Some(match name {
            "srgb" => Self::Srgb,
            "dci-p3" => Self::DciP3,
            "rec2020" => Self::Rec2020,
            "aces2065-1" => Self::Aces,
            _ => return None,
        })
    }

    /// Chromaticities of red, green, blue and white.
    fn primaries(self) -> [[f64; 2]; 4] {
        match self {
            Self::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], WHITE],
            Self::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], WHITE],
            Self::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], WHITE],
            Self::Aces => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.321_68, 0.337_67]],
        }
    }

    /// The map from its colours to XYZ relative to its white.
    fn to_relative_xyz(self) -> DMat3 {
        let [red, green, blue, white] = self.primaries().map(xyz);
        let primaries = DMat3::from_cols(red, green, blue);
        let scale = primaries.inverse() * white;
        DMat3::from_diagonal(white.recip()) * primaries * DMat3::from_diagonal(scale)
    }

    /// A colour of this space as sRGB, so that white stays white.
    fn to_srgb(self, colour: Rgb) -> Rgb {
        if self == Self::Srgb {
            return colour;
        }
        let map = Self::Srgb.to_relative_xyz().inverse() * self.to_relative_xyz();
        Rgb((map * DVec3::from_array(colour.0)).to_array())
    }
}

/// The chromaticity of daylight (D65).
const WHITE: [f64; 2] = [0.3127, 0.3290];

/// XYZ with Y = 1 of a chromaticity.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// A spectrum as a file describes it.
pub(super) enum Spectrum {
    Rgb(Rgb),
    /// Wavelengths in nanometres, rising, with values.
    Listed(Vec<(f64, f64)>),
    /// A black body: its temperature in kelvins, and a factor.
    Blackbody(f64, f64),
    /// A light source that is known by the colour of what is white in it.
    Source(Rgb),
    /// An index of refraction at 587.6 nm.
    Glass(f64),
    /// n and k of a metal.
    Metal([Rgb; 2]),
}

impl Spectrum {
    /// The colour of a surface with this reflectance.
    pub fn as_reflectance(&self) -> Rgb {
        let colour = match self {
            Self::Rgb(colour) | Self::Source(colour) => *colour,
            Self::Listed(values) => to_rgb(values, Illuminant::D65),
            Self::Blackbody(..) => {
                let colour = self.as_emission();
                colour / colour.max_component()
            }
            Self::Glass(index) => Rgb::splat(*index),
            Self::Metal([n, _]) => *n,
        };
        colour.map(|c| c.clamp(0.0, 1.0))
    }

    /// The colour of light of this spectrum, whose luminance is 1 unless it is given as RGB.
    pub fn as_emission(&self) -> Rgb {
        let (colour, factor) = match self {
            Self::Rgb(colour) => return colour.map(|c| c.max(0.0)),
            Self::Blackbody(temperature, factor) => {
                let values: Vec<(f64, f64)> =
                    wavelengths().map(|at| (at, planck(at, *temperature))).collect();
                (to_rgb(&values, Illuminant::Equal), *factor)
            }
            Self::Listed(values) => (to_rgb(values, Illuminant::Equal), 1.0),
            Self::Source(colour) => (*colour, 1.0),
            Self::Glass(_) | Self::Metal(_) => (Rgb::WHITE, 1.0),
        };
        let luminance = colour.luminance();
        let normal = if luminance > 0.0 { colour * (factor / luminance) } else { Rgb::BLACK };
        // Saturated spectra are outside of what the primaries can mix.
        normal.map(|c| c.max(0.0))
    }

    /// The index of refraction of a transparent material.
    pub fn as_index(&self) -> f64 {
        match self {
            Self::Listed(values) => extended(values, 587.6),
            Self::Glass(index) => *index,
            other => other.as_metal(0).mean(),
        }
    }

    /// n (`part` 0) or k (1) of a metal.
    fn as_metal(&self, part: usize) -> Rgb {
        match self {
            Self::Rgb(colour) => *colour,
            Self::Metal(indices) => indices[part],
            Self::Glass(index) => Rgb::splat(*index),
            other => other.as_reflectance(),
        }
    }
}

/// n and k of a metal that these spectra describe.
pub(super) fn metal(n: &Spectrum, k: &Spectrum) -> [Rgb; 2] {
    match (n, k) {
        (Spectrum::Listed(n), Spectrum::Listed(k)) => conductors::from_spectra(n, k),
        _ => [n.as_metal(0), k.as_metal(1)].map(|index| index.map(|c| c.max(0.0))),
    }
}

impl Loader {
    /// The spectrum of a parameter.
    pub(super) fn spectrum(
        &mut self,
        object: &Object,
        parameter: &Parameter,
    ) -> Result<Spectrum, Error> {
        let Parameter { kind, name, values, .. } = parameter;
        let wrong = || object.error(format!("{name} is no {kind}"));
        match (kind.as_str(), values) {
            ("float", Values::Numbers(values)) if values.len() == 1 => {
                Ok(Spectrum::Rgb(Rgb::splat(values[0])))
            }
            ("rgb" | "color" | "xyz", Values::Numbers(values)) => {
                let &[a, b, c] = &values[..] else { return Err(wrong()) };
                Ok(Spectrum::Rgb(if kind == "xyz" {
                    from_xyz([a, b, c])
                } else {
                    object.colours.to_srgb(Rgb::new(a, b, c))
                }))
            }
            // Version 3 has a factor after the temperature.
            ("blackbody", Values::Numbers(values)) if matches!(values.len(), 1 | 2) => {
                let factor = values.get(1).copied().unwrap_or(1.0);
                if values[0] > 0.0 && factor >= 0.0 {
                    Ok(Spectrum::Blackbody(values[0], factor))
                } else {
                    Err(object.error("the temperature of a black body must be positive"))
                }
            }
            ("spectrum" | "blackbody", Values::Numbers(values)) => match values.as_chunks::<2>() {
                (pairs, []) => listed(object, pairs),
                _ => Err(object.error(format!("{name} must have pairs of numbers"))),
            },
            ("spectrum", Values::Texts(names)) if names.len() == 1 => {
                self.named_spectrum(object, &names[0])
            }
            _ => Err(wrong()),
        }
    }

    /// A spectrum that pbrt knows by name, or of a file.
    pub(super) fn named_spectrum(
        &mut self,
        object: &Object,
        name: &str,
    ) -> Result<Spectrum, Error> {
        if let Some(source) = name.strip_prefix("stdillum-").or(name.strip_prefix("illum-"))
            && let Some((_, chromaticity)) = SOURCES.iter().find(|row| row.0 == source)
        {
            let relative = xyz(*chromaticity) / xyz(WHITE);
            let colour = ColourSpace::Srgb.to_relative_xyz().inverse() * relative;
            return Ok(Spectrum::Source(Rgb(colour.to_array())));
        }
        if let Some(glass) = name.strip_prefix("glass-")
            && let Some((_, index)) = GLASSES.iter().find(|row| row.0 == glass)
        {
            return Ok(Spectrum::Glass(*index));
        }
        if let Some(indices) = known_metal(name) {
            return Ok(Spectrum::Metal(indices));
        }
        let (path, bytes) = self.files.read(name, object.location.clone())?;
        let text = String::from_utf8_lossy(&bytes);
        let lines = text.lines().map(|line| line.split('#').next().unwrap_or(""));
        let numbers = lines.flat_map(str::split_whitespace).map(number);
        let numbers = numbers
            .collect::<Result<Vec<f64>, String>>()
            .map_err(|reason| object.error(format!("{}: {reason}", path.display())))?;
        let Spectrum::Listed(mut values) = listed(object, numbers.as_chunks::<2>().0)? else {
            return Err(object.error("a spectrum has no values"));
        };
        // What measurements leave open is as at their ends.
        let (first, last) = (extended(&values, 0.0), extended(&values, f64::INFINITY));
        if values.first().is_some_and(|(at, _)| *at > FIRST_VISIBLE) {
            values.insert(0, (FIRST_VISIBLE, first));
        }
        if values.last().is_some_and(|(at, _)| *at < LAST_VISIBLE) {
            values.push((LAST_VISIBLE, last));
        }
        Ok(Spectrum::Listed(values))
    }
}

/// A spectrum of wavelengths and values.
fn listed(object: &Object, pairs: &[[f64; 2]]) -> Result<Spectrum, Error> {
    let values: Vec<(f64, f64)> = pairs.iter().map(|[at, value]| (*at, value.max(0.0))).collect();
    if values.is_empty() {
        return Err(object.error("a spectrum has no values"));
    }
    if !values.is_sorted_by(|(a, _), (b, _)| a < b) {
        return Err(object.error("wavelengths of a spectrum must rise"));
    }
    Ok(Spectrum::Listed(values))
}

/// n and k of "metal-Cu-eta", or of "spds/Cu.eta.spd" as in scenes of version 3.
fn known_metal(name: &str) -> Option<[Rgb; 2]> {
    let metal = match name.strip_prefix("metal-") {
        Some(rest) => rest.strip_suffix("-eta").or(rest.strip_suffix("-k"))?,
        None => {
            let stem = name.strip_suffix(".eta.spd").or(name.strip_suffix(".k.spd"))?;
            stem.rsplit('/').next()?
        }
    };
    if metal == "CuZn" { Some(BRASS.map(Rgb)) } else { conductors::by_name(metal) }
}

/// n and k of brass (70 % copper, 30 % zinc) as [`conductors::from_spectra`] gives them, from the
/// spectra that pbrt has (Querry 1985).
const BRASS: [[f64; 3]; 2] = [[0.41844, 0.52007, 1.1229], [4.0658, 2.6581, 1.8103]];

/// Indices of refraction at 587.6 nm, after the catalogue of Schott.
const GLASSES: [(&str, f64); 7] = [
    ("BK7", 1.5168),
    ("BAF10", 1.6700),
    ("FK51A", 1.4866),
    ("LASF9", 1.8503),
    ("F5", 1.6727),
    ("F10", 1.7283),
    ("F11", 1.7847),
];

/// Chromaticities of light sources (CIE 15:2004, table T.3, for the observer of 1931; ACES: SMPTE ST
/// 2065-1).
const SOURCES: [(&str, [f64; 2]); 16] = [
    ("A", [0.447_58, 0.407_45]),
    ("D50", [0.345_67, 0.358_51]),
    ("D65", WHITE),
    ("F1", [0.313_10, 0.337_27]),
    ("F2", [0.372_08, 0.375_29]),
    ("F3", [0.409_10, 0.394_30]),
    ("F4", [0.440_18, 0.403_29]),
    ("F5", [0.313_79, 0.345_31]),
    ("F6", [0.377_90, 0.388_35]),
    ("F7", [0.312_92, 0.329_33]),
    ("F8", [0.345_88, 0.358_75]),
    ("F9", [0.374_17, 0.372_81]),
    ("F10", [0.346_09, 0.359_86]),
    ("F11", [0.380_52, 0.377_13]),
    ("F12", [0.436_95, 0.404_41]),
    ("acesD60", [0.321_68, 0.337_67]),
];
