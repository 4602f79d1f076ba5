//! The XML of a scene with its files included, its parameters put in and its references found.

use super::super::files::Files;
use super::super::{Error, Limits, Location};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Elements that are nested deeper than this are refused: nothing needs it, and it protects the
/// stack.
const MOST_NESTED: u32 = 64;
/// Longest name of a parameter that is looked for.
const LONGEST_NAME: usize = 256;
/// Largest XML file; meshes and images are not in it.
const MOST_XML_BYTES: usize = 1 << 26;
/// Most attributes of an element: the time to read them grows with the square of their number.
const MOST_ATTRIBUTES: usize = 256;
/// Attributes that count as one element.
const ATTRIBUTES_PER_ELEMENT: u64 = 8;
/// Elements that an included file counts as: it takes time, though it may be empty.
const ELEMENTS_PER_FILE: u64 = 100;

/// An element after parameters have been put in.
#[derive(Debug)]
pub(super) struct Element {
    /// "bsdf", "float" …
    pub tag: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    file: Rc<PathBuf>,
    line: u32,
}

impl Element {
    /// An attribute; `None` if it is not there.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// An attribute that must be there.
    pub fn required(&self, name: &str) -> Result<&str, Error> {
        self.attribute(name).ok_or_else(|| self.error(format!("the attribute {name} is missing")))
    }

    /// The plug-in's type.
    pub fn kind(&self) -> &str {
        self.attribute("type").unwrap_or("")
    }

    pub fn id(&self) -> Option<&str> {
        self.attribute("id")
    }

    pub fn line(&self) -> u32 {
        self.line
    }

    pub fn location(&self) -> Location {
        let element = match self.attribute("type") {
            Some(kind) => format!("{} of type {kind}", self.tag),
            None => self.tag.clone(),
        };
        let id = self.attribute("id").or(self.attribute("name")).map(str::to_owned);
        Location { file: self.file.to_path_buf(), element, id, line: Some(self.line) }
    }

    pub fn error(&self, reason: impl Into<String>) -> Error {
        Error::new(self.location(), reason)
    }

    /// An error of what asks for more than a limit admits.
    pub fn limit(&self, reason: impl Into<String>) -> Error {
        Error::limit(self.location(), reason)
    }

    pub fn caused(&self, source: impl std::error::Error + Send + Sync + 'static) -> Error {
        Error::caused(self.location(), source)
    }

    /// Gives an element of a scene version before 2 the names that it has since; done twice it is
    /// as once.
    fn upgrade(&mut self) {
        if self.tag == "lookAt" {
            self.tag = "lookat".to_owned();
        }
        let is_diffuse = self.tag == "bsdf" && self.kind() == "diffuse";
        // Scale and offset of texture coordinates.
        let uv = [("scale", "uscale", "vscale"), ("translate", "uoffset", "voffset")].map(
            |(tag, x, y)| {
                let values = [("x", x), ("y", y)].into_iter().filter_map(|(axis, name)| {
                    let index =
                        self.children.iter().position(|c| c.attribute("name") == Some(name))?;
                    let child = self.children.remove(index);
                    Some((axis.to_owned(), child.attribute("value")?.to_owned()))
                });
                let attributes = values.collect();
                Self { attributes, ..self.part(tag) }
            },
        );
        if uv.iter().any(|step| !step.attributes.is_empty()) {
            let mut transform = self.part("transform");
            transform.attributes.push(("name".to_owned(), "to_uv".to_owned()));
            transform.children.extend(uv);
            self.children.push(transform);
        }
        for child in &mut self.children {
            for (key, value) in &mut child.attributes {
                if key == "name" {
                    *value = snake_case(value);
                    if is_diffuse && value == "diffuse_reflectance" {
                        *value = "reflectance".to_owned();
                    }
                }
            }
            child.upgrade();
        }
    }

    /// An element without attributes in the place of this one.
    fn part(&self, tag: &str) -> Self {
        Self {
            tag: tag.to_owned(),
            attributes: Vec::new(),
            children: Vec::new(),
            file: Rc::clone(&self.file),
            line: self.line,
        }
    }
}

/// "int_ior" for "intIOR".
fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let (mut after_lower, mut in_capitals) = (false, false);
    for c in name.chars() {
        in_capitals = c.is_ascii_uppercase() && (after_lower || in_capitals);
        if in_capitals && after_lower {
            result.push('_');
        }
        result.push(if in_capitals { c.to_ascii_lowercase() } else { c });
        after_lower = c.is_ascii_lowercase();
    }
    result
}

