//! Material libraries (MTL), as they are written.

use super::statements::{self, Faults, words};
use crate::math::Rgb;
use glam::{DAffine2, DVec2};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A material as a library describes it; `None` is what it does not say.
#[derive(Clone, Debug, Default)]
pub(super) struct Description {
    pub name: String,
    /// The library, and the directory of the scene in which it is.
    pub file: Rc<PathBuf>,
    pub directory: PathBuf,
    pub line: u32,
    /// The illumination model.
    pub illum: Option<u32>,
    /// Diffuse reflectance (Kd).
    pub diffuse: Coloured,
    /// Reflectance of the highlight (Ks).
    pub specular: Coloured,
    /// Radiance (Ke).
    pub emission: Coloured,
    /// Phong's exponent (Ns).
    pub exponent: Valued,
    /// Opacity (d).
    pub opacity: Valued,
    /// Roughness (Pr), the root of α.
    pub roughness: Valued,
    /// Metalness (Pm).
    pub metalness: Valued,
    /// Index of refraction (Ni).
    pub ior: Option<f64>,
    /// Heights (bump) and normals (norm).
    pub heights: Option<Map>,
    pub normals: Option<Map>,
}

/// A colour and an image to multiply it with.
pub(super) type Coloured = (Option<Rgb>, Option<Map>);
/// A number and an image to multiply it with.
pub(super) type Valued = (Option<f64>, Option<Map>);

/// An image with its options.
#[derive(Clone, Debug)]
pub(super) struct Map {
    pub name: String,
    pub line: u32,
    pub clamp: bool,
    /// The factor of heights (-bm).
    pub scale: f64,
    /// From texture coordinates with v upwards to those of the image, with v upwards, too.
    pub to_uv: DAffine2,
    /// The channel that numbers are taken from.
    pub channel: Option<Channel>,
}

/// A channel of an image, or what is made of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    Red,
    Green,
    Blue,
    /// The alpha channel.
    Matte,
    Luminance,
}

/// Reads the materials of a library, at most `most` of them.
pub(super) fn read(
    bytes: &[u8],
    file: &Path,
    most: u64,
    faults: &mut Faults,
) -> Result<Vec<Description>, String> {
    let file = Rc::new(file.to_owned());
    let mut materials: Vec<Description> = Vec::new();
    statements::for_each(bytes, |line, keyword, rest| {
        if keyword == b"newmtl" {
            if materials.len() as u64 >= most {
                return Err("it has more materials than the limit admits".to_owned());
            }
            let name = String::from_utf8_lossy(rest).trim_end().to_owned();
            materials.push(Description {
                name,
                file: Rc::clone(&file),
                line,
                ..Description::default()
            });
            return Ok(());
        }
        let Some(material) = materials.last_mut() else {
            faults.add(line, "a statement before the first newmtl is left out");
            return Ok(());
        };
        material.statement(line, &String::from_utf8_lossy(keyword), rest, faults);
        Ok(())
    })?;
    Ok(materials)
}

impl Description {
    fn statement(&mut self, line: u32, keyword: &str, rest: &[u8], faults: &mut Faults) {
        let map = |faults: &mut Faults| map(line, keyword, rest, faults);
        let mut value = || {
            let number = words(rest).next().and_then(statements::number);
            let number = number.filter(|number: &f64| number.is_finite());
            if number.is_none() {
                faults.add(line, &format!("{keyword} is not a finite number: it is left out"));
            }
            number
        };
        match keyword {
            "Kd" => self.diffuse.0 = colour(line, keyword, rest, faults).or(self.diffuse.0),
            "Ks" => self.specular.0 = colour(line, keyword, rest, faults).or(self.specular.0),
            "Ke" => self.emission.0 = colour(line, keyword, rest, faults).or(self.emission.0),
            "Ns" => self.exponent.0 = value().or(self.exponent.0),
            "Pr" => self.roughness.0 = value().or(self.roughness.0),
            "Pm" => self.metalness.0 = value().or(self.metalness.0),
            "Ni" => self.ior = value().or(self.ior),
            "d" => match words(rest).next() {
                Some(b"-halo") => faults.add(line, "d -halo is not supported, and left out"),
                _ => self.opacity.0 = value().or(self.opacity.0),
            },
            // What d says counts, wherever it is said.
            "Tr" => {
                let opacity = value().map(|transparency| 1.0 - transparency);
                self.opacity.0 = self.opacity.0.or(opacity);
            }
            "illum" => self.illum = value().map(|number| number as u32),
            "map_Kd" => self.diffuse.1 = map(faults),
            "map_Ks" => self.specular.1 = map(faults),
            "map_Ke" => self.emission.1 = map(faults),
            "map_Ns" => self.exponent.1 = map(faults),
            "map_Pr" => self.roughness.1 = map(faults),
            "map_Pm" => self.metalness.1 = map(faults),
            "map_d" => self.opacity.1 = map(faults),
            "map_Bump" | "map_bump" | "bump" => self.heights = map(faults),
            "norm" | "map_Kn" => self.normals = map(faults),
            // Ambient light is what light transport computes; the others are about aliasing.
            "Ka" | "map_Ka" | "sharpness" | "map_aat" => {}
            "Tf" if words(rest).all(|word| statements::number(word) == Some(1.0f64)) => {}
            "Ps" | "Pc" | "Pcr" | "aniso" | "anisor"
                if words(rest).all(|word| statements::number(word) == Some(0.0f64)) => {}
            _ => {
                let keyword = keyword.get(..16).unwrap_or(keyword);
                faults.add(line, &format!("{keyword} is not supported, and left out"));
            }
        }
    }
}

