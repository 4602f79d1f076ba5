//! Scenes of the tests' own, each full of what another kind of renderer gets wrong, and those of
//! the gallery.
#![allow(dead_code, missing_docs, reason = "shared by several test programs")]

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec2};
use pathspace::endpoint::{
    Camera, ConstantEnvironment, DirectionalLight, EnvironmentMap, LightId, Lookup,
    OrthographicCamera, PinholeCamera, PointLight, SpotLight, ThinLensCamera,
};
use pathspace::film::FilmSample;
use pathspace::geometry::{Disk, Place, Quad, Sphere, SurfacePoint};
use pathspace::math::Rgb;
use pathspace::path::{Path, PathDensities, PathRecord, Stage, Weighting};
use pathspace::sampler::Sampler;
use pathspace::scene::{Emission, Material, MaterialId, Mesh, SurfaceId, World, WorldBuilder};
use std::error::Error;

pub type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

pub struct TestScene {
    pub name: String,
    pub world: World,
    pub camera: Box<dyn Camera + Send>,
}

pub const RESOLUTION: UVec2 = UVec2::new(16, 12);

/// Similarity by which a scene is placed in the world: `scale p + offset`.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub scale: f64,
    pub offset: DVec3,
}

impl Placement {
    pub const UNIT: Self = Self { scale: 1.0, offset: DVec3::ZERO };

    pub fn scaled(scale: f64) -> Self {
        Self { scale, ..Self::UNIT }
    }

    pub fn point(&self, x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z) * self.scale + self.offset
    }

    fn quad(&self, origin: [f64; 3], edge_u: [f64; 3], edge_v: [f64; 3]) -> Quad {
        let [x, y, z] = origin;
        Quad {
            origin: self.point(x, y, z),
            edge_u: DVec3::from(edge_u) * self.scale,
            edge_v: DVec3::from(edge_v) * self.scale,
        }
    }

    fn sphere(&self, center: [f64; 3], radius: f64) -> Sphere {
        let [x, y, z] = center;
        Sphere::new(self.point(x, y, z), radius * self.scale)
    }
}

fn lambert(albedo: f64) -> Material {
    Material::Lambert { albedo: Rgb::new(albedo, 0.9 * albedo, 0.8 * albedo) }
}

fn mixture(a: Material, b: Material, weights: [f64; 2]) -> Material {
    Material::Mixture { components: Box::new([a, b]), weights }
}

fn rough_metal(alpha: f64) -> Material {
    Material::RoughConductor {
        eta: Rgb::new(0.2, 0.9, 1.5),
        k: Rgb::new(3.9, 2.4, 1.9),
        alpha: DVec2::new(alpha, 2.0 * alpha),
    }
}

fn glow(builder: &mut WorldBuilder, surface: SurfaceId, radiance: f64, two_sided: bool) -> Result {
    Ok(builder.set_emission(
        surface,
        Emission { radiance: Rgb::new(radiance, 0.8 * radiance, 0.5 * radiance), two_sided },
    )?)
}