/// All elements of a scene.
#[derive(Debug)]
pub(super) struct Document {
    /// The children of `<scene>`, included ones in the place of their `<include>`.
    pub scene: Vec<Element>,
    pub aliases: HashMap<String, String>,
    /// Parameters that the user has set and no file has asked for.
    pub unused_parameters: Vec<String>,
    /// Errors of what the scene goes without: settings that are hints, for which some parameter has
    /// no value, directories and included files.
    pub left_out: Vec<Error>,
}

/// Reads the files.
pub(super) fn read(
    path: &Path,
    files: &mut Files,
    limits: &Limits,
    parameters: &BTreeMap<String, String>,
) -> Result<Document, Error> {
    let set = parameters
        .iter()
        .map(|(name, value)| (name.clone(), Parameter { value: value.clone(), used: false }))
        .collect();
    let mut reader = Reader {
        files,
        limits,
        parameters: set,
        elements_left: limits.elements,
        expansion_left: limits.expansion,
        aliases: HashMap::new(),
        left_out: Vec::new(),
    };
    let location = Location { file: path.to_owned(), ..Location::default() };
    let bytes = reader.files.read_path(path, location)?;
    let scene = reader.file(path, &bytes, 0)?;
    let unused = reader
        .parameters
        .into_iter()
        .filter(|(name, p)| !p.used && parameters.contains_key(name))
        .map(|(name, _)| name)
        .collect();
    Ok(Document {
        scene,
        aliases: reader.aliases,
        unused_parameters: unused,
        left_out: reader.left_out,
    })
}

struct Parameter {
    value: String,
    used: bool,
}

struct Reader<'a> {
    files: &'a mut Files,
    limits: &'a Limits,
    parameters: BTreeMap<String, Parameter>,
    elements_left: u64,
    expansion_left: u64,
    aliases: HashMap<String, String>,
    left_out: Vec<Error>,
}

/// A file that is being read.
struct Source {
    path: Rc<PathBuf>,
    line_starts: Vec<usize>,
}

impl Source {
    fn line(&self, offset: usize) -> u32 {
        self.line_starts.partition_point(|start| *start <= offset) as u32
    }
}

