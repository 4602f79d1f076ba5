//! The directives of a file, and the state that they change.

use super::super::{Error, Location};
use super::colours::ColourSpace;
use super::materials::Reference;
use super::object::{self, Object};
use super::textures::Sort;
use super::tokens::{Token, Tokens};
use super::{Loader, Place};
use crate::math::{Rgb, unit};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use std::path::Path;
use std::rc::Rc;

/// What an end puts back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    Attribute,
    Transform,
    Object,
}

/// The sorts of objects that `Attribute` is about.
pub(super) const SORTS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// Most parameters of `Attribute` for one sort: each object is asked for all of them.
const MOST_DEFAULTS: usize = 64;

/// What an included file counts as, in elements: to open one takes longer than to read a directive.
const ELEMENTS_PER_FILE: u64 = 64;

impl Loader {
    /// Reads a file. A directive that makes no sense is left out.
    pub(super) fn file(&mut self, path: &Path, bytes: &[u8], depth: u32) -> Result<(), Error> {
        let text = String::from_utf8_lossy(bytes);
        let mut tokens = Tokens::new(&text);
        self.at = Place { file: Rc::new(path.to_owned()), ..Place::default() };
        loop {
            let token = tokens.next();
            let rest = tokens;
            let directive = match &token {
                Ok(Some(Token::Word(name))) => Some(*name),
                _ => None,
            };
            let result = match token {
                Ok(None) => return Ok(()),
                Ok(Some(Token::Word(name))) => {
                    name.clone_into(&mut self.at.directive);
                    self.at.line = Some(tokens.line());
                    self.directive(name, &mut tokens, depth)
                }
                Ok(Some(_)) => Err(self.stray(&tokens, "a directive is wanted here")),
                Err(reason) => Err(self.stray(&tokens, &reason)),
            };
            if result.is_err() {
                match directive {
                    Some("Shape" | "ObjectInstance" | "Include" | "Import") => {
                        self.warnings.rescue_surface(result, "it is left out")?
                    }
                    _ => self.warnings.rescue(result, "it is left out")?,
                };
                // What it has taken for its own may be the next directive.
                tokens = rest;
                tokens.skip_to_directive();
            }
        }
    }

    /// An error of what is no directive.
    fn stray(&self, tokens: &Tokens<'_>, reason: &str) -> Error {
        let location = Location { line: Some(tokens.line()), ..self.location() };
        Error::new(Location { element: String::new(), ..location }, reason)
    }

