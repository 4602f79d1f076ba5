//! Cameras and their films.

use super::super::{Error, Location, Warnings};
use super::document::Element;
use super::values::{Object, number};
use super::{ImportedView, Loader};
use crate::endpoint::{Camera, EndpointError, OrthographicCamera, PinholeCamera, ThinLensCamera};
use crate::film::{FilmRegion, Filter};
use crate::geometry::Bounds;
use crate::math::unit;
use glam::{DAffine3, DMat3, DVec2, DVec3, UVec2};

/// Diagonal of a small-picture film, 36 mm × 24 mm.
const SMALL_PICTURE_DIAGONAL: f64 = 43.266_615_305_567_87;

/// The distance of the plane beyond which a camera sees nothing in Mitsuba if it does not say.
const FAR_CLIP: f64 = 1e4;

/// The planes beyond which a camera does not see in Mitsuba, and does here.
pub(super) struct Clip {
    location: Location,
    position: DVec3,
    forward: DVec3,
    planes: [Option<f64>; 2],
}

impl Clip {
    /// Warns if something of the scene is beyond the planes.
    pub fn check(self, bounds: Bounds, warnings: &mut Warnings) -> Result<(), Error> {
        let center = if bounds.is_empty() { self.position } else { bounds.center() };
        let half = if bounds.is_empty() { DVec3::ZERO } else { 0.5 * (bounds.max - bounds.min) };
        let (depth, reach) =
            ((center - self.position).dot(self.forward), half.dot(self.forward.abs()));
        let [near, far] = self.planes;
        // What is behind the camera cannot be seen either way.
        if near.is_some_and(|near| depth - reach < near && depth + reach > 0.0)
            || far.is_some_and(|far| depth + reach > far)
        {
            warnings.warn(self.location, "the scene reaches beyond near_clip or far_clip, which are not supported: nothing is cut off")?;
        }
        Ok(())
    }
}

/// Film size, window and filter.
struct FilmPlan {
    region: FilmRegion,
    filter: Filter,
}

impl<'a> Loader<'a> {
    /// The camera of a sensor.
    pub(super) fn sensor(
        &mut self,
        element: &'a Element,
        index: usize,
    ) -> Result<(ImportedView, Clip), Error> {
        let object = Object::new(element);
        let to_world = object.transform("to_world")?;
        let [position, forward, up] = self.pose(element, &to_world)?;
        let is_mirrored = to_world.matrix3.determinant() < 0.0;
        let target = position + forward;
        let mut film = None;
        for child in object.objects() {
            let child = self.resolved(child)?;
            match child.tag.as_str() {
                "film" => {
                    let plan = self.film(child);
                    film = self.warnings.rescue(plan, "another film is taken")?;
                }
                "sampler" => {
                    self.hints.sampler = Some(child.kind().to_owned());
                    let samples = Object::new(child).integer("sample_count");
                    let samples = self.warnings.rescue(samples, "it is not taken")?.flatten();
                    self.hints.samples_per_pixel = samples
                        .and_then(|n| u32::try_from(n).ok())
                        .or(self.hints.samples_per_pixel);
                }
                "medium" => {
                    self.warn(child, "participating media are not supported, and left out")?
                }
                other => self
                    .warn(child, format!("a {other} in a sensor is not supported, and left out"))?,
            }
        }
        let film = film.map_or_else(|| film_plan(element, 768, 576), Ok)?;
        let region = self.options.fitted(film.region);
        let FilmRegion { resolution, window_min, window_max } = region;
        let size = resolution.as_dvec2();
        let planes = [object.float("near_clip")?, object.float("far_clip")?];
        let clip = Clip { location: element.location(), position, forward, planes };
        let offset = DVec2::new(
            object.float_or("principal_point_offset_x", 0.0)?,
            object.float_or("principal_point_offset_y", 0.0)?,
        );
        let principal_point = size * (0.5 - offset);
        let made = |error: EndpointError| element.caused(error);
        let camera: Box<dyn Camera + Send> = match element.kind() {
            "orthographic" => {
                object.ignore(&["focus_distance"]);
                let [x, y] = [to_world.matrix3.x_axis.length(), to_world.matrix3.y_axis.length()];
                if (x - y).abs() > 1e-6 * x {
                    self.warn(element, "the pixels of an orthographic sensor are square here: its scale along x is taken")?;
                }
                // The film is two units wide before it is scaled.
                let camera = OrthographicCamera::new(
                    position,
                    target,
                    up,
                    2.0 * x * size.y / size.x,
                    resolution,
                )
                .and_then(|camera| camera.with_window(window_min, window_max))
                .map_err(made)?;
                Box::new(if is_mirrored { camera.mirrored() } else { camera })
            }
            kind => {
                if !matches!(kind, "perspective" | "thinlens") {
                    self.warn(
                        element,
                        format!(
                            "sensors of type {kind} are not supported; it is perspective instead"
                        ),
                    )?;
                }
                let fov = vertical_fov(&object, size);
                let fov = self.warnings.rescue(fov, "the lens is one of 50 mm instead")?;
                let fov = fov.unwrap_or_else(|| default_fov(size));
                let focus = object.float("focus_distance")?.or(planes[1]).unwrap_or(FAR_CLIP);
                let radius =
                    if kind == "thinlens" { object.float("aperture_radius")? } else { Some(0.0) };
                if radius.is_none_or(|radius| radius < 0.0) {
                    self.warn(
                        element,
                        "aperture_radius is missing or negative; the lens is a point",
                    )?;
                }
                match radius.filter(|radius| *radius > 0.0) {
                    None => {
                        let camera = PinholeCamera::new(position, target, up, fov, resolution)
                            .and_then(|camera| camera.with_principal_point(principal_point))
                            .and_then(|camera| camera.with_window(window_min, window_max))
                            .map_err(made)?;
                        Box::new(if is_mirrored { camera.mirrored() } else { camera })
                    }
                    Some(radius) => {
                        let camera = ThinLensCamera::new(
                            position, target, up, fov, radius, focus, resolution,
                        )
                        .and_then(|camera| camera.with_principal_point(principal_point))
                        .and_then(|camera| camera.with_window(window_min, window_max))
                        .map_err(made)?;
                        Box::new(if is_mirrored { camera.mirrored() } else { camera })
                    }
                }
            }
        };
        object.finish(&mut self.warnings)?;
        let name = element.id().map_or_else(|| format!("camera {}", index + 1), str::to_owned);
        Ok((ImportedView { name, camera, filter: film.filter }, clip))
    }

