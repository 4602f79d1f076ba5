//! Materials of surfaces: the elements `bsdf`.

use super::super::Error;
use super::Loader;
use super::conductors;
use super::document::Element;
use super::spectrum::Illuminant;
use super::values::{Object, number};
use crate::bsdf::rough_plastic::reflectances_inside;
use crate::bsdf::{Beckmann, Ggx, Microfacets, PrincipledLobes};
use crate::material::{GreenAxis, Relief, Texture};
use crate::math::Rgb;
use crate::scene::{Material, MaterialId};
use glam::DVec2;

/// The material in place of one that the crate lacks.
fn stand_in() -> Material {
    Material::Lambert { albedo: Rgb::splat(0.5) }.one_sided()
}

impl<'a> Loader<'a> {
    /// The material of a bsdf element, added to the scene once.
    pub(super) fn material(&mut self, element: &'a Element) -> Result<MaterialId, Error> {
        let element = self.resolved(element)?;
        let key = std::ptr::from_ref(element);
        if let Some(id) = self.materials.get(&key) {
            return Ok(*id);
        }
        self.map = None;
        let material = self.bsdf(element, 0);
        let relief = self.map.take();
        let instead = "the surface is diffuse and grey instead";
        let material = self.warnings.rescue(material, instead)?.unwrap_or_else(stand_in);
        // The scene's own names of materials are another set.
        let name = format!("{} {}", self.materials.len(), element.id().unwrap_or(element.kind()));
        let id =
            self.builder.add_material(name, material).map_err(|error| element.caused(error))?;
        if let Some(relief) = relief {
            self.reliefs.insert(id, relief);
        }
        self.materials.insert(key, id);
        Ok(id)
    }

    /// The material of shapes that name none: grey and diffuse, or black if they emit.
    pub(super) fn default_material(
        &mut self,
        shape: &'a Element,
        emits: bool,
    ) -> Result<MaterialId, Error> {
        let (name, material) =
            if emits { ("default emitter", Material::Black) } else { ("default", stand_in()) };
        match self.builder.material(name) {
            Ok(id) => Ok(id),
            Err(_) => {
                self.builder.add_material(name, material).map_err(|error| shape.caused(error))
            }
        }
    }

    /// A bsdf. What only reflects absorbs on its back, unless it is `twosided`.
    fn bsdf(&mut self, element: &'a Element, depth: u32) -> Result<Material, Error> {
        let element = self.resolved(element)?;
        if depth >= self.limits.depth {
            return Err(element.error("bsdfs are nested too deeply, or contain each other"));
        }
        if element.tag != "bsdf" {
            return Err(element.error("a bsdf is wanted here"));
        }
        let object = Object::new(element);
        let material = match element.kind() {
            "diffuse" => self.diffuse(&object)?.one_sided(),
            "dielectric" => {
                let relative_ior = self.relative_ior(&object, "bk7")?;
                self.transmissive(&object, Material::Dielectric { relative_ior })?
            }
            "thindielectric" => {
                let relative_ior = self.relative_ior(&object, "bk7")?;
                self.transmissive(&object, Material::ThinDielectric { relative_ior })?
            }
            "roughdielectric" => {
                let roughness = self.roughness(&object)?;
                let glass = Material::RoughDielectric {
                    relative_ior: self.relative_ior(&object, "bk7")?,
                    alpha: roughness.constant(),
                };
                self.transmissive(&object, roughness.of(glass))?
            }
            "conductor" => {
                let (eta, k) = self.complex_ior(&object)?;
                let smooth = if is_perfect(eta, k) {
                    Material::Mirror { reflectance: Rgb::WHITE }
                } else {
                    Material::Conductor { eta, k }
                };
                self.tinted(&object, smooth)?.one_sided()
            }
            "roughconductor" => {
                let roughness = self.roughness(&object)?;
                let (eta, k) = self.complex_ior(&object)?;
                let alpha = roughness.constant();
                let rough = if is_perfect(eta, k) {
                    Material::RoughMirror { reflectance: Rgb::WHITE, alpha }
                } else {
                    Material::RoughConductor { eta, k, alpha }
                };
                self.tinted(&object, roughness.of(rough))?.one_sided()
            }
            "plastic" => self.plastic(&object)?.one_sided(),
            "roughplastic" => self.rough_plastic(&object)?.one_sided(),
            "principled" => self.principled(&object)?,
            "principledthin" => self.principled_thin(&object)?,
            "null" => Material::Null,
            "twosided" => match self.nested(&object, depth)?[..] {
                [ref both] => {
                    Material::Sided { front: Box::new(both.clone()), back: Box::new(both.clone()) }
                }
                [ref front, ref back] => {
                    Material::Sided { front: Box::new(front.clone()), back: Box::new(back.clone()) }
                }
                _ => return Err(element.error("twosided has one bsdf or two")),
            },
            "mask" => {
                let opacity = self
                    .texture(&object, "opacity", Illuminant::D65)?
                    .unwrap_or(Rgb::splat(0.5).into());
                let [inside] = self.exactly(&object, depth, "mask has one bsdf")?;
                Material::Blend { components: Box::new([Material::Null, inside]), amount: opacity }
            }
            "blendbsdf" => {
                let amount = self
                    .texture(&object, "weight", Illuminant::D65)?
                    .ok_or_else(|| element.error("the weight is missing"))?;
                let components: [Material; 2] =
                    self.exactly(&object, depth, "blendbsdf has two bsdfs")?;
                if self.map.is_some() {
                    self.warn(element, "the map of one bsdf is laid on both")?;
                }
                Material::Blend { components: Box::new(components), amount }
            }
            "bumpmap" | "normalmap" => self.mapped(&object, depth)?,
            other => {
                self.warn(element, format!("bsdfs of type {other} are not supported; the surface is diffuse and grey instead"))?;
                return Ok(stand_in());
            }
        };
        object.finish(&mut self.warnings)?;
        // So that the error names this element, not the outermost one.
        material.finish().map_err(|error| element.caused(error))?;
        Ok(material)
    }

