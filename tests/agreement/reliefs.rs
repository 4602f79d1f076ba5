//! Shading normals of normal and bump maps: on flat and curved surfaces, diffuse, glossy and Dirac,
//! seen from where they face away.

use crate::rooms::{Room, lambert, v};
use crate::team::{THREE, Team, black, metal};
use glam::{DAffine2, DAffine3, DVec2, DVec3};
use pathspace::endpoint::ConstantEnvironment;
use pathspace::film::Image;
use pathspace::geometry::Sphere;
use pathspace::integrator::Depth;
use pathspace::material::{GreenAxis, Interpolation, Relief, Texture, Wrap};
use pathspace::math::Rgb;
use pathspace::scene::{Material, Mesh, SurfaceId};

fn image(pixel: impl Fn(f64, f64) -> Rgb) -> Texture {
    let image = Image::from_fn(8, 8, |x, y| pixel(f64::from(x), f64::from(y)));
    Texture::bitmap(image, Interpolation::Bilinear, [Wrap::Repeat; 2])
        .and_then(|texture| texture.with_transform(DAffine2::from_scale(DVec2::splat(2.0))))
        .expect("valid")
}

/// Slopes of up to 60°.
fn normals() -> Relief {
    let texture = image(|x, y| Rgb::new(0.5 + 0.4 * (x * 0.8).sin(), 0.5 + 0.4 * y.cos(), 0.8));
    Relief::normal_map(texture, 1.0, GreenAxis::AgainstV)
}

/// Slopes of some 50°.
fn heights(scale: f64) -> Relief {
    Relief::bump_map(image(|x, y| Rgb::splat((x * 0.8).sin() * y.cos())), scale)
}

/// A floor under a lamp at its side, and a second one above that light comes back from.
fn stage(floor: Material, relief: Relief) -> Room {
    let mut room = Room::default();
    let lay = |room: &mut Room, surface: SurfaceId, relief: Relief| {
        room.builder.set_relief(surface, relief).expect("valid");
    };
    let floor = room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), floor);
    lay(&mut room, floor, relief.clone());
    let back = lambert(0.7, 0.6, 0.5);
    let back = room.quad(v(-1.0, 1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 1.5), back);
    lay(&mut room, back, relief);
    let lamp = room.quad(v(1.5, -1.0, 0.2), v(0.0, 0.0, 1.0), v(0.0, 1.5, 0.0), black());
    room.emit(lamp, Rgb::new(10.0, 8.0, 6.0), false);
    room
}

#[test]
fn normal_maps() {
    Team::with_light(THREE)
        .balance()
        .general()
        .agree("normal maps", stage(lambert(0.8, 0.7, 0.6), normals()));
}

#[test]
fn bump_maps() {
    Team::with_light(THREE).agree("bump maps", stage(lambert(0.8, 0.7, 0.6), heights(0.1)));
}

/// Each way to find the light alone, and all of the hemisphere.
#[test]
fn normal_maps_under_an_environment() {
    let mut room = stage(lambert(0.8, 0.7, 0.6), normals());
    room.environment(ConstantEnvironment::new(Rgb::new(0.5, 0.7, 1.0)).expect("valid"));
    Team::with_light(Depth::exactly(1))
        .emission_only()
        .next_event_only()
        .agree("normal maps, environment", room);
}

/// Lobes of which directions and coordinates matter.
#[test]
fn normal_maps_on_metal() {
    Team::with_light(Depth::up_to(2)).agree("mapped metal", stage(metal(0.3, 0.6), normals()));
}

/// On vertex normals, with tangents of the mesh, and on a shape with parameters of its own.
#[test]
fn reliefs_on_curved_surfaces() {
    let mut room = stage(lambert(0.5, 0.5, 0.5), heights(0.05));
    let sphere = Mesh::icosphere(1);
    let uvs = sphere.positions.iter().map(|p| DVec2::new(p.x + 0.2 * p.y, p.z)).collect();
    let tangents = sphere.positions.iter().map(|p| DVec3::Z.cross(*p).extend(-1.0)).collect();
    let mesh = Mesh {
        normals: Some(sphere.positions.clone()),
        uvs: Some(uvs),
        tangents: Some(tangents),
        ..sphere
    };
    let transform =
        DAffine3::from_translation(v(-0.4, 0.0, 0.6)) * DAffine3::from_scale(DVec3::splat(0.4));
    let ball = room.mesh(&mesh, transform, lambert(0.8, 0.7, 0.6));
    room.builder.set_relief(ball, normals()).expect("valid");
    let ball = room.sphere(Sphere::new(v(0.5, 0.0, 0.4), 0.3), lambert(0.8, 0.7, 0.6));
    room.builder.set_relief(ball, heights(0.05)).expect("valid");
    Team::with_light(Depth::up_to(2)).agree("reliefs on curves", room);
}

/// A mirror and a pane whose normals turn, beside the floor that they light.
#[test]
fn normal_maps_on_mirrors_and_glass() {
    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), lambert(0.8, 0.7, 0.6));
    let pane = Material::Blend {
        components: Box::new([Material::Null, Material::Dielectric { relative_ior: 1.3 }]),
        amount: Rgb::splat(0.7).into(),
    };
    let pane = room.quad(v(-1.0, -1.0, 1.8), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), pane);
    room.builder.set_relief(pane, normals()).expect("valid");
    let mirror = Material::Mirror { reflectance: Rgb::splat(0.9) };
    let mirror = room.quad(v(-1.0, -1.2, -0.1), v(2.0, 0.0, 0.0), v(0.0, -0.3, 0.45), mirror);
    room.builder.set_relief(mirror, heights(0.05)).expect("valid");
    let lamp = room.quad(v(-1.0, -1.0, 2.3), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0), black());
    room.emit(lamp, Rgb::new(4.0, 3.5, 3.0), false);
    Team::with_light(Depth::up_to(3)).agree_within(0.004, "mapped mirrors and glass", room);
}
