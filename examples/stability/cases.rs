//! The stress matrix: each case is a scene with an exact answer, pushed to an extreme.

use crate::measure::Method::{self, Bidirectional, Emission, Light, Path, UniformArea};
use crate::scenes::{
    Stage, camera, cap_sphere, cube, cube_mesh, footprint, fresnel, furnace_box, furnace_sphere, lambert, polygon_irradiance, square_light,
};
use pathspace::endpoint::{Camera, ConstantEnvironment, DirectionalLight};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DAffine3, DVec2, DVec3};
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::scene::{Material, Mesh, World};
use std::f64::consts::PI;

/// A scene under stress.
pub struct Case {
    /// The row of the matrix.
    pub row: &'static str,
    /// What is pushed.
    pub family: &'static str,
    /// How far; also the abscissa of a figure.
    pub value: f64,
    pub expected: [f64; 3],
    pub world: World,
    pub camera: Box<dyn Camera + Send>,
    pub depth: Depth,
    pub roulette: Roulette,
    pub methods: &'static [Method],
    /// Integrators that must report exactly 0.
    pub blind: &'static [Method],
    /// Relative standard error that suffices.
    pub error: f64,
    /// How well the answer is known, or how improbable are events that it contains and no sample may meet.
    pub tolerance: f64,
    /// The same scene without stress and the factor between both images: with the same random numbers they differ by rounding only.
    pub twin: Option<(World, Box<dyn Camera + Send>, f64)>,
}

const UNLIMITED: Depth = Depth { min_bounces: 0, max_bounces: None };
const ONE: Depth = Depth::exactly(1);
const WALKS: &[Method] = &[Emission, Path, Light, Bidirectional];
const FROM_CAMERA: &[Method] = &[Emission, Path, Bidirectional];
const CONNECTED: &[Method] = &[Path, Bidirectional];

impl Case {
    fn new(row: &'static str, family: &'static str, value: f64, expected: f64, world: World, camera: impl Camera + Send + 'static) -> Self {
        Self {
            row,
            family,
            value,
            expected: [expected; 3],
            world,
            camera: Box::new(camera),
            depth: UNLIMITED,
            roulette: Roulette::default(),
            methods: WALKS,
            blind: &[],
            error: 0.005,
            tolerance: 1e-9,
            twin: None,
        }
    }

    fn by(self, methods: &'static [Method]) -> Self {
        Self { methods, ..self }
    }

    fn depth(self, depth: Depth) -> Self {
        Self { depth, ..self }
    }

    fn twin(self, world: World, camera: impl Camera + Send + 'static, factor: f64) -> Self {
        // The twin tells more than statistics can.
        Self { twin: Some((world, Box::new(camera), factor)), error: 0.02, ..self }
    }
}

fn sky() -> ConstantEnvironment {
    ConstantEnvironment::new(Rgb::WHITE).expect("valid")
}

/// The furnace of the box, seen from its middle.
fn boxed(row: &'static str, family: &'static str, value: f64, scale: f64, offset: DVec3, radiance: f64) -> Case {
    let at = |scale: f64, offset: DVec3, radiance: f64| {
        let world = furnace_box(offset, scale, &lambert(0.5), radiance);
        (world, camera(offset + DVec3::splat(0.5 * scale), offset + DVec3::new(1.0, 0.7, 0.4) * scale, 80.0))
    };
    let (world, eye) = at(scale, offset, radiance);
    let (twin, twin_eye) = at(1.0, DVec3::ZERO, 1.0);
    Case::new(row, family, value, 2.0 * radiance, world, eye).twin(twin, twin_eye, radiance)
}

fn capped(row: &'static str, family: &'static str, value: f64, scale: f64, offset: DVec3, radiance: f64) -> Case {
    let at = |scale: f64, offset: DVec3, radiance: f64| {
        (cap_sphere(offset, scale, 0.5, radiance), camera(offset, offset - DVec3::Z * scale, 53.0))
    };
    let (world, eye) = at(scale, offset, radiance);
    let (twin, twin_eye) = at(1.0, DVec3::ZERO, 1.0);
    Case::new(row, family, value, 0.1 * radiance, world, eye).by(&Method::ALL).twin(twin, twin_eye, radiance)
}

fn lit_floor() -> f64 {
    let lamp = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 2.0));
    0.5 / PI * polygon_irradiance(DVec3::ZERO, DVec3::Z, &lamp)
}

