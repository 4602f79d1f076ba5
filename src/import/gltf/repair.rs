//! JSON of which parts are missing that the format requires, but nothing depends on.

use gltf::json::{Error, Root, Value, deserialize};

/// Longer ones are not repaired: values of unknown types take many times their space.
const MOST_BYTES: usize = 1 << 26;

/// Lists that may be missing: where the objects with them are, and their name.
const LISTS: [(&str, &str); 3] =
    [("scenes", "nodes"), ("meshes", "primitives"), ("skins", "joints")];

/// The document, with sentences on what has been put into it or left out of it.
pub(super) fn parse(json: &[u8]) -> Result<(Root, Vec<String>), Error> {
    // Some writers mark the encoding, or fill the chunk with zeros.
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let json = &json[..end];
    Root::from_slice(json).map(|root| (root, Vec::new())).or_else(|error| {
        if json.len() > MOST_BYTES {
            return Err(error);
        }
        let Ok(mut root) = deserialize::from_slice::<Value>(json) else { return Err(error) };
        let repairs = repair(&mut root);
        // The first error has a line.
        deserialize::from_value(root).map(|root| (root, repairs)).map_err(|_| error)
    })
}

fn repair(root: &mut Value) -> Vec<String> {
    let mut repairs = Vec::new();
    remove_nulls(root);
    let asset = put(root, "asset", Value::Object(Default::default()));
    let version = root.get_mut("asset").is_some_and(|asset| put(asset, "version", "2.0".into()));
    if version || asset {
        repairs.push("its version is missing: 2.0 is taken".to_owned());
    }
    for (list, name) in LISTS {
        for (index, object) in objects(root, list).enumerate() {
            // A scene may be empty.
            if put(object, name, Value::Array(Vec::new())) && list != "scenes" {
                repairs.push(format!("{name} of {list}[{index}] are missing: there are none"));
            }
        }
    }
    for mesh in objects(root, "meshes") {
        for primitive in objects(mesh, "primitives") {
            if put(primitive, "attributes", Value::Object(Default::default())) {
                repairs.push("a primitive has no attributes".to_owned());
            }
        }
    }
    for (index, material) in objects(root, "materials").enumerate() {
        if remove_textures(material) {
            repairs.push(format!("a texture of materials[{index}] has no index: it is left out"));
        }
    }
    for (index, camera) in objects(root, "cameras").enumerate() {
        for (name, kind) in [("perspective", "perspective"), ("orthographic", "orthographic")] {
            if let Some(lens) = camera.get_mut(name) {
                // They do not clip.
                put(lens, "znear", 0.0.into());
                put(lens, "zfar", 1.0.into());
                if put(camera, "type", kind.into()) {
                    repairs.push(format!("the type of cameras[{index}] is missing: it is {kind}"));
                }
            }
        }
    }
    const LIGHTS: &str = "KHR_lights_punctual";
    for (index, node) in objects(root, "nodes").enumerate() {
        if let Some(extensions) = node.get_mut("extensions").and_then(Value::as_object_mut)
            && extensions.get(LIGHTS).is_some_and(|light| light.get("light").is_none())
        {
            extensions.remove(LIGHTS);
            repairs.push(format!("the light of nodes[{index}] has no number: it is left out"));
        }
    }
    if let Some(lights) = root.get_mut("extensions").and_then(|all| all.get_mut(LIGHTS)) {
        put(lights, "lights", Value::Array(Vec::new()));
    }
    // They are not shown in any case.
    if root.as_object_mut().and_then(|root| root.remove("animations")).is_some() {
        repairs.push("animations are left out: the scene is shown at rest".to_owned());
    }
    repairs
}

/// The elements of a list in an object; none if there is no such list.
fn objects<'a>(object: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Value> {
    object.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Puts a value into an object that has none of its name; true if it did.
fn put(object: &mut Value, name: &str, value: Value) -> bool {
    match object.as_object_mut() {
        Some(object) if !object.contains_key(name) => {
            object.insert(name.to_owned(), value);
            true
        }
        _ => false,
    }
}

/// Removes what stands for nothing.
fn remove_nulls(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.retain(|_, value| !value.is_null());
            object.values_mut().for_each(remove_nulls);
        }
        Value::Array(list) => list.iter_mut().for_each(remove_nulls),
        _ => {}
    }
}

/// Removes textures of a material that name none; true if there were some.
fn remove_textures(value: &mut Value) -> bool {
    let Value::Object(object) = value else { return false };
    let before = object.len();
    object.retain(|name, value| {
        !(name.ends_with("Texture") && value.is_object() && value.get("index").is_none())
    });
    let removed = object.len() < before;
    object.values_mut().fold(removed, |removed, value| remove_textures(value) || removed)
}
