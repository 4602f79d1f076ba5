//! Nodes and meshes of a file, put together to a scene.

use super::accessor::Budget;
use super::document::Document;
use super::framing::framing;
use super::material::{self, Look};
use super::tangents::with_tangents;
use super::texture::Textures;
use crate::endpoint::ConstantEnvironment;
use crate::film::Filter;
use crate::import::{Error, Hints, Import, ImportedView, Location};
use crate::math::Rgb;
use crate::scene::{MaterialId, Mesh, SceneError, WorldBuilder};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, DVec4, UVec2};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Node};
use std::collections::{HashMap, HashSet};

/// Builds the world and the views of a document.
pub(super) fn build(document: &mut Document, resolution: UVec2) -> Result<Import, Error> {
    let mut scene = SceneReader::new(document, resolution)?;
    let nodes = scene.placed_nodes()?;
    scene.decode_images(&nodes);
    for (node, transform) in nodes {
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
    textures: Textures,
    meshes: HashMap<(usize, usize), Option<Mesh>>,
    budget: Budget,
    triangles: u64,
    pub emits: bool,
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
            builder: WorldBuilder::new(),
            names: HashSet::new(),
            materials: vec![None; document.root.materials.len()],
            fallback: None,
            textures: Textures::new(document),
            meshes: HashMap::new(),
            budget: Budget::new(document),
            triangles: document.limits.triangles,
            emits: false,
            views: Vec::new(),
            document,
        })
    }

    /// The nodes of the scene with their transforms to world space, parents first.
    fn placed_nodes(&self) -> Result<Vec<(usize, DAffine3)>, Error> {
        let root = &self.document.root;
        let scene = root.scene.map(|index| index.value()).or(if root.scenes.is_empty() {
            None
        } else {
            Some(0)
        });
        let roots: Vec<usize> = match scene {
            Some(scene) => root.scenes[scene].nodes.iter().map(Index::value).collect(),
            None => {
                let children: HashSet<usize> = root
                    .nodes
                    .iter()
                    .flat_map(|node| node.children.iter().flatten())
                    .map(Index::value)
                    .collect();
                (0..root.nodes.len()).filter(|node| !children.contains(node)).collect()
            }
        };
        let mut visited = vec![false; root.nodes.len()];
        let mut placed = Vec::new();
        let mut open: Vec<(usize, DAffine3)> =
            roots.into_iter().rev().map(|node| (node, DAffine3::IDENTITY)).collect();
        while let Some((index, parent)) = open.pop() {
            let node = &root.nodes[index];
            let location = self.document.location(format!("node {index}"), node.name.as_ref());
            if std::mem::replace(&mut visited[index], true) {
                return Err(Error::new(location, "it is reached twice: nodes must form a tree"));
            }
            let transform =
                parent * local_transform(node).map_err(|reason| Error::new(location, reason))?;
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
            .cloned()
            .collect();
        let is_skinned = node.skin.is_some();
        let morphs = node
            .weights
            .as_ref()
            .is_some_and(|weights| weights.iter().any(|weight| *weight != 0.0));
        for name in others {
            self.document.warnings.warn(
                location.clone(),
                format!("the extension {name} is not supported: it is shown without it"),
            )?;
        }
        if is_skinned {
            self.document
                .warnings
                .warn(location.clone(), "skins are left out: the mesh is shown as it is stored")?;
        }
        if morphs {
            self.document.warnings.warn(
                location.clone(),
                "morph targets are left out: the mesh is shown without them",
            )?;
        }
        if let Some(mesh) = mesh {
            self.add_mesh(index, mesh, transform, &location)?;
        }
        if let Some(light) = light {
            self.add_light(index, light, &transform, &location)?;
        }
        if let Some(camera) = camera {
            self.add_camera(index, camera, &transform, &location)?;
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
        let source = &self.document.root.meshes[mesh];
        let primitives = source.primitives.len();
        let name = location.id.clone().or_else(|| source.name.clone());
        if source
            .weights
            .as_ref()
            .is_some_and(|weights| weights.iter().any(|weight| *weight != 0.0))
        {
            self.document.warnings.warn(
                location.clone(),
                "morph targets are left out: the mesh is shown without them",
            )?;
        }
        for primitive in 0..primitives {
            if !self.meshes.contains_key(&(mesh, primitive)) {
                let read = self.read_primitive(mesh, primitive)?;
                self.meshes.insert((mesh, primitive), read);
            }
            let material = self.document.root.meshes[mesh].primitives[primitive]
                .material
                .map(|material| material.value());
            let (id, look) = self.material(material)?;
            let name =
                self.unique_name(name.as_deref(), node, (primitives > 1).then_some(primitive));
            let geometry = self.meshes.get(&(mesh, primitive)).and_then(Option::as_ref);
            // Vertices that no triangle uses are copied, too, for every instance; and what has no
            // triangles takes time in every instance.
            let triangles = geometry
                .map_or(1, |geometry| geometry.indices.len().max(geometry.positions.len() / 3))
                as u64;
            self.triangles = self.triangles.checked_sub(triangles).ok_or_else(|| {
                Error::new(
                    location.clone(),
                    format!(
                        "more than {} triangles, which is the limit",
                        self.document.limits.triangles
                    ),
                )
            })?;
            let Some(geometry) = geometry else { continue };
            let caused = |error| Error::caused(location.clone(), error);
            let mut added = self.builder.add_mesh(name.clone(), geometry, transform, id);
            if let Err(SceneError::SingularTransform { .. }) = added {
                let Some(flat) = flattened(geometry, transform) else {
                    let reason = "its transform leaves nothing of its triangles: it is left out";
                    self.document.warnings.warn(location.clone(), reason)?;
                    continue;
                };
                added = self.builder.add_mesh(name, &flat, DAffine3::IDENTITY, id);
            }
            let surface = added.map_err(caused)?;
            if let Some((relief, _)) = look.relief {
                self.builder.set_relief(surface, relief).map_err(caused)?;
            }
            if let Some(radiance) = look.emission {
                self.builder
                    .set_textured_emission(surface, radiance, look.double_sided)
                    .map_err(caused)?;
                self.emits = true;
            }
        }
        Ok(())
    }

    /// The triangles of a primitive; `None` if it has none.
    fn read_primitive(&mut self, mesh: usize, index: usize) -> Result<Option<Mesh>, Error> {
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
                .warn(location, "points and lines have no area: they are left out")?;
            return Ok(None);
        };
        let attribute = |semantic| {
            primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value())
        };
        let Some(positions) = attribute(Semantic::Positions) else {
            self.document.warnings.warn(location, "it has no positions: it is left out")?;
            return Ok(None);
        };
        let material = primitive.material.map(|material| material.value());
        let look = self.material(material)?.1;
        let [set, other_set] = look.coordinates;
        let vectors =
            |values: Vec<[f64; 3]>| values.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let positions = vectors(self.document.vectors(positions, &mut self.budget)?);
        let mut normals = match attribute(Semantic::Normals) {
            Some(normals) => Some(vectors(self.document.vectors(normals, &mut self.budget)?)),
            None => None,
        };
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
        let Some((relief, to_uv)) = look.relief else { return Ok(Some(mesh)) };
        let tangents = match tangents {
            Some(tangents) => self.tangents(tangents, &mesh, location)?,
            None => None,
        };
        Ok(Some(match tangents {
            Some(_) => Mesh { tangents, ..mesh },
            None => with_tangents(mesh, relief.texture().has_other_coordinates(), to_uv),
        }))
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
        mesh: &Mesh,
        location: Location,
    ) -> Result<Option<Vec<DVec4>>, Error> {
        let tangents: Vec<DVec4> = self
            .document
            .vectors(accessor, &mut self.budget)?
            .into_iter()
            .map(DVec4::from_array)
            .collect();
        if tangents.len() == mesh.positions.len() && tangents.iter().all(|t| t.is_finite()) {
            return Ok(Some(tangents));
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
        let id = self.builder.add_material(free, look.material.clone());
        let id = id.map_err(|error| {
            Error::caused(self.document.location(element, name.as_ref()), error)
        })?;
        let slot = match index {
            Some(index) => &mut self.materials[index],
            None => &mut self.fallback,
        };
        Ok(slot.insert((id, look)).clone())
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
        if !self.emits {
            self.document
                .warnings
                .warn(whole.clone(), "it has no light: it is shown in a white environment")?;
            let environment =
                ConstantEnvironment::new(Rgb::WHITE).map_err(|error| caused(&error))?;
            let name = self.unique_name(Some("environment"), usize::MAX, None);
            self.builder.set_environment(name, environment).map_err(|error| caused(&error))?;
        }
        let world = self.builder.build().map_err(|error| caused(&error))?;
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
        let warnings = std::mem::take(&mut self.document.warnings).into_list();
        Ok(Import { world, views: self.views, hints: Hints::default(), warnings })
    }
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
        matches!((a, b, c), (Some(a), Some(b), Some(c)) if (b - a).cross(c - a) != DVec3::ZERO)
    });
    has_area.then(|| Mesh { positions, normals: None, ..mesh.clone() })
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