    fn directive(&mut self, name: &str, tokens: &mut Tokens<'_>, depth: u32) -> Result<(), Error> {
        self.spend(1)?;
        match name {
            "AttributeBegin" => self.begin(Scope::Attribute),
            "AttributeEnd" => return self.end(Scope::Attribute),
            "TransformBegin" => self.begin(Scope::Transform),
            "TransformEnd" => return self.end(Scope::Transform),
            "ObjectBegin" => {
                let name = self.text(tokens)?;
                if self.definition.is_some() {
                    return Err(self.wrong("an object in an object is not supported"));
                }
                self.begin(Scope::Object);
                self.definition = Some((name, Vec::new()));
            }
            "ObjectEnd" => {
                self.end(Scope::Object)?;
                if let Some((name, shapes)) = self.definition.take() {
                    self.definitions.insert(name, Rc::new(shapes));
                }
            }
            "ObjectInstance" => {
                let name = self.text(tokens)?;
                return self.instance(&name);
            }
            "Identity" => self.set_transform(DAffine3::IDENTITY)?,
            "Translate" => {
                let offset = self.numbers::<3>(tokens)?;
                self.concat(DAffine3::from_translation(offset.into()))?;
            }
            "Scale" => {
                let factors = self.numbers::<3>(tokens)?;
                self.concat(DAffine3::from_scale(factors.into()))?;
            }
            "Rotate" => {
                let [angle, x, y, z] = self.numbers(tokens)?;
                match unit(DVec3::new(x, y, z)) {
                    Some(axis) => {
                        self.concat(DAffine3::from_axis_angle(axis, angle.to_radians()))?;
                    }
                    // Nothing is turned, about whatever axis.
                    None if angle == 0.0 => {}
                    None => return Err(self.wrong("the axis has length zero")),
                }
            }
            "LookAt" => {
                let values = self.numbers::<9>(tokens)?;
                let place = look_at(&values).map_err(|reason| self.wrong(reason))?;
                self.concat(place.inverse())?;
            }
            "Transform" => {
                let values = self.numbers(tokens)?;
                self.set_transform(self.affine(&values)?)?;
            }
            "ConcatTransform" => {
                let values = self.numbers(tokens)?;
                self.concat(self.affine(&values)?)?;
            }
            "CoordinateSystem" => {
                let name = self.text(tokens)?;
                self.coordinate_systems.insert(name, self.state.to_world);
            }
            "CoordSysTransform" => {
                let name = self.text(tokens)?;
                let Some(transform) = self.coordinate_systems.get(&name) else {
                    return Err(self.wrong(format!("there is no coordinate system {name}")));
                };
                self.set_transform(*transform)?;
            }
            "ActiveTransform" => {
                let time = tokens.next().map_err(|reason| self.wrong(reason))?;
                self.state.at_start = time != Some(Token::Word("EndTime"));
                if !self.state.at_start {
                    let reason = "motion is not supported: everything is where it starts";
                    self.warnings.warn(self.location(), reason)?;
                }
            }
            "TransformTimes" => drop(self.numbers::<2>(tokens)?),
            "ReverseOrientation" => self.state.reverse = !self.state.reverse,
            "ColorSpace" => {
                let name = self.text(tokens)?;
                self.state.colours = ColourSpace::by_name(&name)
                    .ok_or_else(|| self.wrong(format!("the colour space {name} is not known")))?;
            }
            "Attribute" => return self.attribute(tokens),
            "Option" => drop(self.parameters(tokens)?),
            "Include" | "Import" => return self.include(name, tokens, depth),
            "WorldBegin" => {
                self.state.to_world = DAffine3::IDENTITY;
                self.state.at_start = true;
                self.coordinate_systems.insert("world".to_owned(), DAffine3::IDENTITY);
                let scale = self.film_scale();
                let scale = self.warnings.rescue(scale, "the film's scale is 1")?;
                self.exposure = scale.unwrap_or(1.0);
            }
            "WorldEnd" => {}
            "Camera" => {
                let object = self.object(tokens, None)?;
                let from_world = self.state.to_world;
                self.coordinate_systems.insert("camera".to_owned(), from_world.inverse());
                self.setup.camera = Some((object, from_world));
            }
            "Film" => self.setup.film = Some(self.object(tokens, None)?),
            "PixelFilter" => self.setup.filter = Some(self.object(tokens, None)?),
            "Sampler" => {
                let object = self.object(tokens, None)?;
                return self.sampler(&object);
            }
            "Integrator" | "SurfaceIntegrator" => {
                let object = self.object(tokens, None)?;
                return self.integrator(&object);
            }
            "Accelerator" | "Renderer" | "VolumeIntegrator" => {
                drop(self.object(tokens, None)?);
            }
            "MakeNamedMedium" => {
                let mut object = self.object(tokens, Some("medium"))?;
                let kind = object.text("type")?.unwrap_or("").to_owned();
                let name = std::mem::replace(&mut object.kind, kind);
                object.location.id = Some(name.clone());
                let absorption = self.medium(&object)?;
                self.media.insert(name, absorption);
            }
            "MediumInterface" => {
                let inside = self.text(tokens)?;
                if let Ok(Some(Token::Text(_))) = tokens.peek() {
                    let outside = self.text(tokens)?;
                    if outside == inside {
                        return Ok(());
                    }
                }
                self.state.absorption = self.media.get(&inside).copied().unwrap_or(Rgb::BLACK);
            }
            "Material" => {
                let object = self.object(tokens, Some("material"))?;
                self.state.material = Reference::Given(Rc::new(object));
            }
            "MakeNamedMaterial" => {
                let mut object = self.object(tokens, Some("material"))?;
                let kind = object.text("type")?.unwrap_or("").to_owned();
                let name = std::mem::replace(&mut object.kind, kind);
                object.location.element = format!("{} material", object.kind);
                object.location.id = Some(name.clone());
                self.named_materials.insert(name, Rc::new(object));
            }
            "NamedMaterial" => self.state.material = Reference::Named(self.text(tokens)?),
            "Texture" => {
                let name = self.text(tokens)?;
                let sort = self.text(tokens)?;
                let mut object = self.object(tokens, Some("texture"))?;
                object.location.id = Some(name.clone());
                let sort = match sort.as_str() {
                    "float" => Sort::Float,
                    "spectrum" | "color" | "rgb" => Sort::Spectrum,
                    _ => return Err(object.error(format!("a texture of {sort} is not known"))),
                };
                return self.add_texture(name, sort, &object);
            }
            "AreaLightSource" => {
                let object = self.object(tokens, Some("light"))?;
                let is_none = matches!(object.kind.as_str(), "" | "none");
                self.state.light = (!is_none).then(|| Rc::new(object));
            }
            "LightSource" => {
                let object = self.object(tokens, Some("light"))?;
                return self.light_source(&object);
            }
            "Shape" => {
                let object = self.object(tokens, Some("shape"))?;
                return self.shape(&object);
            }
            _ => return Err(self.wrong("this is no directive")),
        }
        Ok(())
    }