/// A colour of one number or three; `None` if it is none.
fn colour(line: u32, keyword: &str, rest: &[u8], faults: &mut Faults) -> Option<Rgb> {
    let numbers: Option<Vec<f64>> = words(rest).take(3).map(statements::number).collect();
    let colour = match numbers.as_deref() {
        Some(&[grey]) => Some(Rgb::splat(grey)),
        Some(&[r, g, b]) => Some(Rgb::new(r, g, b)),
        _ => None,
    };
    let colour = colour.filter(|colour| colour.is_finite());
    if colour.is_none() {
        faults.add(line, &format!("{keyword} is not one finite number, nor three: it is left out"));
    }
    colour
}

/// The file name of a map, which may contain spaces, and the options before it.
fn map(line: u32, keyword: &str, rest: &[u8], faults: &mut Faults) -> Option<Map> {
    let text = String::from_utf8_lossy(rest);
    let mut map = Map {
        name: String::new(),
        line,
        clamp: false,
        scale: 1.0,
        to_uv: DAffine2::IDENTITY,
        channel: None,
    };
    let (mut scale, mut offset) = (DVec2::ONE, DVec2::ZERO);
    let mut left = text.trim();
    let word = |left: &mut &str| {
        let (word, rest) = left.split_once(char::is_whitespace).unwrap_or((left, ""));
        let word = word.to_owned();
        *left = rest.trim_start();
        word
    };
    while left.starts_with('-') {
        let option = word(&mut left);
        let mut unsupported = |values: &str| {
            faults.add(line, &format!("the option {option}{values} of {keyword} is left out"));
        };
        match option.as_str() {
            "-o" | "-s" | "-t" => {
                // One to three numbers.
                let mut numbers = [None; 3];
                for number in &mut numbers {
                    let next = left.split_whitespace().next().unwrap_or("");
                    *number = next.parse::<f64>().ok().filter(|number| number.is_finite());
                    match number {
                        Some(_) => drop(word(&mut left)),
                        None => break,
                    }
                }
                let or = |default: f64| {
                    DVec2::new(numbers[0].unwrap_or(default), numbers[1].unwrap_or(default))
                };
                match option.as_str() {
                    "-s" => scale = or(1.0),
                    "-o" => offset = or(0.0),
                    _ => unsupported(""),
                }
            }
            "-bm" => {
                let scale = word(&mut left).parse().ok().filter(|scale: &f64| scale.is_finite());
                map.scale = scale.unwrap_or(1.0);
            }
            "-clamp" => map.clamp = word(&mut left) == "on",
            "-imfchan" => {
                map.channel = match word(&mut left).as_str() {
                    "r" => Some(Channel::Red),
                    "g" => Some(Channel::Green),
                    "b" => Some(Channel::Blue),
                    "m" => Some(Channel::Matte),
                    "l" => Some(Channel::Luminance),
                    other => {
                        unsupported(&format!(" {other}"));
                        None
                    }
                }
            }
            "-mm" => {
                let values = [word(&mut left), word(&mut left)];
                if values.each_ref().map(|value| value.parse::<f64>()) != [Ok(0.0), Ok(1.0)] {
                    unsupported("");
                }
            }
            // They are about how an image is filtered.
            "-blendu" | "-blendv" | "-boost" | "-texres" => drop(word(&mut left)),
            _ => {
                unsupported("");
                word(&mut left);
            }
        }
    }
    if left.is_empty() {
        faults.add(line, &format!("{keyword} names no file: it is left out"));
        return None;
    }
    map.name = left.to_owned();
    map.to_uv = DAffine2::from_scale_angle_translation(scale, 0.0, offset);
    Some(map)
}
