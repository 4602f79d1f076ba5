//! The ends of paths: lights and cameras.

use super::scene::SceneReader;
use crate::endpoint::{
    Camera, DirectionalLight, OrthographicCamera, PinholeCamera, PointLight, SpotLight,
};
use crate::film::Filter;
use crate::import::{Error, ImportedView, Location};
use crate::math::Rgb;
use glam::{DAffine3, DMat3, DVec2, DVec3, UVec2};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use gltf::json::validation::Checked;

impl SceneReader<'_> {
    pub fn add_light(
        &mut self,
        node: usize,
        index: usize,
        transform: &DAffine3,
        location: &Location,
    ) -> Result<(), Error> {
        let extensions = self.document.root.extensions.as_ref();
        let Some(light) = extensions
            .and_then(|extensions| extensions.khr_lights_punctual.as_ref()?.lights.get(index))
            .cloned()
        else {
            return Err(Error::new(location.clone(), format!("there is no light {index}")));
        };
        if light.range.is_some() {
            let reason = format!(
                "the range of light {index} is left out: light follows the inverse square law to any distance"
            );
            self.document.warnings.warn(location.clone(), reason)?;
        }
        let intensity = Rgb(light.color.map(f64::from)) * f64::from(light.intensity);
        let name = self.unique_name(location.id.as_deref().or(light.name.as_deref()), node, None);
        let position = transform.translation;
        let forward = match (light.type_, oriented(transform.matrix3)) {
            (Checked::Valid(LightType::Directional | LightType::Spot), None) => {
                let reason =
                    format!("its transform leaves light {index} no direction: it is left out");
                return self.document.warnings.warn(location.clone(), reason);
            }
            (_, axes) => -axes.unwrap_or_default().z_axis,
        };
        let refuse = |error| Error::caused(location.clone(), error);
        let added = match light.type_ {
            Checked::Valid(LightType::Point) => {
                self.builder.add_light(name, PointLight::new(position, intensity).map_err(refuse)?)
            }
            Checked::Valid(LightType::Directional) => self
                .builder
                .add_light(name, DirectionalLight::new(forward, intensity).map_err(refuse)?),
            Checked::Valid(LightType::Spot) => {
                let angles =
                    light.spot.map_or([0.0, f64::from(std::f32::consts::FRAC_PI_4)], |spot| {
                        [spot.inner_cone_angle, spot.outer_cone_angle].map(f64::from)
                    });
                let [inner, outer] = angles.map(f64::to_degrees);
                let spot =
                    SpotLight::new(position, forward, intensity, inner, outer).map_err(refuse)?;
                self.builder.add_light(name, spot.with_squared_falloff())
            }
            Checked::Invalid => {
                return Err(Error::new(
                    location.clone(),
                    format!("light {index} is of an unknown type"),
                ));
            }
        };
        added.map_err(|error| Error::caused(location.clone(), error))
    }

    pub fn add_camera(
        &mut self,
        node: usize,
        index: usize,
        transform: &DAffine3,
        location: &Location,
    ) -> Result<(), Error> {
        let camera = self.document.root.cameras[index].clone();
        let DAffine3 { matrix3, translation: position } = *transform;
        if matrix3.determinant() < 0.0 {
            self.document
                .warnings
                .warn(location.clone(), "the mirroring of a camera is left out")?;
        }
        let Some(axes) = oriented(matrix3)
            .filter(|axes| axes.y_axis.cross(axes.z_axis).try_normalize().is_some())
        else {
            let reason = "its transform leaves its camera no direction: it is left out";
            return self.document.warnings.warn(location.clone(), reason);
        };
        let (target, up) = (position - axes.z_axis, axes.y_axis);
        let refuse = |error| Error::caused(location.clone(), error);
        let missing = || {
            Error::new(location.clone(), format!("camera {index} lacks the properties of its type"))
        };
        let camera_box: Box<dyn Camera + Send> = match camera.type_ {
            Checked::Valid(CameraType::Perspective) => {
                let lens = camera.perspective.ok_or_else(missing)?;
                let film = self.film(lens.aspect_ratio.map(f64::from), location)?;
                Box::new(
                    PinholeCamera::new(
                        position,
                        target,
                        up,
                        f64::from(lens.yfov).to_degrees(),
                        film,
                    )
                    .map_err(refuse)?,
                )
            }
            Checked::Valid(CameraType::Orthographic) => {
                let lens = camera.orthographic.ok_or_else(missing)?;
                let (width, height) = (2.0 * f64::from(lens.xmag), 2.0 * f64::from(lens.ymag));
                let film = self.film(Some(width / height), location)?;
                Box::new(
                    OrthographicCamera::new(position, target, up, height, film).map_err(refuse)?,
                )
            }
            Checked::Invalid => return Err(missing()),
        };
        let name = location.id.clone().or(camera.name).unwrap_or_else(|| format!("camera {node}"));
        self.views.push(ImportedView { name, camera: camera_box, filter: Filter::default() });
        Ok(())
    }

    /// The largest film of an aspect ratio within the resolution that was asked for.
    fn film(&self, aspect_ratio: Option<f64>, location: &Location) -> Result<UVec2, Error> {
        let whole = self.resolution.as_dvec2();
        let Some(ratio) = aspect_ratio else { return Ok(self.resolution) };
        if !(ratio > 0.0 && ratio.is_finite()) {
            return Err(Error::new(
                location.clone(),
                format!("the aspect ratio of its camera must be positive, but is {ratio}"),
            ));
        }
        let height = whole.y.min(whole.x / ratio);
        let film = DVec2::new((height * ratio).min(whole.x), height).round().max(DVec2::ONE);
        Ok(film.as_uvec2())
    }
}

/// The axes of a node without their lengths, which mean nothing to lights and cameras. One of length
/// 0 is made of the two others; two stay 0, unless z, the direction, is one of them.
fn oriented(axes: DMat3) -> Option<DMat3> {
    let unit = |axis: DVec3, others: DVec3| {
        // First to a length whose square is a number.
        let scaled = axis / axis.abs().max_element();
        if scaled.is_finite() { scaled.normalize() } else { others.normalize_or_zero() }
    };
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = axes;
    let [x, y, z] = [unit(x, y.cross(z)), unit(y, z.cross(x)), unit(z, x.cross(y))];
    (z != DVec3::ZERO).then(|| DMat3::from_cols(x, y, z))
}