    /// Counts elements.
    fn spend(&mut self, elements: u64) -> Result<(), Error> {
        let left = self.elements_left.checked_sub(elements);
        self.elements_left = left.ok_or_else(|| {
            Error::limit(self.location(), "the scene has more elements than the limit admits")
        })?;
        Ok(())
    }

    fn wrong(&self, reason: impl Into<String>) -> Error {
        Error::new(self.location(), reason)
    }

    fn begin(&mut self, scope: Scope) {
        self.scopes.push((scope, self.state.clone()));
    }

    fn end(&mut self, scope: Scope) -> Result<(), Error> {
        match self.scopes.pop_if(|(open, _)| *open == scope) {
            Some((Scope::Transform, state)) => self.state.to_world = state.to_world,
            Some((_, state)) => self.state = state,
            None => return Err(self.wrong("no scope of its kind is open")),
        }
        Ok(())
    }

    fn set_transform(&mut self, transform: DAffine3) -> Result<(), Error> {
        if !transform.is_finite() {
            return Err(self.wrong("the transform is not finite"));
        }
        if self.state.at_start {
            self.state.to_world = transform;
        }
        Ok(())
    }

    fn concat(&mut self, transform: DAffine3) -> Result<(), Error> {
        self.set_transform(self.state.to_world * transform)
    }

    /// The affine transform of a matrix in columns.
    fn affine(&self, values: &[f64; 16]) -> Result<DAffine3, Error> {
        let matrix = DMat4::from_cols_array(values);
        let last = matrix.row(3);
        if last.truncate() != DVec3::ZERO || last.w == 0.0 {
            return Err(self.wrong("the transform is not affine"));
        }
        Ok(DAffine3::from_mat4(matrix * (1.0 / last.w)))
    }

    fn include(
        &mut self,
        directive: &str,
        tokens: &mut Tokens<'_>,
        depth: u32,
    ) -> Result<(), Error> {
        let name = self.text(tokens)?;
        let location = self.location();
        self.spend(ELEMENTS_PER_FILE)?;
        if depth + 1 >= self.limits.depth {
            let reason = "files are included too deeply, or include each other";
            return Err(Error::limit(location, reason));
        }
        let (path, bytes) = self.read(&name, &location)?;
        // An imported file leaves the state as it is.
        let state = (directive == "Import").then(|| self.state.clone());
        let at = self.at.clone();
        self.file(&path, &bytes, depth + 1)?;
        self.at = at;
        self.state = state.unwrap_or_else(|| self.state.clone());
        Ok(())
    }

