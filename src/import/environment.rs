//! The environment of a scene: its file's, the one that the options want, or a white one.

use super::{Environment, Error, Location, Warnings};
use crate::endpoint::{
    AnyLight, ConstantEnvironment, Endpoint, EnvironmentMap, Light, LightId, Lookup,
};
use crate::film::ImageFile;
use crate::math::Rgb;
use crate::scene::{Scene, SurfaceArea, World, WorldBuilder};
use glam::{DMat3, DVec2};
use std::f64::consts::PI;

/// The mean radiance from which on a surface needs no other light to be seen.
const GLOW: f64 = 0.05;
/// The part of all surfaces, by area, that must glow for a scene to be seen by that: of those with
/// the same radiance everywhere, and of those with a texture, which may be labels or displays.
const GLOWING: [f64; 2] = [0.05, 0.25];
/// The part of a white environment's light from which on emission is a lamp.
const LAMP: f64 = 1e-3;
/// Rays that find out how much of the emission arrives somewhere.
const RAYS: u32 = 4096;

impl Environment {
    /// The light that is wished for in place of the file's own.
    ///
    /// # Errors
    /// If the image cannot be read, or the radiance is negative or not finite.
    pub fn light(&self) -> Result<Option<AnyLight>, Error> {
        let at = |element: &str| Location { element: element.to_owned(), ..Location::default() };
        match self {
            Self::Automatic | Self::None => Ok(None),
            Self::Colour(radiance) => ConstantEnvironment::new(*radiance)
                .map(|light| Some(light.into_any()))
                .map_err(|error| Error::caused(at("environment"), error)),
            Self::File(path) => {
                let at = Location { file: path.clone(), ..at("environment") };
                let image =
                    ImageFile::load(path).map_err(|error| Error::caused(at.clone(), error))?.image;
                let (width, height) = (image.width(), image.height());
                EnvironmentMap::new(width, height, image.pixels().to_vec(), DMat3::IDENTITY)
                    .map(|map| Some(map.with_lookup(Lookup::Bilinear).into_any()))
                    .map_err(|error| Error::caused(at, error))
            }
        }
    }

    /// Builds the scene of a file whose format has no environments, in the one that is wished for
    /// or, if nothing is and nothing else lights the scene, in a white one; then also returns a
    /// sentence on why.
    pub(super) fn surround(
        &self,
        mut builder: WorldBuilder,
        name: String,
        file: &Location,
        warnings: &mut Warnings,
    ) -> Result<(World, Option<&'static str>), Error> {
        let caused = |error| Error::caused(file.clone(), error);
        let has_lights = builder.has_lights();
        if *self != Self::Automatic || has_lights || !builder.has_emission() {
            let mut why = None;
            let environment = match self {
                Self::Automatic if has_lights => {
                    warnings.note("its own lights light it: no environment is added");
                    None
                }
                Self::Automatic => {
                    why = Some("it has no light: it is shown in a white environment");
                    Self::Colour(Rgb::WHITE).light()?
                }
                wish => wish.light()?,
            };
            if let Some(environment) = environment {
                builder.set_environment(name, environment).map_err(caused)?;
            }
            return Ok((builder.build().map_err(caused)?, why));
        }
        let world = builder.build().map_err(caused)?;
        if is_lit(&world) {
            warnings.note("its emission lights it: no environment is added");
            return Ok((world, None));
        }
        let why = "its emission is too faint to light it: it is shown in a white environment";
        let white = ConstantEnvironment::new(Rgb::WHITE)
            .map_err(|error| Error::caused(file.clone(), error))?;
        Ok((world.with_environment(name, white).map_err(caused)?, Some(why)))
    }
}

/// True if many surfaces glow, or if emission lights others. What counts is the flux that arrives
/// at surfaces times the part of it that does: a label or a display shines out of the scene, a lamp
/// into it.
fn is_lit(world: &World) -> bool {
    let lights = || (0..world.light_count()).map(|index| world.light(LightId(index as u32)));
    let glow = lights().map(|light| match light {
        AnyLight::Area(light) => {
            let sides = if light.is_two_sided() { 2.0 } else { 1.0 };
            let glows = light.power().mean() >= GLOW * PI * sides * light.area();
            let needed = GLOWING[usize::from(light.radiance().as_constant().is_none())];
            if glows { light.area() / needed } else { 0.0 }
        }
        _ => 0.0,
    });
    let (arriving, emitted) =
        (arriving(world), lights().map(|light| light.power().mean()).sum::<f64>());
    // A white environment sends π to a surface that has nothing before it.
    glow.sum::<f64>() >= world.total_area()
        || arriving * arriving > LAMP * PI * world.total_area() * emitted
}

/// The flux that surfaces get directly from those that emit, by the mean of some light walks of one
/// edge.
fn arriving(world: &World) -> f64 {
    let ray = |index: u32| -> Option<f64> {
        // Roberts' sequence in six dimensions: 1/φ^k, φ⁷ = φ + 1.
        let mut power = 1.0;
        let [a, b, c, d, e, f] = [(); 6].map(|()| {
            power /= 1.112_775_684_278_706;
            (0.5 + f64::from(index) * power).fract()
        });
        let (id, pmf) = world.pick_light(a)?;
        let light = world.light(id);
        let start = light.sample_point(b, DVec2::new(c, d))?;
        let next = light.sample_direction(&start.point, DVec2::new(e, f))?;
        world.intersect(&next.from, next.direction)?;
        Some(next.weight.mean() / (start.pdf.value() * pmf))
    };
    (0..RAYS).filter_map(ray).sum::<f64>() / f64::from(RAYS)
}
