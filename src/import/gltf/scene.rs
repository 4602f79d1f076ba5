//! Nodes and meshes of a file, put together to a scene.

use super::accessor::Budget;
use super::document::Document;
use super::instances;
use super::material::{self, Look};
use super::solid::is_solid;
use super::tangents::with_tangents;
use super::texture::Textures;
use crate::film::Filter;
use crate::geometry::Bounds;
use crate::import::framing::framing;
use crate::import::{Error, Hints, Import, ImportedView, Location};
use crate::scene::{MaterialId, Mesh, SceneError, WorldBuilder};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, DVec4, UVec2};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Node};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// The fate of a mesh whose skin cannot be used.
const STORED: &str = "its mesh is shown as it is stored";

/// Builds the world and the views of a document.
pub(super) fn build(document: &mut Document, resolution: UVec2) -> Result<Import, Error> {
    let mut scene = SceneReader::new(document, resolution)?;
    let placed = scene.placed_nodes()?;
    scene.decode_images(&placed);
    for &(node, transform) in &placed {
        scene.transforms[node] = Some(transform);
        if scene.document.root.nodes[node].camera.is_some() {
            scene.eyes.push(transform.translation);
        }
    }
    for (node, transform) in placed {
        scene.add_node(node, transform)?;
    }
    scene.finish()
}

pub(super) struct SceneReader<'a> {
    pub document: &'a mut Document,
    pub resolution: UVec2,
    pub builder: WorldBuilder,
    names: HashSet<String>,
    materials: Vec<Option<(MaterialId, Look)>>,
    fallback: Option<(MaterialId, Look)>,
    /// Materials without culling in place of those with it.
    of_solids: HashMap<MaterialId, MaterialId>,
    /// The primitives, by mesh and number, that are solids or are none.
    solids: HashMap<(usize, usize), bool>,
    /// The places of cameras.
    eyes: Vec<DVec3>,
    textures: Textures,
    /// Geometry that has been read of primitives, by mesh, primitive and weights of morph targets.
    geometries: HashMap<(usize, usize, Vec<u32>), Option<Arc<Mesh>>>,
    /// Nodes of the scene to world space.
    pub transforms: Vec<Option<DAffine3>>,
    pub budget: Budget,
    triangles: u64,
    /// Instances that may still be added.
    pub instances: u64,
    pub views: Vec<ImportedView>,
}

impl<'a> SceneReader<'a> {
    fn new(document: &'a mut Document, resolution: UVec2) -> Result<Self, Error> {
        let pixels = u64::from(resolution.x) * u64::from(resolution.y);
        if pixels == 0 || pixels > document.limits.pixels {
            let reason = format!(
                "{} × {} pixels must be at least 1 and at most {}",
                resolution.x, resolution.y, document.limits.pixels
            );
            return Err(Error::new(document.location("film", None), reason));
        }
        Ok(Self {
            resolution,
            builder: WorldBuilder::varied(document.variation),
            names: HashSet::new(),
            materials: vec![None; document.root.materials.len()],
            fallback: None,
            of_solids: HashMap::new(),
            solids: HashMap::new(),
            eyes: Vec::new(),
            textures: Textures::new(document),
            geometries: HashMap::new(),
            transforms: vec![None; document.root.nodes.len()],
            budget: Budget::new(document),
            triangles: document.limits.triangles,
            instances: document.limits.elements,
            views: Vec::new(),
            document,
        })
    }

