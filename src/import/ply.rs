//! Meshes in the PLY format.

use crate::scene::Mesh;
use glam::{DVec2, DVec3, DVec4};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::Cursor;

/// A vertex of a PLY file: x, y, z, nx, ny, nz, u, v, red, green, blue, and which of them the file
/// gives.
#[derive(Default)]
struct PlyVertex {
    values: [f64; 11],
    known: u16,
}

#[derive(Default)]
struct PlyFace {
    vertices: Vec<u32>,
}

struct Skipped;

impl PropertyAccess for PlyVertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let index = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "nx" => 3,
            "ny" => 4,
            "nz" => 5,
            "u" | "s" | "texture_u" | "texture_s" => 6,
            "v" | "t" | "texture_v" | "texture_t" => 7,
            "r" | "red" | "color_0" => 8,
            "g" | "green" | "color_1" => 9,
            "b" | "blue" | "color_2" => 10,
            _ => return PropertyAccessResult::Ignored,
        };
        let value = match property {
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            Property::UChar(value) if index >= 8 => f64::from(value) / 255.0,
            _ if index >= 8 => return PropertyAccessResult::Ignored,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        self.values[index] = value;
        self.known |= 1 << index;
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        match property.to_u32_list() {
            Some(vertices) => {
                self.vertices = vertices;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// The mesh of a PLY file, with triangles up to the first one too many.
pub(super) fn mesh(bytes: &[u8], most_triangles: u64) -> Result<Mesh, String> {
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| e.to_string())?;
    let mut mesh = Mesh::default();
    let (mut normals, mut uvs) = (Vec::new(), Vec::new());
    let (mut with_normals, mut with_uvs) = (true, true);
    let mut colors = Vec::new();
    for (name, definition) in &header.elements {
        // Each element takes a byte at least; more of them, or elements of nothing, would never
        // end.
        if definition.count > bytes.len()
            || (definition.properties.is_empty() && definition.count > 0)
        {
            return Err(format!("{} elements {name} do not fit into the file", definition.count));
        }
        match name.as_str() {
            "vertex" => {
                for vertex in Parser::<PlyVertex>::new()
                    .read_payload_for_element(&mut reader, definition, &header)
                    .map_err(|e| e.to_string())?
                {
                    let [x, y, z, nx, ny, nz, u, v, r, g, b] = vertex.values;
                    if vertex.known & 7 != 7 {
                        return Err("a vertex lacks x, y or z".to_owned());
                    }
                    mesh.positions.push(DVec3::new(x, y, z));
                    with_normals &= vertex.known & 0b11_1000 == 0b11_1000;
                    with_uvs &= vertex.known & 0b1100_0000 == 0b1100_0000;
                    normals.push(DVec3::new(nx, ny, nz));
                    uvs.push(DVec2::new(u, v));
                    if vertex.known >> 8 == 0b111 && r.is_finite() && g.is_finite() && b.is_finite()
                    {
                        colors.push(DVec4::new(r, g, b, 1.0));
                    }
                }
            }
            "face" => {
                for face in Parser::<PlyFace>::new()
                    .read_payload_for_element(&mut reader, definition, &header)
                    .map_err(|e| e.to_string())?
                {
                    let [first, rest @ ..] = &face.vertices[..] else {
                        return Err("a face has no vertices".to_owned());
                    };
                    mesh.indices.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
                    if mesh.indices.len() as u64 > most_triangles {
                        break;
                    }
                }
            }
            _ => {
                Parser::<Skipped>::new()
                    .read_payload_for_element(&mut reader, definition, &header)
                    .map_err(|e| e.to_string())?;
            }
        }
    }
    let any = !mesh.positions.is_empty();
    let with_colors = any && colors.len() == mesh.positions.len();
    Ok(Mesh {
        colors: with_colors.then_some(colors),
        normals: (any && with_normals).then_some(normals),
        uvs: (any && with_uvs).then_some(uvs),
        ..mesh
    })
}
