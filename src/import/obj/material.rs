//! Models of the materials that libraries describe.

use super::Loader;
use super::library::{Channel, Coloured, Description, Map, Valued};
use crate::film::Image;
use crate::import::images::{decode, linear_colours};
use crate::import::{Error, Location};
use crate::material::{Bitmap, GreenAxis, Interpolation, Material, Relief, Texture, Wrap};
use crate::math::Rgb;
use glam::{DAffine2, DVec2};
use std::collections::HashMap;

/// Diffuse reflectance where the file gives none.
pub(super) const DEFAULT_ALBEDO: f64 = 0.6;
/// Index of refraction where the file gives none.
const DEFAULT_IOR: f64 = 1.5;
/// Roughness where the file gives metalness and neither roughness nor an exponent.
const DEFAULT_ROUGHNESS: f64 = 0.5;
/// The largest exponent that the format knows: a mirror where reflections are traced.
const LARGEST_EXPONENT: f64 = 1000.0;

/// The look of a surface.
#[derive(Clone)]
pub(super) struct Look {
    pub material: Material,
    /// Radiance, if it emits.
    pub emission: Option<Texture>,
    pub relief: Option<Relief>,
    /// True if it needs texture coordinates.
    pub is_textured: bool,
}

impl Look {
    /// The look of what has no material.
    pub fn plain() -> Self {
        let material = Material::Lambert { albedo: Rgb::splat(DEFAULT_ALBEDO) };
        Self { material, emission: None, relief: None, is_textured: false }
    }
}

/// The numbers that are taken from an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Meaning {
    /// Colours, of which those of 8 or 16 bits are in the transfer function of sRGB.
    Colour,
    /// Three linear numbers.
    Numbers,
    /// Linear numbers of a channel, as grey. `None`: the alpha channel, or, if there is none, the
    /// luminance.
    Number(Option<Channel>),
}

/// Images that have been read, or failed to be.
#[derive(Debug, Default)]
pub(super) struct Bitmaps(HashMap<(String, Meaning), Option<Bitmap>>);

impl Loader {
    /// The look of a material.
    pub(super) fn look(&mut self, description: &Description) -> Result<Look, Error> {
        let location = description.location();
        let albedo = match (description.diffuse.0, &description.diffuse.1) {
            (None, None) => Rgb::splat(DEFAULT_ALBEDO).into(),
            _ => self.reflectance("Kd", &description.diffuse, description)?,
        };
        let specular = self.reflectance("Ks", &description.specular, description)?;
        let opacity = self.opacity(description)?;
        let has = |valued: &Valued| valued.0.is_some() || valued.1.is_some();
        let mut material = match description.illum {
            Some(6 | 7) => self.glass(description)?,
            _ if has(&description.roughness) || has(&description.metalness) => {
                self.metallic_roughness(description, albedo)?
            }
            Some(0 | 1) => diffuse(albedo),
            _ if specular.range()[1].is_black() => diffuse(albedo),
            _ if opacity.as_constant() != Some(Rgb::WHITE) && !albedo.range()[1].is_black() => {
                let reason = "Ks is left out of a material that is seen through in part";
                self.warnings.warn(location.clone(), reason)?;
                diffuse(albedo)
            }
            _ => self.phong(description, albedo, specular)?,
        };
        let is_glass = matches!(description.illum, Some(6 | 7));
        if !is_glass && opacity.as_constant() != Some(Rgb::WHITE) {
            material = match opacity.as_constant() {
                Some(Rgb::BLACK) => Material::Null,
                _ => Material::Blend {
                    components: Box::new([Material::Null, material]),
                    amount: opacity,
                },
            };
        }
        let emission = self.emission(description)?;
        if emission.is_some() && matches!(material, Material::Null | Material::Blend { .. }) {
            self.warnings.warn(location, "its emission is not reduced by its opacity")?;
        }
        let relief = self.relief(description)?;
        Ok(Look { material, emission, relief, is_textured: description.has_maps() })
    }