    /// The nodes of the scene with their transforms to world space, parents first.
    fn placed_nodes(&mut self) -> Result<Vec<(usize, DAffine3)>, Error> {
        let root = &self.document.root;
        let scene = root.scene.map_or(0, |index| index.value());
        let mut roots: Vec<usize> =
            root.scenes.get(scene).map_or_else(Vec::new, |scene| indices(&scene.nodes));
        if roots.is_empty() {
            let children = root.nodes.iter().filter_map(|node| node.children.as_deref());
            let children: HashSet<usize> = children.flat_map(indices).collect();
            roots = (0..root.nodes.len()).filter(|node| !children.contains(node)).collect();
            if let Some(empty) = root.scenes.get(scene).filter(|_| !roots.is_empty()) {
                let location =
                    self.document.location(format!("scene {scene}"), empty.name.as_ref());
                let reason = "it has no nodes: all of the file are shown";
                self.document.warnings.warn(location, reason)?;
            }
        }
        let root = &self.document.root;
        let mut visited = vec![false; root.nodes.len()];
        let mut placed = Vec::new();
        let mut open: Vec<(usize, DAffine3)> =
            roots.into_iter().rev().map(|node| (node, DAffine3::IDENTITY)).collect();
        while let Some((index, parent)) = open.pop() {
            let node = &root.nodes[index];
            let location = self.document.location(format!("node {index}"), node.name.as_ref());
            if std::mem::replace(&mut visited[index], true) {
                let reason = "it is reached twice, but nodes form a tree: it is shown once";
                self.document.warnings.warn(location, reason)?;
                continue;
            }
            let local = local_transform(node).map_err(|reason| Error::new(location, reason));
            let left_out = "it is left out with all below it";
            let Some(local) = self.document.warnings.rescue(local, left_out)? else { continue };
            let transform = parent * local;
            placed.push((index, transform));
            open.extend(
                node.children.iter().flatten().rev().map(|child| (child.value(), transform)),
            );
        }
        Ok(placed)
    }

    /// Decodes the images of the materials of these nodes.
    fn decode_images(&mut self, nodes: &[(usize, DAffine3)]) {
        let root = &self.document.root;
        let meshes = nodes.iter().filter_map(|(node, _)| root.nodes[*node].mesh);
        let primitives = meshes.flat_map(|mesh| &root.meshes[mesh.value()].primitives);
        let mut known = HashSet::new();
        let materials: Vec<usize> = primitives
            .filter_map(|primitive| primitive.material.map(|material| material.value()))
            .filter(|material| known.insert(*material))
            .collect();
        self.textures.decode_ahead(self.document, &materials);
    }

    fn add_node(&mut self, index: usize, transform: DAffine3) -> Result<(), Error> {
        let node = &self.document.root.nodes[index];
        let location = self.document.location(format!("node {index}"), node.name.as_ref());
        let (mesh, camera) =
            (node.mesh.map(|mesh| mesh.value()), node.camera.map(|camera| camera.value()));
        let light =
            node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        let light = light.map(|light| light.light.value());
        let others: Vec<String> = node
            .extensions
            .iter()
            .flat_map(|extensions| extensions.others.keys())
            .filter(|name| *name != instances::EXTENSION)
            .cloned()
            .collect();
        for name in others {
            self.document.warnings.warn(
                location.clone(),
                format!("the extension {name} is not supported: it is shown without it"),
            )?;
        }
        if let Some(mesh) = mesh {
            self.add_mesh(index, mesh, transform, &location)?;
        }
        if let Some(light) = light {
            let added = self.add_light(index, light, &transform, &location);
            self.document.warnings.rescue(added, "the light is left out")?;
        }
        if let Some(camera) = camera {
            let added = self.add_camera(index, camera, &transform, &location);
            self.document.warnings.rescue(added, "the camera is left out")?;
        }
        Ok(())
    }

