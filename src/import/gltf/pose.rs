//! Meshes at rest: morph targets with their default weights, skins in the pose of their joints.

use super::accessor::Budget;
use super::document::Document;
use super::scene::SceneReader;
use crate::import::{Error, Location};
use crate::math::unit;
use crate::scene::{Mesh, SceneError};
use glam::{DAffine3, DMat3, DVec3};
use gltf::json::mesh::{MorphTarget, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index};

impl Document {
    /// Adds the displacements of morph targets, times their weights, to an attribute of vertices.
    pub fn morph(
        &self,
        primitive: &Primitive,
        weights: &[f32],
        attribute: impl Fn(&MorphTarget) -> Option<Index<Accessor>>,
        vertices: &mut [DVec3],
        budget: &mut Budget,
    ) -> Result<(), Error> {
        for (target, &weight) in primitive.targets.iter().flatten().zip(weights) {
            let Some(accessor) = attribute(target).filter(|_| weight != 0.0) else { continue };
            let displacements = self.vectors(accessor.value(), budget)?;
            self.check_count(accessor.value(), displacements.len(), vertices.len())?;
            for (vertex, displacement) in vertices.iter_mut().zip(displacements) {
                *vertex += DVec3::from_array(displacement) * f64::from(weight);
            }
        }
        Ok(())
    }

    fn check_count(&self, accessor: usize, found: usize, expected: usize) -> Result<(), Error> {
        if found == expected {
            return Ok(());
        }
        let reason = format!("{found} elements for {expected} vertices");
        Err(Error::new(self.accessor_location(accessor), reason))
    }
}

impl SceneReader<'_> {
    /// The transforms of a skin's joints, from the space of the mesh to world space.
    pub fn joints(&mut self, index: usize, location: &Location) -> Result<Vec<DAffine3>, Error> {
        let refuse = |reason: String| Error::new(location.clone(), reason);
        let skin = &self.document.root.skins[index];
        let mut joints = Vec::with_capacity(skin.joints.len());
        for joint in &skin.joints {
            let transform = self.transforms[joint.value()];
            joints.push(transform.ok_or_else(|| {
                refuse(format!("joint {} of skin {index} is not in the scene", joint.value()))
            })?);
        }
        if let Some(accessor) = &skin.inverse_bind_matrices {
            let inverses: Vec<[f64; 16]> =
                self.document.vectors(accessor.value(), &mut self.budget)?;
            if inverses.len() < joints.len() {
                return Err(refuse(format!(
                    "skin {index} has {} inverse bind matrices for {} joints",
                    inverses.len(),
                    joints.len()
                )));
            }
            for (joint, inverse) in joints.iter_mut().zip(inverses) {
                *joint *= DAffine3::from_mat4(glam::DMat4::from_cols_array(&inverse));
            }
        }
        Ok(joints)
    }

    /// A mesh in world space, each vertex where its joints take it.
    pub fn posed(
        &mut self,
        mesh: &Mesh,
        primitive: &Primitive,
        joints: &[DAffine3],
        location: &Location,
    ) -> Result<Mesh, Error> {
        let transforms = self.blended(primitive, joints, mesh.positions.len(), location)?;
        let mut posed = mesh.clone();
        for (position, transform) in posed.positions.iter_mut().zip(&transforms) {
            *position = transform.transform_point3(*position);
        }
        for (normal, transform) in posed.normals.iter_mut().flatten().zip(&transforms) {
            // Where the transform leaves only a line or a point, no triangle asks for it.
            let facing = *normal * transform.matrix3.determinant().signum();
            *normal = unit(cofactors(transform.matrix3) * facing).unwrap_or(*normal);
        }
        for (tangent, transform) in posed.tangents.iter_mut().flatten().zip(&transforms) {
            let side = tangent.w * transform.matrix3.determinant().signum();
            *tangent = transform.matrix3.mul_vec3(tangent.truncate()).extend(side);
        }
        let mirrors = |vertex: u32| {
            let transform = transforms.get(vertex as usize);
            transform.is_some_and(|transform| transform.matrix3.determinant() < 0.0)
        };
        posed.indices.iter_mut().filter(|corners| mirrors(corners[0])).for_each(|t| t.swap(1, 2));
        let fits = |p: &DVec3| p.abs().cmple(DVec3::splat(SceneError::MAX_COORDINATE)).all();
        if posed.positions.iter().all(fits) {
            Ok(posed)
        } else {
            Err(Error::new(location.clone(), "its skin moves vertices too far away"))
        }
    }

    /// The transform of each vertex: the mean of its joints' by its weights. Vertices without
    /// weights follow the first joint.
    fn blended(
        &mut self,
        primitive: &Primitive,
        joints: &[DAffine3],
        vertices: usize,
        location: &Location,
    ) -> Result<Vec<DAffine3>, Error> {
        let mut sums = vec![(DAffine3::ZERO, 0.0); vertices];
        let attribute = |semantic| {
            primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value())
        };
        let sets: Vec<(usize, usize)> = (0..)
            .map_while(|set| {
                Some((attribute(Semantic::Joints(set))?, attribute(Semantic::Weights(set))?))
            })
            .collect();
        let (Some(first), false) = (joints.first(), sets.is_empty()) else {
            return Err(Error::new(location.clone(), "its skin or its mesh has no joints"));
        };
        for (joints_of, weights_of) in sets {
            let indices: Vec<[f64; 4]> = self.document.vectors(joints_of, &mut self.budget)?;
            let weights: Vec<[f64; 4]> = self.document.vectors(weights_of, &mut self.budget)?;
            self.document.check_count(joints_of, indices.len(), vertices)?;
            self.document.check_count(weights_of, weights.len(), vertices)?;
            for ((sum, total), (indices, weights)) in
                sums.iter_mut().zip(indices.iter().zip(weights))
            {
                for (&index, weight) in indices.iter().zip(weights).filter(|(_, w)| *w != 0.0) {
                    let joint = joints.get(index as usize).ok_or_else(|| {
                        let reason = format!("it names joint {index} of {}", joints.len());
                        Error::new(self.document.accessor_location(joints_of), reason)
                    })?;
                    sum.matrix3 += joint.matrix3 * weight;
                    sum.translation += joint.translation * weight;
                    *total += weight;
                }
            }
        }
        let mean = |(sum, total): (DAffine3, f64)| {
            if total > 0.0 {
                let (matrix3, translation) = (sum.matrix3 * total.recip(), sum.translation / total);
                DAffine3 { matrix3, translation }
            } else {
                *first
            }
        };
        Ok(sums.into_iter().map(mean).collect())
    }
}

/// The cofactors of a matrix: its inverse transpose times its determinant, which takes normals
/// along even where the matrix flattens what they stand on.
fn cofactors(matrix: DMat3) -> DMat3 {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}
