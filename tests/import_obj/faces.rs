//! Vertices, faces, normals and groups.

use crate::files::{CORNERS, Directory, below};
use approx::assert_relative_eq;
use glam::{DVec3, UVec2};
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Options, obj};
use pathspace::scene::{Scene, SurfaceArea, World};

const CUBE: [&str; 8] = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "1 1 1", "0 1 1"];
const SIDES: [[i32; 4]; 6] =
    [[1, 4, 3, 2], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]];

fn cube(index: impl Fn(i32) -> String) -> String {
    let vertices: String = CUBE.iter().map(|v| format!("v {v}\n")).collect();
    let face = |corners: &[i32; 4]| {
        let corners: Vec<String> = corners.iter().map(|&corner| index(corner)).collect();
        format!("f {}\n", corners.join(" "))
    };
    vertices + &SIDES.iter().map(face).collect::<String>()
}

/// The shading normal that rays down the z axis see.
fn normal(world: &World, x: f64, y: f64) -> DVec3 {
    below(world, x, y).shading_normal
}

#[test]
fn indices_count_from_either_end() {
    let directory = Directory::new("indices");
    for text in [
        cube(|corner| corner.to_string()),
        cube(|corner| (corner - 9).to_string()),
        cube(|corner| format!("{corner}//")),
        cube(|corner| format!("+{corner}/")),
        format!("# cube \\\n{}", cube(|corner| format!("{corner} \\\n"))),
        cube(|corner| corner.to_string()).replace('\n', "\r\n"),
        cube(|corner| corner.to_string()).replace('\n', "\r"),
        cube(|corner| format!("\t{corner}  ")).replace("\n", " # a comment\n"),
    ] {
        let world = directory.world(&text);
        assert_eq!((world.primitive_count(), world.surface_count()), (12, 1), "{text}");
        assert_relative_eq!(world.total_area(), 6.0, max_relative = 1e-15);
        // The front is outside.
        for direction in [DVec3::X, DVec3::Y, DVec3::Z] {
            for direction in [direction, -direction] {
                let from = SurfacePoint::dirac(DVec3::splat(0.5) - direction * 3.0);
                let hit = world.intersect(&from, direction).expect("the cube");
                assert_eq!(hit.shading_normal, -direction);
            }
        }
    }
}

/// What a face refers to may come after it.
#[test]
fn faces_may_precede_their_vertices() {
    let world = Directory::new("order").world("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    assert_relative_eq!(world.total_area(), 0.5);
}

#[test]
fn polygons_that_bend_inwards_keep_their_area() {
    let directory = Directory::new("polygons");
    let outline = ["0 0 0", "3 0 0", "3 0 2", "2 0 2", "2 0 1", "1 0 1", "1 0 3", "0 0 3"];
    for start in 0..outline.len() {
        let mut outline = outline;
        outline.rotate_left(start);
        let vertices: String = outline.iter().map(|v| format!("v {v}\n")).collect();
        let world = directory.world(&format!("{vertices}f 1 2 3 4 5 6 7 8\n"));
        assert_eq!(world.primitive_count(), 6);
        assert_relative_eq!(world.total_area(), 6.0, max_relative = 1e-15);
        // In the notch there is nothing.
        let up = |x: f64, z: f64| {
            world.intersect(&SurfacePoint::dirac(DVec3::new(x, -1.0, z)), DVec3::Y).is_some()
        };
        assert!(!up(1.5, 1.5) && up(1.5, 0.5) && up(2.5, 1.5) && up(0.5, 2.5));
    }
}

/// Two squares that meet at a right angle, in the planes of z = 0 and x = 1.
const CORNER: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 -1\nv 1 1 -1\nvn 0 0 1\nvn 0.6 0 0.8\nvn 0 0 0\n";

#[test]
fn normals_are_given_smooth_or_flat() {
    let directory = Directory::new("smooth");
    let world = |faces: &str| directory.world(&format!("{CORNER}{faces}"));
    let (first, second) = ("f 1 2 3 4\n", "f 2 5 6 3\n");
    for flat in ["", "s off\n", "s 0\n"] {
        assert_eq!(normal(&world(&format!("{flat}{first}{second}")), 0.99, 0.5), DVec3::Z);
    }
    // Each face has a right angle in all of its corners, so that the edge has the mean normal.
    let edge = DVec3::new(1.0, 0.0, 1.0).normalize();
    for smooth in ["s 1\n", "s on\n"] {
        let world = world(&format!("{smooth}{first}{second}"));
        let middle = (edge + DVec3::Z).normalize();
        assert_relative_eq!(normal(&world, 0.5, 0.5), middle, epsilon = 1e-7);
    }
    // Groups of their own; two surfaces of one group.
    let world_of_two = world(&format!("s 1\n{first}s 2\n{second}"));
    assert_eq!(normal(&world_of_two, 0.99, 0.5), DVec3::Z);
    let world_of_one = world(&format!("s 3\ng a\n{first}g b\n{second}"));
    assert_eq!(world_of_one.surface_count(), 2);
    let middle = (edge + DVec3::Z).normalize();
    assert_relative_eq!(normal(&world_of_one, 0.5, 0.5), middle, epsilon = 1e-7);
    // Given normals count more than groups; those that are missing are the face's.
    let world = world("s 1\nf 1//1 2//2 3//2 4//1\n");
    let middle = DVec3::new(0.3, 0.0, 0.9).normalize();
    assert_relative_eq!(normal(&world, 0.5, 0.5), middle, epsilon = 1e-7);
    let (world, warnings) = directory.load(&format!("{CORNER}f 1//1 2//2 3//2 4//3\n"));
    assert_relative_eq!(normal(&world, 0.5, 0.5), middle, epsilon = 1e-7);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("scene.obj:10: a normal that is not there, zero or not finite"));
}

#[test]
fn groups_and_materials_make_surfaces() {
    let directory = Directory::new("groups");
    let text = format!(
        "{CORNERS}v 2 0 0\nv 2 1 0\no left\nf 1 2 3\ng right\nf 2 5 6\no left\nf 1 3 4\nusemtl a\nf 2 6 3\n"
    );
    directory.write("a.mtl", "newmtl a\nKd 0.25 0.25 0.25\n");
    let world = directory.world(&format!("mtllib a.mtl\n{text}"));
    let names: Vec<_> = [(0.6, 0.1), (0.1, 0.6), (1.6, 0.1), (1.1, 0.6)]
        .map(|(x, y)| world.surface_name(&below(&world, x, y)).expect("a mesh").to_owned())
        .into();
    assert_eq!(world.surface_count(), 3);
    assert_eq!(names[..3], ["left", "left", "right"]);
    assert!(names[3].starts_with("left (line "), "{names:?}");
}

#[test]
fn the_camera_sees_the_whole() {
    let directory = Directory::new("camera");
    let path = directory.write("scene.obj", cube(|corner| corner.to_string()));
    for size in [UVec2::new(64, 16), UVec2::new(16, 64), UVec2::new(1, 1)] {
        let import = obj::load(&path, size, &Options::default()).expect("valid");
        let camera = &import.views[0].camera;
        assert_eq!(camera.film().resolution, size);
        let lens = camera.sample_point(0.5, glam::DVec2::splat(0.5)).expect("a point").point;
        for corner in CUBE {
            let [x, y, z] = [0, 2, 4].map(|k| f64::from(corner.as_bytes()[k] - b'0'));
            let towards = (DVec3::new(x, y, z) - lens.position).normalize();
            assert!(camera.raster(&lens, towards).is_some(), "{corner} at {size}");
        }
    }
}
