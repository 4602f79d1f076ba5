//! Shapes that stand for several: groups, their instances, and merged shapes.

use super::super::Error;
use super::Loader;
use super::document::Element;
use super::shapes::Part;
use super::values::Object;
use std::rc::Rc;

impl<'a> Loader<'a> {
    /// Adds the shapes of a group once more, under the transform of an instance.
    pub(super) fn instance(&mut self, element: &'a Element) -> Result<(), Error> {
        let object = Object::new(element);
        let to_world = object.transform("to_world")?;
        let mut groups = Vec::new();
        for child in object.objects() {
            let target = self.resolved(child)?;
            if (target.tag.as_str(), target.kind()) == ("shape", "shapegroup") {
                groups.push(target);
            } else {
                let reason =
                    format!("a {} in an instance is not supported, and left out", target.tag);
                self.warn(child, reason)?;
            }
        }
        let [group] = groups[..] else {
            return Err(element.error("an instance is of one shapegroup"));
        };
        for part in self.group(group)?.iter() {
            self.spend_triangles(element, part.triangles())?;
            let added = self.add_part(part, &to_world);
            self.warnings.rescue_surface(added, "it is left out")?;
        }
        object.finish(&mut self.warnings)
    }

    /// The shapes of a group, read once.
    fn group(&mut self, element: &'a Element) -> Result<Rc<[Part<'a>]>, Error> {
        if let Some(known) = self.groups.get(&std::ptr::from_ref(element)) {
            return Ok(Rc::clone(known));
        }
        let object = Object::new(element);
        let mut parts = Vec::new();
        for child in self.shapes(&object)? {
            if matches!(child.kind(), "instance" | "merge" | "shapegroup") {
                let reason = format!(
                    "shapes of type {} in a shapegroup are not supported; it is left out",
                    child.kind()
                );
                self.warnings.lose(child.location(), reason)?;
                continue;
            }
            let part = self.part(child);
            parts.extend(self.warnings.rescue_surface(part, "it is left out")?.flatten());
        }
        object.finish(&mut self.warnings)?;
        let parts: Rc<[Part]> = parts.into();
        self.groups.insert(element, Rc::clone(&parts));
        Ok(parts)
    }

    /// Adds the shapes in an element one by one.
    pub(super) fn merged(&mut self, element: &'a Element) -> Result<(), Error> {
        let object = Object::new(element);
        for child in self.shapes(&object)? {
            let read = self.shape(child);
            self.warnings.rescue_surface(read, "it is left out")?;
        }
        object.finish(&mut self.warnings)
    }

    /// The shapes among the children of an object; others are left out.
    fn shapes(&mut self, object: &Object<'a>) -> Result<Vec<&'a Element>, Error> {
        let mut shapes = Vec::new();
        for child in object.objects() {
            let target = self.resolved(child);
            let Some(target) = self.warnings.rescue_surface(target, "it is left out")? else {
                continue;
            };
            if target.tag == "shape" {
                shapes.push(target);
            } else {
                let reason = format!("a {} in a group is not supported, and left out", target.tag);
                self.warn(child, reason)?;
            }
        }
        Ok(shapes)
    }
}