    fn add_mesh(
        &mut self,
        node: usize,
        mesh: usize,
        transform: DAffine3,
        location: &Location,
    ) -> Result<(), Error> {
        let (source, root) = (&self.document.root.nodes[node], &self.document.root.meshes[mesh]);
        let primitives = root.primitives.clone();
        let name = location.id.clone().or_else(|| root.name.clone());
        let weights = source.weights.as_ref().or(root.weights.as_ref()).cloned();
        let weights = weights.filter(|weights| weights.iter().any(|weight| *weight != 0.0));
        let weights = weights.unwrap_or_default();
        let skin = source.skin.map(|skin| skin.value());
        let joints = skin.map(|skin| self.joints(skin, location)).transpose();
        let joints = self.document.warnings.rescue(joints, STORED)?.flatten();
        let instances = self.instances(node, location);
        let instances = self.document.warnings.rescue(instances, "it is shown once")?.flatten();
        for (index, primitive) in primitives.iter().enumerate() {
            let geometry = self.geometry(mesh, index, &weights)?;
            let material = self.material(primitive.material.map(|material| material.value()))?;
            let is_solid = self.is_solid((mesh, index), geometry.as_deref(), &material.1);
            let part = (primitives.len() > 1).then_some(index);
            let name = self.unique_name(name.as_deref(), node, part);
            let posed = match (&geometry, &joints) {
                (Some(geometry), Some(joints)) => {
                    let posed = self.posed(geometry, primitive, joints, location);
                    self.document.warnings.rescue(posed, STORED)?
                }
                _ => None,
            };
            if let Some(posed) = posed {
                let posed = with_missing_tangents(posed, &material.1);
                // The skin alone says where it is.
                let there = DAffine3::IDENTITY;
                self.add_surface(name, Some(&posed), there, is_solid, &material, location)?;
                continue;
            }
            let geometry = geometry.as_deref();
            let Some(instances) = &instances else {
                self.add_surface(name, geometry, transform, is_solid, &material, location)?;
                continue;
            };
            for (k, instance) in instances.iter().enumerate() {
                let name = self.unique_name(Some(&format!("{name}[{k}]")), node, None);
                let there = transform * *instance;
                self.add_surface(name, geometry, there, is_solid, &material, location)?;
            }
        }
        Ok(())
    }

    /// Adds the triangles of a primitive, if it has any, to the scene.
    fn add_surface(
        &mut self,
        name: String,
        geometry: Option<&Mesh>,
        transform: DAffine3,
        is_solid: bool,
        (id, look): &(MaterialId, Look),
        location: &Location,
    ) -> Result<(), Error> {
        self.spend_triangles(geometry, location)?;
        let Some(geometry) = geometry else { return Ok(()) };
        // Nobody sees the back of a solid from outside, culled or not.
        let id = if is_solid && !self.has_camera_in(geometry, &transform) {
            &self.material_of_solids(*id, look, location)?
        } else {
            id
        };
        let caused = |error| Error::caused(location.clone(), error);
        let mut added = self.builder.add_mesh(name.clone(), geometry, transform, *id);
        if let Err(SceneError::SingularTransform { .. }) = added {
            let Some(flat) = flattened(geometry, transform) else {
                let reason = "its transform leaves nothing of its triangles: it is left out";
                return self.document.warnings.lose(location.clone(), reason);
            };
            added = self.builder.add_mesh(name, &flat, DAffine3::IDENTITY, *id);
        }
        let surface = match added {
            Ok(surface) => surface,
            Err(error) => {
                let reason = format!("{error}: it is left out");
                return self.document.warnings.lose(location.clone(), reason);
            }
        };
        if let Some(there) = &look.cutout {
            self.builder.set_cutout(surface, there.clone()).map_err(caused)?;
        }
        self.builder.set_absorption(surface, look.absorption).map_err(caused)?;
        if let Some((relief, _)) = &look.relief {
            self.builder.set_relief(surface, relief.clone()).map_err(caused)?;
        }
        if let Some(radiance) = &look.emission {
            let emits = self
                .builder
                .set_textured_emission(surface, radiance.clone(), look.double_sided)
                .map_err(caused);
            self.document.warnings.rescue(emits, "it does not emit")?;
        }
        Ok(())
    }

