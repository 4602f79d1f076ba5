//! Clear coats: `KHR_materials_clearcoat`.

use super::document::Document;
use super::texture::{Meaning, Textures};
use crate::import::{Error, Location};
use crate::material::Texture;
use crate::math::Rgb;
use gltf::json;
use gltf::json::texture::Info;

pub(super) const EXTENSION: &str = "KHR_materials_clearcoat";

/// A clear coat as the file describes it.
pub(super) struct ClearCoat {
    share: f64,
    share_texture: Option<Info>,
    roughness: f64,
    roughness_texture: Option<Info>,
    /// The texture of its normal map.
    normals: Option<usize>,
}

impl ClearCoat {
    /// The clear coat of a material, if it has one that can be seen.
    ///
    /// # Errors
    /// If it is malformed: the reason.
    pub fn of(root: &json::Root, material: &json::Material) -> Result<Option<Self>, String> {
        let extensions = material.extensions.as_ref();
        let Some(coat) = extensions.and_then(|extensions| extensions.others.get(EXTENSION)) else {
            return Ok(None);
        };
        let factor = |name: &str| match coat.get(name) {
            None => Ok(0.0),
            Some(value) => value
                .as_f64()
                .map(|factor| super::material::share(factor as f32))
                .filter(|factor| (0.0..=1.0).contains(factor))
                .ok_or_else(|| format!("{name} must be a number in [0, 1], but is {value}")),
        };
        let texture = |name: &str| {
            let Some(value) = coat.get(name) else { return Ok(None) };
            let info: Info = json::deserialize::from_value(value.clone())
                .map_err(|error| format!("{name}: {error}"))?;
            let exists = info.index.value() < root.textures.len();
            if exists { Ok(Some(info)) } else { Err(format!("{name} does not exist")) }
        };
        let coat = Self {
            share: factor("clearcoatFactor")?,
            share_texture: texture("clearcoatTexture")?,
            roughness: factor("clearcoatRoughnessFactor")?,
            roughness_texture: texture("clearcoatRoughnessTexture")?,
            normals: texture("clearcoatNormalTexture")?.map(|info| info.index.value()),
        };
        Ok(Some(coat).filter(|coat| coat.share > 0.0))
    }

    /// The textures that are read.
    pub fn infos(&self) -> impl Iterator<Item = &Info> {
        self.share_texture.iter().chain(&self.roughness_texture)
    }

    /// Share and roughness of the coat, in red and in green.
    pub fn textures(
        &self,
        document: &mut Document,
        textures: &mut Textures,
        location: &Location,
    ) -> Result<[Texture; 2], Error> {
        let mut read = |info: &Option<Info>, factor: Rgb| match info {
            Some(info) => textures.texture(document, info, Meaning::Data, factor, location),
            None => Ok(factor.into()),
        };
        Ok([
            read(&self.share_texture, Rgb::new(self.share, 0.0, 0.0))?,
            read(&self.roughness_texture, Rgb::new(0.0, self.roughness, 0.0))?,
        ])
    }

    /// True if the coat has the normal map of the material under it, or neither has one.
    pub fn shares_normals(&self, material: &json::Material) -> bool {
        self.normals == material.normal_texture.as_ref().map(|normals| normals.index.value())
    }
}
