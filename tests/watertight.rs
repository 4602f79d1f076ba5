//! No ray passes between the surfaces of a closed scene, and none meets the surface that it leaves.

use pathspace::geometry::{Quad, Sphere, SurfacePoint};
use pathspace::glam::{DAffine3, DVec2, DVec3};
use pathspace::scene::{Material, Mesh, Scene, SurfaceArea, World, WorldBuilder};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn world(add: impl FnOnce(&mut WorldBuilder, pathspace::scene::MaterialId)) -> World {
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black).expect("valid");
    add(&mut builder, black);
    builder.build().expect("valid")
}

fn mesh_world(mesh: &Mesh, scale: f64, offset: DVec3) -> World {
    let transform = DAffine3 {
        matrix3: pathspace::glam::DMat3::from_diagonal(DVec3::splat(scale)),
        translation: offset,
    };
    world(|builder, black| {
        builder.add_mesh("mesh", mesh, transform, black).expect("valid");
    })
}

fn box_mesh() -> Mesh {
    let corner = |i: u32| {
        DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0 - 1.0
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let indices = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions: (0..8).map(corner).collect(), indices, ..Mesh::default() }
}

fn quad_box(builder: &mut WorldBuilder, material: pathspace::scene::MaterialId) {
    let (x, y, z, low) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0, DVec3::splat(-1.0));
    for (i, (origin, edge_u, edge_v)) in
        [(low, x, y), (low, y, z), (low, z, x), (low + z, x, y), (low + x, y, z), (low + y, z, x)]
            .into_iter()
            .enumerate()
    {
        builder
            .add_quad(format!("wall {i}"), Quad { origin, edge_u, edge_v }, material)
            .expect("valid");
    }
}

fn random_direction(rng: &mut Pcg64Mcg) -> DVec3 {
    pathspace::math::warp::square_to_sphere(DVec2::new(rng.random(), rng.random()))
}

/// Rays from inside at vertices, at points of edges and into random directions; returns the number
/// of misses.
fn misses(world: &World, mesh: &Mesh, scale: f64, offset: DVec3, rays: u32) -> u32 {
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let mut missed = 0;
    for i in 0..rays {
        let inside = random_direction(&mut rng) * rng.random_range(0.0..0.5);
        let [a, b, _] = mesh.indices[rng.random_range(0..mesh.indices.len())]
            .map(|i| mesh.positions[i as usize]);
        let target = match i % 4 {
            0 => a,
            1 => 0.5 * (a + b),
            2 => a + (b - a) * rng.random::<f64>(),
            _ => inside + random_direction(&mut rng),
        };
        let (from, target) = (inside * scale + offset, target * scale + offset);
        if world.intersect(&SurfacePoint::dirac(from), (target - from).normalize()).is_none() {
            missed += 1;
        }
    }
    missed
}

#[test]
fn nothing_leaks_through_edges_and_vertices() {
    let rays = if cfg!(debug_assertions) { 20_000 } else { 1_000_000 };
    for (name, mesh) in [("icosphere", Mesh::icosphere(4)), ("box", box_mesh())] {
        for (scale, offset, share) in [
            (1.0, DVec3::ZERO, 1),
            (1.0, DVec3::new(1e6, -1e6, 1e6), 4),
            (1e-6, DVec3::ZERO, 4),
            (1e6, DVec3::ZERO, 4),
            (1e-6, DVec3::new(1.0, 1.0, -1.0), 8),
            (1e-30, DVec3::ZERO, 8),
            (1e30, DVec3::ZERO, 8),
        ] {
            let world = mesh_world(&mesh, scale, offset);
            assert_eq!(
                misses(&world, &mesh, scale, offset, rays / share),
                0,
                "{name}, scale {scale}, offset {offset}"
            );
        }
    }
    let quads = world(quad_box);
    assert_eq!(misses(&quads, &box_mesh(), 1.0, DVec3::ZERO, rays / 4), 0, "quads");
}

#[test]
fn far_cameras_see_every_edge() {
    let mesh = Mesh::icosphere(3);
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    for offset in [DVec3::ZERO, DVec3::new(1e5, 3e5, -2e5)] {
        let world = mesh_world(&mesh, 1.0, offset);
        for distance in [1e3, 1e6, 1e9] {
            for _ in 0..20_000 {
                let toward = random_direction(&mut rng);
                let from = offset + toward * distance;
                let vertex = mesh.positions[rng.random_range(0..mesh.positions.len())];
                // Vertices near the silhouette are missed for good reason.
                if vertex.dot(toward) > 0.1 {
                    let hit = world.intersect(
                        &SurfacePoint::dirac(from),
                        (vertex + offset - from).normalize(),
                    );
                    let hit = hit.expect("a vertex on the near side");
                    assert!(
                        hit.position.distance(vertex + offset) < 1e-15 * (distance + 1e6) * 20.0
                    );
                }
            }
        }
    }
}