/// The walls of the cube [-1, 1]³, front sides inside; without the one at z = 1 if `open`.
fn room(
    builder: &mut WorldBuilder,
    at: &Placement,
    walls: MaterialId,
    floor: MaterialId,
    open: bool,
) -> Result {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for (axis, name) in
        ["left", "floor", "back", "right", "ceiling", "front"].into_iter().enumerate()
    {
        if open && name == "front" {
            continue;
        }
        let (n, u, v) = (axes[axis % 3], axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        let (u, v, side) = if axis < 3 { (u, v, -1.0) } else { (v, u, 1.0) };
        let quad = at.quad((n * side - u - v).into(), (u * 2.0).into(), (v * 2.0).into());
        builder.add_quad(name, quad, if name == "floor" { floor } else { walls })?;
    }
    Ok(())
}

/// A closed room of mixtures under an area light and a spherical one, through a thin lens.
pub fn mixtures(at: Placement) -> Result<TestScene> {
    let mut b = WorldBuilder::new();
    let walls = b.add_material("walls", mixture(lambert(0.8), rough_metal(0.25), [0.6, 0.4]))?;
    let floor = b.add_material(
        "floor",
        mixture(lambert(0.7), Material::Mirror { reflectance: Rgb::splat(0.9) }, [0.5, 0.5]),
    )?;
    let coat = b.add_material(
        "coat",
        mixture(Material::Dielectric { relative_ior: 1.5 }, lambert(0.9), [0.3, 0.6]),
    )?;
    let black = b.add_material("black", Material::Black)?;
    room(&mut b, &at, walls, floor, false)?;
    b.add_sphere("ball", at.sphere([-0.4, -0.6, -0.3], 0.35), coat)?;
    let lamp =
        b.add_quad("lamp", at.quad([-0.3, 0.9, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6]), black)?;
    glow(&mut b, lamp, 5.0, true)?;
    let bulb = b.add_sphere("bulb", at.sphere([0.5, 0.2, -0.4], 0.1), walls)?;
    glow(&mut b, bulb, 20.0, false)?;
    let eye = at.point(0.1, 0.05, 0.95);
    let camera = ThinLensCamera::new(
        eye,
        at.point(0.0, -0.1, -1.0),
        DVec3::Y,
        60.0,
        0.03 * at.scale,
        1.3 * at.scale,
        RESOLUTION,
    )?;
    Ok(TestScene { name: "mixtures".into(), world: b.build()?, camera: Box::new(camera) })
}

/// Frosted and clear glass, a mirror and a mask in a room lit by a spot light and a disk.
pub fn glass(at: Placement) -> Result<TestScene> {
    let mut b = WorldBuilder::new();
    let walls = b.add_material("walls", lambert(0.75))?;
    let frosted = b.add_material(
        "frosted",
        Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::new(0.2, 0.35) },
    )?;
    let clear = b.add_material("clear", Material::Dielectric { relative_ior: 1.33 })?;
    let mirror = b.add_material(
        "mirror",
        Material::Conductor { eta: Rgb::new(0.2, 0.9, 1.5), k: Rgb::new(3.9, 2.4, 1.9) },
    )?;
    let curtain = b.add_material("curtain", mixture(Material::Null, lambert(0.8), [0.5, 0.5]))?;
    room(&mut b, &at, walls, walls, true)?;
    b.add_sphere("frosted", at.sphere([-0.45, -0.55, 0.1], 0.4), frosted)?;
    b.add_sphere("clear", at.sphere([0.45, -0.6, 0.2], 0.35), clear)?;
    b.add_disk(
        "mirror",
        Disk {
            center: at.point(0.6, 0.2, -0.6),
            normal: DVec3::new(-1.0, 0.2, 0.8),
            radius: 0.4 * at.scale,
        },
        mirror,
    )?;
    b.add_quad("curtain", at.quad([-0.9, -0.2, -0.5], [0.8, 0.0, -0.1], [0.0, 0.9, 0.0]), curtain)?;
    let lamp = b.add_disk(
        "lamp",
        Disk { center: at.point(0.0, 0.95, 0.0), normal: DVec3::NEG_Y, radius: 0.25 * at.scale },
        walls,
    )?;
    glow(&mut b, lamp, 8.0, false)?;
    let intensity = Rgb::splat(3.0 * at.scale * at.scale);
    b.add_light(
        "spot",
        SpotLight::new(
            at.point(0.7, 0.8, 0.8),
            DVec3::new(-1.0, -1.2, -0.8),
            intensity,
            15.0,
            40.0,
        )?,
    )?;
    let camera = PinholeCamera::new(
        at.point(0.0, 0.1, 3.0),
        at.point(0.0, 0.0, 0.0),
        DVec3::Y,
        45.0,
        RESOLUTION,
    )?;
    Ok(TestScene { name: "glass".into(), world: b.build()?, camera: Box::new(camera) })
}

/// Meshes with smooth normals, one of them of glass, under an environment map.
pub fn smooth_normals(at: Placement) -> Result<TestScene> {
    let mut b = WorldBuilder::new();
    let mut ball = Mesh::icosphere(2);
    ball.normals = Some(ball.positions.clone());
    let place = |scale: DVec3, [x, y, z]: [f64; 3]| {
        DAffine3::from_scale_rotation_translation(
            scale * at.scale,
            DQuat::from_rotation_x(0.4),
            at.point(x, y, z),
        )
    };
    let clay = b.add_material("clay", lambert(0.7))?;
    let metal = b.add_material("metal", rough_metal(0.15))?;
    let glass = b.add_material("glass", Material::Dielectric { relative_ior: 1.5 })?;
    let frosted = b.add_material(
        "frosted",
        Material::RoughDielectric { relative_ior: 1.4, alpha: DVec2::splat(0.3) },
    )?;
    b.add_mesh("clay", &ball, place(DVec3::new(0.4, 0.4, 0.3), [-0.9, 0.0, 0.0]), clay)?;
    b.add_mesh("metal", &ball, place(DVec3::new(-0.4, 0.3, 0.4), [0.0, 0.0, -0.4]), metal)?;
    b.add_mesh("glass", &ball, place(DVec3::splat(0.35), [0.8, 0.0, 0.1]), glass)?;
    b.add_mesh("frosted", &ball, place(DVec3::splat(0.25), [0.2, -0.1, 0.6]), frosted)?;
    b.add_quad("ground", at.quad([-2.0, -0.42, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, -4.0]), clay)?;
    let (width, height) = (16, 8);
    let pixel = |i: u32| {
        let bright = if i == 37 { 40.0 } else { 0.2 + 0.05 * f64::from(i % 7) };
        Rgb::new(bright, 0.9 * bright, if i.is_multiple_of(3) { 0.0 } else { bright })
    };
    let map = EnvironmentMap::new(
        width,
        height,
        (0..width * height).map(pixel).collect(),
        DMat3::IDENTITY,
    )?;
    b.set_environment("sky", map.with_lookup(Lookup::Bilinear))?;
    let camera = PinholeCamera::new(
        at.point(0.2, 0.7, 3.0),
        at.point(0.0, 0.0, 0.0),
        DVec3::Y,
        40.0,
        RESOLUTION,
    )?;
    Ok(TestScene { name: "smooth-normals".into(), world: b.build()?, camera: Box::new(camera) })
}