    /// The bsdf that a normal or bump map is laid on.
    fn mapped(&mut self, object: &Object<'a>, depth: u32) -> Result<Material, Error> {
        let element = object.element;
        for name in ["flip_invalid_normals", "use_shadowing_function"] {
            if object.boolean(name)? == Some(false) {
                self.warn(element, format!("{name} cannot be turned off"))?;
            }
        }
        let instead = "the surface is as smooth as its shape";
        let relief = if element.kind() == "normalmap" {
            let normals = self.texture(object, "normalmap", Illuminant::D65)?;
            normals.map(|normals| Relief::normal_map(normals, 1.0, GreenAxis::RightHanded))
        } else {
            let scale = object.float_or("scale", 1.0)?;
            // It has any name.
            let heights = object.children(|child| self.resolved(child).is_ok_and(is_texture));
            let [heights] = heights[..] else {
                return Err(element.error("bumpmap has one texture"));
            };
            let heights = self.texture_of(heights, Illuminant::D65);
            let heights = self.warnings.rescue(heights, instead)?;
            heights.map(|heights| Relief::bump_map(heights, scale))
        };
        let [inside] = self.exactly(object, depth, "a map is laid on one bsdf")?;
        if self.map.is_some() {
            self.warn(element, "the surface has another map, too: this one is left out")?;
        } else {
            self.map = relief;
        }
        Ok(inside)
    }

    fn nested(&mut self, object: &Object<'a>, depth: u32) -> Result<Vec<Material>, Error> {
        object.objects().into_iter().map(|child| self.bsdf(child, depth + 1)).collect()
    }

    fn exactly<const N: usize>(
        &mut self,
        object: &Object<'a>,
        depth: u32,
        reason: &str,
    ) -> Result<[Material; N], Error> {
        self.nested(object, depth)?.try_into().map_err(|_| object.element.error(reason))
    }

    fn diffuse(&mut self, object: &Object<'a>) -> Result<Material, Error> {
        let reflectance =
            self.texture(object, "reflectance", Illuminant::D65)?.unwrap_or(Rgb::splat(0.5).into());
        Ok(match reflectance.as_constant() {
            Some(albedo) => Material::Lambert { albedo },
            None => Material::Lambert { albedo: Rgb::WHITE }.tinted(reflectance),
        })
    }

    fn plastic(&mut self, object: &Object<'a>) -> Result<Material, Error> {
        Ok(Material::Plastic {
            albedo: self
                .texture(object, "diffuse_reflectance", Illuminant::D65)?
                .unwrap_or(Rgb::splat(0.5).into()),
            specular: self
                .colour(object, "specular_reflectance", Illuminant::D65)?
                .unwrap_or(Rgb::WHITE),
            relative_ior: self.relative_ior(object, "polypropylene")?,
            colour_shift: object.boolean("nonlinear")?.unwrap_or(false),
        })
    }