/// Powers of ten.
fn decades(exponents: &'static [i32]) -> impl Iterator<Item = f64> {
    exponents.iter().map(|&e| 10f64.powi(e))
}

pub fn all() -> Vec<Case> {
    let mut cases = Vec::new();
    placement(&mut cases);
    energy(&mut cases);
    lights(&mut cases);
    geometry(&mut cases);
    materials(&mut cases);
    cases
}

fn placement(cases: &mut Vec<Case>) {
    for scale in decades(&[-45, -30, -6, -3, 0, 3, 6, 30, 45]) {
        cases.push(boxed("S01", "scene scale, box", scale, scale, DVec3::ZERO, 1.0));
        cases.push(capped("S01", "scene scale, sphere", scale, scale, DVec3::ZERO, 1.0));
    }
    for offset in decades(&[1, 3, 6, 9]) {
        let by = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
        cases.push(boxed("S02", "world offset, box", offset, 1.0, by, 1.0));
        cases.push(capped("S02", "world offset, sphere", offset, 1.0, by, 1.0));
    }
    for distance in decades(&[1, 2, 4, 6, 8]) {
        let eye = DVec3::new(0.8, 0.1, 0.4).normalize() * distance;
        let world = square_light(0.5, DVec3::ZERO, 1.0, 1.0);
        let eye = camera(eye, DVec3::ZERO, 2.0 * (1e-3 / distance).atan().to_degrees());
        cases.push(Case::new("S03", "camera distance", distance, lit_floor(), world, eye).by(FROM_CAMERA).depth(ONE));
    }
    for radiance in decades(&[-150, -30, -6, 0, 6, 30, 150]) {
        cases.push(boxed("S04", "radiance", radiance, 1.0, DVec3::ZERO, radiance));
    }
    for scale in decades(&[-6, 0, 6]) {
        let at = |scale: f64| {
            let mut stage = Stage::default();
            stage.sphere(Sphere::new(DVec3::ZERO, scale), lambert(0.6));
            stage.environment(sky());
            (stage.world(), camera(DVec3::Z * 3.0 * scale, DVec3::ZERO, 20.0))
        };
        let ((world, eye), (twin, twin_eye)) = (at(scale), at(1.0));
        cases.push(Case::new("S30", "scale under an environment", scale, 0.6, world, eye).twin(twin, twin_eye, 1.0));
    }
}

fn energy(cases: &mut Vec<Case>) {
    let eye = || camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0);
    for black in [1e-1, 1e-2, 1e-3] {
        let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(1.0 - black), 1.0);
        let methods: &[Method] = if black > 0.05 { WALKS } else { &[Emission, Light] };
        let error = if black < 0.005 { 0.03 } else { 0.01 };
        cases.push(Case { error, ..Case::new("S05", "1 - albedo", black, 1.0 / black, world, eye()).by(methods) });
    }
    for bounces in [10, 100, 1000] {
        let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(1.0), 1.0);
        let methods: &[Method] = if bounces > 10 { &[Emission, Path, Light] } else { &Method::ALL };
        let case = Case::new("S06", "bounces at albedo 1", f64::from(bounces), f64::from(bounces) + 1.0, world, eye());
        cases.push(case.by(methods).depth(Depth::up_to(bounces)));
    }
    // Only the blue channel goes on: roulette must neither kill it by luminance nor couple the channels.
    let wall = Material::Lambert { albedo: Rgb::new(0.0, 0.0, 0.9) };
    let world = furnace_sphere(DVec3::ZERO, 1.0, &wall, 1.0);
    let case = Case::new("S08", "albedo of one channel", 0.9, 1.0, world, eye());
    cases.push(Case { error: 0.02, expected: [1.0, 1.0, 10.0], roulette: Roulette { start: 0, ..Roulette::default() }, ..case });
    let wall =
        Material::Mixture { components: Box::new([lambert(1.0), Material::Mirror { reflectance: Rgb::WHITE }]), weights: [0.4, 0.4] };
    let world = furnace_sphere(DVec3::ZERO, 1.0, &wall, 1.0);
    // Light tracing cannot see what the mirror shows.
    cases.push(Case::new("S37", "albedo of diffuse and mirror", 0.8, 5.0, world, eye()).by(FROM_CAMERA));
}