/// Random surface points and directions on their inner side; each ray must reach the opposite wall
/// and never its own.
fn check_departures(
    world: &World,
    inner: f64,
    exact_opposite: impl Fn(&SurfacePoint, DVec3) -> Option<f64>,
) {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let rays = if cfg!(debug_assertions) { 10_000 } else { 300_000 };
    for i in 0..rays {
        let mut x = world.sample_surface(rng.random(), DVec2::new(rng.random(), rng.random()));
        // Every fourth point lies on an edge or at a vertex.
        if i % 4 == 0 {
            x = world.sample_surface(
                rng.random(),
                DVec2::new(if i % 8 == 0 { 0.0 } else { rng.random() }, 0.0),
            );
        }
        let mut d = random_direction(&mut rng);
        if d.dot(x.geometric_normal) * inner < 0.0 {
            d = -d;
        }
        let Some(expected) = exact_opposite(&x, d) else { continue };
        let y =
            world.intersect(&x, d).unwrap_or_else(|| panic!("ray {i} from {x:?} into {d} leaks"));
        let found = x.position.distance(y.position);
        // A point on an edge lies on the neighbouring wall as well, within rounding.
        let on_both = i % 4 == 0 && found <= 4.0 * x.error && y.primitive != x.primitive;
        assert!(
            on_both || (found - expected).abs() <= 1e-6 * expected + 1e-13,
            "ray {i}: {found} instead of {expected} from {x:?} into {d} to {y:?}"
        );
    }
}

/// Distance to the walls of the box [-1, 1]³, unless the ray starts at or hits an edge, where one
/// wall's distance is 0.
fn box_exit(x: &SurfacePoint, d: DVec3) -> Option<f64> {
    let n = x.geometric_normal;
    (0..3)
        .map(|axis| {
            if n[axis].abs() > 0.5 {
                (2.0 / d[axis]).abs()
            } else {
                (1.0f64.copysign(d[axis]) - x.position[axis]) / d[axis]
            }
        })
        .min_by(f64::total_cmp)
        .filter(|&t| t > 1e-10)
}

#[test]
fn rays_leave_the_walls_of_a_box() {
    check_departures(&mesh_world(&box_mesh(), 1.0, DVec3::ZERO), -1.0, box_exit);
    // The quads' normals point both ways; start on the inner side by position.
    let quads = world(quad_box);
    check_departures(&quads, 0.0, |x, d| {
        if d.dot(x.position * x.geometric_normal.abs()) < 0.0 { box_exit(x, d) } else { None }
    });
}

#[test]
fn rays_leave_the_inside_of_a_sphere() {
    for (center, radius) in
        [(DVec3::ZERO, 1.0), (DVec3::new(30.0, -20.0, 10.0), 0.01), (DVec3::splat(-3.0), 1e3)]
    {
        let sphere = Sphere { inward: true, ..Sphere::new(center, radius) };
        let world = world(|builder, black| {
            builder.add_sphere("shell", sphere, black).expect("valid");
        });
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        for _ in 0..100_000 {
            let x = world.sample_surface(rng.random(), DVec2::new(rng.random(), rng.random()));
            let mut d = random_direction(&mut rng);
            d *= d.dot(x.geometric_normal).signum();
            let chord = 2.0 * radius * d.dot(x.geometric_normal);
            let y = world.intersect(&x, d).expect("closed");
            let found = x.position.distance(y.position);
            assert!(
                (found - chord).abs() <= 1e-12 * radius + 20.0 * x.error,
                "{found} instead of {chord}"
            );
            assert!(world.intersect(&x, -d).is_none(), "nothing is outside");
            assert!(world.visible(&x, &y) && world.visible(&y, &x));
        }
    }
}

