//! Metallic-roughness materials with the extensions that can be represented.

use super::clear_coat::{self, ClearCoat};
use super::document::Document;
use super::texture::{Meaning, Textures, coordinate_set, transform};
use crate::import::{Error, Location};
use crate::material::{GreenAxis, Relief, Texture, VertexFactor};
use crate::math::Rgb;
use crate::scene::Material;
use glam::DAffine2;
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::extensions::material::Volume;
use gltf::json::material::AlphaMode;
use gltf::json::mesh::Semantic;
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

/// The look of a surface, made from a material of the file.
#[derive(Clone)]
pub(super) struct Look {
    pub material: Material,
    /// Radiance, if it emits.
    pub emission: Option<Texture>,
    /// The normal map, and the transform of its texture coordinates.
    pub relief: Option<(Relief, DAffine2)>,
    /// The absorption coefficient of the body behind it.
    pub absorption: Rgb,
    pub double_sided: bool,
    /// True if its back is not there.
    pub is_culled: bool,
    /// True if no light passes it.
    pub is_opaque: bool,
    /// Black where there is nothing of the surface, if it is cut out.
    pub cutout: Option<Texture>,
    /// The sets of texture coordinates of its textures, if it has any: that of its emission, and
    /// another one.
    pub coordinates: [Option<u32>; 2],
}

impl Look {
    /// The look that the format wants where the file gives no material: white, rough metal.
    pub fn default_look(document: &Document) -> Self {
        let material = Material::MetallicRoughness {
            base_color: VertexColors::of(document, None).on_color(Rgb::WHITE.into()),
            metallic_roughness: Rgb::WHITE.into(),
            relative_ior: DEFAULT_IOR,
        };
        Self {
            material,
            emission: None,
            relief: None,
            absorption: Rgb::BLACK,
            double_sided: false,
            is_culled: !document.back_faces,
            is_opaque: true,
            cutout: None,
            coordinates: [None; 2],
        }
    }
}

/// The colours that meshes of a material have at their vertices.
#[derive(Clone, Copy)]
struct VertexColors {
    exist: bool,
    have_alpha: bool,
}

impl VertexColors {
    fn of(document: &Document, material: Option<usize>) -> Self {
        let root = &document.root;
        let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let colors: Vec<bool> = primitives
            .filter(|primitive| primitive.material.map(|index| index.value()) == material)
            .filter_map(|primitive| primitive.attributes.get(&Checked::Valid(Semantic::Colors(0))))
            .map(|index| root.accessors[index.value()].type_ == Checked::Valid(Type::Vec4))
            .collect();
        Self { exist: !colors.is_empty(), have_alpha: colors.contains(&true) }
    }

    fn on_color(self, color: Texture) -> Texture {
        if self.exist { color.with_vertex_factor(VertexFactor::Color) } else { color }
    }

    fn on_alpha(self, alpha: Texture) -> Texture {
        if self.have_alpha { alpha.with_vertex_factor(VertexFactor::Alpha) } else { alpha }
    }
}

const DEFAULT_IOR: f64 = 1.5;

/// The index of refraction in place of 0, by which the format means that everything is reflected:
/// the largest that models take. All but 4e-6 is reflected.
const INFINITE_IOR: f64 = 1e6;

/// A factor in [0, 1]; 1 if it exceeds 1 by no more than rounding explains.
pub(super) fn share(factor: f32) -> f64 {
    let factor = f64::from(factor);
    if (1.0..1.0 + 1e-6).contains(&factor) { 1.0 } else { factor }
}