fn lights(cases: &mut Vec<Case>) {
    let floor_and = |radius: f64, distance: f64, radiance: f64| {
        let mut stage = Stage::default();
        stage.square(0.0, 1e-3 * distance, true, lambert(1.0));
        let sphere = stage.sphere(Sphere::new(DVec3::Z * distance, radius), Material::Black);
        stage.glow(sphere, radiance);
        stage.world()
    };
    for ratio in decades(&[-12, -9, -6, -3, -1]) {
        let world = floor_and(ratio, 1.0, 1.0 / (ratio * ratio));
        let eye = footprint(DVec3::ZERO, 0.5, 1e-6);
        cases.push(Case::new("S09", "radius / distance of a sphere light", ratio, 1.0, world, eye).by(CONNECTED).depth(ONE));
    }
    for gap in decades(&[-12, -9, -6, -3, -1]) {
        let mut stage = Stage::default();
        stage.square(0.0, 1e-3, true, lambert(1.0));
        let sphere = stage.sphere(Sphere::new(DVec3::Z * (1.0 + gap), 1.0), Material::Black);
        stage.glow(sphere, 1.0);
        let eye = footprint(DVec3::ZERO, 0.5 * gap, 1e-3 * gap);
        let expected = 1.0 / (1.0 + gap).powi(2);
        cases.push(Case::new("S10", "gap before a sphere light", gap, expected, stage.world(), eye).by(CONNECTED).depth(ONE));
    }
    for half in decades(&[-6, -4, -2, 2, 4]) {
        let mut stage = Stage::default();
        stage.square(0.0, 0.1, true, lambert(1.0));
        let lamp = stage.square(1.0, half, false, Material::Black);
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| DVec3::new(x, y, 1.0));
        let irradiance = polygon_irradiance(DVec3::ZERO, DVec3::Z, &corners);
        stage.glow(lamp, PI / irradiance);
        let eye = footprint(DVec3::ZERO, 0.5, 1e-6);
        cases.push(Case::new("S40", "size of a square light", half, 1.0, stage.world(), eye).by(CONNECTED).depth(ONE));
    }
    for ratio in decades(&[2, 4, 6]) {
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(0.5));
        let lamp = stage.square(2.0, 1.0, false, Material::Black);
        stage.glow(lamp, 1.0);
        // Shines upwards, into nothing.
        let strong = stage.square(3.0, 1.0, true, Material::Black);
        stage.glow(strong, ratio);
        let eye = footprint(DVec3::ZERO, 1.0, 1e-4);
        let case = Case::new("S31", "power of a useless light", ratio, lit_floor(), stage.world(), eye);
        cases.push(case.by(FROM_CAMERA).depth(ONE));
    }
    for half in decades(&[0, 3, 6]) {
        let mut stage = Stage::default();
        stage.square(0.0, half, true, lambert(0.5));
        stage.light(DirectionalLight::new(DVec3::new(0.75f64.sqrt(), 0.0, -0.5), Rgb::splat(3.0)).expect("valid"));
        let eye = footprint(DVec3::ZERO, half, half);
        let case = Case::new("S52", "plane under a directional light", half, 0.75 / PI, stage.world(), eye);
        cases.push(Case { blind: &[Emission, UniformArea], ..case.by(&[Path, Light, Bidirectional]).depth(ONE) });
    }
}

