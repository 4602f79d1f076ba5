//! Lights that are not surfaces, and the units of all lights.
//!
//! pbrt divides a light by the luminance of its spectrum, or, where that is given as RGB, by the
//! luminance of white in its colour space; and its film counts luminance. So RGB is what a film
//! without a scale records, and any other spectrum has the luminance 1 (one nit, before `scale` and
//! `power`), whatever its magnitude in the file.

use super::super::Error;
use super::Loader;
use super::object::Object;
use crate::endpoint::{
    ConstantEnvironment, DirectionalLight, EndpointError, EnvironmentMap, Light, PointLight,
    SpotLight,
};
use crate::film::Image;
use crate::math::Rgb;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The axes of a latitude-longitude image of the crate in those of a light of pbrt, whose up axis
/// is z and whose azimuth goes from x to y: as seen from inside, images there are mirrored.
const TO_LIGHT: DMat3 = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::NEG_X);

/// What arrives from all sides: a colour, and an image with its axes.
#[derive(Default)]
pub(super) struct Environment {
    constant: Rgb,
    image: Option<(Image, DMat3)>,
}

impl Loader {
    /// Adds a light of the scene.
    pub(super) fn light_source(&mut self, object: &Object) -> Result<(), Error> {
        let made = |error: EndpointError| object.caused(error);
        let to_world = self.state.to_world;
        let from = object.point("from")?.unwrap_or(DVec3::ZERO);
        let to = object.point("to")?.unwrap_or(DVec3::Z);
        let position = to_world.transform_point3(from);
        let direction = to_world.transform_vector3(to - from);
        let power = object.number("power")?.filter(|power| *power > 0.0);
        let scale = self.light_scale(object)?;
        match object.kind.as_str() {
            "point" => {
                let scale = scale * power.map_or(1.0, |power| power / (4.0 * PI));
                let intensity = self.emitted(object, "I")? * scale;
                self.add_light(object, PointLight::new(position, intensity).map_err(made)?)?;
            }
            "spot" => {
                let outer = object.number_or("coneangle", 30.0)?;
                let inner = (outer - object.number_or("conedeltaangle", 5.0)?).max(0.0);
                let [start, end] = [inner, outer].map(|angle| libm::cos(angle.to_radians()));
                let cone = TAU * ((1.0 - start) + 0.5 * (start - end));
                let intensity =
                    self.emitted(object, "I")? * scale * power.map_or(1.0, |power| power / cone);
                let light = SpotLight::new(position, direction, intensity, inner, outer);
                self.add_light(object, light.map_err(made)?)?;
            }
            "distant" => {
                let illuminance = object.number("illuminance")?.filter(|value| *value > 0.0);
                let irradiance = self.emitted(object, "L")? * scale * illuminance.unwrap_or(1.0);
                self.add_light(
                    object,
                    DirectionalLight::new(direction, irradiance).map_err(made)?,
                )?;
            }
            "infinite" => self.infinite(object, scale)?,
            "goniometric" | "projection" => self.imaged(object, position, scale, power)?,
            other => {
                let reason = format!("lights of type {other} are not supported, and left out");
                return self.warnings.warn(object.location.clone(), reason);
            }
        }
        object.ignore(&["samples", "nsamples", "from", "to", "power"]);
        object.finish(&mut self.warnings)
    }

    /// The colour of a light, white if it has none.
    pub(super) fn emitted(&mut self, object: &Object, name: &str) -> Result<Rgb, Error> {
        match object.get(name) {
            Some(parameter) => Ok(self.spectrum(object, parameter)?.as_emission()),
            None => Ok(Rgb::WHITE),
        }
    }

    /// The factor that a light has beside its power, with that of the film. In version 3 it is a
    /// spectrum.
    pub(super) fn light_scale(&mut self, object: &Object) -> Result<Rgb, Error> {
        Ok(match object.get("scale") {
            Some(parameter) if parameter.kind == "float" => {
                Rgb::splat(object.number_or("scale", 1.0)?)
            }
            Some(parameter) => self.spectrum(object, parameter)?.as_emission(),
            None => Rgb::WHITE,
        } * self.exposure)
    }

    fn add_light(
        &mut self,
        object: &Object,
        light: impl Light + Send + 'static,
    ) -> Result<(), Error> {
        self.lights += 1;
        let name = format!("{} light {}", object.kind, self.lights);
        self.builder.add_light(name, light).map_err(|error| object.caused(error))
    }