    fn rough_plastic(&mut self, object: &Object<'a>) -> Result<Material, Error> {
        let mut roughness = self.roughness(object)?;
        let alpha = roughness.constant();
        if roughness.alpha.iter().any(|alpha| alpha.as_constant().is_none()) {
            self.warn(object.element, format!("the roughness of rough plastic must be a number; it is {} along u and {} along v", alpha.x, alpha.y))?;
        }
        roughness.alpha = alpha.to_array().map(|alpha| Rgb::splat(alpha).into());
        if alpha.x != alpha.y {
            self.warn(object.element, "rough plastic is the same in all directions; alpha is the geometric mean of alpha_u and alpha_v")?;
        }
        let alpha = (alpha.x * alpha.y).sqrt();
        let mut plastic = self.plastic(object)?;
        if let Material::Plastic { albedo, specular, relative_ior, colour_shift } = plastic {
            let factor =
                body_of_mitsuba(&albedo, relative_ior, colour_shift, alpha, roughness.beckmann);
            let albedo = albedo.scaled(factor).map_err(|error| object.element.caused(error))?;
            plastic =
                Material::RoughPlastic { albedo, specular, relative_ior, colour_shift, alpha };
        }
        Ok(roughness.of(plastic))
    }

    /// A parameter in [0, 1] that must not vary.
    fn constant_share(&mut self, object: &Object<'a>, name: &str) -> Result<f64, Error> {
        let share = self.colour(object, name, Illuminant::D65)?.map_or(0.0, Rgb::luminance);
        if !(-1e-12..=1.0 + 1e-12).contains(&share) {
            self.warn(
                object.element,
                format!("{name} is {share}, but must be in [0, 1], and is the nearest of them"),
            )?;
        }
        Ok(share.clamp(0.0, 1.0))
    }

    fn principled(&mut self, object: &Object<'a>) -> Result<Material, Error> {
        object.ignore(&[
            "diffuse_reflectance_sampling_rate",
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
        ]);
        let grey = |value: f64| Texture::from(Rgb::splat(value));
        let mut texture = |name: &str, default: f64| -> Result<Texture, Error> {
            Ok(self.texture(object, name, Illuminant::D65)?.unwrap_or_else(|| grey(default)))
        };
        let (base_color, metalness, roughness) =
            (texture("base_color", 0.5)?, texture("metallic", 0.0)?, texture("roughness", 0.5)?);
        let transmission = self.constant_share(object, "spec_trans")?;
        let relative_ior = match object.float("eta")? {
            Some(eta) => eta,
            None => {
                let specular = object.float_or("specular", 0.5)?;
                2.0 / (1.0 - (0.08 * specular.clamp(0.0, 1.0)).sqrt()) - 1.0
            }
        };
        let lobes = PrincipledLobes {
            relative_ior,
            transmission,
            anisotropy: self.constant_share(object, "anisotropic")?,
            specular_tint: self.constant_share(object, "spec_tint")?,
            sheen: self.constant_share(object, "sheen")?,
            sheen_tint: self.constant_share(object, "sheen_tint")?,
            flatness: self.constant_share(object, "flatness")?,
            clearcoat: self.constant_share(object, "clearcoat")?,
            clearcoat_gloss: self.constant_share(object, "clearcoat_gloss")?,
        };
        let material =
            Material::Principled { base_color, metalness, roughness, lobes: Box::new(lobes) };
        Ok(if transmission > 0.0 { material } else { material.one_sided() })
    }

    /// A thin sheet, which reflects on both sides.
    fn principled_thin(&mut self, object: &Object<'a>) -> Result<Material, Error> {
        object.ignore(&[
            "diffuse_transmittance_sampling_rate",
            "diffuse_reflectance_sampling_rate",
            "specular_reflectance_sampling_rate",
            "specular_transmittance_sampling_rate",
            "diff_trans",
        ]);
        self.warn(object.element, "principledthin is approximated: it transmits as a smooth pane, and reflects what it transmits diffusely")?;
        let sheet = match self.principled(object)? {
            Material::Sided { front, .. } => return Ok(*front),
            sheet => sheet,
        };
        let Material::Principled { base_color, metalness, roughness, lobes } = sheet else {
            return Ok(sheet);
        };
        let (transmission, relative_ior) = (lobes.transmission, lobes.relative_ior);
        let lobes = Box::new(PrincipledLobes { transmission: 0.0, ..*lobes });
        let pane = Material::ThinDielectric { relative_ior }.stained(base_color.clone());
        let sheet = Material::Principled { base_color, metalness, roughness, lobes };
        let weights = [1.0 - transmission, transmission];
        Ok(Material::Mixture { components: Box::new([sheet, pane]), weights })
    }