/// Reads material `index`.
pub(super) fn look(
    document: &mut Document,
    textures: &mut Textures,
    index: usize,
) -> Result<Look, Error> {
    let source = document.root.materials[index].clone();
    let location = document.location(format!("material {index}"), source.name.as_ref());
    warn_about_the_rest(document, &source, &location)?;
    let normals = normal_info(&source, &location)?;
    let coat = clear_coat(document, &source, &location)?;
    let coordinates =
        coordinate_sets(document, &source, normals.as_ref(), coat.as_ref(), &location)?;
    textures.other_set = coordinates[1];
    let vertex_colors = VertexColors::of(document, Some(index));

    let pbr = &source.pbr_metallic_roughness;
    let [r, g, b, opacity] = pbr.base_color_factor.0.map(share);
    let factor = Rgb::new(r, g, b);
    let base_color = match &pbr.base_color_texture {
        Some(info) => textures.texture(document, info, Meaning::Colour, factor, &location)?,
        None => factor.into(),
    };
    let base_color = vertex_colors.on_color(base_color);
    let (roughness, metalness) = (share(pbr.roughness_factor.0), share(pbr.metallic_factor.0));
    let surface = Rgb::new(0.0, roughness, metalness);
    let metallic_roughness = match &pbr.metallic_roughness_texture {
        Some(info) => textures.texture(document, info, Meaning::Data, surface, &location)?,
        None => surface.into(),
    };
    let extensions = source.extensions.clone().unwrap_or_default();
    let relative_ior = extensions.ior.map_or(DEFAULT_IOR, |ior| match f64::from(ior.ior.0) {
        0.0 => INFINITE_IOR,
        ior => ior,
    });

    let transmission = extensions
        .transmission
        .as_ref()
        .map_or(0.0, |transmission| share(transmission.transmission_factor.0));
    if !(0.0..=1.0).contains(&transmission) {
        return Err(Error::new(
            location,
            format!("transmission must be in [0, 1], but is {transmission}"),
        ));
    }
    let transmitting = transmission * (1.0 - metalness);
    let transmits = transmission > 0.0 && transmitting > 0.0;
    let mut material = if transmits {
        if coat.is_some() {
            let reason = "its clear coat is left out, since it transmits light";
            document.warnings.warn(location.clone(), reason)?;
        }
        let rest = metalness / (1.0 - transmitting);
        let opaque = Material::MetallicRoughness {
            base_color: base_color.clone(),
            metallic_roughness: Rgb::new(0.0, roughness, rest.min(1.0)).into(),
            relative_ior,
        };
        let glass = glass(document, &source, base_color, roughness, relative_ior, &location)?;
        if transmitting >= 1.0 {
            glass
        } else {
            Material::Mixture {
                components: Box::new([opaque, glass]),
                weights: [1.0 - transmitting, transmitting],
            }
        }
    } else if let Some(coat) = coat {
        let coat = Box::new(coat.textures(document, textures, &location)?);
        Material::Coated { base_color, metallic_roughness, relative_ior, coat }
    } else {
        Material::MetallicRoughness { base_color, metallic_roughness, relative_ior }
    };

    let strength = extensions
        .emissive_strength
        .map_or(1.0, |strength| f64::from(strength.emissive_strength.0));
    let factor = Rgb(source.emissive_factor.0.map(f64::from)) * strength;
    let visible = visibility(document, textures, &source, opacity, vertex_colors, &location)?;
    // Lights see no vertices, and must not differ from what rays meet.
    let is_unseen = |visible: &&Texture| !factor.is_black() && visible.asks_vertices();
    if visible.as_ref().is_some_and(|visible| is_unseen(&visible)) {
        document.warnings.warn(
            location.clone(),
            "its emission is not reduced by alpha of vertices or of a second set of texture \
             coordinates",
        )?;
    }
    let cut = visible.as_ref().filter(|visible| !is_unseen(visible)).cloned();
    let mut cutout = None;
    if let Some(visible) = &visible {
        if visible.as_constant() == Some(Rgb::BLACK) {
            material = Material::Null;
        } else if visible.is_cut() && cut.is_some() {
            cutout = cut.clone();
        } else if matches!(material, Material::Mixture { .. }) {
            document.warnings.warn(
                location.clone(),
                "alpha is left out of a material that also transmits light in part",
            )?;
        } else {
            let components = Box::new([Material::Null, material]);
            material = Material::Blend { components, amount: visible.clone() };
            // Rays pass without an event where there is nothing.
            cutout = cut.clone().filter(|cut| cut.range()[0].is_black());
        }
    }
    let is_opaque = visible.is_none() && !transmits;
    // The back of what transmits light is where it leaves.
    let is_culled =
        !(document.back_faces || source.double_sided || transmits || material == Material::Null);

    let emission = match &source.emissive_texture {
        _ if factor.is_black() => None,
        Some(info) => Some(textures.texture(document, info, Meaning::Colour, factor, &location)?),
        None => Some(factor.into()),
    };
    // What is not there does not emit.
    let emission = match (emission, cut) {
        (Some(emission), Some(cut)) => Some(emission.times(cut)),
        (emission, _) => emission,
    };
    let relief = normal_map(document, textures, &source, normals.as_ref(), &location)?;
    let absorption = match extensions.volume {
        Some(volume) if transmitting > 0.0 && volume.thickness_factor.0 > 0.0 => {
            absorption(&volume, &location)?
        }
        _ => Rgb::BLACK,
    };
    let double_sided = source.double_sided;
    Ok(Look {
        material,
        emission,
        relief,
        absorption,
        double_sided,
        is_culled,
        is_opaque,
        cutout,
        coordinates,
    })
}