    /// Counts the triangles of a mesh that is added to the scene. Vertices that no triangle uses
    /// are copied, too, for every instance; and what has no triangles takes time in every instance.
    fn spend_triangles(
        &mut self,
        geometry: Option<&Mesh>,
        location: &Location,
    ) -> Result<(), Error> {
        let triangles = geometry
            .map_or(1, |geometry| geometry.indices.len().max(geometry.positions.len() / 3))
            as u64;
        let limit = self.document.limits.triangles;
        self.triangles = self.triangles.checked_sub(triangles).ok_or_else(|| {
            let reason = format!("more than {limit} triangles, which is the limit");
            Error::limit(location.clone(), reason)
        })?;
        Ok(())
    }

    /// The triangles of a primitive under weights of morph targets, read once.
    fn geometry(
        &mut self,
        mesh: usize,
        primitive: usize,
        weights: &[f32],
    ) -> Result<Option<Arc<Mesh>>, Error> {
        let key = (mesh, primitive, weights.iter().map(|weight| weight.to_bits()).collect());
        if let Some(known) = self.geometries.get(&key) {
            return Ok(known.clone());
        }
        let read = self.read_primitive(mesh, primitive, weights);
        let read = self.document.warnings.rescue_surface(read, "its mesh is left out")?.flatten();
        let read = read.map(Arc::new);
        self.geometries.insert(key, read.clone());
        Ok(read)
    }