#[test]
fn a_thin_gap_between_spheres_is_resolved() {
    let gap = 1e-6;
    let world = world(|builder, black| {
        builder.add_sphere("inner", Sphere::new(DVec3::ZERO, 1.0), black).expect("valid");
        builder.add_sphere("outer", Sphere::new(DVec3::ZERO, 1.0 + gap), black).expect("valid");
    });
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for _ in 0..100_000 {
        let n = random_direction(&mut rng);
        let start =
            SurfacePoint { primitive: 0, surface: 0, ..Sphere::new(DVec3::ZERO, 1.0).point_at(n) };
        let mut d = random_direction(&mut rng);
        d *= d.dot(n).signum();
        let outer = world.intersect(&start, d).expect("enclosed");
        assert_eq!(outer.primitive, 1);
        // The chord across the gap: root of t² + 2 t cos = gap (2 + gap).
        let (c, k) = (d.dot(n), gap * (2.0 + gap));
        let expected = k / (c + (c * c + k).sqrt());
        assert!((outer.position.distance(start.position) / expected - 1.0).abs() < 1e-8);
        assert!(world.visible(&start, &outer) && world.visible(&outer, &start));
        // Back from the outer sphere: the inner one blocks what goes down steeply.
        let down = world.intersect(&outer, -d).expect("the point where we came from");
        assert_eq!(down.primitive, 0);
        assert!(down.position.distance(start.position) < 1e-7);
        let opposite =
            SurfacePoint { primitive: 0, surface: 0, ..Sphere::new(DVec3::ZERO, 1.0).point_at(-n) };
        assert!(!world.visible(&outer, &opposite) && !world.visible(&opposite, &outer));
    }
}

/// Triangles of all sizes and shapes, among them long thin ones.
fn soup(rng: &mut Pcg64Mcg, count: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let center = random_direction(rng) * rng.random::<f64>();
        let size = 10f64.powf(rng.random_range(-4.0..0.0));
        let stretch = random_direction(rng) * if i % 3 == 0 { 0.5 } else { 0.0 };
        let base = mesh.positions.len() as u32;
        mesh.positions.extend([
            center,
            center + random_direction(rng) * size,
            center + random_direction(rng) * size + stretch,
        ]);
        mesh.indices.push([base, base + 1, base + 2]);
        // Coincident copies: the lower number must win.
        if i % 10 == 0 {
            mesh.indices.push([base, base + 1, base + 2]);
        }
    }
    mesh
}

#[test]
fn the_tree_agrees_with_brute_force() {
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    for (scale, offset) in [(1.0, DVec3::ZERO), (1e-12, DVec3::ZERO), (1e3, DVec3::splat(1e6))] {
        let mut mesh = soup(&mut rng, 300);
        mesh.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
        let world = mesh_world(&mesh, 1.0, DVec3::ZERO);
        let shapes: Vec<_> =
            (0..world.primitive_count() as u32).map(|i| *world.shape(i).expect("exists")).collect();
        let mut blocked = 0;
        for i in 0..20_000 {
            let mut d = random_direction(&mut rng);
            // Components that are zero or that f32 cannot tell from zero.
            if i % 3 == 0 {
                d[i % 2] = [0.0, 1e-8, -1e-12][i / 3 % 3];
                d = d.normalize();
            }
            let from = random_direction(&mut rng) * rng.random_range(0.0..1.0) * scale + offset;
            let ray = pathspace::geometry::Ray::new(from, d);
            let expected = shapes
                .iter()
                .enumerate()
                .filter_map(|(id, shape)| Some((shape.intersect(&ray)?.t, id as u32)))
                .min_by(|a, b| a.partial_cmp(b).expect("finite"));
            let found = world.intersect(&SurfacePoint::dirac(from), d);
            assert_eq!(
                found.map(|x| x.primitive),
                expected.map(|(_, id)| id),
                "ray {i} at scale {scale}"
            );

            let to = random_direction(&mut rng) * rng.random_range(0.0..1.0) * scale + offset;
            let (a, b) = (SurfacePoint::dirac(from), SurfacePoint::dirac(to));
            let segment = pathspace::geometry::Ray::new(from, (to - from).normalize());
            let free = shapes
                .iter()
                .all(|s| s.intersect(&segment).is_none_or(|hit| hit.t >= from.distance(to)));
            assert_eq!(world.visible(&a, &b), free);
            assert_eq!(world.visible(&b, &a), free);
            blocked += u32::from(!free);
        }
        assert!(blocked > 1000);
    }
}

