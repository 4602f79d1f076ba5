//! Cameras and what belongs to them: film, filter, sampler and integrator.

use super::super::{Error, ImportedView};
use super::Loader;
use super::object::Object;
use crate::endpoint::{Camera, EndpointError, OrthographicCamera, PinholeCamera, ThinLensCamera};
use crate::film::{FilmRegion, Filter};
use glam::{DAffine3, DVec2, DVec3, UVec2};

/// The focal length in millimetres that a lens has whose file is not read.
const FOCAL_LENGTH: f64 = 50.0;

/// Integrators that estimate what the camera sees along paths of up to `maxdepth` scattering
/// events.
const OF_PATHS: [&str; 9] = [
    "path",
    "volpath",
    "simplepath",
    "simplevolpath",
    "lightpath",
    "bdpt",
    "mlt",
    "sppm",
    "randomwalk",
];

/// What is described before the world begins.
#[derive(Default)]
pub(super) struct Setup {
    /// The camera, and the transform from the world to it.
    pub camera: Option<(Object, DAffine3)>,
    pub film: Option<Object>,
    pub filter: Option<Object>,
}

/// What the window of a camera is in its own units.
struct Screen {
    min: DVec2,
    max: DVec2,
}

impl Loader {
    /// The factor between radiance and what the film records.
    pub(super) fn film_scale(&mut self) -> Result<f64, Error> {
        let mut exposure = 1.0;
        if let Some((camera, _)) = &self.setup.camera {
            let (open, close) = (camera.number("shutteropen"), camera.number("shutterclose"));
            exposure = close?.unwrap_or(1.0) - open?.unwrap_or(0.0);
        }
        let Some(film) = &self.setup.film else { return Ok(exposure) };
        let factor = film.number_or("scale", 1.0)? * film.number_or("iso", 100.0)? / 100.0;
        if !matches!(film.text("sensor")?, None | Some("cie1931")) {
            let reason = "the film's sensor is not supported: colours are those that one sees";
            self.warnings.warn(film.location.clone(), reason)?;
        }
        let scale = exposure * factor;
        if scale > 0.0 { Ok(scale) } else { Err(film.error("the exposure is not positive")) }
    }

    /// The view of the camera, or of pbrt's own one if the file has none.
    pub(super) fn view(&mut self) -> Result<ImportedView, Error> {
        let setup = std::mem::take(&mut self.setup);
        let region = match &setup.film {
            None => None,
            Some(film) => {
                let region = self.film(film);
                self.warnings.rescue(region, "another film is taken")?
            }
        };
        let region = region.unwrap_or(FilmRegion::full(UVec2::new(1280, 720)));
        let region = self.options.fitted(region);
        let diagonal =
            setup.film.as_ref().map_or(Ok(35.0), |film| film.number_or("diagonal", 35.0));
        let filter = match &setup.filter {
            None => Ok(gaussian(1.5, 0.5)),
            Some(filter) => self.filter(filter),
        };
        let filter = self.warnings.rescue(filter, "a Gaussian is taken")?;
        let filter = filter.unwrap_or(gaussian(1.5, 0.5));
        let given = match &setup.camera {
            None => {
                let reason = "the scene has no camera; it looks along z from the origin";
                self.warnings.warn(self.location(), reason)?;
                None
            }
            Some((object, from_world)) => {
                let camera = self.camera(object, from_world, region, diagonal?);
                self.warnings.rescue(camera, "another camera is taken")?
            }
        };
        let camera = match given {
            Some(camera) => camera,
            None => {
                let from_world = setup.camera.map(|(_, from_world)| from_world);
                let from_world = from_world.filter(|m| m.inverse().is_finite()).unwrap_or_default();
                let plain = Object { location: self.location(), ..Object::default() };
                self.camera(&plain, &from_world, region, 35.0)?
            }
        };
        Ok(ImportedView { name: "camera 1".to_owned(), camera, filter })
    }