    /// Multiplies by `specular_reflectance`.
    fn tinted(&mut self, object: &Object<'a>, material: Material) -> Result<Material, Error> {
        Ok(match self.texture(object, "specular_reflectance", Illuminant::D65)? {
            Some(tint) if tint.as_constant() != Some(Rgb::WHITE) => material.tinted(tint),
            _ => material,
        })
    }

    /// Multiplies by `specular_reflectance` and `specular_transmittance`, if they are the same or
    /// all is reflected that can be.
    fn transmissive(&mut self, object: &Object<'a>, material: Material) -> Result<Material, Error> {
        let white = || Texture::from(Rgb::WHITE);
        let reflectance =
            self.texture(object, "specular_reflectance", Illuminant::D65)?.unwrap_or_else(white);
        let transmittance =
            self.texture(object, "specular_transmittance", Illuminant::D65)?.unwrap_or_else(white);
        if reflectance == white() && transmittance != white() {
            return Ok(material.stained(transmittance));
        }
        if reflectance != transmittance {
            self.warn(object.element, "specular_reflectance and specular_transmittance differ, which is not supported: both are 1")?;
            return Ok(material);
        }
        Ok(if reflectance == white() { material } else { material.tinted(reflectance) })
    }

    fn roughness(&mut self, object: &Object<'a>) -> Result<Roughness, Error> {
        // It concerns sampling only.
        object.ignore(&["sample_visible"]);
        let beckmann = match object.string("distribution")? {
            None | Some("beckmann") => true,
            Some("ggx") => false,
            Some(other) => {
                self.warn(
                    object.element,
                    format!("the distribution \"{other}\" is beckmann instead"),
                )?;
                true
            }
        };
        let mut alpha = |name: &str| self.texture(object, name, Illuminant::D65);
        let both = alpha("alpha")?.unwrap_or(Rgb::splat(0.1).into());
        let [u, v] = [alpha("alpha_u")?, alpha("alpha_v")?];
        Ok(Roughness { alpha: [u.unwrap_or(both.clone()), v.unwrap_or(both)], beckmann })
    }

    /// n inside over n outside.
    fn relative_ior(&mut self, object: &Object<'a>, inside: &str) -> Result<f64, Error> {
        let mut index = |name: &str, default: &str| -> Result<f64, Error> {
            let given = object.get(name).map_or(Ok(None), |child| ior(child).map(Some));
            let given = self.warnings.rescue(given, &format!("it is that of {default}"))?.flatten();
            Ok(given.or(named_ior(default)).unwrap_or(1.0))
        };
        Ok(index("int_ior", inside)? / index("ext_ior", "air")?)
    }

    /// Takes 0 for negative components of an index of refraction.
    fn without_negative<'v>(
        &mut self,
        element: &Element,
        name: &str,
        values: impl Iterator<Item = &'v mut f64>,
    ) -> Result<(), Error> {
        let mut any = false;
        for value in values.filter(|value| **value < 0.0) {
            *value = 0.0;
            any = true;
        }
        if any {
            self.warn(element, format!("{name} has negative components; they are 0 instead"))?;
        }
        Ok(())
    }

    fn complex_ior(&mut self, object: &Object<'a>) -> Result<(Rgb, Rgb), Error> {
        let element = object.element;
        let mut spectrum = |name| object.get(name).map_or(Ok(None), |child| self.spectrum(child));
        if let (Some(mut n), Some(mut k)) = (spectrum("eta")?, spectrum("k")?) {
            if n.is_empty() || k.is_empty() {
                return Err(element.error("eta and k must have values"));
            }
            for (name, values) in [("eta", &mut n), ("k", &mut k)] {
                let negative = values.iter_mut().map(|(_, value)| value);
                self.without_negative(element, name, negative)?;
            }
            let [eta, k] = conductors::from_spectra(&n, &k);
            return Ok((eta, k));
        }
        let name = object.string("material")?;
        let mut eta = self.colour(object, "eta", Illuminant::D65)?;
        let mut k = self.colour(object, "k", Illuminant::D65)?;
        for (name, value) in [("eta", &mut eta), ("k", &mut k)] {
            let components = value.iter_mut().flat_map(|value| &mut value.0);
            self.without_negative(element, name, components)?;
        }
        match (name, eta, k) {
            (None, Some(eta), Some(k)) => Ok((eta, k)),
            (None, None, None) => Ok((Rgb::BLACK, Rgb::WHITE)),
            (Some(name), None, None) => match conductors::by_name(name) {
                Some([eta, k]) => Ok((eta, k)),
                None => {
                    self.warn(
                        element,
                        format!(
                            "the conductor {name} is not known; it is a perfect mirror instead"
                        ),
                    )?;
                    Ok((Rgb::BLACK, Rgb::WHITE))
                }
            },
            _ => Err(element.error("a conductor has either a material or both eta and k")),
        }
    }
}