impl Reader<'_> {
    /// A result, or `None` and an error that costs no more than what it is about; limits do.
    fn or_without<T>(&mut self, result: Result<T, Error>) -> Result<Option<T>, Error> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error) if error.is_limit() => Err(error),
            Err(error) => {
                let reason = format!("{}; it is left out", error.reason);
                self.left_out.push(Error { reason, ..error });
                Ok(None)
            }
        }
    }

    /// The children of a file's `<scene>`.
    fn file(&mut self, path: &Path, bytes: &[u8], depth: u32) -> Result<Vec<Element>, Error> {
        let whole =
            |line: Option<u32>| Location { file: path.to_owned(), line, ..Location::default() };
        if bytes.len() > MOST_XML_BYTES {
            return Err(Error::new(whole(None), "the XML file is larger than 64 MiB"));
        }
        let text = std::str::from_utf8(bytes).map_err(|error| Error::caused(whole(None), error))?;
        // No attribute has a < in it, so that no element is longer than one of these parts.
        let too_many = |part: &&str| {
            !part.starts_with("!--")
                && part.bytes().filter(|byte| *byte == b'=').count() > MOST_ATTRIBUTES
        };
        if text.split('<').any(|part| too_many(&part)) {
            return Err(Error::new(
                whole(None),
                format!("an element has more than {MOST_ATTRIBUTES} attributes"),
            ));
        }
        // Text and comments are nodes, too.
        let nodes_limit = u32::try_from(self.limits.elements.saturating_mul(4)).unwrap_or(u32::MAX);
        // Documents with a DTD, and with it entities that expand without end, are refused by
        // default.
        let options =
            roxmltree::ParsingOptions { nodes_limit, ..roxmltree::ParsingOptions::default() };
        let tree = roxmltree::Document::parse_with_options(text, options)
            .map_err(|error| Error::caused(whole(Some(error.pos().row)), error))?;
        let line_starts =
            std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let source = Source { path: Rc::new(path.to_owned()), line_starts };
        let root = tree.root_element();
        if root.tag_name().name() != "scene" {
            return Err(Error::new(
                whole(Some(source.line(root.range().start))),
                "the outermost element is not a scene",
            ));
        }
        let version = root.attribute("version").unwrap_or("");
        let mut numbers = version.split('.').map(|part| part.trim().parse::<u32>().ok());
        let camel_case = match (numbers.next().flatten(), numbers.next().flatten()) {
            (Some(0), Some(4..)) | (Some(1), _) => true,
            (Some(2 | 3), _) => false,
            _ => {
                let reason = format!("scene version \"{version}\" is none from 0.4 to 3.x");
                return Err(Error::new(whole(Some(source.line(root.range().start))), reason));
            }
        };
        let mut children = self.children(root, &source, depth, 0)?;
        if camel_case {
            children.iter_mut().for_each(Element::upgrade);
        }
        Ok(children)
    }

    fn children(
        &mut self,
        parent: roxmltree::Node<'_, '_>,
        source: &Source,
        depth: u32,
        nested: u32,
    ) -> Result<Vec<Element>, Error> {
        let mut children = Vec::new();
        for node in parent.children().filter(roxmltree::Node::is_element) {
            let mut element = Element {
                tag: node.tag_name().name().to_owned(),
                attributes: Vec::new(),
                children: Vec::new(),
                file: Rc::clone(&source.path),
                line: source.line(node.range().start),
            };
            let files = u64::from(element.tag == "include") * ELEMENTS_PER_FILE;
            let attributes = node.attributes().len() as u64 / ATTRIBUTES_PER_ELEMENT;
            let left = self.elements_left.checked_sub(1 + attributes + files);
            self.elements_left = left.ok_or_else(|| {
                element.error("the scene has more elements than the limit admits")
            })?;
            if nested >= MOST_NESTED {
                return Err(element.error("elements are nested too deeply"));
            }
            let mut undefined = None;
            for attribute in node.attributes() {
                match self.expanded(attribute.value(), &element)? {
                    Ok(value) => element.attributes.push((attribute.name().to_owned(), value)),
                    Err(error) => undefined = undefined.or(Some(error)),
                }
            }
            if let Some(error) = undefined {
                let is_hint = |tag: &str| matches!(tag, "integrator" | "sampler");
                if !(is_hint(&element.tag) || is_hint(parent.tag_name().name())) {
                    return Err(error);
                }
                let reason = format!("{}; without it its default holds", error.reason);
                self.left_out.push(Error { reason, ..error });
                continue;
            }
            match element.tag.as_str() {
                "default" => {
                    let (name, value) = (
                        element.required("name")?.to_owned(),
                        element.required("value")?.to_owned(),
                    );
                    self.parameters.entry(name).or_insert(Parameter { value, used: false });
                }
                "path" => {
                    let value = element.required("value")?;
                    let added = self.files.add_directory(value, element.location());
                    self.or_without(added)?;
                }
                "alias" => {
                    self.aliases.insert(
                        element.required("as")?.to_owned(),
                        element.required("id")?.to_owned(),
                    );
                }
                "include" => {
                    if depth + 1 >= self.limits.depth {
                        return Err(
                            element.error("files are included too deeply, or include each other")
                        );
                    }
                    let name = element.required("filename")?;
                    let read = self.files.read(name, element.location());
                    if let Some((path, bytes)) = self.or_without(read)? {
                        let mut included = self.file(&path, &bytes, depth + 1)?;
                        children.append(&mut included);
                    }
                }
                _ => {
                    element.children = self.children(node, source, depth, nested + 1)?;
                    children.push(element);
                }
            }
        }
        Ok(children)
    }

    /// A value with its `$parameters` replaced, once: what is put in is taken as it is. The inner
    /// error is that of one that has no value.
    fn expanded(&mut self, value: &str, element: &Element) -> Result<Result<String, Error>, Error> {
        let mut result = String::new();
        let mut rest = value;
        while let Some(at) = rest.find('$') {
            result.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            let end = rest
                .find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
                .unwrap_or(rest.len())
                .min(LONGEST_NAME);
            // "$widthpx" is the parameter "width" if there is no longer one.
            let Some(name) = (1..=end)
                .rev()
                .map(|length| &rest[..length])
                .find(|name| self.parameters.contains_key(*name))
            else {
                let name = &rest[..end];
                let reason = format!(
                    "the parameter ${name} has no value; it gets one from the file or from whoever \
                     reads it (-D {name}=VALUE)"
                );
                return Ok(Err(element.error(reason)));
            };
            let Some(parameter) = self.parameters.get_mut(name) else { continue };
            parameter.used = true;
            result.push_str(&parameter.value);
            rest = &rest[name.len()..];
            let left = self.expansion_left.checked_sub(parameter.value.len() as u64);
            self.expansion_left = left.ok_or_else(|| {
                element.error("parameters expand to more characters than the limit admits")
            })?;
        }
        result.push_str(rest);
        Ok(Ok(result))
    }
}
