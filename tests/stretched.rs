//! Clusters of shapes at any scale: hits are those of all shapes one by one, to the bit.

use pathspace::geometry::{Quad, Ray, Shape, Sphere, SurfacePoint};
use pathspace::glam::{DAffine3, DMat3, DVec2, DVec3};
use pathspace::math::warp::square_to_sphere;
use pathspace::scene::{Material, Mesh, Scene, SurfaceArea, World, WorldBuilder};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A ball in a frame, with a wall through it that may be much larger.
#[derive(Clone, Debug)]
struct Cluster {
    /// The cluster in whose frame this one lies, modulo those before.
    within: usize,
    place: [f64; 3],
    /// The decades by which it is smaller.
    smaller: f64,
    /// Subdivisions of the ball.
    level: u32,
    /// The decades by which the wall is larger.
    wall: Option<f64>,
    is_sphere: bool,
}

fn cluster() -> impl Strategy<Value = Cluster> {
    let place = prop::array::uniform3(-1.0..1.0);
    let wall = prop::option::of(0.0..9.0);
    (0..9usize, place, 1.0..9.0, 0..3u32, wall, any::<bool>()).prop_map(
        |(within, place, smaller, level, wall, is_sphere)| Cluster {
            within,
            place,
            smaller,
            level,
            wall,
            is_sphere,
        },
    )
}

/// The world of some clusters, and their middles and sizes.
fn world(clusters: &[Cluster]) -> (World, Vec<(DVec3, f64)>) {
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black).expect("valid");
    let mut frames = vec![(DVec3::ZERO, 1.0)];
    for (i, cluster) in clusters.iter().enumerate() {
        let (center, size) = frames[cluster.within % frames.len()];
        let center = center + DVec3::from(cluster.place) * size;
        // A smaller one has no digits left.
        let size = (size * 10f64.powf(-cluster.smaller)).max(1e-10);
        frames.push((center, size));
        let place =
            DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(size)), translation: center };
        let mesh = Mesh::icosphere(cluster.level);
        builder.add_mesh(format!("ball {i}"), &mesh, place, black).expect("valid");
        let Some(wall) = cluster.wall else { continue };
        let wall = (size * 10f64.powf(wall)).min(1.0);
        if cluster.is_sphere {
            let sphere = Sphere::new(center + DVec3::X * wall, wall);
            builder.add_sphere(format!("wall {i}"), sphere, black).expect("valid");
        } else {
            let [edge_u, edge_v] =
                [DVec3::new(1.0, 0.2, 0.1), DVec3::new(0.1, -0.3, 1.0)].map(|edge| edge * wall);
            let origin = center - 0.4 * edge_u - 0.6 * edge_v;
            let wall = Quad { origin, edge_u, edge_v };
            builder.add_quad(format!("wall {i}"), wall, black).expect("valid");
        }
    }
    (builder.build().expect("valid"), frames)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..Default::default() })]

    #[test]
    fn hits_are_those_of_all_shapes(
        clusters in prop::collection::vec(cluster(), 1..9),
        seed in any::<u64>(),
    ) {
        let (world, frames) = world(&clusters);
        let shapes: Vec<Shape> =
            (0..world.primitive_count() as u32).map(|i| *world.shape(i).expect("a shape")).collect();
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut pair = || DVec2::new(rng.random(), rng.random());
        let bounds = world.bounds();
        let mut rays = Vec::new();
        for i in 0..400 {
            let (center, size) = frames[i % frames.len()];
            let origin = match i % 3 {
                0 => world.sample_surface(pair().x, pair()).position,
                _ => center + square_to_sphere(pair()) * (size * 1.2 * pair().x),
            };
            let aim = shapes[(pair().x * shapes.len() as f64) as usize].sample_area(pair());
            let to_aim = aim.position - origin;
            let direction = if i % 4 == 0 { None } else { to_aim.try_normalize() };
            let direction = direction.unwrap_or_else(|| square_to_sphere(pair()));
            // Those that start outside are moved first.
            if origin.cmpge(bounds.min).all() && origin.cmple(bounds.max).all() {
                rays.push((origin, direction, to_aim.length() * [0.5, 1.0, 2.0][i / 4 % 3]));
            }
        }
        let nearest = |&(origin, direction, _): &(DVec3, DVec3, f64)| {
            let ray = Ray::new(origin, direction);
            let hits = (0u32..).zip(&shapes).filter_map(|(i, s)| Some((i, s.intersect(&ray)?)));
            hits.min_by(|(i, a), (j, b)| a.t.total_cmp(&b.t).then(i.cmp(j)))
        };
        let expected: Vec<_> = rays.iter().map(nearest).collect();
        let mut together = vec![None; rays.len()];
        world.first_hits(rays.iter().map(|r| (r.0, r.1)), |i, hit| together[i] = hit);
        let mut clear = vec![false; rays.len()];
        world.are_clear(rays.iter().copied(), |i, answer| clear[i] = answer);
        for (i, (&(origin, direction, length), hit)) in rays.iter().zip(&expected).enumerate() {
            let found = hit.map(|(primitive, hit)| (primitive, hit.t));
            prop_assert_eq!(world.first_hit(origin, direction), found, "ray {}", i);
            prop_assert_eq!(together[i], found, "ray {} of all", i);
            let free = hit.is_none_or(|(_, hit)| hit.t >= length);
            prop_assert_eq!(world.is_clear(origin, direction, length), free, "segment {}", i);
            prop_assert_eq!(clear[i], free, "segment {} of all", i);
            let point = world.intersect(&SurfacePoint::dirac(origin), direction);
            let ray = Ray::new(origin, direction);
            let expected = hit.map(|(primitive, hit)| {
                (primitive, shapes[primitive as usize].point_at_hit(&ray, &hit).position)
            });
            prop_assert_eq!(point.map(|x| (x.primitive, x.position)), expected, "point {}", i);
        }
    }
}