fn is_texture(element: &Element) -> bool {
    element.tag == "texture"
}

/// The parameters of a distribution of micro-normals.
struct Roughness {
    /// α along u and along v.
    alpha: [Texture; 2],
    /// True if the distribution is Beckmann's.
    beckmann: bool,
}

impl Roughness {
    /// α along u and along v; of what varies the middle of its range.
    fn constant(&self) -> DVec2 {
        let middle = |texture: &Texture| {
            let [least, greatest] = texture.range();
            0.5 * (least.g() + greatest.g())
        };
        self.alpha.each_ref().map(middle).into()
    }

    /// A rough material with this distribution, whose α is already right if it is constant.
    fn of(self, rough: Material) -> Material {
        let rough = Material::IndependentMasking { rough: Box::new(rough) };
        let rough =
            if self.beckmann { Material::Beckmann { rough: Box::new(rough) } } else { rough };
        if self.alpha.iter().all(|alpha| alpha.as_constant().is_some()) {
            return rough;
        }
        Material::VaryingRoughness { rough: Box::new(rough), alpha: Box::new(self.alpha) }
    }
}

/// An index of 0 + i mirrors everything.
fn is_perfect(eta: Rgb, k: Rgb) -> bool {
    eta == Rgb::BLACK && !k.0.contains(&0.0)
}

/// The factor of a body's albedo a that makes it as dark as Mitsuba's, which has the mean of `2 μ
/// R(μ)` over 64 cosines from 0 to 1 in place of the integral `R_i`: `(63 R_i + R(1)) / 64`, up to
/// the error of the trapezium rule. `a/(1 - a R_i)` is then exact for the mean albedo of a texture,
/// and right to 0.5 % for all others.
fn body_of_mitsuba(
    albedo: &Texture,
    relative_ior: f64,
    colour_shift: bool,
    alpha: f64,
    beckmann: bool,
) -> Rgb {
    let distribution = if beckmann {
        Beckmann::new(alpha, alpha).map(Microfacets::from)
    } else {
        Ggx::isotropic(alpha).map(Microfacets::from)
    };
    // What is wrong with it is said of the material.
    let Ok(distribution) = distribution else { return Rgb::WHITE };
    let [inside, normal] = reflectances_inside(&distribution, relative_ior);
    let missing = (inside - normal) / 64.0;
    let [least, greatest] = albedo.range();
    ((least + greatest) * 0.5).map(|a| {
        if colour_shift {
            1.0 / (1.0 + a * missing)
        } else {
            1.0 / (1.0 + missing / (1.0 - inside))
        }
    })
}

/// An index of refraction, a number or the name of a material.
fn ior(element: &Element) -> Result<f64, Error> {
    let value = element.required("value")?;
    let index = match element.tag.as_str() {
        "string" => named_ior(value).ok_or_else(|| {
            element.error(format!("the material {value} is not known; give its index as a number"))
        })?,
        "float" | "integer" => number(element, value)?,
        _ => return Err(element.error("must be a number or the name of a material")),
    };
    if index > 0.0 { Ok(index) } else { Err(element.error(format!("{index} is not positive"))) }
}

/// Indices of refraction of common materials for the sodium D line.
fn named_ior(name: &str) -> Option<f64> {
    Some(match name {
        "vacuum" => 1.0,
        "helium" => 1.000_036,
        "hydrogen" => 1.000_132,
        "air" => 1.000_277,
        "carbon dioxide" => 1.000_45,
        "water ice" => 1.31,
        "water" => 1.333,
        "acetone" => 1.36,
        "ethanol" => 1.361,
        "fused quartz" => 1.458,
        "carbon tetrachloride" => 1.461,
        "pyrex" => 1.47,
        "glycerol" => 1.4729,
        "acrylic glass" | "polypropylene" => 1.49,
        "benzene" => 1.501,
        "bk7" => 1.5046,
        "silicone oil" => 1.520_45,
        "sodium chloride" => 1.544,
        "amber" => 1.55,
        "pet" => 1.575,
        "bromine" => 1.661,
        "diamond" => 2.419,
        _ => return None,
    })
}