/// The clear coat of a material, with warnings of what it lacks.
fn clear_coat(
    document: &mut Document,
    source: &json::Material,
    location: &Location,
) -> Result<Option<ClearCoat>, Error> {
    let mut warn = |reason: String| document.warnings.warn(location.clone(), reason);
    let coat = match ClearCoat::of(&document.root, source) {
        Ok(coat) => coat,
        Err(reason) => {
            warn(format!("its clear coat is left out: {reason}"))?;
            None
        }
    };
    if coat.as_ref().is_some_and(|coat| !coat.shares_normals(source)) {
        warn("its clear coat has the normals of what is under it".to_owned())?;
    }
    Ok(coat)
}

/// The normal map of a material, and the transform of its texture coordinates.
fn normal_map(
    document: &mut Document,
    textures: &mut Textures,
    source: &json::Material,
    info: Option<&Info>,
    location: &Location,
) -> Result<Option<(Relief, DAffine2)>, Error> {
    let (Some(info), Some(normals)) = (info, &source.normal_texture) else { return Ok(None) };
    let texture = textures.texture(document, info, Meaning::Data, Rgb::WHITE, location)?;
    if texture.as_constant().is_some() {
        // There is no image to read.
        return Ok(None);
    }
    let relief = Relief::normal_map(texture, f64::from(normals.scale), GreenAxis::AgainstV);
    Ok(Some((relief, transform(info))))
}

/// The texture of the normal map, as other textures are given.
fn normal_info(source: &json::Material, location: &Location) -> Result<Option<Info>, Error> {
    let Some(normals) = &source.normal_texture else { return Ok(None) };
    let others = normals.extensions.as_ref().map(|extensions| &extensions.others);
    let transform = others
        .and_then(|others| others.get("KHR_texture_transform"))
        .map(|value| json::deserialize::from_value(value.clone()))
        .transpose()
        .map_err(|error| Error::caused(location.clone(), error))?;
    let extensions = json::extensions::texture::Info {
        texture_transform: transform,
        ..json::extensions::texture::Info::default()
    };
    Ok(Some(Info {
        index: normals.index,
        tex_coord: normals.tex_coord,
        extensions: Some(extensions),
        extras: None,
    }))
}

/// The transmitting part of a material.
fn glass(
    document: &mut Document,
    source: &json::Material,
    base_color: Texture,
    roughness: f64,
    relative_ior: f64,
    location: &Location,
) -> Result<Material, Error> {
    let extensions = source.extensions.clone().unwrap_or_default();
    let mut warn = |reason: &str| document.warnings.warn(location.clone(), reason);
    if extensions
        .transmission
        .is_some_and(|transmission| transmission.transmission_texture.is_some())
    {
        warn("the texture of transmission is left out, its factor holds everywhere")?;
    }
    if source.pbr_metallic_roughness.metallic_roughness_texture.is_some() {
        warn(
            "roughness and metalness of a material that transmits light do not vary: their texture is left out",
        )?;
    }
    let volume = extensions.volume.filter(|volume| volume.thickness_factor.0 > 0.0);
    let alpha = roughness * roughness;
    let glass = match volume {
        Some(_) => {
            if alpha > 0.0 {
                Material::RoughDielectric { relative_ior, alpha: glam::DVec2::splat(alpha) }
            } else {
                Material::Dielectric { relative_ior }
            }
        }
        None => {
            if alpha > 0.0 {
                warn("a rough thin wall cannot be represented: it is a smooth pane")?;
            }
            Material::ThinDielectric { relative_ior }
        }
    };
    if base_color.as_constant() == Some(Rgb::WHITE) {
        return Ok(glass);
    }
    Ok(glass.stained(base_color))
}