    /// Light from all sides. That of several lights of one colour is summed up.
    fn infinite(&mut self, object: &Object, scale: Rgb) -> Result<(), Error> {
        let illuminance = object.number("illuminance")?.filter(|value| *value > 0.0);
        if object.get("portal").is_some() {
            let reason = "portals are not supported: light arrives from everywhere";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let (name, is_old) = match (object.text("filename")?, object.text("mapname")?) {
            (Some(name), _) => (name, false),
            (None, Some(name)) => (name, true),
            (None, None) => {
                let radiance = self.emitted(object, "L")? * scale;
                self.environment.constant += radiance * illuminance.map_or(1.0, |e| e / PI);
                return Ok(());
            }
        };
        if self.environment.image.is_some() {
            return Err(object.error("a second image of an environment is not supported"));
        }
        let image = self.light_image(object, name)?;
        let is_square = image.width() == image.height();
        if !is_old && !is_square {
            let reason = "an image that is not square is taken to be of latitude and longitude";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let mut scale = if is_old { scale * self.emitted(object, "L")? } else { scale };
        let mut image = if !is_old && is_square {
            if let Some(illuminance) = illuminance {
                scale *= illuminance / upper_illuminance(&image);
            }
            let pixels = 2 * u64::from(image.width()) * u64::from(image.width());
            self.spend_pixels(object, pixels)?;
            latitude_longitude(&image)
        } else {
            image
        };
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel *= scale);
        let axes = self.rotation(object)? * TO_LIGHT;
        self.environment.image = Some((image, axes));
        Ok(())
    }

    /// The rotation of a light, without scale.
    fn rotation(&mut self, object: &Object) -> Result<DMat3, Error> {
        let matrix = self.state.to_world.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::normalize_or_zero);
        // The nearest that keeps z and the side of y.
        let across = z.cross(x).normalize_or_zero();
        let along = across.cross(z);
        let side = if across.dot(y) < 0.0 { -1.0 } else { 1.0 };
        let rotation = DMat3::from_cols(along, across * side, z);
        let error =
            (rotation.transpose() * DMat3::from_cols(x, y, z) - DMat3::IDENTITY).to_cols_array();
        if error.iter().any(|e| e.abs() > 1e-4) {
            let reason = "the transform of the light is no rotation; the nearest one is taken";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        Ok(rotation)
    }

    /// A light that shines an image, as one without it that is as bright.
    fn imaged(
        &mut self,
        object: &Object,
        position: DVec3,
        scale: Rgb,
        power: Option<f64>,
    ) -> Result<(), Error> {
        let reason = "a light that shines an image is not supported: the image's mean is taken";
        self.warnings.warn(object.location.clone(), reason)?;
        let made = |error: EndpointError| object.caused(error);
        let name = object.text("filename")?.or(object.text("mapname")?);
        let mean = match name {
            Some(name) => self.light_image(object, name)?.mean(),
            None => Rgb::WHITE,
        };
        if object.kind == "goniometric" {
            let colour = self.emitted(object, "I")? * scale;
            let factor = power.map_or(mean.mean(), |power| power / (4.0 * PI));
            self.add_light(object, PointLight::new(position, colour * factor).map_err(made)?)
        } else {
            let angle = 0.5 * object.number_or("fov", 90.0)?;
            let cone = TAU * (1.0 - libm::cos(angle.to_radians()));
            let factor = power.map_or(1.0, |power| power / (cone * mean.luminance()));
            let axis = self.state.to_world.transform_vector3(DVec3::Z);
            let intensity = mean * scale * factor;
            let light = SpotLight::new(position, axis, intensity, angle, angle);
            self.add_light(object, light.map_err(made)?)
        }
    }

    /// Adds what arrives from all sides.
    pub(super) fn surround(&mut self) -> Result<(), Error> {
        if let Some(light) = self.options.environment.light()? {
            let set = self.builder.set_environment("environment", light);
            return set.map(|_| ()).map_err(|error| Error::caused(self.location(), error));
        }
        let Environment { constant, image } = std::mem::take(&mut self.environment);
        if self.options.environment == crate::import::Environment::None {
            return Ok(());
        }
        let name = "infinite light";
        let location = self.location();
        let made = |error: EndpointError| Error::caused(location.clone(), error);
        let set = match image {
            Some((image, axes)) => {
                let pixels = image.pixels().iter().map(|pixel| *pixel + constant).collect();
                let map = EnvironmentMap::new(image.width(), image.height(), pixels, axes);
                self.builder.set_environment(name, map.map_err(made)?)
            }
            None if constant.is_black() => return Ok(()),
            None => {
                let light = ConstantEnvironment::new(constant).map_err(made)?;
                self.builder.set_environment(name, light)
            }
        };
        set.map_err(|error| Error::caused(location.clone(), error))
    }
}

/// The illuminance that pbrt finds for an equal-area image on a plane that faces up: half of what
/// it is.
fn upper_illuminance(image: &Image) -> f64 {
    let side = image.width();
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let rows = image.pixels().chunks_exact(side as usize).zip(0..);
    let sum: f64 = rows
        .flat_map(|(row, y)| {
            row.iter().zip(0..).map(move |(pixel, x)| {
                let height = height(DVec2::new(at(x), at(y)));
                pixel.luminance() * height.max(0.0)
            })
        })
        .sum();
    sum * 2.0 * PI / f64::from(side).powi(2)
}

/// The height z of the direction that a point of the square stands for (Clarberg 2008): the square
/// is folded to an octahedron with z up in its middle, each part of which has its share of the
/// sphere's area.
fn height(p: DVec2) -> f64 {
    let q = (2.0 * p - 1.0).abs();
    let distance = 1.0 - (q.x + q.y);
    let r = 1.0 - distance.abs();
    (1.0 - r * r).copysign(distance)
}

/// The image of latitude and longitude of a square one in that map: each pixel is the mean of
/// samples that have the same solid angle. Pixels are as fine as there, so that what is sharp stays
/// so, and the light of a single pixel is kept to about 1 %.
fn latitude_longitude(image: &Image) -> Image {
    let side = image.width();
    let samples = (4096 / side).clamp(4, 16);
    let (width, height) = (2 * side, side);
    let last = f64::from(side - 1);
    let index = |x: f64| (f64::from(side) * x).clamp(0.0, last) as usize;
    let column = |x: u32, i: u32| {
        // Azimuth in quarter turns.
        let at = f64::from(x) + (f64::from(i) + 0.5) / f64::from(samples);
        let turn = 4.0 * at / f64::from(width);
        // A point of the quadrant where both coordinates are positive, 0 at its x axis.
        let (quadrant, within) = (turn as u32 % 4, turn.fract());
        let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][quadrant as usize];
        let part = if quadrant.is_multiple_of(2) { within } else { 1.0 - within };
        (DVec2::from(signs), part)
    };
    Image::from_fn(width, height, |x, y| {
        // cos θ is uniform within the pixel's band.
        let edge = |row: u32| libm::cos(PI * f64::from(row) / f64::from(height));
        let (upper, lower) = (edge(y), edge(y + 1));
        let mut sum = Rgb::BLACK;
        for j in 0..samples {
            let z = upper + (lower - upper) * (f64::from(j) + 0.5) / f64::from(samples);
            let r = (1.0 - z.abs()).max(0.0).sqrt();
            for i in 0..samples {
                let (signs, part) = column(x, i);
                let mut p = DVec2::new(r * (1.0 - part), r * part);
                if z < 0.0 {
                    p = DVec2::new(1.0 - p.y, 1.0 - p.x);
                }
                let p = 0.5 + 0.5 * signs * p;
                sum += image.pixels()[index(p.y) * side as usize + index(p.x)];
            }
        }
        sum * (1.0 / f64::from(samples * samples))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The direction of a point of the square (Clarberg 2008), the inverse of what
    /// [`latitude_longitude`] does.
    fn direction(p: DVec2) -> DVec3 {
        let q = (2.0 * p - 1.0).abs();
        let r = 1.0 - (1.0 - q.x - q.y).abs();
        let azimuth = if r == 0.0 { PI / 4.0 } else { ((q.y - q.x) / r + 1.0) * PI / 4.0 };
        let (sin, cos) = azimuth.sin_cos();
        let radius = r * (2.0 - r * r).sqrt();
        let sign = |x: f64| 1f64.copysign(x - 0.5);
        DVec3::new(cos * sign(p.x) * radius, sin * sign(p.y) * radius, height(p))
    }

    /// One pixel after the other is white: it is seen where it should be, with its solid angle.
    #[test]
    fn equal_area_images_keep_their_light_and_its_place() {
        const SIDE: u32 = 8;
        for y in 0..SIDE {
            for x in 0..SIDE {
                let white = |u: u32, v: u32| Rgb::splat(f64::from(u8::from((u, v) == (x, y))));
                let image = latitude_longitude(&Image::from_fn(SIDE, SIDE, white));
                let map = EnvironmentMap::new(
                    image.width(),
                    image.height(),
                    image.pixels().to_vec(),
                    TO_LIGHT,
                )
                .expect("valid");
                let p = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / f64::from(SIDE);
                // A cell of the map is about as large as a pixel and may show two of them.
                assert!(map.radiance(direction(p)).r() > 0.45, "{x}, {y}");
                let mut integral = 0.0;
                for (row, pixels) in image.pixels().chunks_exact(2 * SIDE as usize).enumerate() {
                    let edge = |row: usize| (PI * row as f64 / f64::from(SIDE)).cos();
                    let band = edge(row) - edge(row + 1);
                    let width = TAU / f64::from(2 * SIDE);
                    integral += band * width * pixels.iter().map(|p| p.r()).sum::<f64>();
                }
                let expected = 4.0 * PI / f64::from(SIDE * SIDE);
                assert!((integral / expected - 1.0).abs() < 0.02, "{x}, {y}: {integral}");
            }
        }
    }
}
