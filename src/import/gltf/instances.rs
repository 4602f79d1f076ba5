//! Many copies of a node's mesh: `EXT_mesh_gpu_instancing`.

use super::scene::SceneReader;
use crate::import::{Error, Location};
use glam::{DAffine3, DQuat, DVec3, DVec4};

/// The name of the extension.
pub(super) const EXTENSION: &str = "EXT_mesh_gpu_instancing";

impl SceneReader<'_> {
    /// The transforms of a node's instances to the space of the node; `None` if it is not
    /// instanced.
    pub fn instances(
        &mut self,
        node: usize,
        location: &Location,
    ) -> Result<Option<Vec<DAffine3>>, Error> {
        let refuse = |reason: String| Error::new(location.clone(), reason);
        let extensions = self.document.root.nodes[node].extensions.as_ref();
        let Some(extension) = extensions.and_then(|extensions| extensions.others.get(EXTENSION))
        else {
            return Ok(None);
        };
        let accessor = |name: &str| {
            let index = extension.get("attributes")?.get(name)?;
            index.as_u64().map(|index| index as usize)
        };
        let places = [accessor("TRANSLATION"), accessor("ROTATION"), accessor("SCALE")];
        let counts = places.map(|place| {
            place.map(|index| self.document.root.accessors.get(index).map(|found| found.count.0))
        });
        let mut counts = counts.into_iter().flatten();
        let count = counts.next().flatten().filter(|count| counts.all(|c| c == Some(*count)));
        let count = count.ok_or_else(|| {
            refuse(format!("the attributes of {EXTENSION} are missing or differ in number"))
        })?;
        self.instances = self.instances.checked_sub(count).ok_or_else(|| {
            let limit = self.document.limits.elements;
            Error::limit(location.clone(), format!("more than {limit} instances"))
        })?;

        let [translations, rotations, scales] = places;
        let mut instances = vec![(DVec3::ONE, DQuat::IDENTITY, DVec3::ZERO); count as usize];
        if let Some(index) = translations {
            let read = self.document.vectors(index, &mut self.budget)?;
            for (instance, translation) in instances.iter_mut().zip(read) {
                instance.2 = DVec3::from_array(translation);
            }
        }
        if let Some(index) = rotations {
            let read = self.document.vectors(index, &mut self.budget)?;
            for (instance, rotation) in instances.iter_mut().zip(read) {
                let unit = DVec4::from_array(rotation).try_normalize();
                instance.1 = DQuat::from_vec4(unit.ok_or_else(|| {
                    refuse(format!("the rotation {rotation:?} of an instance is none"))
                })?);
            }
        }
        if let Some(index) = scales {
            let read = self.document.vectors(index, &mut self.budget)?;
            for (instance, scale) in instances.iter_mut().zip(read) {
                instance.0 = DVec3::from_array(scale);
            }
        }
        let transform = |(scale, rotation, translation)| {
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        };
        Ok(Some(instances.into_iter().map(transform).collect()))
    }
}