    fn camera(
        &mut self,
        object: &Object,
        from_world: &DAffine3,
        region: FilmRegion,
        diagonal: f64,
    ) -> Result<Box<dyn Camera + Send>, Error> {
        let FilmRegion { resolution, window_min, window_max } = region;
        let size = resolution.as_dvec2();
        // The camera's space has x to the right, y up, and looks along z: it is left-handed.
        let to_world = from_world.inverse();
        let axes = to_world.matrix3;
        let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
        let lengths = DVec3::new(x.length(), y.length(), z.length());
        if !(to_world.is_finite() && lengths.min_element() > 0.0) {
            return Err(object.error("the transform of the camera is not invertible"));
        }
        let skew = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
        if lengths.max_element() - lengths.min_element() > 1e-3 * lengths.z
            || skew > 1e-3 * lengths.z * lengths.z
        {
            let reason = "the transform of the camera is no rotation: its axes y and z are taken";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        let is_mirrored = z.cross(y).dot(x) < 0.0;
        let position = to_world.translation;
        let screen = self.screen(object, size)?;
        let made = |error: EndpointError| object.caused(error);
        let kind = object.kind.as_str();
        let camera: Box<dyn Camera + Send> = if kind == "orthographic" {
            let center = 0.5 * (screen.min + screen.max);
            let position = position + x * center.x + y * center.y;
            let height = (screen.max.y - screen.min.y) * lengths.y;
            let camera = OrthographicCamera::new(position, position + z, y, height, resolution)
                .and_then(|camera| camera.with_window(window_min, window_max))
                .map_err(made)?;
            Box::new(if is_mirrored { camera.mirrored() } else { camera })
        } else {
            // Half the angle of the shorter side has this tangent; the screen's unit is that side.
            let tangent = match kind {
                "" | "perspective" => {
                    let fov = match object.number("halffov")? {
                        Some(half) => 2.0 * half,
                        None => object.number_or("fov", 90.0)?,
                    };
                    if !(fov > 0.0 && fov < 180.0) {
                        let reason = format!("fov is {fov}, but must be between 0 and 180 degrees");
                        return Err(object.error(reason));
                    }
                    libm::tan(0.5 * fov.to_radians())
                }
                "realistic" => 0.5 * diagonal / FOCAL_LENGTH * size.min_element() / size.length(),
                _ => 1.0,
            };
            if !matches!(kind, "" | "perspective") {
                let reason = format!("a {kind} camera is not supported; it is perspective instead");
                self.warnings.warn(object.location.clone(), reason)?;
                object.ignore(&["lensfile", "aperturediameter", "focusdistance", "aperture"]);
                object.ignore(&["mapping", "simpleweighting"]);
            }
            let fov = 2.0 * libm::atan(0.5 * (screen.max.y - screen.min.y) * tangent).to_degrees();
            let principal_point =
                DVec2::new(-screen.min.x, screen.max.y) / (screen.max - screen.min) * size;
            let radius = object.number_or("lensradius", 0.0)? * lengths.x;
            let focus = object.number_or("focaldistance", 1e6)? * lengths.z;
            let target = position + z;
            if radius > 0.0 {
                let camera =
                    ThinLensCamera::new(position, target, y, fov, radius, focus, resolution)
                        .and_then(|camera| camera.with_principal_point(principal_point))
                        .and_then(|camera| camera.with_window(window_min, window_max))
                        .map_err(made)?;
                Box::new(if is_mirrored { camera.mirrored() } else { camera })
            } else {
                let camera = PinholeCamera::new(position, target, y, fov, resolution)
                    .and_then(|camera| camera.with_principal_point(principal_point))
                    .and_then(|camera| camera.with_window(window_min, window_max))
                    .map_err(made)?;
                Box::new(if is_mirrored { camera.mirrored() } else { camera })
            }
        };
        object.ignore(&["shutteropen", "shutterclose", "lensradius", "focaldistance"]);
        object.finish(&mut self.warnings)?;
        Ok(camera)
    }

    /// The window, from -1 to 1 along the shorter side if nothing else is said.
    fn screen(&mut self, object: &Object, size: DVec2) -> Result<Screen, Error> {
        let aspect = object.number_or("frameaspectratio", size.x / size.y)?;
        let half =
            if aspect > 1.0 { DVec2::new(aspect, 1.0) } else { DVec2::new(1.0, 1.0 / aspect) };
        let screen = match object.numbers("screenwindow")? {
            None => Screen { min: -half, max: half },
            Some(&[x0, x1, y0, y1]) => Screen { min: DVec2::new(x0, y0), max: DVec2::new(x1, y1) },
            Some(_) => return Err(object.error("a screenwindow has four numbers")),
        };
        let extent = screen.max - screen.min;
        if !(extent.is_finite() && extent.cmpgt(DVec2::ZERO).all()) {
            return Err(object.error("the screen of the camera is empty"));
        }
        let pixel = extent / size;
        if (pixel.x - pixel.y).abs() > 1e-3 * pixel.y {
            let reason = "pixels are square here: their height is taken";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        Ok(screen)
    }

    fn film(&mut self, object: &Object) -> Result<FilmRegion, Error> {
        // Version 3 has another size.
        let default = if object.kind == "image" { [640, 480] } else { [1280, 720] };
        let resolution = UVec2::new(
            object.count("xresolution")?.unwrap_or(default[0]),
            object.count("yresolution")?.unwrap_or(default[1]),
        );
        let [width, height] = resolution.to_array();
        if u64::from(width) * u64::from(height) > self.limits.pixels {
            let reason =
                format!("a film of {width} x {height} pixels is larger than the limit admits");
            return Err(object.limit(reason));
        }
        if width == 0 || height == 0 {
            return Err(object.error("the film has no pixels"));
        }
        let mut region = FilmRegion::full(resolution);
        let window = match (object.numbers("cropwindow")?, object.numbers("pixelbounds")?) {
            (Some(&[x0, x1, y0, y1]), _) => {
                let size = resolution.as_dvec2();
                let corner = |x: f64, y: f64| {
                    (DVec2::new(x, y).clamp(DVec2::ZERO, DVec2::ONE) * size).ceil()
                };
                Some([corner(x0.min(x1), y0.min(y1)), corner(x0.max(x1), y0.max(y1))])
            }
            (None, Some(&[x0, x1, y0, y1])) => Some([DVec2::new(x0, y0), DVec2::new(x1, y1)]),
            (None, None) => None,
            _ => return Err(object.error("a window of the film has four numbers")),
        };
        if let Some(corners) = window {
            let [min, max] = corners.map(|corner| corner.as_uvec2().min(resolution));
            if min.cmpge(max).any() {
                return Err(object.error("the window of the film is empty"));
            }
            region = FilmRegion { window_min: min, window_max: max, ..region };
        }
        object.ignore(&["filename", "savefp16", "diagonal", "iso", "scale", "sensor"]);
        object.ignore(&["coordinatesystem", "whitebalance", "exposuretime"]);
        object.finish(&mut self.warnings)?;
        Ok(region)
    }

    /// The filter. One whose form the crate lacks is a Gaussian of the same variance.
    fn filter(&mut self, object: &Object) -> Result<Filter, Error> {
        let mut radius = |default: f64| -> Result<f64, Error> {
            let [x, y] = [
                object.number("xradius")?.or(object.number("xwidth")?).unwrap_or(default),
                object.number("yradius")?.or(object.number("ywidth")?).unwrap_or(default),
            ];
            if x != y {
                let reason = "a filter is as wide along x as along y here; x is taken";
                self.warnings.warn(object.location.clone(), reason)?;
            }
            Ok(x)
        };
        let (filter, is_same) = match object.kind.as_str() {
            "box" => match radius(0.5)? {
                0.5 => (Filter::Box, true),
                r => (of_variance(r * r / 3.0), false),
            },
            "triangle" => match radius(2.0)? {
                1.0 => (Filter::Tent, true),
                r => (of_variance(r * r / 6.0), false),
            },
            "gaussian" => {
                let radius = radius(1.5)?;
                // Version 3 has the exponent's factor instead.
                let sigma = match object.number("alpha")? {
                    Some(alpha) => (0.5 / alpha).sqrt(),
                    None => object.number_or("sigma", 0.5)?,
                };
                (gaussian(radius, sigma), true)
            }
            _ => {
                object.ignore(&["B", "C", "tau", "xradius", "yradius", "xwidth", "ywidth"]);
                (gaussian(1.5, 0.5), false)
            }
        };
        if !is_same {
            let reason = format!("a {} filter of this sort is a Gaussian instead", object.kind);
            self.warnings.warn(object.location.clone(), reason)?;
        }
        object.finish(&mut self.warnings)?;
        filter.kernel().map_err(|error| object.caused(error))?;
        Ok(filter)
    }

    pub(super) fn sampler(&mut self, object: &Object) -> Result<(), Error> {
        self.hints.sampler = Some(object.kind.clone());
        let samples = match object.count("pixelsamples")? {
            Some(samples) => Some(samples),
            None if object.kind == "stratified" => {
                let [x, y] = [object.count("xsamples")?, object.count("ysamples")?];
                Some(x.unwrap_or(4).saturating_mul(y.unwrap_or(4)))
            }
            None => None,
        };
        self.hints.samples_per_pixel = samples.or(Some(16)).filter(|samples| *samples > 0);
        Ok(())
    }

    pub(super) fn integrator(&mut self, object: &Object) -> Result<(), Error> {
        let kind = object.kind.as_str();
        self.hints.integrator = Some(kind.to_owned());
        self.hints.max_bounces = match (kind, object.count("maxdepth")?) {
            ("directlighting" | "whitted", _) => {
                let reason = format!("of the integrator {kind} one scattering event is taken");
                self.warnings.warn(object.location.clone(), reason)?;
                Some(1)
            }
            (_, depth) => {
                if !OF_PATHS.contains(&kind) {
                    let reason =
                        format!("the integrator {kind} is not supported; it is path instead");
                    self.warnings.warn(object.location.clone(), reason)?;
                }
                depth.or(Some(5))
            }
        };
        Ok(())
    }
}

/// A filter that is Gaussian minus its value at the radius, as pbrt's is.
fn gaussian(radius: f64, sigma: f64) -> Filter {
    let value = |x: f64| libm::exp(-0.5 * (x / sigma).powi(2));
    const STEPS: u32 = 1000;
    let (mut sum, mut square) = (0.0, 0.0);
    for i in 0..STEPS {
        let x = radius * (f64::from(i) + 0.5) / f64::from(STEPS);
        let weight = value(x) - value(radius);
        sum += weight;
        square += weight * x * x;
    }
    of_variance(square / sum)
}

/// A filter of a variance per axis.
fn of_variance(variance: f64) -> Filter {
    // That of the pixel's box is the least.
    if variance > 1.0 / 12.0 + 1e-9 {
        Filter::Gaussian { standard_deviation: variance.sqrt() }
    } else {
        Filter::Box
    }
}