    /// Position, view and up vector. A camera's space looks along z, with y up and x to the left.
    fn pose(&mut self, element: &'a Element, to_world: &DAffine3) -> Result<[DVec3; 3], Error> {
        let axes = to_world.matrix3;
        let unit = [axes.x_axis, axes.y_axis, axes.z_axis].map(unit);
        let [Some(x), Some(y), Some(z)] = unit else {
            return Err(element.error("to_world is not invertible"));
        };
        let skew = DMat3::from_cols(x, y, z);
        let error = skew.transpose() * skew - DMat3::IDENTITY;
        if error.to_cols_array().iter().any(|e| e.abs() > 1e-3) {
            self.warn(element, "to_world of a sensor must not shear; its axes y and z are taken")?;
        }
        Ok([to_world.translation, z, y])
    }

    fn film(&mut self, element: &'a Element) -> Result<FilmPlan, Error> {
        let object = Object::new(element);
        let pixels = |name: &str, default: i64| -> Result<u32, Error> {
            let value = object.integer(name)?.unwrap_or(default);
            u32::try_from(value).map_err(|_| {
                element.error(format!("{name} is {value}, which is no number of pixels"))
            })
        };
        let (width, height) = (pixels("width", 768)?, pixels("height", 576)?);
        if u64::from(width) * u64::from(height) > self.limits.pixels {
            return Err(element.limit(format!(
                "a film of {width} x {height} pixels is larger than the limit admits"
            )));
        }
        let mut plan = film_plan(element, width, height)?;
        let min = UVec2::new(pixels("crop_offset_x", 0)?, pixels("crop_offset_y", 0)?);
        let rest = |size: u32, offset: u32| i64::from(size.saturating_sub(offset));
        let crop = UVec2::new(
            pixels("crop_width", rest(width, min.x))?,
            pixels("crop_height", rest(height, min.y))?,
        );
        let max = UVec2::new(min.x.saturating_add(crop.x), min.y.saturating_add(crop.y));
        if crop.cmpeq(UVec2::ZERO).any() || max.cmpgt(plan.region.resolution).any() {
            return Err(element.error("the crop window is empty or reaches out of the film"));
        }
        plan.region = FilmRegion { window_min: min, window_max: max, ..plan.region };
        for child in object.objects() {
            let child = self.resolved(child)?;
            if child.tag == "rfilter" {
                let filter = self.filter(child);
                let filter = self.warnings.rescue(filter, "a Gaussian of 0.5 pixels is taken")?;
                plan.filter = filter.unwrap_or(plan.filter);
            } else {
                self.warn(
                    child,
                    format!("a {} in a film is not supported, and left out", child.tag),
                )?;
            }
        }
        // They concern the file that is written.
        object.ignore(&[
            "file_format",
            "pixel_format",
            "component_format",
            "sample_border",
            "compensate",
            "banner",
        ]);
        object.finish(&mut self.warnings)?;
        Ok(plan)
    }