    /// Clear or frosted glass.
    fn glass(&mut self, description: &Description) -> Result<Material, Error> {
        let relative_ior = self.ior(description)?;
        let (roughness, map) = &description.roughness;
        let without = if map.is_some() { 1.0 } else { 0.0 };
        let roughness = self.share("Pr", roughness.unwrap_or(without), description)?;
        let squared = |value: f64, _| Rgb::splat((roughness * value).powi(2));
        let alpha = self.baked([map, &None], squared, description)?;
        Ok(if alpha.range()[1].is_black() {
            Material::Dielectric { relative_ior }
        } else {
            rough(|alpha| Material::RoughDielectric { relative_ior, alpha }, alpha)
        })
    }

    fn metallic_roughness(
        &mut self,
        description: &Description,
        base_color: Texture,
    ) -> Result<Material, Error> {
        let without = match (&description.roughness.1, description.exponent.0) {
            (Some(_), _) => 1.0,
            (None, Some(exponent)) => alpha(exponent).sqrt(),
            (None, None) => DEFAULT_ROUGHNESS,
        };
        let roughness = description.roughness.0.unwrap_or(without);
        let roughness = self.share("Pr", roughness, description)?;
        let without = if description.metalness.1.is_some() { 1.0 } else { 0.0 };
        let metalness = description.metalness.0.unwrap_or(without);
        let metalness = self.share("Pm", metalness, description)?;
        let maps = [&description.roughness.1, &description.metalness.1];
        let values = |rough, metal| Rgb::new(0.0, roughness * rough, metalness * metal);
        let surface = self.baked(maps, values, description)?;
        Ok(Material::MetallicRoughness {
            base_color,
            metallic_roughness: surface,
            relative_ior: self.ior(description)?,
        })
    }

    /// A diffuse surface and a lobe whose reflectance is the same at all angles, scaled so that no
    /// channel reflects more than arrives.
    fn phong(
        &mut self,
        description: &Description,
        albedo: Texture,
        specular: Texture,
    ) -> Result<Material, Error> {
        let sum = (albedo.range()[1] + specular.range()[1]).max_component();
        if sum > 1.0 + 1e-6 {
            let reason =
                format!("Kd + Ks reflect {sum:.3} times what arrives: both are divided by that");
            self.warnings.warn(description.location(), reason)?;
        }
        let greatest = |texture: &Texture| texture.range()[1].max_component();
        let weights = [greatest(&albedo), greatest(&specular)];
        let unit = |texture: Texture, weight: f64| {
            // The product of a pixel and two factors may exceed 1 by rounding.
            let room = if texture.as_constant().is_some() { 0.0 } else { 4.0 * f64::EPSILON };
            self.scaled(texture, Rgb::splat((1.0 - room) / weight), description)
        };
        if weights[0] == 0.0 {
            return self.lobe(description, specular);
        }
        let (albedo, specular) = (unit(albedo, weights[0])?, unit(specular, weights[1])?);
        Ok(Material::Mixture {
            components: Box::new([diffuse(albedo), self.lobe(description, specular)?]),
            weights: weights.map(|weight| weight / sum.max(1.0)),
        })
    }

    /// The lobe of a reflectance by the exponent; a mirror where reflections are traced and nothing
    /// blurs them.
    fn lobe(&mut self, description: &Description, reflectance: Texture) -> Result<Material, Error> {
        let (exponent, map) = &description.exponent;
        let is_traced = matches!(description.illum, Some(3 | 5 | 8));
        let is_sharp = exponent.is_none_or(|exponent| exponent >= LARGEST_EXPONENT);
        if is_traced && is_sharp && map.is_none() {
            return Ok(coloured(|reflectance| Material::Mirror { reflectance }, reflectance));
        }
        let without = if map.is_some() { 1.0 } else { 0.0 };
        let exponent = exponent.unwrap_or(without);
        let alpha = |value: f64, _| Rgb::splat(alpha(exponent * value));
        let alpha = self.baked([map, &None], alpha, description)?;
        let mirror = |reflectance| {
            rough(|alpha| Material::RoughMirror { reflectance, alpha }, alpha.clone())
        };
        Ok(coloured(mirror, reflectance))
    }

