//! Media inside of shapes, as far as they absorb.

use super::super::Error;
use super::Loader;
use super::document::Element;
use super::spectrum::Illuminant;
use super::values::Object;
use crate::math::Rgb;

/// Integrators that do not see media.
const WITHOUT_MEDIA: [&str; 5] = ["path", "direct", "prb", "prb_basic", "prb_projective"];

impl<'a> Loader<'a> {
    /// The absorption coefficient of a medium that a shape refers to; `None` if it is left out.
    pub(super) fn absorption(
        &mut self,
        child: &'a Element,
        medium: &'a Element,
    ) -> Result<Option<Rgb>, Error> {
        if child.attribute("name") != Some("interior") {
            self.warn(child, "media around shapes are not supported, and left out")?;
            return Ok(None);
        }
        let integrator = self.hints.integrator.as_deref();
        if integrator.is_some_and(|kind| WITHOUT_MEDIA.contains(&kind)) {
            self.warn(child, "the scene's integrator does not see media: it is left out")?;
            return Ok(None);
        }
        if medium.kind() != "homogeneous" {
            let kind = medium.kind();
            self.warn(medium, format!("media of type {kind} are not supported, and left out"))?;
            return Ok(None);
        }
        let object = Object::new(medium);
        let scale = object.float_or("scale", 1.0)?;
        let (sigma_a, sigma_s) =
            (self.coefficient(&object, "sigma_a")?, self.coefficient(&object, "sigma_s")?);
        let (absorbed, scattered) = match (sigma_a, sigma_s) {
            (None, None) => {
                let sigma_t = self.coefficient(&object, "sigma_t")?.unwrap_or(Rgb::WHITE);
                let albedo = self.coefficient(&object, "albedo")?.unwrap_or(Rgb::splat(0.75));
                (sigma_t * (Rgb::WHITE - albedo), sigma_t * albedo)
            }
            (a, s) => (a.unwrap_or(Rgb::BLACK), s.unwrap_or(Rgb::BLACK)),
        };
        object.ignore(&["sample_emitters", "has_spectral_extinction"]);
        if !scattered.is_black() {
            self.warn(medium, "scattering inside of media is not supported: it absorbs only")?;
        }
        // Phase functions mean nothing where nothing scatters.
        let _ = object.objects();
        object.finish(&mut self.warnings)?;
        Ok(Some(absorbed * scale))
    }

    /// A coefficient of a medium: a colour, or a volume of one.
    fn coefficient(&mut self, object: &Object<'a>, name: &str) -> Result<Option<Rgb>, Error> {
        let Some(element) = object.get(name) else { return Ok(None) };
        let element = self.resolved(element)?;
        if element.tag == "volume" {
            let volume = Object::new(element);
            if element.kind() != "constvolume" {
                return Err(element.error("volumes that vary are not supported"));
            }
            return self.colour(&volume, "value", Illuminant::Equal);
        }
        self.colour(object, name, Illuminant::Equal)
    }
}