    fn filter(&mut self, element: &'a Element) -> Result<Filter, Error> {
        let object = Object::new(element);
        let filter = match element.kind() {
            "box" => {
                if object.float("radius")?.is_some_and(|radius| radius != 0.5) {
                    self.warn(
                        element,
                        "only a radius of 0.5 is supported for the box filter, and taken",
                    )?;
                }
                Filter::Box
            }
            "tent" => {
                if object.float("radius")?.is_some_and(|radius| radius != 1.0) {
                    self.warn(
                        element,
                        "only a radius of 1 is supported for the tent filter, and taken",
                    )?;
                }
                Filter::Tent
            }
            "gaussian" => Filter::Gaussian { standard_deviation: object.float_or("stddev", 0.5)? },
            other => {
                object.ignore(&["lobes", "B", "C", "b", "c"]);
                self.warn(element, format!("the reconstruction filter {other} is not supported; a Gaussian of 0.5 pixels is taken"))?;
                Filter::Gaussian { standard_deviation: 0.5 }
            }
        };
        filter.kernel().map_err(|error| element.caused(error))?;
        object.finish(&mut self.warnings)?;
        Ok(filter)
    }
}

/// A whole film with the filter that Mitsuba takes if none is named.
fn film_plan(element: &Element, width: u32, height: u32) -> Result<FilmPlan, Error> {
    if width == 0 || height == 0 {
        return Err(element.error("the film has no pixels"));
    }
    Ok(FilmPlan {
        region: FilmRegion::full(UVec2::new(width, height)),
        filter: Filter::Gaussian { standard_deviation: 0.5 },
    })
}

/// The vertical field of view in degrees, from fov along fov_axis or from a focal length for a
/// small-picture film.
fn vertical_fov(object: &Object<'_>, size: DVec2) -> Result<f64, Error> {
    let element = object.element;
    let axis = object.string("fov_axis")?.unwrap_or("x");
    let focal_length = object.string("focal_length")?;
    let (tangent, axis) = match object.float("fov")? {
        Some(_) if focal_length.is_some() => {
            return Err(element.error("a sensor has either fov or focal_length"));
        }
        Some(fov) if fov > 0.0 && fov < 180.0 => (libm::tan(0.5 * fov.to_radians()), axis),
        Some(fov) => {
            return Err(
                element.error(format!("fov is {fov}, but must be between 0 and 180 degrees"))
            );
        }
        None => {
            let text = focal_length.unwrap_or("50mm");
            let millimetres = number(element, text.strip_suffix("mm").unwrap_or(text))?;
            if millimetres <= 0.0 {
                return Err(element.error("focal_length must be positive"));
            }
            (0.5 * SMALL_PICTURE_DIAGONAL / millimetres, "diagonal")
        }
    };
    let extent = match axis {
        "x" => size.x,
        "y" => size.y,
        "diagonal" => size.length(),
        "smaller" => size.min_element(),
        "larger" => size.max_element(),
        other => return Err(element.error(format!("the fov_axis \"{other}\" is not known"))),
    };
    Ok(degrees(tangent * size.y / extent))
}

/// The vertical field of view of the lens that sensors have by default.
fn default_fov(size: DVec2) -> f64 {
    degrees(0.5 * SMALL_PICTURE_DIAGONAL / 50.0 * size.y / size.length())
}

/// The angle of which half has this tangent.
fn degrees(tangent: f64) -> f64 {
    2.0 * libm::atan(tangent).to_degrees()
}