    /// The opacity in every channel.
    fn opacity(&mut self, description: &Description) -> Result<Texture, Error> {
        let (opacity, map) = &description.opacity;
        let opacity = Rgb::splat(self.share("d", opacity.unwrap_or(1.0), description)?);
        match map {
            Some(map) => self.texture(map, Meaning::Number(map.channel), opacity, description),
            None => Ok(opacity.into()),
        }
    }

    fn emission(&mut self, description: &Description) -> Result<Option<Texture>, Error> {
        let (radiance, map) = &description.emission;
        let without = if map.is_some() { Rgb::WHITE } else { Rgb::BLACK };
        let radiance = radiance.unwrap_or(without);
        if radiance.0.iter().any(|channel| *channel < 0.0) {
            let reason = "Ke is negative: it emits nothing";
            self.warnings.warn(description.location(), reason)?;
            return Ok(None);
        }
        if radiance.is_black() {
            return Ok(None);
        }
        Ok(Some(match map {
            Some(map) => self.texture(map, Meaning::Colour, radiance, description)?,
            None => radiance.into(),
        }))
    }

    /// The normal map, or else the bump map, which is a normal map, too, if it has colours.
    fn relief(&mut self, description: &Description) -> Result<Option<Relief>, Error> {
        let map = description.normals.as_ref().or(description.heights.as_ref());
        let Some(map) = map else { return Ok(None) };
        let Some(bitmap) = self.bitmap(map, Meaning::Numbers, description)? else {
            return Ok(None);
        };
        let is_grey = bitmap.image().pixels().iter().all(|p| p.r() == p.g() && p.g() == p.b());
        let texture = self.placed(bitmap, map, Rgb::WHITE, description)?;
        if description.normals.is_none() && is_grey {
            return Ok(Some(Relief::bump_map(texture, map.scale)));
        }
        if description.normals.is_none() {
            let reason = format!("{} has colours: it is taken for a normal map", map.name);
            self.warnings.warn(description.location_of(map), reason)?;
        }
        Ok(Some(Relief::normal_map(texture, 1.0, GreenAxis::AgainstV)))
    }

    fn ior(&mut self, description: &Description) -> Result<f64, Error> {
        match description.ior {
            None => Ok(DEFAULT_IOR),
            Some(ior) if ior >= 1.0 => Ok(ior.min(1e6)),
            Some(ior) => {
                let reason = format!("the index of refraction {ior} is less than 1: it is 1.5");
                self.warnings.warn(description.location(), reason)?;
                Ok(DEFAULT_IOR)
            }
        }
    }

    /// A number in [0, 1], or the nearest one that is.
    fn share(
        &mut self,
        keyword: &str,
        value: f64,
        description: &Description,
    ) -> Result<f64, Error> {
        let share = value.clamp(0.0, 1.0);
        if share != value {
            let reason = format!("{keyword} is {value}, and not in [0, 1]: it is {share}");
            self.warnings.warn(description.location(), reason)?;
        }
        Ok(share)
    }

    /// A colour in [0, 1] with its image; black if there is neither.
    fn reflectance(
        &mut self,
        keyword: &str,
        (colour, map): &Coloured,
        description: &Description,
    ) -> Result<Texture, Error> {
        let without = if map.is_some() { Rgb::WHITE } else { Rgb::BLACK };
        let colour = colour.unwrap_or(without);
        let factor = Rgb(colour.0.map(|channel| channel.clamp(0.0, 1.0)));
        if factor != colour {
            let reason = format!("{keyword} is not in [0, 1]: it is the nearest colour that is");
            self.warnings.warn(description.location(), reason)?;
        }
        let Some(map) = map else { return Ok(factor.into()) };
        let texture = self.texture(map, Meaning::Colour, factor, description)?;
        if texture.is_within(0.0, 1.0) {
            return Ok(texture);
        }
        let reason =
            format!("colours of {} are not in [0, 1]: {keyword} holds without it", map.name);
        self.warnings.warn(description.location_of(map), reason)?;
        Ok(factor.into())
    }