fn geometry(cases: &mut Vec<Case>) {
    let eye = || camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 80.0);
    // A mirrored instance emits on the image of its front side.
    for x in [1.0, -1.0] {
        let mut stage = Stage::default();
        let walls = stage.mesh(&cube_mesh(), DAffine3::from_scale(DVec3::new(x, 1.0, 1.0)), lambert(0.5));
        stage.glow(walls, 1.0);
        let eye = camera(DVec3::new(0.5 * x, 0.5, 0.5), DVec3::new(x, 0.7, 0.4), 80.0);
        cases.push(Case::new("S11", "mirrored instance", x, 2.0, stage.world(), eye));
    }
    for width in decades(&[-15, -12, -9, -6, -3]) {
        let mut stage = Stage::default();
        for (i, face) in cube(DVec3::ZERO, 1.0).into_iter().enumerate() {
            if i != 1 {
                let face = stage.quad(face, lambert(0.5));
                stage.glow(face, 1.0);
            }
        }
        // The wall that the camera looks at has strips ever thinner towards the point that it looks at.
        let mut cuts = vec![0.0, 1.0];
        let mut w = width;
        while w < 0.25 {
            cuts.extend([0.7 - w, 0.7 + w]);
            w *= 10.0;
        }
        cuts.sort_by(f64::total_cmp);
        let positions = cuts.iter().flat_map(|&y| [DVec3::new(1.0, y, 0.0), DVec3::new(1.0, y, 1.0)]).collect();
        let indices = (0..cuts.len() as u32 - 1).map(|i| 2 * i).flat_map(|i| [[i, i + 1, i + 2], [i + 1, i + 3, i + 2]]).collect();
        let strips = stage.mesh(&Mesh { positions, indices, ..Mesh::default() }, DAffine3::IDENTITY, lambert(0.5));
        stage.glow(strips, 1.0);
        let narrow = camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 60.0);
        cases.push(Case::new("S13", "width of slivers", width, 2.0, stage.world(), narrow));
    }
    for gap in decades(&[-12, -9, -6, -3]) {
        let mut stage = Stage::default();
        let inner = stage.sphere(Sphere::new(DVec3::ZERO, 1.0), lambert(0.5));
        let outer = stage.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0 + gap) }, lambert(0.5));
        stage.glow(inner, 1.0);
        stage.glow(outer, 1.0);
        let eye = DVec3::Z * (1.0 + 0.5 * gap);
        let eye = camera(eye, eye + DVec3::new(1.0, 0.5, 0.1), 60.0);
        cases.push(Case::new("S16", "gap between spheres", gap, 2.0, stage.world(), eye).by(FROM_CAMERA));
    }
    for distance in decades(&[-9, -6, -3, 0]) {
        let mut stage = Stage::default();
        let (corner, along) = (DVec3::new(0.0, -1e4, 0.0), DVec3::Y * 2e4);
        stage.quad(Quad { origin: corner, edge_u: DVec3::X * 1e4, edge_v: along }, lambert(0.6));
        stage.quad(Quad { origin: corner, edge_u: along, edge_v: DVec3::Z * 1e4 }, lambert(0.6));
        stage.environment(sky());
        let eye = camera(DVec3::new(distance, 0.0, 0.5 * distance), DVec3::X * distance, 1e-3);
        cases.push(Case::new("S17", "distance from a corner", distance, 3.0 / 7.0, stage.world(), eye).by(FROM_CAMERA));
    }
    for copies in [1.0, 2.0] {
        // A wall that is there twice scatters once.
        let mut stage = Stage::default();
        for (i, face) in cube(DVec3::ZERO, 1.0).into_iter().enumerate() {
            for _ in 0..if i == 4 { copies as u32 } else { 1 } {
                let id = stage.quad(face, if i == 4 { lambert(0.5) } else { Material::Black });
                if i == 5 {
                    stage.glow(id, PI);
                }
            }
        }
        let expected = 0.5 * 0.752_274_688_454_107_5;
        let eye = footprint(DVec3::new(0.5, 0.5, 0.0), 0.5, 1e-4);
        cases.push(Case::new("S15", "copies of a wall", copies, expected, stage.world(), eye).by(FROM_CAMERA).depth(ONE));
    }
    for bounces in [5, 18] {
        // Without weights the corners' 1/r² would have no variance to speak of.
        let expected = 2.0 * (1.0 - 0.5f64.powi(bounces + 1));
        let world = furnace_box(DVec3::ZERO, 1.0, &lambert(0.5), 1.0);
        let case = Case::new("S18", "bounces of weighted paths", f64::from(bounces), expected, world, eye());
        cases.push(Case { roulette: Roulette::NEVER, ..case.by(CONNECTED).depth(Depth::up_to(bounces as u32)) });
    }
}

