//! Lights that are not surfaces.

use super::super::{Environment, Error};
use super::Loader;
use super::document::Element;
use super::spectrum::Illuminant;
use super::values::Object;
use crate::endpoint::{
    ConstantEnvironment, DirectionalLight, EndpointError, EnvironmentMap, Light, Lookup,
    PointLight, SpotLight,
};
use crate::material::Texture;
use crate::math::Rgb;
use crate::scene::SceneError;
use glam::{DAffine3, DMat3, DVec3};

impl<'a> Loader<'a> {
    /// Adds an emitter of the scene. Area lights in their place are left to the shapes that refer
    /// to them.
    pub(super) fn emitter(&mut self, element: &'a Element) -> Result<(), Error> {
        if self.options.environment != Environment::Automatic
            && matches!(element.kind(), "constant" | "envmap" | "sky" | "sunsky")
        {
            let reason = "its environment gives way to the one that is wished for";
            self.warnings.note(format!("{}: {reason}", element.location()));
            return Ok(());
        }
        let object = Object::new(element);
        let made = |error: EndpointError| element.caused(error);
        match element.kind() {
            "area" => {
                if !self.referenced.contains(&std::ptr::from_ref(element)) {
                    self.warn(element, "an area light that belongs to no shape is left out")?;
                }
                return Ok(());
            }
            "point" => {
                let intensity = self.emitted(&object, "intensity")?;
                let position = match object.vector("position")? {
                    Some(position) => position,
                    None => object.transform("to_world")?.translation,
                };
                self.light(element, PointLight::new(position, intensity).map_err(made)?)?;
            }
            "spot" => {
                let intensity = self.emitted(&object, "intensity")?;
                let to_world = object.transform("to_world")?;
                let cutoff = object.float_or("cutoff_angle", 20.0)?;
                let beam = object.float_or("beam_width", 0.75 * cutoff)?;
                let light = SpotLight::new(
                    to_world.translation,
                    to_world.transform_vector3(DVec3::Z),
                    intensity,
                    beam,
                    cutoff,
                )
                .map_err(made)?;
                self.light(element, light.with_linear_falloff())?;
            }
            "directional" => {
                let irradiance = self.emitted(&object, "irradiance")?;
                let direction = match object.vector("direction")? {
                    Some(direction) => direction,
                    None => object.transform("to_world")?.transform_vector3(DVec3::Z),
                };
                self.light(element, DirectionalLight::new(direction, irradiance).map_err(made)?)?;
            }
            "constant" => {
                let radiance = self.emitted(&object, "radiance")?;
                self.environment(element, ConstantEnvironment::new(radiance).map_err(made)?)?;
            }
            "envmap" => {
                let map = self.environment_map(&object)?;
                self.environment(element, map)?;
            }
            other => {
                return self.warn(
                    element,
                    format!("emitters of type {other} are not supported, and left out"),
                );
            }
        }
        object.ignore(&["sampling_weight"]);
        object.finish(&mut self.warnings)
    }

    /// The radiance of the area light in a shape.
    pub(super) fn area_light(&mut self, element: &'a Element) -> Result<Option<Texture>, Error> {
        let element = self.resolved(element)?;
        if element.kind() != "area" {
            self.warn(element, "only area lights can belong to a shape; it is left out")?;
            return Ok(None);
        }
        let object = Object::new(element);
        let radiance =
            self.texture(&object, "radiance", Illuminant::Equal)?.unwrap_or(Rgb::WHITE.into());
        object.ignore(&["sampling_weight"]);
        object.finish(&mut self.warnings)?;
        Ok(Some(radiance))
    }

    fn emitted(&mut self, object: &Object<'a>, name: &str) -> Result<Rgb, Error> {
        Ok(self.colour(object, name, Illuminant::Equal)?.unwrap_or(Rgb::WHITE))
    }

    fn light(
        &mut self,
        element: &'a Element,
        light: impl Light + Send + 'static,
    ) -> Result<(), Error> {
        let name = self.name(element);
        self.builder.add_light(name, light).map_err(|error| element.caused(error))
    }

    fn environment(
        &mut self,
        element: &'a Element,
        light: impl Light + Send + 'static,
    ) -> Result<(), Error> {
        let name = self.name(element);
        self.builder.set_environment(name, light).map_err(|error: SceneError| element.caused(error))
    }

    fn environment_map(&mut self, object: &Object<'a>) -> Result<EnvironmentMap, Error> {
        let element = object.element;
        let scale = object.float_or("scale", 1.0)?;
        let name =
            object.string("filename")?.ok_or_else(|| element.error("the filename is missing"))?;
        let image = self.image(name, element, false)?;
        let rotation = rotation(element, &object.transform("to_world")?)?;
        let pixels = image.pixels().iter().map(|pixel| *pixel * scale).collect();
        let map = EnvironmentMap::new(image.width(), image.height(), pixels, rotation)
            .map_err(|error| element.caused(error))?;
        Ok(map.with_lookup(Lookup::BilinearToPoles))
    }
}

/// The linear part without its scale, which must be the same along all axes.
fn rotation(element: &Element, to_world: &DAffine3) -> Result<DMat3, Error> {
    let scale = libm::cbrt(to_world.matrix3.determinant().abs());
    let rotation = to_world.matrix3 * (1.0 / scale);
    let error = rotation.transpose() * rotation - DMat3::IDENTITY;
    if error.to_cols_array().iter().all(|e| e.abs() < 1e-4) {
        Ok(rotation)
    } else {
        Err(element.error("to_world is not a rotation"))
    }
}
