//! Images of textures and environments.

use super::super::Error;
use super::super::images::{Encoded, decode, linear_colours, on_all_threads, spend};
use super::Loader;
use super::document::Element;
use super::values::Object;
use crate::film::Image;
use crate::material::Bitmap;
use std::collections::HashSet;

/// An image of which nobody has asked yet.
pub(super) struct Ahead {
    pixels: u64,
    bitmap: Bitmap,
}

impl<'a> Loader<'a> {
    /// Decodes the textures that shapes and emitters refer to, on all threads. What cannot be read
    /// is tried again, and warned about, when it is asked for.
    pub(super) fn decode_ahead(&mut self) {
        let (mut known, mut wanted) = (HashSet::new(), Vec::new());
        let mut open: Vec<&Element> = self.document.scene.iter().rev().collect();
        open.retain(|element| matches!(element.tag.as_str(), "shape" | "emitter"));
        while let Some(element) = open.pop() {
            let Ok(element) = self.resolved(element) else { continue };
            if !known.insert(std::ptr::from_ref(element)) {
                continue;
            }
            open.extend(element.children.iter().rev());
            if element.tag == "texture" && element.kind() == "bitmap" {
                let object = Object::new(element);
                if let (Ok(Some(name)), Ok(raw)) =
                    (object.string("filename"), object.boolean("raw"))
                {
                    wanted.push((name, raw.unwrap_or(false), element));
                }
            }
        }
        let mut left = self.pixels_left;
        let mut names = HashSet::new();
        let mut jobs = Vec::new();
        for (name, raw, element) in wanted {
            if !names.insert((name, raw)) {
                continue;
            }
            let Ok((path, bytes)) = self.files.read(name, element.location()) else { continue };
            let Ok(encoded) = Encoded::guess(&path, bytes) else { continue };
            match left.checked_sub(encoded.pixels) {
                Some(rest) => left = rest,
                None => break,
            }
            jobs.push(((name.to_owned(), raw), encoded));
        }
        let decoded = on_all_threads(jobs, |(key, encoded)| {
            let decoded = encoded.decode().ok()?;
            let [width, height] = encoded.size;
            let image = Image::new(width, height, linear_colours(&decoded, key.1))?;
            let bitmap = Bitmap::new(image).ok()?;
            Some((key, Ahead { pixels: encoded.pixels, bitmap }))
        });
        self.ahead.extend(decoded.into_iter().flatten());
    }

    /// The image file of a texture.
    pub(super) fn bitmap_of(
        &mut self,
        name: &str,
        element: &Element,
        raw: bool,
    ) -> Result<Bitmap, Error> {
        if let Some(Ahead { pixels, bitmap }) = self.ahead.get(&(name.to_owned(), raw)) {
            let (pixels, bitmap) = (*pixels, bitmap.clone());
            spend(pixels, &mut self.pixels_left, &element.location())?;
            return Ok(bitmap);
        }
        let image = self.image(name, element, raw)?;
        Bitmap::new(image).map_err(|error| element.caused(error))
    }

    /// Reads an image file as linear RGB, or, if `raw`, as the numbers that it holds.
    pub(super) fn image(
        &mut self,
        name: &str,
        element: &Element,
        raw: bool,
    ) -> Result<Image, Error> {
        let (path, bytes) = self.files.read(name, element.location())?;
        let decoded = decode(&path, bytes, &mut self.pixels_left, &element.location())?;
        Image::new(decoded.width(), decoded.height(), linear_colours(&decoded, raw))
            .ok_or_else(|| element.error("the image has another size than it says"))
    }
}