    /// The triangles of a primitive; `None` if it has none.
    fn read_primitive(
        &mut self,
        mesh: usize,
        index: usize,
        weights: &[f32],
    ) -> Result<Option<Mesh>, Error> {
        let source = &self.document.root.meshes[mesh];
        let location = self
            .document
            .location(format!("primitive {index} of mesh {mesh}"), source.name.as_ref());
        let primitive: Primitive = source.primitives[index].clone();
        let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) =
            primitive.mode
        else {
            self.document
                .warnings
                .lose(location, "points and lines have no area: they are left out")?;
            return Ok(None);
        };
        let attribute = |semantic| {
            primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value())
        };
        let Some(positions) = attribute(Semantic::Positions) else {
            self.document.warnings.lose(location, "it has no positions: it is left out")?;
            return Ok(None);
        };
        let unpacked = self.document.unpack_primitive(&primitive, self.triangles, &location);
        match unpacked {
            // What a file does not require of its readers is there without compression, too.
            Err(error) if error.is_damage() => {
                if self.document.root.accessors[positions].buffer_view.is_none() {
                    return Err(error);
                }
            }
            unpacked => unpacked?,
        }
        let material = primitive.material.map(|material| material.value());
        let look = self.material(material)?.1;
        let [set, other_set] = look.coordinates;
        let vectors =
            |values: Vec<[f64; 3]>| values.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let mut positions = vectors(self.document.vectors(positions, &mut self.budget)?);
        let (document, budget) = (&*self.document, &mut self.budget);
        document.morph(&primitive, weights, |target| target.positions, &mut positions, budget)?;
        let mut normals = match attribute(Semantic::Normals) {
            Some(normals) => Some(vectors(self.document.vectors(normals, &mut self.budget)?)),
            None => None,
        };
        if let Some(normals) = &mut normals {
            let (document, budget) = (&*self.document, &mut self.budget);
            document.morph(&primitive, weights, |target| target.normals, normals, budget)?;
        }
        if normals
            .as_ref()
            .is_some_and(|normals| normals.iter().any(|normal| normal.try_normalize().is_none()))
        {
            self.document.warnings.warn(
                location.clone(),
                "some of its normals are zero: it is shown with flat triangles",
            )?;
            normals = None;
        }
        let coordinates = |set: u32| attribute(Semantic::TexCoords(set));
        let count = positions.len();
        let uvs = match set {
            Some(set) => Some(self.coordinates(coordinates(set), count, &location)?),
            None => match coordinates(0) {
                Some(uvs) => Some(self.coordinates(Some(uvs), count, &location)?),
                None => None,
            },
        };
        let other_uvs = match other_set {
            Some(set) => Some(self.coordinates(coordinates(set), count, &location)?),
            None => None,
        };
        let colors = match attribute(Semantic::Colors(0)) {
            Some(colors) => self.colors(colors, count, &location)?,
            None => None,
        };
        let corners = match primitive.indices {
            Some(indices) => self.document.indices(indices.value(), &mut self.budget)?,
            None => (0..u32::try_from(positions.len()).unwrap_or(u32::MAX)).collect(),
        };
        let indices = triangles(&corners, mode);
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            return Err(Error::new(
                location,
                format!("{} corners do not make whole triangles", corners.len()),
            ));
        }
        if indices.is_empty() {
            return Ok(None);
        }
        let tangents = attribute(Semantic::Tangents).filter(|_| normals.is_some());
        let mesh = Mesh { positions, normals, uvs, other_uvs, colors, indices, ..Mesh::default() };
        if look.relief.is_none() {
            return Ok(Some(mesh));
        }
        let tangents = match tangents {
            Some(tangents) => self.tangents(tangents, &primitive, weights, &mesh, location)?,
            None => None,
        };
        let mesh = Mesh { tangents, ..mesh };
        // They make vertices of their own, so a mesh gets them in its pose.
        let is_skinned = attribute(Semantic::Joints(0)).is_some();
        Ok(Some(if is_skinned { mesh } else { with_missing_tangents(mesh, &look) }))
    }

    /// A set of texture coordinates that a material asks for; zeros if the mesh lacks it.
    fn coordinates(
        &mut self,
        accessor: Option<usize>,
        count: usize,
        location: &Location,
    ) -> Result<Vec<DVec2>, Error> {
        let Some(accessor) = accessor else {
            self.document.warnings.warn(
                location.clone(),
                "its material has textures, but it lacks their coordinates: they are 0",
            )?;
            return Ok(vec![DVec2::ZERO; count]);
        };
        let uvs = self.document.vectors(accessor, &mut self.budget)?;
        Ok(uvs.into_iter().map(DVec2::from_array).collect())
    }

    /// The colours of vertices; `None` if they cannot be used.
    fn colors(
        &mut self,
        accessor: usize,
        count: usize,
        location: &Location,
    ) -> Result<Option<Vec<DVec4>>, Error> {
        let has_alpha = self.document.root.accessors[accessor].type_ == Checked::Valid(Type::Vec4);
        let colors: Result<Vec<DVec4>, Error> = if has_alpha {
            let colors = self.document.vectors(accessor, &mut self.budget);
            colors.map(|colors| colors.into_iter().map(DVec4::from_array).collect())
        } else {
            let colors = self.document.vectors(accessor, &mut self.budget);
            let opaque = |[r, g, b]: [f64; 3]| DVec4::new(r, g, b, 1.0);
            colors.map(|colors| colors.into_iter().map(opaque).collect())
        };
        let reason = match colors {
            Ok(colors) if colors.len() == count && colors.iter().all(|c| c.is_finite()) => {
                return Ok(Some(colors));
            }
            Ok(_) => "too few, too many or not finite".to_owned(),
            Err(error) => error.reason,
        };
        let reason = format!("colours of vertices are left out: {reason}");
        self.document.warnings.warn(location.clone(), reason)?;
        Ok(None)
    }

    /// The tangents that a file gives; `None` if they cannot be used.
    fn tangents(
        &mut self,
        accessor: usize,
        primitive: &Primitive,
        weights: &[f32],
        mesh: &Mesh,
        location: Location,
    ) -> Result<Option<Vec<DVec4>>, Error> {
        let (document, budget) = (&*self.document, &mut self.budget);
        let tangents: Vec<DVec4> =
            document.vectors(accessor, budget)?.into_iter().map(DVec4::from_array).collect();
        if tangents.len() == mesh.positions.len() && tangents.iter().all(|t| t.is_finite()) {
            let mut along: Vec<DVec3> = tangents.iter().map(|t| t.truncate()).collect();
            document.morph(primitive, weights, |target| target.tangents, &mut along, budget)?;
            let morphed = along.into_iter().zip(&tangents).map(|(along, t)| along.extend(t.w));
            return Ok(Some(morphed.collect()));
        }
        let reason = "its tangents are too few, too many or not finite: they are made anew";
        self.document.warnings.warn(location, reason)?;
        Ok(None)
    }

    /// A material of the file, or the one of primitives that name none.
    fn material(&mut self, index: Option<usize>) -> Result<(MaterialId, Look), Error> {
        let known = index.map_or(&self.fallback, |index| &self.materials[index]);
        if let Some(known) = known {
            return Ok(known.clone());
        }
        let read = match index {
            Some(_) => {
                let read = self.read_material(index);
                let instead = "it is shown as white, rough metal";
                match self.document.warnings.rescue(read, instead)? {
                    Some(read) => read,
                    None => self.material(None)?,
                }
            }
            None => self.read_material(None)?,
        };
        let slot = match index {
            Some(index) => &mut self.materials[index],
            None => &mut self.fallback,
        };
        Ok(slot.insert(read).clone())
    }

    fn read_material(&mut self, index: Option<usize>) -> Result<(MaterialId, Look), Error> {
        let look = match index {
            Some(index) => material::look(self.document, &mut self.textures, index)?,
            None => Look::default_look(self.document),
        };
        let element =
            index.map_or("the default material".to_owned(), |index| format!("material {index}"));
        let name = index.and_then(|index| self.document.root.materials[index].name.clone());
        let free = name
            .clone()
            .filter(|name| self.builder.material(name).is_err())
            .unwrap_or_else(|| element.clone());
        let plain = look.material.clone();
        let shown = if look.is_culled { plain.culled() } else { plain };
        let id = self.builder.add_material(free, shown);
        let id = id.map_err(|error| {
            Error::caused(self.document.location(element, name.as_ref()), error)
        })?;
        Ok((id, look))
    }

    /// True if culling a primitive would make no difference for who is outside of it.
    fn is_solid(&mut self, key: (usize, usize), geometry: Option<&Mesh>, look: &Look) -> bool {
        look.is_culled
            && look.is_opaque
            && *self.solids.entry(key).or_insert_with(|| geometry.is_some_and(is_solid))
    }

    /// True if a camera is in the box around a mesh.
    fn has_camera_in(&self, geometry: &Mesh, transform: &DAffine3) -> bool {
        let place = |position: &DVec3| transform.transform_point3(*position);
        let Bounds { min, max } = if self.eyes.is_empty() {
            Bounds::EMPTY
        } else {
            Bounds::of_points(geometry.positions.iter().map(place))
        };
        self.eyes.iter().any(|eye| eye.cmpge(min).all() && eye.cmple(max).all())
    }

    /// The material of a look without culling.
    fn material_of_solids(
        &mut self,
        culled: MaterialId,
        look: &Look,
        location: &Location,
    ) -> Result<MaterialId, Error> {
        if let Some(id) = self.of_solids.get(&culled) {
            return Ok(*id);
        }
        let name = format!("solid {}", self.of_solids.len());
        let id = self.builder.add_material(name, look.material.clone());
        let id = id.map_err(|error| Error::caused(location.clone(), error))?;
        self.of_solids.insert(culled, id);
        Ok(id)
    }

    /// The file's name for an object, or one that no other object has.
    pub fn unique_name(&mut self, name: Option<&str>, node: usize, part: Option<usize>) -> String {
        let part = part.map_or(String::new(), |part| format!("/{part}"));
        let wanted =
            name.map_or_else(|| format!("node {node}{part}"), |name| format!("{name}{part}"));
        let free =
            if self.names.contains(&wanted) { format!("{wanted} (node {node})") } else { wanted };
        self.names.insert(free.clone());
        free
    }

    fn finish(mut self) -> Result<Import, Error> {
        let whole = self.document.location("", None);
        let caused = |error: &dyn std::error::Error| Error::new(whole.clone(), error.to_string());
        let name = self.unique_name(Some("environment"), usize::MAX, None);
        let (world, why_white) = self.document.environment.surround(
            self.builder,
            name,
            &whole,
            &mut self.document.warnings,
        )?;
        self.document.warnings.check_surfaces(&world)?;
        if let Some(reason) = why_white {
            self.document.warnings.warn(whole.clone(), reason)?;
        }
        if self.views.is_empty() {
            if world.bounds().is_empty() {
                return Err(Error::new(whole, "it has neither cameras nor surfaces"));
            }
            let camera =
                framing(world.bounds(), self.resolution).map_err(|error| caused(&error))?;
            self.views.push(ImportedView {
                name: "whole scene".to_owned(),
                camera: Box::new(camera),
                filter: Filter::default(),
            });
        }
        let (warnings, notes) = std::mem::take(&mut self.document.warnings).into_lists();
        Ok(Import { world, views: self.views, hints: Hints::default(), warnings, notes })
    }
}

