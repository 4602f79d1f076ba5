//! A scene by its name in the gallery, or from a file.

use super::arguments::parse_environment;
use super::{AnyIntegrator, WrongArgument, imported, info};
use clap::Args;
use pathspace::endpoint::Camera;
use pathspace::film::Filter;
use pathspace::gallery::{self, Claims, GalleryScene};
use pathspace::glam::UVec2;
use pathspace::import::{Environment, Options};
use pathspace::path::{DrawnBy, MissingPaths};
use pathspace::render::RenderError;
use pathspace::report::Method;
use pathspace::scene::World;
use std::error::Error;
use std::path::Path;

/// A scene ready to be rendered.
#[derive(Debug)]
pub struct NamedScene {
    /// Name in the gallery, or the file's name without its extension.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Surfaces, materials and lights.
    pub world: World,
    /// The camera, with the film.
    pub camera: AnyCamera,
    /// The depth to render with unless the user wants another; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The integrators that see every path, if that is known of the scene.
    pub claims: Option<Claims>,
    /// The pixel filter to render with unless the user wants another.
    pub filter: Filter,
    /// The names of all cameras.
    pub views: Vec<String>,
    /// Warnings, and notes on decisions.
    pub messages: Vec<String>,
}

impl NamedScene {
    /// The paths that an integrator's image will lack, as far as the scene has them.
    pub fn missing(
        &self,
        integrator: AnyIntegrator,
        method: &dyn Method<World>,
    ) -> Result<Vec<MissingPaths>, RenderError> {
        let mut missing = method.blind_spots(&self.world, &*self.camera.0)?;
        if self.claims.is_some_and(|claims| integrator.sees_all(&claims)) {
            missing.retain(|paths| paths.drawn_by != DrawnBy::Connections);
        }
        Ok(missing)
    }

    /// True if an integrator that lacks these paths draws all that can be connected.
    pub fn is_complete(&self, integrator: AnyIntegrator, missing: &[MissingPaths]) -> bool {
        self.claims.is_none_or(|claims| integrator.sees_all(&claims))
            && missing.iter().all(|paths| paths.drawn_by != DrawnBy::Connections)
    }
}

/// Options of reading scene files.
#[derive(Args, Clone, Debug, Default)]
pub struct FileOptions {
    /// Refuse scene files that ask for what is not supported, instead of warning
    #[arg(long)]
    pub strict: bool,
    /// Set a parameter of a Mitsuba scene, such as spp=16; may be given several times
    #[arg(short = 'D', long, value_name = "NAME=VALUE", value_parser = parse_definition)]
    pub define: Vec<(String, String)>,
    /// Let scene files name files outside of their directory
    #[arg(long)]
    pub outside_files: bool,
    /// Show the backs of glTF surfaces that are not double-sided
    #[arg(long)]
    pub back_faces: bool,
    /// Camera of a scene file, by its name or number [default: the first]
    #[arg(long, value_name = "NAME|NUMBER")]
    pub view: Option<String>,
    /// Light from everywhere in place of the file's own: a colour such as white, 0.5 or 0.4,0.6,1,
    /// an image of latitude and longitude, or none [default: the file's own; white for glTF files
    /// that nothing lights]
    #[arg(long, value_name = "FILE|COLOUR|none", value_parser = parse_environment)]
    pub environment: Option<Environment>,
}

impl FileOptions {
    /// The library's options.
    pub fn options(&self, size: Option<UVec2>) -> Options {
        let mut options = Options {
            strict: self.strict,
            environment: self.environment.clone().unwrap_or_default(),
            size,
            back_faces: self.back_faces,
            ..Options::default()
        };
        options.limits.outside_files = self.outside_files;
        options
    }

    /// The first option that is given and would change what a file shows.
    fn first(&self) -> Option<&'static str> {
        let given = [
            (!self.define.is_empty(), "-D"),
            (self.back_faces, "--back-faces"),
            (self.view.is_some(), "--view"),
            (self.environment.is_some(), "--environment"),
        ];
        given.into_iter().find_map(|(is_given, option)| is_given.then_some(option))
    }
}

fn parse_definition(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("a parameter looks like name=value")?;
    Ok((name.to_owned(), value.to_owned()))
}

/// A camera of any kind.
pub struct AnyCamera(pub Box<dyn Camera + Send>);

impl std::fmt::Debug for AnyCamera {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("AnyCamera").field(&self.0.film()).finish()
    }
}

impl From<GalleryScene> for NamedScene {
    fn from(scene: GalleryScene) -> Self {
        Self {
            name: scene.name.to_owned(),
            description: scene.description.to_owned(),
            world: scene.world,
            camera: AnyCamera(scene.camera),
            max_bounces: scene.max_bounces,
            claims: Some(scene.claims),
            filter: Filter::Box,
            views: vec!["camera".to_owned()],
            messages: Vec::new(),
        }
    }
}

/// Width and height of films unless the user or the file wants others.
pub const SIZE: UVec2 = UVec2::splat(256);

/// The scene of the gallery with this name, or the one in the file at this path: Wavefront OBJ,
/// glTF, Mitsuba or pbrt. Its film has the size or, in files, fits into it. Tells what reading and
/// building it warns of.
pub fn scene_or_file(
    name_or_path: &str,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let scene = load(name_or_path, size, options).map_err(wrong_scene)?;
    scene.messages.iter().for_each(|message| eprintln!("{message}"));
    Ok(scene)
}

/// The contents of a scene as text.
pub fn scene_info(
    name_or_path: &str,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<String, Box<dyn Error>> {
    load(name_or_path, size, options).map(|scene| info::text(&scene)).map_err(wrong_scene)
}

fn wrong_scene(error: Box<dyn Error>) -> Box<dyn Error> {
    WrongArgument(error.to_string()).into()
}

fn load(
    name_or_path: &str,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let path = Path::new(name_or_path);
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    let extension = extension.as_ref().and_then(|extension| extension.to_str()).unwrap_or_default();
    let imported = imported::load(path, extension, size, options);
    let scene = match (imported, options.first()) {
        (Some(scene), _) => scene,
        _ if path.exists() && !gallery::NAMES.contains(&name_or_path) => {
            Err(format!("{name_or_path}: only Wavefront OBJ (.obj), glTF (.gltf, .glb), Mitsuba (.xml) and pbrt (.pbrt, .pbrt.gz) files can be read").into())
        }
        (None, Some(option)) => {
            Err(format!("{option} is for scenes from files, which {name_or_path} is not").into())
        }
        (None, None) => Ok(gallery::build(name_or_path, size.unwrap_or(SIZE))?.into()),
    };
    // The library knows no command line.
    let mut scene = scene.map_err(|error: Box<dyn Error>| with_flag(&error.to_string()))?;
    scene.messages = scene.messages.iter().map(|message| with_flag(message)).collect();
    scene.messages.extend(info::grouped(scene.world.warnings()));
    Ok(scene)
}

/// A message that names the flag in place of the option.
fn with_flag(message: &str) -> String {
    message.replace("set `outside_files` to allow it", "--outside-files allows it")
}

/// The gallery as text, a line for each scene.
pub fn scene_list() -> String {
    let line =
        |name: &&str| format!("{name:<14} {}\n", gallery::description(name).unwrap_or_default());
    gallery::NAMES.iter().map(line).collect()
}