/// The absorption coefficient of a volume, of which the attenuation colour is left after the
/// attenuation distance. Where that leaves nothing, it is as much as the smallest number.
fn absorption(volume: &Volume, location: &Location) -> Result<Rgb, Error> {
    let distance = f64::from(volume.attenuation_distance.0);
    let colour = volume.attenuation_color.0.map(share);
    if !(distance > 0.0 && colour.iter().all(|c| (0.0..=1.0).contains(c))) {
        let reason = format!(
            "attenuation needs a positive distance and a colour in [0, 1], but has {distance} and \
             {colour:?}"
        );
        return Err(Error::new(location.clone(), reason));
    }
    Ok(Rgb(colour.map(|c| -libm::log(c.max(f64::MIN_POSITIVE)) / distance)))
}

/// The share of the surface that is there; `None` if all of it.
fn visibility(
    document: &mut Document,
    textures: &mut Textures,
    source: &json::Material,
    opacity: f64,
    vertex_colors: VertexColors,
    location: &Location,
) -> Result<Option<Texture>, Error> {
    let mode = match source.alpha_mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => AlphaMode::Opaque,
    };
    if mode == AlphaMode::Opaque {
        return Ok(None);
    }
    let alpha = match &source.pbr_metallic_roughness.base_color_texture {
        Some(info) => {
            textures.texture(document, info, Meaning::Alpha, Rgb::splat(opacity), location)?
        }
        None => Rgb::splat(opacity).into(),
    };
    let alpha = vertex_colors.on_alpha(alpha);
    let alpha = if mode == AlphaMode::Mask {
        let cutoff = source.alpha_cutoff.map_or(0.5, |cutoff| f64::from(cutoff.0));
        alpha.cut(cutoff)
    } else {
        alpha
    };
    Ok(Some(alpha).filter(|alpha| alpha.range()[0] != Rgb::WHITE))
}

/// The sets of texture coordinates of a material's textures, that of its emission first.
fn coordinate_sets(
    document: &mut Document,
    source: &json::Material,
    normals: Option<&Info>,
    coat: Option<&ClearCoat>,
    location: &Location,
) -> Result<[Option<u32>; 2], Error> {
    let pbr = &source.pbr_metallic_roughness;
    let infos: [&Option<Info>; 3] =
        [&source.emissive_texture, &pbr.base_color_texture, &pbr.metallic_roughness_texture];
    let coat = coat.into_iter().flat_map(ClearCoat::infos);
    let all = infos.into_iter().flatten().chain(normals).chain(coat);
    let sets: Vec<u32> = all.map(coordinate_set).collect();
    let first = sets.first().copied();
    let other = sets.iter().copied().find(|set| Some(*set) != first);
    if sets.iter().any(|set| ![first, other].contains(&Some(*set))) {
        document.warnings.warn(
            location.clone(),
            "its textures use more than two sets of texture coordinates: the first one's is used for the rest",
        )?;
    }
    Ok([first, other])
}

/// Adds warnings of everything that a material asks for in vain.
fn warn_about_the_rest(
    document: &mut Document,
    source: &json::Material,
    location: &Location,
) -> Result<(), Error> {
    let others = source.extensions.iter().flat_map(|extensions| extensions.others.keys());
    for name in others.filter(|name| *name != clear_coat::EXTENSION) {
        document.warnings.warn(
            location.clone(),
            format!("the extension {name} is not supported: it is shown without it"),
        )?;
    }
    Ok(())
}