    /// A texture of what `values` makes of the numbers of two images; a number is 1 where its image
    /// is missing.
    fn baked(
        &mut self,
        maps: [&Option<Map>; 2],
        values: impl Fn(f64, f64) -> Rgb,
        description: &Description,
    ) -> Result<Texture, Error> {
        let [rough, metal] = maps;
        let mut images = [None, None];
        for (image, map) in images.iter_mut().zip(maps) {
            let Some(map) = map else { continue };
            let channel = map.channel.unwrap_or(Channel::Luminance);
            *image = self.bitmap(map, Meaning::Number(Some(channel)), description)?;
        }
        let shown = match (&images, rough, metal) {
            ([Some(_), _], Some(map), _) | ([None, Some(_)], _, Some(map)) => map,
            _ => return Ok(values(1.0, 1.0).into()),
        };
        if let (Some(rough), Some(metal), [Some(_), Some(_)]) = (rough, metal, &images)
            && (rough.to_uv, rough.clamp) != (metal.to_uv, metal.clamp)
        {
            let reason = format!("the options of {} are those of {}", metal.name, rough.name);
            self.warnings.warn(description.location_of(metal), reason)?;
        }
        let size = |axis: fn(&Image) -> u32| {
            images.iter().flatten().map(|bitmap: &Bitmap| axis(bitmap.image())).max().unwrap_or(1)
        };
        let (width, height) = (size(Image::width), size(Image::height));
        let textures = images.map(|image| {
            image.map(|bitmap| bitmap.texture(Interpolation::Bilinear, [Wrap::Clamp; 2]))
        });
        let image = Image::from_fn(width, height, |x, y| {
            let size = DVec2::new(f64::from(width), f64::from(height));
            let uv = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size;
            let [rough, metal] =
                textures.each_ref().map(|texture| texture.as_ref().map_or(1.0, |t| t.at(uv).r()));
            values(rough, metal)
        });
        let bitmap = Bitmap::new(image).map_err(|e| Error::caused(description.location(), e))?;
        self.placed(bitmap, shown, Rgb::WHITE, description)
    }

    /// An image times a factor; the factor alone if it cannot be read.
    fn texture(
        &mut self,
        map: &Map,
        meaning: Meaning,
        factor: Rgb,
        description: &Description,
    ) -> Result<Texture, Error> {
        match self.bitmap(map, meaning, description)? {
            Some(bitmap) => self.placed(bitmap, map, factor, description),
            None => Ok(factor.into()),
        }
    }

    fn placed(
        &mut self,
        bitmap: Bitmap,
        map: &Map,
        factor: Rgb,
        description: &Description,
    ) -> Result<Texture, Error> {
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        // Meshes have v downwards already.
        let turned = DAffine2::from_cols_array(&[1.0, 0.0, 0.0, -1.0, 0.0, 1.0]);
        let texture = bitmap
            .texture(Interpolation::Bilinear, [wrap; 2])
            .with_transform(turned * map.to_uv * turned)
            .map_err(|error| Error::caused(description.location_of(map), error))?;
        self.scaled(texture, factor, description)
    }

    fn scaled(
        &self,
        texture: Texture,
        factor: Rgb,
        description: &Description,
    ) -> Result<Texture, Error> {
        texture.scaled(factor).map_err(|error| Error::caused(description.location(), error))
    }