/// Light at infinity, Dirac and not, seen by a camera at infinity.
pub fn parallel(at: Placement) -> Result<TestScene> {
    let mut b = WorldBuilder::new();
    let clay = b.add_material("clay", lambert(0.7))?;
    let plate = b.add_material("plate", mixture(lambert(0.5), rough_metal(0.1), [0.5, 0.5]))?;
    let mirror =
        b.add_material("mirror", Material::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) })?;
    b.add_quad("ground", at.quad([-1.5, -0.5, 1.5], [3.0, 0.0, 0.0], [0.0, 0.0, -3.0]), clay)?;
    b.add_quad("plate", at.quad([-1.0, -0.4, -0.8], [2.0, 0.0, 0.0], [0.0, 1.0, -0.5]), plate)?;
    b.add_sphere("ball", at.sphere([0.5, -0.2, 0.2], 0.3), clay)?;
    b.add_sphere("mirror", at.sphere([-0.4, -0.2, 0.3], 0.3), mirror)?;
    b.add_light("sun", DirectionalLight::new(DVec3::new(0.3, -1.0, -0.4), Rgb::splat(3.0))?)?;
    b.set_environment("sky", ConstantEnvironment::new(Rgb::new(0.3, 0.4, 0.6))?)?;
    b.add_light(
        "lamp",
        PointLight::new(at.point(-0.9, 0.6, 0.9), Rgb::splat(0.5 * at.scale * at.scale))?,
    )?;
    let camera = OrthographicCamera::new(
        at.point(0.5, 1.0, 3.0),
        at.point(0.0, 0.0, 0.0),
        DVec3::Y,
        2.0 * at.scale,
        RESOLUTION,
    )?;
    Ok(TestScene { name: "parallel".into(), world: b.build()?, camera: Box::new(camera) })
}

/// An environment map of constant pixels over a zone of a sphere that looks inside, through a thin
/// lens.
pub fn bowl(at: Placement) -> Result<TestScene> {
    let mut b = WorldBuilder::new();
    let clay = b.add_material("clay", lambert(0.8))?;
    let metal = b.add_material("metal", rough_metal(0.4))?;
    let zone = Sphere {
        cos_min: -1.0,
        cos_max: 0.3,
        axis: DVec3::Y,
        inward: true,
        ..at.sphere([0.0, 0.0, 0.0], 1.0)
    };
    b.add_sphere("bowl", zone, clay)?;
    b.add_sphere("ball", at.sphere([0.1, -0.4, 0.0], 0.4), metal)?;
    let pixel = |i: u32| Rgb::splat(if i == 2 { 6.0 } else { f64::from(i % 4) * 0.3 });
    b.set_environment(
        "sky",
        EnvironmentMap::new(8, 4, (0..32).map(pixel).collect(), DMat3::from_rotation_x(0.7))?,
    )?;
    let eye = at.point(0.0, 2.5, 0.6);
    let camera = ThinLensCamera::new(
        eye,
        at.point(0.0, 0.0, 0.0),
        DVec3::NEG_Z,
        45.0,
        0.05 * at.scale,
        2.4 * at.scale,
        RESOLUTION,
    )?;
    Ok(TestScene { name: "bowl".into(), world: b.build()?, camera: Box::new(camera) })
}

