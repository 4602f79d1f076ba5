//! Materials of surfaces.

use super::super::Error;
use super::Loader;
use super::colours::{self, Spectrum};
use super::object::{Object, Values};
use super::textures::{Sort, mean, upside_down};
use crate::material::{GreenAxis, Relief, Texture};
use crate::math::Rgb;
use crate::scene::{Material, MaterialId};
use glam::{DAffine2, DVec2};
use std::rc::Rc;

/// The material of a graphics state.
#[derive(Clone, Debug)]
pub(super) enum Reference {
    Given(Rc<Object>),
    /// One that is looked up when a shape wants it.
    Named(String),
}

/// A reference with what varies between the shapes that have it, as text: the place of texture
/// coordinates, the texture of opacity, and what is inside.
pub(super) type Key = (*const Object, String);

/// Roughness below which pbrt takes a surface for smooth.
const SMOOTH: f64 = 1e-3;

/// The material in place of one that the crate lacks, which is also that of shapes without one.
fn stand_in() -> Material {
    Material::Lambert { albedo: Rgb::splat(0.5) }
}

impl Loader {
    /// The object of a reference.
    fn resolved(&mut self, reference: &Reference) -> Result<Rc<Object>, Error> {
        match reference {
            Reference::Given(object) => Ok(Rc::clone(object)),
            Reference::Named(name) => match self.named_materials.get(name) {
                Some(object) => Ok(Rc::clone(object)),
                None => {
                    let reason =
                        format!("there is no material {name}; it is diffuse and grey instead");
                    self.warnings.warn(self.location(), reason)?;
                    Ok(Rc::clone(&self.default_material))
                }
            },
        }
    }

    /// True if all that the reference names has been described: files may do so further on.
    pub(super) fn is_described(&self, reference: &Reference) -> bool {
        let (name, object) = match reference {
            Reference::Given(object) => (None, Some(object)),
            Reference::Named(name) => (Some(name), self.named_materials.get(name)),
        };
        object.is_some_and(|object| {
            let parts = object.parameters.iter().find(|p| p.name == "materials");
            let Some(Values::Texts(parts)) = parts.map(|p| &p.values) else { return true };
            parts.iter().all(|part| name == Some(part) || self.named_materials.contains_key(part))
        })
    }

    /// True if the material may vary with texture coordinates.
    pub(super) fn is_textured(&self, reference: &Reference) -> bool {
        let object = match reference {
            Reference::Given(object) => Some(object),
            Reference::Named(name) => self.named_materials.get(name),
        };
        object.is_some_and(|object| {
            object.kind == "mix" || object.parameters.iter().any(|p| p.kind == "texture")
        })
    }

    /// The material of a shape, added to the scene once. `opacity` has a name to tell it by.
    pub(super) fn material(
        &mut self,
        reference: &Reference,
        to_uv: DAffine2,
        opacity: Option<&(String, Texture)>,
    ) -> Result<MaterialId, Error> {
        let object = self.resolved(reference)?;
        let key = (Rc::as_ptr(&object), format!("{to_uv:?} {:?}", opacity.map(|o| &o.0)));
        if let Some((_, id)) = self.materials.get(&key) {
            return Ok(*id);
        }
        let instead = "the surface is diffuse and grey instead";
        self.relief = None;
        let material = self.described_material(&object, to_uv, 0);
        let mut material = self.warnings.rescue(material, instead)?.unwrap_or_else(stand_in);
        if let Some((_, opacity)) = opacity {
            let components = Box::new([Material::Null, material.clone()]);
            let blend = Material::Blend { components, amount: opacity.clone() };
            let checked = blend.finish().map(|_| blend).map_err(|error| object.caused(error));
            let checked = self.warnings.rescue(checked, "the surface is opaque")?;
            material = checked.unwrap_or(material);
        }
        let name = format!("{} {}", self.materials.len(), object.kind);
        let id = self.builder.add_material(name, material).map_err(|error| object.caused(error))?;
        if let Some(relief) = self.relief.take() {
            self.reliefs.insert(id, relief);
        }
        // With the object, so that no other one has its address.
        self.materials.insert(key, (object, id));
        Ok(id)
    }