    /// An image; `None` if it cannot be read, which is warned of once.
    fn bitmap(
        &mut self,
        map: &Map,
        meaning: Meaning,
        description: &Description,
    ) -> Result<Option<Bitmap>, Error> {
        let key = (map.name.clone(), meaning);
        if let Some(known) = self.bitmaps.0.get(&key) {
            return Ok(known.clone());
        }
        let read = self.read_bitmap(map, meaning, description);
        let instead = match meaning {
            Meaning::Numbers => "the surface is as smooth as its shape",
            _ => "the factor holds in place of it",
        };
        let bitmap = self.warnings.rescue(read, instead)?;
        self.bitmaps.0.insert(key, bitmap.clone());
        Ok(bitmap)
    }

    fn read_bitmap(
        &mut self,
        map: &Map,
        meaning: Meaning,
        description: &Description,
    ) -> Result<Bitmap, Error> {
        let location = description.location_of(map);
        let (path, bytes) = self.fetch(&description.directory, &map.name, &location)?;
        let decoded = decode(&path, bytes, &mut self.pixels_left, &location)?;
        let (width, height) = (decoded.width(), decoded.height());
        let pixels = match meaning {
            Meaning::Colour => linear_colours(&decoded, false),
            Meaning::Numbers => linear_colours(&decoded, true),
            Meaning::Number(None | Some(Channel::Matte)) if decoded.color().has_alpha() => {
                decoded.into_rgba32f().pixels().map(|p| Rgb::splat(f64::from(p[3]))).collect()
            }
            // Without an alpha channel everything is there.
            Meaning::Number(Some(Channel::Matte)) => vec![Rgb::WHITE; (width * height) as usize],
            Meaning::Number(channel) => {
                let number = |colour: Rgb| match channel {
                    Some(Channel::Red) => colour.r(),
                    Some(Channel::Green) => colour.g(),
                    Some(Channel::Blue) => colour.b(),
                    _ => colour.luminance(),
                };
                let mut pixels = linear_colours(&decoded, true);
                pixels.iter_mut().for_each(|p| *p = Rgb::splat(number(*p).clamp(0.0, 1.0)));
                pixels
            }
        };
        let image = Image::new(width, height, pixels).ok_or_else(|| {
            Error::new(location.clone(), "the image has another size than it says")
        })?;
        Bitmap::new(image).map_err(|error| Error::caused(location, error))
    }
}

impl Description {
    pub fn location(&self) -> Location {
        Location {
            file: self.file.to_path_buf(),
            element: "material".to_owned(),
            id: Some(self.name.clone()),
            line: Some(self.line),
        }
    }

    fn location_of(&self, map: &Map) -> Location {
        Location { line: Some(map.line), ..self.location() }
    }

    fn has_maps(&self) -> bool {
        let colours = [&self.diffuse.1, &self.specular.1, &self.emission.1];
        let numbers = [&self.exponent.1, &self.opacity.1, &self.roughness.1, &self.metalness.1];
        let reliefs = [&self.heights, &self.normals];
        colours.into_iter().chain(numbers).chain(reliefs).any(Option::is_some)
    }
}

/// The roughness of GGX whose lobe is about as wide as that of Phong's exponent (Walter et al.
/// 2007, section 5.2, with the Blinn-Phong exponent).
fn alpha(exponent: f64) -> f64 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt()
}

/// A rough material of an α in all directions that may vary.
fn rough(material: impl Fn(DVec2) -> Material, alpha: Texture) -> Material {
    match alpha.as_constant() {
        Some(alpha) => material(DVec2::splat(alpha.r())),
        None => Material::VaryingRoughness {
            rough: Box::new(material(DVec2::ONE)),
            alpha: Box::new([alpha.clone(), alpha]),
        },
    }
}

fn diffuse(albedo: Texture) -> Material {
    coloured(|albedo| Material::Lambert { albedo }, albedo)
}

/// A material of a colour that may vary.
fn coloured(material: impl Fn(Rgb) -> Material, colour: Texture) -> Material {
    match colour.as_constant() {
        Some(colour) => material(colour),
        None => material(Rgb::WHITE).tinted(colour),
    }
}