#[test]
fn what_a_ray_hits_is_visible_both_ways() {
    let mut rng = Pcg64Mcg::seed_from_u64(13);
    let ball = Mesh::icosphere(3);
    for (scale, offset) in
        [(1.0, DVec3::ZERO), (1e-6, DVec3::ZERO), (1e6, DVec3::ZERO), (1.0, DVec3::splat(1e6))]
    {
        let place = |s: f64, p: DVec3| DAffine3 {
            matrix3: pathspace::glam::DMat3::from_diagonal(DVec3::splat(s * scale)),
            translation: p * scale + offset,
        };
        let world = world(|builder, black| {
            builder.add_mesh("room", &box_mesh(), place(2.0, DVec3::ZERO), black).expect("valid");
            builder
                .add_mesh("ball", &ball, place(0.7, DVec3::new(0.2, 0.4, -0.3)), black)
                .expect("valid");
            builder
                .add_sphere(
                    "sphere",
                    Sphere::new(DVec3::new(-1.0, -1.2, -1.1) * scale + offset, 0.5 * scale),
                    black,
                )
                .expect("valid");
        });
        let mut unseen = 0;
        for _ in 0..100_000 {
            let x = world.sample_surface(rng.random(), DVec2::new(rng.random(), rng.random()));
            let mut d = random_direction(&mut rng);
            if x.surface == 0 && d.dot(x.geometric_normal) > 0.0 {
                d = -d;
            }
            let y = world.intersect(&x, d).expect("the room is closed");
            // A grazing ray may have been hit by rounding; it carries no light.
            if d.dot(y.geometric_normal).abs() > 1e-3 && d.dot(x.geometric_normal).abs() > 1e-3 {
                assert_eq!(world.visible(&x, &y), world.visible(&y, &x));
                unseen += u32::from(!world.visible(&x, &y));
            }
        }
        assert_eq!(unseen, 0, "scale {scale}, offset {offset}");
    }
}

#[test]
fn corners_see_each_other_at_any_distance() {
    let world = world(quad_box);
    let point = |position: DVec3, normal: DVec3, wall: u32| SurfacePoint {
        primitive: wall,
        surface: wall,
        ..SurfacePoint::on_surface(position, 1e-15, normal)
    };
    for exponent in 1..16 {
        let d = 10f64.powi(-exponent);
        let floor = point(DVec3::new(-1.0 + d, 0.1, -1.0), DVec3::Z, 0);
        let wall = point(DVec3::new(-1.0, 0.2, -1.0 + d), DVec3::X, 1);
        let close = point(DVec3::new(-1.0, 0.1, -1.0 + d), DVec3::X, 1);
        for (a, b) in [(floor, wall), (wall, floor), (floor, close), (close, floor)] {
            assert!(world.visible(&a, &b), "distance {d}");
        }
        if exponent < 14 {
            let y =
                world.intersect(&floor, DVec3::new(-1.0, 0.0, 1.0).normalize()).expect("the wall");
            assert_eq!(y.primitive, 1);
        }
    }
}

#[test]
fn rays_that_are_none_hit_nothing() {
    let world = mesh_world(&Mesh::icosphere(2), 1.0, DVec3::ZERO);
    let inside = SurfacePoint::dirac(DVec3::ZERO);
    for d in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::new(f64::NAN, 0.0, 1.0)] {
        assert!(world.intersect(&inside, d).is_none());
    }
    for p in [DVec3::NAN, DVec3::INFINITY, DVec3::splat(f64::MAX)] {
        assert!(world.intersect(&SurfacePoint::dirac(p), DVec3::X).is_none());
        assert!(!world.visible(&SurfacePoint::dirac(p), &inside));
        assert!(!world.visible(&inside, &SurfacePoint::dirac(p)));
    }
    assert!(!world.visible(&inside, &inside));
    // Not of unit length, but a direction all the same.
    assert!(world.intersect(&inside, DVec3::Z * 1e-30).is_some());
    assert!(world.intersect(&inside, DVec3::Z * 1e30).is_some());
}

#[test]
fn points_at_infinity_are_seen_along_their_normal() {
    let world = world(|builder, black| {
        builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), black).expect("valid");
    });
    let top = SurfacePoint {
        primitive: 0,
        surface: 0,
        ..Sphere::new(DVec3::ZERO, 1.0).point_at(DVec3::Z)
    };
    let bottom = SurfacePoint {
        primitive: 0,
        surface: 0,
        ..Sphere::new(DVec3::ZERO, 1.0).point_at(-DVec3::Z)
    };
    let sun = |x: &SurfacePoint| SurfacePoint::infinite(x.position + DVec3::Z * 4.0, -DVec3::Z);
    assert!(world.visible(&top, &sun(&top)) && world.visible(&sun(&top), &top));
    assert!(!world.visible(&bottom, &sun(&bottom)) && !world.visible(&sun(&bottom), &bottom));
    assert!(!world.visible(&sun(&top), &sun(&bottom)));
}