/// Light at infinity over a scene that takes several boxes to cover: pebbles a hundred and ten
/// thousand sizes away.
pub fn pebbles(at: Placement) -> Result<TestScene> {
    let mut b = WorldBuilder::new();
    let clay = b.add_material("clay", lambert(0.7))?;
    let plate = b.add_material("plate", mixture(lambert(0.4), rough_metal(0.2), [0.5, 0.5]))?;
    b.add_quad("ground", at.quad([-1.5, -0.5, 1.5], [3.0, 0.0, 0.0], [0.0, 0.0, -3.0]), clay)?;
    b.add_sphere("ball", at.sphere([0.3, -0.1, 0.0], 0.4), plate)?;
    b.add_sphere("pebble", at.sphere([60.0, 80.0, -10.0], 0.2), clay)?;
    b.add_sphere("farther", at.sphere([-8e3, 6e3, 0.0], 0.5), clay)?;
    b.add_light("sun", DirectionalLight::new(DVec3::new(0.3, -1.0, -0.4), Rgb::splat(2.0))?)?;
    let pixel = |i: u32| Rgb::splat(if i == 5 { 4.0 } else { f64::from(i % 3) * 0.4 });
    b.set_environment(
        "sky",
        EnvironmentMap::new(8, 4, (0..32).map(pixel).collect(), DMat3::from_rotation_x(0.3))?,
    )?;
    let camera = PinholeCamera::new(
        at.point(0.2, 0.7, 3.0),
        at.point(0.0, 0.0, 0.0),
        DVec3::Y,
        40.0,
        RESOLUTION,
    )?;
    Ok(TestScene { name: "pebbles".into(), world: b.build()?, camera: Box::new(camera) })
}

pub fn own(at: Placement) -> Result<Vec<TestScene>> {
    Ok(vec![mixtures(at)?, glass(at)?, smooth_normals(at)?, parallel(at)?, bowl(at)?, pebbles(at)?])
}

/// All scenes of the gallery and the tests' own, but for doors: the paths through a slit are too few
/// to be counted.
pub fn all() -> Result<Vec<TestScene>> {
    let mut scenes = own(Placement::UNIT)?;
    for name in pathspace::gallery::NAMES.into_iter().filter(|name| !name.starts_with("door")) {
        let scene = pathspace::gallery::build(name, RESOLUTION)?;
        scenes.push(TestScene { name: name.to_owned(), world: scene.world, camera: scene.camera });
    }
    Ok(scenes)
}

/// A point of the film, uniform over its window.
pub fn film_sample(camera: &(impl Camera + ?Sized), sampler: &mut impl Sampler) -> FilmSample {
    FilmSample { raster: camera.film().from_window(sampler.next_2d()), offset: DVec2::ZERO }
}

/// The record with every vertex displaced by a few times its error bound.
fn displaced(
    stage: &Stage<'_, World>,
    record: &PathRecord,
    light: LightId,
    random: &mut impl Sampler,
) -> PathRecord {
    let mut sign =
        || DVec3::from([0.0; 3].map(|_| if random.next_1d() < 0.5 { -1.0 } else { 1.0 }));
    let move_point = |(i, x): (usize, &SurfacePoint)| {
        let near = |j: usize| {
            if record.points[j].place == Place::Infinite {
                0.0
            } else {
                record.points[j].position.distance(x.position)
            }
        };
        let reach = near(i.saturating_sub(1)).max(near((i + 1).min(record.points.len() - 1)));
        let rounding = 4.0 * f64::EPSILON;
        match x.place {
            Place::Infinite => SurfacePoint {
                geometric_normal: (x.geometric_normal + sign() * rounding).normalize(),
                ..*x
            },
            _ => SurfacePoint {
                position: x.position + sign() * (4.0 * x.error + rounding * reach),
                ..*x
            },
        }
    };
    let points: Vec<SurfacePoint> = record.points.iter().enumerate().map(move_point).collect();
    PathRecord::evaluate(stage, &points, &record.dirac, light)
}

/// The largest change of value and weight that is let pass: eight times the most that they do over
/// some random displacements, since these add up to the root of their number while the worst case
/// adds up to their number.
pub fn sensitivity(
    path: &Path<'_, '_, World>,
    weighting: &Weighting,
    displacements: u32,
    random: &mut impl Sampler,
) -> (f64, f64) {
    let (record, t) = (path.record(), usize::from(path.technique().t));
    let (value, weight) = (record.estimate(t), record.weight(path.technique(), weighting));
    let mut largest = (0.0f64, 0.0f64);
    for _ in 0..displacements {
        let moved = displaced(path.stage(), &record, path.light(), random);
        let change =
            (moved.estimate(t) - value).map(f64::abs).max_component() / value.max_component();
        largest.0 = largest.0.max(change);
        largest.1 = largest.1.max((moved.weight(path.technique(), weighting) - weight).abs());
    }
    (8.0 * largest.0, 8.0 * largest.1)
}
