//! The host of the example `mesh_host`: f32 triangles over obvhs, as exact as any scene.
#![allow(missing_docs, reason = "a test program")]

#[path = "../examples/mesh_host/scene.rs"]
mod scene;

use glam::{DVec3, UVec2};
use pathspace::bsdf::Lambert;
use pathspace::endpoint::{Camera, IrradianceMeter, PinholeCamera};
use pathspace::geometry::SurfacePoint;
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer, PathTracing};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Render, Settings, measure};
use pathspace::scene::Scene;
use scene::MeshScene;

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

/// A closed surface like a sphere, seen from inside: an octahedron whose faces are divided so often,
/// around `center`. All of it emits 1 and reflects one half, so that the radiance is 2 everywhere.
fn furnace(divisions: u32, center: [f32; 3]) -> Result<MeshScene> {
    let n = divisions as f32;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    // The vertices of a face that two faces share are the same to the bit.
    for signs in 0..8 {
        let sign = |axis: u32| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let first = vertices.len() as u32;
        let row = |i: u32| first + i * (i + 1) / 2;
        for i in 0..=divisions {
            for j in 0..=i {
                let [x, y, z] = [(divisions - i) as f32, (i - j) as f32, j as f32].map(|c| c / n);
                let r = (x * x + y * y + z * z).sqrt();
                let on_sphere = [x / r * sign(0), y / r * sign(1), z / r * sign(2)];
                vertices.push([0, 1, 2].map(|k| center[k] + on_sphere[k]));
                if i < divisions {
                    let (a, b) = (row(i) + j, row(i + 1) + j);
                    triangles.push([a, b, b + 1]);
                    if j < i {
                        triangles.push([a, b + 1, a + 1]);
                    }
                }
            }
        }
    }
    let center = DVec3::from_array(center.map(f64::from));
    for triangle in &mut triangles {
        let [a, b, c] =
            triangle.map(|i: u32| DVec3::from_array(vertices[i as usize].map(f64::from)));
        if (b - a).cross(c - a).dot(center - a) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    let grey = Lambert::new(0.5.into())?;
    Ok(MeshScene::new(vertices, triangles, grey, (0, Rgb::WHITE))?)
}

const CENTERS: [[f32; 3]; 2] = [[0.0; 3], [900.0, -300.0, 50.0]];

/// Within 3 standard errors, of which one is at most 0.25 %. Light that leaks out, or that a surface
/// takes from itself, is missing; next event estimation alone depends on shadow rays, and
/// emission that is hit on none.
#[test]
fn the_white_furnace_is_closed_and_casts_no_shadow_on_itself() -> Result {
    let next_event = PathTracer { mode: PathTracing::NextEventOnly, ..PathTracer::default() };
    let emission = PathTracer { mode: PathTracing::EmissionOnly, ..PathTracer::default() };
    for center in CENTERS {
        let scene = furnace(6, center)?;
        let at = DVec3::from_array(center.map(f64::from)) + DVec3::new(0.2, 0.1, -0.3);
        let meter = IrradianceMeter::new(at, DVec3::new(1.0, 2.0, 3.0))?;
        let eye = PinholeCamera::new(at, at + DVec3::ONE, DVec3::Y, 70.0, UVec2::splat(32))?;
        let both = PathTracer::default();
        let cases: [(&dyn Camera, &dyn Render<MeshScene>, f64); 5] = [
            (&eye, &both, 2.0),
            (&eye, &emission, 2.0),
            // Without the light that the walls emit towards the lens themselves.
            (&eye, &next_event, 1.0),
            (&meter, &LightTracer::default(), 2.0 * std::f64::consts::PI),
            (&meter, &Bidirectional::default(), 2.0 * std::f64::consts::PI),
        ];
        for (index, (camera, integrator, expected)) in cases.into_iter().enumerate() {
            let settings =
                Settings { budget: Budget::Samples(256), seed: 1, ..Settings::default() };
            let measured = measure(&scene, camera, integrator, &settings)?;
            let (mean, error) = (measured.mean().g(), measured.standard_error().g());
            let name = format!("{index} at {center:?}: {mean} ± {error}, expected {expected}");
            assert!((mean - expected).abs() <= 3.0 * error + 1e-9, "{name}");
            assert!(error <= 0.0025 * expected, "{name}");
            assert_eq!(measured.counters.non_finite, 0, "{name}");
        }
    }
    Ok(())
}

/// No ray from inside gets out, also not through an edge or a vertex, and whoever is hit is seen.
#[test]
fn no_ray_leaves_a_closed_mesh() -> Result {
    for center in CENTERS {
        let scene = furnace(5, center)?;
        let middle = DVec3::from_array(center.map(f64::from));
        let inside = SurfacePoint::dirac(middle);
        let mut point = inside;
        let mut hits = 0;
        // At the vertices, and at the middles of the edges, of all faces.
        for (i, j) in (0..=20u32).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let corner = DVec3::new(f64::from(20 - i), f64::from(i - j), f64::from(j));
            for signs in 0..8 {
                let sign = |axis: u32| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
                let direction = (corner * DVec3::new(sign(0), sign(1), sign(2))).normalize();
                let hit = scene.intersect(&inside, direction).ok_or("a leak")?;
                assert!(scene.visible(&inside, &hit), "{hit:?}");
                // From wall to wall.
                if point.primitive != hit.primitive && point.primitive != SurfacePoint::NONE {
                    let across = (hit.position - point.position).normalize();
                    let normal = point.geometric_normal;
                    if across.dot(normal) > 1e-3 && across.dot(hit.geometric_normal) < -1e-3 {
                        let next = scene.intersect(&point, across).ok_or("a leak between walls")?;
                        assert!(next.position.distance(hit.position) < 1e-6, "{next:?} {hit:?}");
                        assert!(scene.visible(&point, &hit) && scene.visible(&hit, &point));
                        hits += 1;
                    }
                }
                point = hit;
            }
        }
        assert!(hits > 300, "{hits}");
    }
    Ok(())
}