fn materials(cases: &mut Vec<Case>) {
    let under_sky = |material: Material, cosine: f64| {
        let mut stage = Stage::default();
        stage.square(0.0, 10.0, true, material);
        stage.environment(sky());
        let eye = camera(DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine), DVec3::ZERO, 1e-3 * cosine);
        (stage.world(), eye)
    };
    let ggx = |x: f64, y: f64| Material::RoughMirror { reflectance: Rgb::WHITE, alpha: DVec2::new(x, y) };
    for alpha in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-8] {
        let (world, eye) = under_sky(ggx(alpha, alpha), 0.5);
        // Known at 1 and 0.1. Below, G2/G1 = 1 - Λ(i) and Λ = α² tan² θ / 4 up to 5 %.
        let expected = match alpha {
            1.0 => 0.450_693_855_665_945_16,
            0.1 => 0.969_204_984_411_689_5,
            _ if alpha < 1e-4 => 1.0,
            _ => 1.0 - 0.75 * alpha * alpha,
        };
        let tolerance = if alpha < 0.1 { 0.05 * alpha * alpha + 1e-9 } else { 1e-9 };
        cases.push(Case { tolerance, ..Case::new("S20", "roughness", alpha, expected, world, eye).by(FROM_CAMERA).depth(ONE) });
    }
    for cosine in [1.0, 1e-2, 1e-4, 1e-6, 1e-8] {
        let (world, eye) = under_sky(lambert(0.6), cosine);
        cases.push(Case::new("S21", "grazing cosine, diffuse", cosine, 0.6, world, eye).by(FROM_CAMERA).depth(ONE));
        let (world, eye) = under_sky(ggx(1e-5, 1e-5), cosine);
        cases.push(Case::new("S21", "grazing cosine, mirror limit", cosine, 1.0, world, eye).by(FROM_CAMERA).depth(ONE));
    }
    // A pane between the camera and a wall: multiple reflections inside.
    for ior in [1e-3, 0.5, 1.0, 1.0 + 1e-7, 1.0001, 1.5, 10.0, 100.0] {
        let mut stage = Stage::default();
        let glass = Material::Dielectric { relative_ior: ior };
        stage.square(0.0, 10.0, false, glass.clone());
        stage.square(0.1, 10.0, true, glass);
        let wall = stage.square(1.0, 10.0, false, Material::Black);
        stage.glow(wall, 1.0);
        let reflectance = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let eye = camera(DVec3::NEG_Z, DVec3::ZERO, 1e-6);
        let expected = (1.0 - reflectance) / (1.0 + reflectance);
        let row = if (ior - 1.0f64).abs() < 1e-3 { "S22" } else { "S48" };
        let case = Case::new(row, "index of refraction of a pane", ior, expected, stage.world(), eye).by(FROM_CAMERA);
        // The walks inside n = 100 go on for a thousand events, of which most bring nothing.
        let tolerance = if row == "S22" { 1e-8 } else { 1e-9 };
        cases.push(Case { error: if expected < 0.1 { 0.05 } else { 0.005 }, tolerance, ..case });
    }
    // From inside glass: just below the critical angle a little light gets in, above it none.
    for beyond in [1e-1, 1e-2, 1e-3, 1e-6, 0.0, -1e-7, -1e-2] {
        let mut stage = Stage::default();
        stage.square(0.0, 1e3, true, Material::Dielectric { relative_ior: 1.5 });
        stage.environment(sky());
        let far: f64 = beyond;
        let sine = if far >= 0.0 { (1.0 - far * far).sqrt() / 1.5 } else { (1.0 - far) / 1.5 };
        let near = ((1.0 - sine) * (1.0 + sine)).sqrt();
        let eye = camera(DVec3::new(-sine, 0.0, -near), DVec3::ZERO, 1e-12);
        // Inside, the sky is there too, above by refraction and below by reflection.
        let reflectance = if far > 0.0 { fresnel(near, far, 1.0 / 1.5) } else { 1.0 };
        let expected = 2.25 * (1.0 - reflectance) + reflectance;
        let case = Case::new("S23", "cosine behind the critical angle", beyond, expected, stage.world(), eye).by(FROM_CAMERA);
        cases.push(Case { tolerance: if (0.0..1e-5).contains(&beyond) { 1e-5 } else { 1e-9 }, ..case });
    }
    let bent = |tilt: f64| {
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(0.5));
        let positions =
            vec![DVec3::new(-1.0, -1.0, 2.0), DVec3::new(-1.0, 1.0, 2.0), DVec3::new(1.0, 1.0, 2.0), DVec3::new(1.0, -1.0, 2.0)];
        let normals = Some(positions.iter().map(|p| DVec3::new(tilt * p.x, tilt * p.y, -1.0).normalize()).collect());
        let mesh = Mesh { positions, normals, indices: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
        let lamp = stage.mesh(&mesh, DAffine3::IDENTITY, Material::Black);
        stage.glow(lamp, 1.0);
        stage.world()
    };
    for tilt in [0.0, 1.0, 100.0] {
        let eye = footprint(DVec3::ZERO, 1.0, 1e-4);
        cases.push(Case::new("S27", "bend of a light's normals", tilt, lit_floor(), bent(tilt), eye).by(FROM_CAMERA).depth(ONE));
    }
}