    /// The absorption coefficient of a medium, which is all that is taken of it.
    fn medium(&mut self, object: &Object) -> Result<Rgb, Error> {
        let mut scatters = true;
        let mut absorption = Rgb::BLACK;
        if object.kind == "homogeneous" && object.get("preset").is_none() {
            // pbrt's own coefficients, of a marble, in 1/mm.
            let mut coefficient = |name: &str, default: [f64; 3]| match object.get(name) {
                Some(parameter) => Ok(self.spectrum(object, parameter)?.as_coefficient()),
                None => Ok(Rgb(default)),
            };
            let scale = object.number_or("scale", 1.0)?.max(0.0);
            absorption = coefficient("sigma_a", [0.0011, 0.0024, 0.014])? * scale;
            scatters = !coefficient("sigma_s", [2.55, 3.21, 3.77])?.is_black();
        }
        if scatters {
            let reason = "a medium that scatters or varies is not supported; it only absorbs, if it is \
                          homogeneous";
            self.warnings.warn(object.location.clone(), reason)?;
        }
        Ok(absorption)
    }

    /// Parameters for all objects of a sort that follow.
    fn attribute(&mut self, tokens: &mut Tokens<'_>) -> Result<(), Error> {
        let sort = self.text(tokens)?;
        let parameters = self.parameters(tokens)?;
        let Some(index) = SORTS.iter().position(|other| *other == sort) else {
            return Err(self.wrong(format!("attributes of {sort} are not known")));
        };
        let defaults = Rc::make_mut(&mut self.state.defaults[index]);
        if defaults.len() + parameters.len() > MOST_DEFAULTS {
            return Err(self.wrong(format!("there are more than {MOST_DEFAULTS} attributes")));
        }
        // The last one counts.
        defaults.splice(0..0, parameters.into_iter().map(Rc::new));
        Ok(())
    }

    fn text(&mut self, tokens: &mut Tokens<'_>) -> Result<String, Error> {
        match tokens.peek().map_err(|reason| self.wrong(reason))? {
            Some(Token::Text(text)) => {
                let text = text.into_owned();
                tokens.next().map_err(|reason| self.wrong(reason))?;
                Ok(text)
            }
            _ => Err(self.wrong("a text in quotes is wanted here")),
        }
    }

    /// N numbers, which may be in brackets.
    fn numbers<const N: usize>(&mut self, tokens: &mut Tokens<'_>) -> Result<[f64; N], Error> {
        let mut next = || tokens.next().map_err(|reason| self.wrong(reason));
        let missing = || self.wrong(format!("{N} numbers are wanted here"));
        let mut values = [0.0; N];
        let mut token = next()?;
        let is_list = token == Some(Token::Open);
        if is_list {
            token = next()?;
        }
        for (i, value) in values.iter_mut().enumerate() {
            let Some(Token::Word(word)) = token else { return Err(missing()) };
            *value = object::number(word).map_err(|reason| self.wrong(reason))?;
            token = if i + 1 < N || is_list { next()? } else { None };
        }
        if is_list && token != Some(Token::Close) { Err(missing()) } else { Ok(values) }
    }

    fn parameters(&mut self, tokens: &mut Tokens<'_>) -> Result<Vec<object::Parameter>, Error> {
        let parameters = object::parameters(tokens).map_err(|reason| self.wrong(reason))?;
        self.spend(parameters.len() as u64)?;
        Ok(parameters)
    }

    /// A type and parameters.
    fn object(&mut self, tokens: &mut Tokens<'_>, sort: Option<&str>) -> Result<Object, Error> {
        let kind = self.text(tokens)?;
        let defaults = SORTS.iter().position(|other| sort == Some(other));
        let directive = self.at.directive.to_ascii_lowercase();
        self.at.directive = format!("{kind} {directive}");
        Ok(Object {
            location: self.location(),
            kind,
            colours: self.state.colours,
            parameters: self.parameters(tokens)?,
            defaults: defaults.map(|i| Rc::clone(&self.state.defaults[i])).unwrap_or_default(),
        })
    }
}

/// The transform from a camera to the world: x to the right, y up, z forward, left-handed if the
/// world is.
fn look_at(values: &[f64; 9]) -> Result<DAffine3, &'static str> {
    let [eye, target, up] = [0, 3, 6].map(|i| DVec3::from_slice(&values[i..]));
    let forward = unit(target - eye).ok_or("eye and target are the same")?;
    let right = unit(up.cross(forward)).ok_or("up is zero or along the view")?;
    let axes = DMat3::from_cols(right, forward.cross(right), forward);
    Ok(DAffine3::from_mat3_translation(axes, eye))
}