    fn described_material(
        &mut self,
        object: &Object,
        to_uv: DAffine2,
        depth: u32,
    ) -> Result<Material, Error> {
        if depth >= self.limits.depth {
            return Err(object.error("materials are nested too deeply, or contain each other"));
        }
        let material = self.kind(object, to_uv, depth)?;
        let relief = self.relief(object, to_uv)?;
        if depth == 0 {
            self.relief = relief;
        } else if relief.is_some() {
            let reason = "bump and normal maps of a mix's parts are not supported, and left out";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        object.finish(&mut self.warnings)?;
        material.finish().map_err(|error| object.caused(error))?;
        Ok(material)
    }

    /// The bump or normal map of a material.
    fn relief(&mut self, object: &Object, to_uv: DAffine2) -> Result<Option<Relief>, Error> {
        // Bump maps of version 3 have another name.
        for name in ["displacement", "bumpmap"] {
            if let Some(heights) = self.texture(object, name, Sort::Float, to_uv)? {
                return Ok(Some(Relief::bump_map(heights, 1.0)));
            }
        }
        let Some(name) = object.text("normalmap")? else { return Ok(None) };
        let normals = self.normals(object, name).and_then(|normals| {
            normals.with_transform(upside_down() * to_uv).map_err(|error| object.caused(error))
        });
        let normals = self.warnings.rescue(normals, "the surface is as smooth as its shape")?;
        Ok(normals.map(|normals| Relief::normal_map(normals, 1.0, GreenAxis::RightHanded)))
    }

    fn kind(&mut self, object: &Object, to_uv: DAffine2, depth: u32) -> Result<Material, Error> {
        let kind = object.kind.as_str();
        if let Some((counterpart, is_close)) = counterpart(kind)
            && !is_close
        {
            let reason = format!("the material {kind} is approximated by {counterpart}");
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let mut colour = |name: &str, default: f64| self.albedo(object, name, default, to_uv);
        Ok(match kind {
            "" | "none" | "interface" => Material::Null,
            "diffuse" => lambert(colour("reflectance", 0.5)?),
            "diffusetransmission" => {
                object.ignore(&["transmittance"]);
                let scale = object.number_or("scale", 1.0)?;
                let reflectance = colour("reflectance", 0.25)?;
                let reflectance = reflectance.scaled(Rgb::splat(scale.clamp(0.0, 1.0)));
                lambert(reflectance.map_err(|error| object.caused(error))?)
            }
            "coateddiffuse" => {
                object.ignore(&["thickness", "maxdepth", "nsamples", "twosided"]);
                let albedo = colour("reflectance", 0.5)?;
                let alpha = self.alpha(object, "", 0.0, to_uv)?;
                self.coated(object, albedo, alpha, to_uv)?
            }
            "conductor" => {
                let alpha = self.alpha(object, "", 0.0, to_uv)?;
                self.conductor(object, "", alpha, to_uv)?
            }
            "coatedconductor" => {
                object.ignore(&["thickness", "maxdepth", "nsamples", "twosided", "interface.eta"]);
                object.ignore(&[
                    "interface.roughness",
                    "interface.uroughness",
                    "interface.vroughness",
                ]);
                let alpha = self.alpha(object, "conductor.", 0.0, to_uv)?;
                self.conductor(object, "conductor.", alpha, to_uv)?
            }
            "dielectric" => {
                let alpha = self.alpha(object, "", 0.0, to_uv)?;
                let relative_ior = self.index(object, "eta", to_uv)?;
                dielectric(relative_ior, alpha)
            }
            "thindielectric" => {
                let relative_ior = self.index(object, "eta", to_uv)?;
                Material::ThinDielectric { relative_ior }
            }
            "mix" => self.mix(object, to_uv, depth)?,
            "subsurface" | "kdsubsurface" => {
                object.ignore(&["sigma_a", "sigma_s", "mfp", "scale", "name", "g", "Kr", "Kt"]);
                let name = if kind == "subsurface" { "reflectance" } else { "Kd" };
                let albedo = colour(name, 0.5)?;
                let alpha = self.alpha(object, "", 0.0, to_uv)?;
                self.coated(object, albedo, alpha, to_uv)?
            }
            "hair" => {
                let ignored = ["sigma_a", "eumelanin", "pheomelanin", "eta"];
                object.ignore(&ignored);
                object.ignore(&["beta_m", "beta_n", "alpha"]);
                let name = if object.get("color").is_some() { "color" } else { "reflectance" };
                lambert(colour(name, 0.1)?)
            }
            "matte" => {
                object.ignore(&["sigma"]);
                lambert(colour("Kd", 0.5)?)
            }
            "translucent" => {
                object.ignore(&["Ks", "roughness", "remaproughness", "reflect", "transmit"]);
                lambert(colour("Kd", 0.25)?)
            }
            "mirror" => tinted(Material::Mirror { reflectance: Rgb::WHITE }, colour("Kr", 0.9)?),
            "plastic" | "substrate" | "uber" => {
                object.ignore(&["Ks", "Kr", "Kt", "opacity", "eta", "index"]);
                let albedo = colour("Kd", if kind == "substrate" { 0.5 } else { 0.25 })?;
                let alpha = self.alpha(object, "", 0.1, to_uv)?;
                self.coated(object, albedo, alpha, to_uv)?
            }
            "glass" => {
                let (reflected, transmitted) = (colour("Kr", 1.0)?, colour("Kt", 1.0)?);
                let alpha = self.alpha(object, "", 0.0, to_uv)?;
                let name = if object.get("index").is_some() { "index" } else { "eta" };
                let glass = dielectric(self.index(object, name, to_uv)?, alpha);
                if reflected == transmitted {
                    tinted(glass, reflected)
                } else if reflected.as_constant() == Some(Rgb::WHITE) {
                    glass.stained(transmitted)
                } else {
                    let reason = "Kr and Kt differ, which is not supported: both are 1";
                    self.warnings.warn(object.location.clone(), reason)?;
                    glass
                }
            }
            "metal" => {
                let alpha = self.alpha(object, "", 0.01, to_uv)?;
                self.conductor(object, "", alpha, to_uv)?
            }
            "disney" => {
                let base_color = colour("color", 0.5)?;
                let roughness = self.scalar(object, "roughness", to_uv)?.unwrap_or(0.5);
                let metalness = self.scalar(object, "metallic", to_uv)?.unwrap_or(0.0);
                let relative_ior = self.index(object, "eta", to_uv)?;
                metallic(base_color, roughness, metalness, relative_ior)
            }
            "measured" | "fourier" => {
                object.ignore(&["filename", "bsdffile"]);
                stand_in()
            }
            other => {
                return Err(object.error(format!("materials of type {other} are not supported")));
            }
        })
    }

    /// A reflectance, which is scaled down to at most 1.
    fn albedo(
        &mut self,
        object: &Object,
        name: &str,
        default: f64,
        to_uv: DAffine2,
    ) -> Result<Texture, Error> {
        let texture = self.texture(object, name, Sort::Spectrum, to_uv)?;
        let texture = texture.unwrap_or(Rgb::splat(default).into());
        let greatest = texture.range()[1].max_component();
        if greatest <= 1.0 {
            return Ok(texture);
        }
        let reason = format!("the {name} is up to {greatest}; it is scaled down to 1");
        self.warnings.warn(object.location.clone(), reason)?;
        texture.scaled(Rgb::splat(1.0 / greatest)).map_err(|error| object.caused(error))
    }

    /// The roughness α along u and v.
    fn alpha(
        &mut self,
        object: &Object,
        prefix: &str,
        default: f64,
        to_uv: DAffine2,
    ) -> Result<[Texture; 2], Error> {
        let mut roughness =
            |name: &str| self.texture(object, &format!("{prefix}{name}"), Sort::Float, to_uv);
        let both = roughness("roughness")?.unwrap_or(Rgb::splat(default).into());
        let u = roughness("uroughness")?.unwrap_or(both.clone());
        let v = roughness("vroughness")?.unwrap_or(both);
        let is_remapped = object.truth("remaproughness")?.unwrap_or(true);
        let is_new = counterpart(&object.kind).is_some_and(|(_, is_new)| is_new)
            || matches!(object.kind.as_str(), "coatedconductor" | "subsurface");
        let alpha = |roughness: f64| {
            let alpha = match (is_remapped, is_new) {
                (false, _) => roughness,
                (true, true) => roughness.max(0.0).sqrt(),
                // Version 3 has a polynomial, and is smooth only at 0.
                (true, false) if roughness == 0.0 => 0.0,
                (true, false) => {
                    let x = libm::log(roughness.max(1e-3));
                    let terms = [0.000_640_711, 0.017_120_1, 0.1734, 0.819_955, 1.621_42];
                    terms.into_iter().fold(0.0, |sum, term| sum * x + term)
                }
            };
            alpha.clamp(0.0, 1.0)
        };
        let alpha = |roughness: Rgb| roughness.map(alpha);
        Ok([self.recoloured(object, &u, alpha)?, self.recoloured(object, &v, alpha)?])
    }

    /// The index of refraction of the inside, of glass if nothing says.
    fn index(&mut self, object: &Object, name: &str, to_uv: DAffine2) -> Result<f64, Error> {
        let Some(parameter) = object.get(name) else { return Ok(1.5) };
        if parameter.kind == "spectrum" {
            let reason = "dispersion is not supported; the index is that at 587.6 nm";
            self.warnings.warn(object.location.clone(), reason)?;
            return Ok(self.spectrum(object, parameter)?.as_index());
        }
        Ok(self.scalar(object, name, to_uv)?.unwrap_or(1.5))
    }

    /// A diffuse body under a dielectric coat. Light that the coat throws back is coloured again.
    fn coated(
        &mut self,
        object: &Object,
        albedo: Texture,
        alpha: [Texture; 2],
        to_uv: DAffine2,
    ) -> Result<Material, Error> {
        if object.get("albedo").is_some() || object.get("g").is_some() {
            let reason = "a medium between coat and body is not supported, and left out";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let relative_ior = self.index(object, "eta", to_uv)?.max(1.0);
        let specular = Rgb::WHITE;
        let along = means(&alpha);
        if along.max_element() < SMOOTH {
            return Ok(Material::Plastic { albedo, specular, relative_ior, colour_shift: true });
        }
        if along.x != along.y || alpha.iter().any(|alpha| alpha.as_constant().is_none()) {
            let reason = "the roughness of a coat is a number here: its mean is taken";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let alpha = 0.5 * (along.x + along.y);
        Ok(Material::RoughPlastic { albedo, specular, relative_ior, colour_shift: true, alpha })
    }

    fn conductor(
        &mut self,
        object: &Object,
        prefix: &str,
        alpha: [Texture; 2],
        to_uv: DAffine2,
    ) -> Result<Material, Error> {
        let of = |name: &str| format!("{prefix}{name}");
        let [eta, k] = if object.get("reflectance").is_some() {
            let reflectance = self.albedo(object, "reflectance", 1.0, to_uv)?;
            let Some(colour) = reflectance.as_constant() else {
                return Ok(metallic(reflectance, mean_roughness(means(&alpha)), 1.0, 1.5));
            };
            // Of all pairs with this reflectance that with n = 1.
            let k = colour.map(|r| {
                let r = r.min(0.9999);
                2.0 * (r / (1.0 - r)).sqrt()
            });
            [Rgb::WHITE, k]
        } else {
            let copper = |part: &str| format!("metal-Cu-{part}");
            let mut part = |name: &str| -> Result<Spectrum, Error> {
                match object.get(&of(name)) {
                    Some(parameter) if parameter.kind == "texture" => {
                        let texture = self.texture(object, &of(name), Sort::Spectrum, to_uv)?;
                        Ok(Spectrum::Rgb(texture.map_or(Rgb::WHITE, |texture| mean(&texture))))
                    }
                    Some(parameter) => self.spectrum(object, parameter),
                    None => self.named_spectrum(object, &copper(name)),
                }
            };
            colours::metal(&part("eta")?, &part("k")?)
        };
        let smooth = Material::Conductor { eta, k };
        Ok(rough(alpha, smooth, |alpha| Material::RoughConductor { eta, k, alpha }))
    }

    fn mix(&mut self, object: &Object, to_uv: DAffine2, depth: u32) -> Result<Material, Error> {
        let amount = self.texture(object, "amount", Sort::Float, to_uv)?;
        let amount = amount.unwrap_or(Rgb::splat(0.5).into());
        let names = match object.get("materials").map(|parameter| &parameter.values) {
            Some(Values::Texts(names)) => names.clone(),
            // Version 3, where the amount is that of the first.
            _ => {
                let name = |name: &str| Ok(object.text(name)?.unwrap_or("").to_owned());
                vec![name("namedmaterial2")?, name("namedmaterial1")?]
            }
        };
        let [first, second] = &names[..] else {
            return Err(object.error("a mix has two materials"));
        };
        let mut component = |name: &str| -> Result<Material, Error> {
            let object = self.resolved(&Reference::Named(name.to_owned()))?;
            self.described_material(&object, to_uv, depth + 1)
        };
        let components = Box::new([component(first)?, component(second)?]);
        let share = mean(&amount).r();
        let [first, second] = components.as_ref().clone();
        let blend = Material::Blend { components, amount };
        if blend.finish().is_ok() {
            return Ok(blend);
        }
        let reason =
            "a mix of these materials is not supported: the one that has more of it is taken";
        self.warnings.warn(object.location.clone(), reason)?;
        Ok(if share > 0.5 { second } else { first })
    }
}

/// What the crate has for a type of material, and whether it is one of version 4 that is the same.
fn counterpart(kind: &str) -> Option<(&'static str, bool)> {
    Some(match kind {
        "diffuse" | "coateddiffuse" | "conductor" | "dielectric" | "thindielectric" => ("", true),
        "coatedconductor" => ("the conductor without its coat", false),
        "diffusetransmission" | "translucent" => ("what it reflects", false),
        "subsurface" | "kdsubsurface" => ("a coated diffuse surface", false),
        "hair" | "matte" | "measured" | "fourier" => ("a diffuse surface", false),
        "plastic" | "substrate" | "uber" => ("a coated diffuse surface", false),
        "metal" => ("a conductor", false),
        "glass" => ("a dielectric", false),
        "mirror" => ("a mirror", false),
        "disney" => ("a metallic-roughness material", false),
        _ => return None,
    })
}

fn lambert(albedo: Texture) -> Material {
    match albedo.as_constant() {
        Some(albedo) => Material::Lambert { albedo },
        None => Material::Lambert { albedo: Rgb::WHITE }.tinted(albedo),
    }
}

fn tinted(material: Material, tint: Texture) -> Material {
    if tint.as_constant() == Some(Rgb::WHITE) { material } else { material.tinted(tint) }
}

fn dielectric(relative_ior: f64, alpha: [Texture; 2]) -> Material {
    let smooth = Material::Dielectric { relative_ior };
    rough(alpha, smooth, |alpha| Material::RoughDielectric { relative_ior, alpha })
}

/// The rough material, which may vary, or the smooth one.
fn rough(alpha: [Texture; 2], smooth: Material, rough: impl Fn(DVec2) -> Material) -> Material {
    let along = means(&alpha);
    if alpha.iter().any(|alpha| alpha.as_constant().is_none()) {
        Material::VaryingRoughness { rough: Box::new(rough(along)), alpha: Box::new(alpha) }
    } else if along.max_element() < SMOOTH {
        smooth
    } else {
        rough(along)
    }
}

/// The mean roughness along u and v.
fn means([u, v]: &[Texture; 2]) -> DVec2 {
    DVec2::new(mean(u).r(), mean(v).r())
}

fn metallic(base_color: Texture, roughness: f64, metalness: f64, relative_ior: f64) -> Material {
    let surface = Rgb::new(1.0, roughness.clamp(0.0, 1.0), metalness.clamp(0.0, 1.0));
    Material::MetallicRoughness { base_color, metallic_roughness: surface.into(), relative_ior }
}

/// The roughness of a metallic-roughness material, the root of α.
fn mean_roughness(alpha: DVec2) -> f64 {
    (0.5 * (alpha.x + alpha.y)).sqrt()
}