/// Indices as numbers.
fn indices<T>(list: &[Index<T>]) -> Vec<usize> {
    list.iter().map(Index::value).collect()
}

/// A node's transform to its parent.
fn local_transform(node: &Node) -> Result<DAffine3, String> {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let transform = match node.matrix {
        Some(matrix) => {
            let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
            if matrix.row(3) != glam::DVec4::W {
                return Err("its matrix is not affine".to_owned());
            }
            DAffine3 { matrix3: DMat3::from_mat4(matrix), translation: matrix.w_axis.truncate() }
        }
        None => {
            let rotation = match &node.rotation {
                Some(rotation) => DQuat::from_array(rotation.0.map(f64::from)),
                None => DQuat::IDENTITY,
            };
            // Rounding to f32 makes an error of 1e-7, careless writers a larger one.
            if (rotation.length_squared() - 1.0).abs() > 1e-2 || !rotation.is_finite() {
                return Err("its rotation is not a unit quaternion".to_owned());
            }
            let scale = node.scale.map_or(DVec3::ONE, vector);
            DAffine3::from_scale_rotation_translation(
                scale,
                rotation.normalize(),
                node.translation.map_or(DVec3::ZERO, vector),
            )
        }
    };
    if transform.is_finite() {
        Ok(transform)
    } else {
        Err("its transform is infinite or not a number".to_owned())
    }
}

/// A mesh in world space, without normals, since a singular transform has none for them; `None` if
/// no triangle keeps an area.
fn flattened(mesh: &Mesh, transform: DAffine3) -> Option<Mesh> {
    let positions: Vec<DVec3> =
        mesh.positions.iter().map(|&position| transform.transform_point3(position)).collect();
    let has_area = mesh.indices.iter().any(|corners| {
        let [a, b, c] = corners.map(|corner| positions.get(corner as usize).copied());
        matches!((a, b, c), (Some(a), Some(b), Some(c)) if (b - a).cross(c - a).length_squared() > 0.0)
    });
    has_area.then(|| Mesh { positions, normals: None, ..mesh.clone() })
}

/// The mesh with tangents if its material has a relief.
fn with_missing_tangents(mesh: Mesh, look: &Look) -> Mesh {
    match &look.relief {
        Some((relief, to_uv)) if mesh.tangents.is_none() => {
            with_tangents(mesh, relief.texture().has_other_coordinates(), *to_uv)
        }
        _ => mesh,
    }
}

/// Corners of triangles. Every other triangle of a strip is turned, so that all face the same side.
fn triangles(corners: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    let windows = corners.windows(3).enumerate();
    match mode {
        Mode::TriangleStrip => windows
            .map(|(k, w)| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [w[0], w[1], corners[0]]).collect(),
        _ => corners.as_chunks::<3>().0.to_vec(),
    }
}
