//! The traversal against all shapes one by one, on scenes that are hard for boxes and for f32, with
//! every instruction set.

use super::forest::Forest;
use super::query::{Ends, Query, Segment};
use crate::geometry::{Bounds, Contact, Disk, Quad, Ray, Shape, Sphere, SurfacePoint, Triangle};
use crate::math::warp::square_to_sphere;
use fearless_simd::Level;
use glam::{DVec2, DVec3, swizzles::Vec3Swizzles};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::cell::Cell;

const NONE: u32 = SurfacePoint::NONE;

thread_local! {
    static TESTS: Cell<usize> = const { Cell::new(0) };
}

/// Counts what takes as long as so many boxes of a node: 8 for a node or an exact test, 2 for a
/// region.
pub(super) fn count(boxes: usize) {
    TESTS.set(TESTS.get() + boxes);
}

fn direction(rng: &mut Pcg64Mcg) -> DVec3 {
    square_to_sphere(DVec2::new(rng.random(), rng.random()))
}

/// A point of the unit cube; now and then on a coarse grid, so that points coincide and boxes are
/// flat.
fn point(rng: &mut Pcg64Mcg) -> DVec3 {
    let p = DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0)));
    if rng.random_range(0..3) == 0 { (p * 2.0).round() * 0.5 } else { p }
}

/// A shape of any kind and of any size down to 1e-7 of the scene, slivers and copies included.
fn shape(rng: &mut Pcg64Mcg, earlier: &[Shape]) -> Shape {
    let center = point(rng);
    let size = 10f64.powf(rng.random_range(-7.0..0.0));
    let mut offset = |stretch: f64| direction(rng) * size + DVec3::X * stretch;
    match (earlier.len() * 7) % 16 {
        0 if !earlier.is_empty() => earlier[earlier.len() / 2],
        1 => Shape::Sphere(Sphere::new(center, size)),
        2 => Shape::Sphere(Sphere { cos_min: -0.5, ..Sphere::new(center, size) }),
        3 => Shape::Disk(Disk { center, normal: offset(0.0).normalize(), radius: size }),
        4 | 5 => Shape::Quad(Quad { origin: center, edge_u: offset(0.0), edge_v: offset(0.7) }),
        6 => Shape::Quad(Quad { origin: center, edge_u: DVec3::X, edge_v: DVec3::Y * size }),
        7 | 8 => Shape::Triangle(Triangle {
            vertices: [center, center + offset(0.0), center + offset(1.0)],
        }),
        9 => Shape::Triangle(Triangle { vertices: [center, point(rng), point(rng)] }),
        // A vertex of an earlier one: hits at the same distance.
        10 | 11 => match earlier.last() {
            Some(Shape::Triangle(t)) => {
                Shape::Triangle(Triangle { vertices: [t.vertices[0], t.vertices[1], center] })
            }
            _ => Shape::Triangle(Triangle {
                vertices: [center, point(rng), center + DVec3::Z * size],
            }),
        },
        _ => Shape::Triangle(Triangle {
            vertices: [center, center + offset(0.0), center + offset(0.0)],
        }),
    }
}

/// Triangles and what is made of them, few of which are tested without a tree.
fn is_flat(shape: &Shape) -> bool {
    matches!(shape, Shape::Triangle(_) | Shape::Quad(_))
}

/// A point to aim at: where f32 is least sure of the answer.
fn target(rng: &mut Pcg64Mcg, shapes: &[Shape]) -> DVec3 {
    let shape = &shapes[rng.random_range(0..shapes.len())];
    match (shape, rng.random_range(0..4)) {
        (Shape::Triangle(t), 0) => t.vertices[0],
        (Shape::Triangle(t), 1) => {
            t.vertices[0] + (t.vertices[1] - t.vertices[0]) * rng.random::<f64>()
        }
        (Shape::Quad(q), 0) => q.origin,
        (Shape::Quad(q), 1) => q.origin + (q.edge_u + q.edge_v) * rng.random::<f64>(),
        _ => shape.sample_area(DVec2::new(rng.random(), rng.random())).position,
    }
}

fn ray(
    rng: &mut Pcg64Mcg,
    shapes: &[Shape],
    place: impl Fn(DVec3) -> DVec3,
) -> (DVec3, DVec3, f64) {
    let aim = target(rng, shapes);
    let origin = match rng.random_range(0..4) {
        0 => target(rng, shapes),
        _ => place(point(rng)),
    };
    let mut d = match rng.random_range(0..4) {
        0 => direction(rng),
        1 => DVec3::AXES[rng.random_range(0..3)],
        _ => (aim - origin).try_normalize().unwrap_or(DVec3::NEG_Y),
    };
    // Components that are zero, of either sign, or that f32 cannot tell from zero.
    if rng.random_range(0..3) == 0 {
        d[rng.random_range(0..3)] = [0.0, -0.0, 1e-9, -1e-30][rng.random_range(0..4)];
        d = d.try_normalize().unwrap_or(DVec3::new(-0.0, 0.0, -1.0));
    }
    (origin, d, aim.distance(origin) * [0.5, 1.0, 1.0 + 1e-9, 2.0][rng.random_range(0..4)])
}

/// All instruction sets that this processor has.
fn levels() -> Vec<Level> {
    let mut levels = vec![Level::new(), Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(
        [
            Level::new().as_sse4_2().map(Level::Sse4_2),
            Level::new().as_avx2().map(Level::Avx2),
            Level::new().as_avx512().map(Level::Avx512),
        ]
        .into_iter()
        .flatten(),
    );
    levels
}

fn tree(shapes: &[Shape]) -> Forest {
    let bounds = shapes.iter().fold(Bounds::EMPTY, |bounds, shape| bounds.union(shape.bounds()));
    Forest::new(shapes.to_vec(), &bounds)
}

/// Answers that come in any order, each once.
fn in_order<T>(count: usize, ask: impl FnOnce(&mut dyn FnMut(usize, T))) -> Vec<T> {
    let mut answers: Vec<Option<T>> = (0..count).map(|_| None).collect();
    ask(&mut |index, answer| {
        assert!(answers[index].replace(answer).is_none(), "{index} of {count} twice")
    });
    answers.into_iter().map(|answer| answer.expect("an answer to each")).collect()
}

fn closest_many(bvh: &Forest, queries: &[Query]) -> Vec<Option<(f64, u32)>> {
    in_order(queries.len(), |answer| {
        bvh.closest_many(queries.iter().copied(), |index, hit| {
            answer(index, hit.map(|hit| (hit.intersection.t, hit.primitive)))
        });
    })
}

fn are_free(bvh: &Forest, segments: &[Result<Segment, bool>]) -> Vec<bool> {
    in_order(segments.len(), |answer| bvh.are_free(segments.iter().copied(), answer))
}

/// True if a ray comes near a shape. The exact test cannot tell for a triangle that is smaller than
/// the rounding of its distance from the ray.
fn passes(ray: &Ray, shape: &Shape) -> bool {
    let Bounds { min, max } = shape.bounds();
    let (min, max) = (min - ray.origin, max - ray.origin);
    let rounding = 1e-14 * min.abs().max(max.abs()).max_element();
    let (a, b) = ((min - rounding) / ray.direction, (max + rounding) / ray.direction);
    a.min(b).max_element().max(0.0) <= a.max(b).min_element()
}

/// Compares with all shapes one by one, bit by bit; returns how many rays hit, how many of them
/// what f32 holds exactly, and how many segments are blocked.
fn compare(shapes: &[Shape], rays: &[(DVec3, DVec3, f64)], name: &str) -> (usize, usize, usize) {
    let mut bvh = tree(shapes);
    let is_nested = bvh.statistics().trees > 1;
    let (mut hits, mut held, mut blocked) = (0, 0, 0);
    for (level, step) in levels().into_iter().zip([1, 3, 3, 3, 3]) {
        bvh.set_level(level);
        let (mut queries, mut nearest, mut segments, mut free_ones) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (i, &(origin, direction, length)) in rays.iter().enumerate().step_by(step) {
            let ray = Ray::new(origin, direction);
            // Every other ray starts on a primitive, and ends on one.
            let ends = if i % 2 == 0 {
                Ends::FREE
            } else {
                Ends { origin: i as u32 % 7, end: i as u32 % 5 }
            };
            let from = |id: u32| if id == ends.origin { Contact::Origin } else { Contact::None };
            let expected = (0u32..)
                .zip(shapes)
                .filter(|(_, shape)| !is_nested || passes(&ray, shape))
                .filter_map(|(id, shape)| Some((shape.intersect_apart_from(&ray, from(id))?.t, id)))
                .min_by(|a, b| a.partial_cmp(b).expect("numbers"));
            let query = Query { origin, direction, origin_primitive: ends.origin };
            let found = bvh.closest(query, |hit| {
                assert_eq!(
                    bvh.triangle_of(&hit),
                    shapes[hit.primitive as usize].as_triangle(),
                    "{name}, ray {i}"
                );
                held += usize::from(hit.candidate.is_exact());
                (hit.intersection.t, hit.primitive)
            });
            assert_eq!(
                found, expected,
                "{name}, ray {i} from {origin:?} to {direction:?}, {level:?}"
            );

            let within = |id: u32| match (id == ends.origin, id == ends.end) {
                (false, false) => Contact::None,
                (true, false) => Contact::Origin,
                (false, true) => Contact::End(length),
                (true, true) => Contact::Both,
            };
            let free = !(0u32..).zip(shapes).any(|(id, shape)| {
                (!is_nested || passes(&ray, shape))
                    && shape
                        .intersect_apart_from(&ray, within(id))
                        .is_some_and(|hit| hit.t < length)
            });
            let segment = Segment { origin, direction, length, ends };
            assert_eq!(bvh.is_free(&segment), free, "{name}, segment {i} of {length}, {level:?}");
            hits += usize::from(found.is_some());
            blocked += usize::from(!free);
            queries.push(query);
            nearest.push(found);
            segments.push(Ok(segment));
            free_ones.push(free);
        }
        assert_eq!(closest_many(&bvh, &queries), nearest, "{name}, at once, {level:?}");
        assert_eq!(are_free(&bvh, &segments), free_ones, "{name}, segments at once, {level:?}");
    }
    (hits, held, blocked)
}

#[test]
fn the_traversal_agrees_with_all_shapes_one_by_one() {
    let rays = if cfg!(debug_assertions) { 300 } else { 4000 };
    for (seed, (count, scale, offset, single)) in (0..).zip([
        (1, 1.0, 0.0, false),
        (9, 1.0, 0.0, false),
        (9, 1.0, 0.0, true),
        (35, 1.0, 0.0, true),
        (200, 1.0, 0.0, false),
        (200, 1e-20, 0.0, false),
        (200, 1e20, 0.0, false),
        (200, 1.0, 1e5, false),
        (700, 1.0, 0.0, false),
        (700, 1.0, 0.0, true),
        (200, 1e20, 0.0, true),
        (200, 3.0, 1e3, true),
    ]) {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut shapes: Vec<Shape> = Vec::new();
        for _ in 0..count {
            let shape = shape(&mut rng, &shapes);
            shapes.push(shape);
        }
        if single {
            shapes.retain(is_flat);
        }
        let place = |p: DVec3| {
            let p = p * scale + offset * DVec3::new(1.0, -1.0, 0.5);
            if single { p.as_vec3().as_dvec3() } else { p }
        };
        let shapes: Vec<Shape> = shapes.iter().map(|shape| placed(shape, place, scale)).collect();
        let rays: Vec<_> = (0..rays).map(|_| ray(&mut rng, &shapes, place)).collect();
        // Rays that start outside are moved first, which only `tests/watertight.rs` can judge.
        let bounds =
            shapes.iter().fold(Bounds::EMPTY, |bounds, shape| bounds.union(shape.bounds()));
        let inside = |p: &DVec3| p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
        let rays: Vec<_> = rays.into_iter().filter(|(origin, ..)| inside(origin)).collect();
        let (hits, held, blocked) =
            compare(&shapes, &rays, &format!("{count} shapes at {scale} and {offset}"));
        assert!(
            hits > rays.len() / 8 && blocked > rays.len() / 16,
            "{hits} hits and {blocked} blocked of {}",
            rays.len()
        );
        // Shapes that are no triangles and long edges through the middle are not held.
        assert!(!single || (held > hits / 16 && held < hits), "{held} of {hits} hits are held");
    }
}

/// A shape in another place and of another size.
fn placed(shape: &Shape, place: impl Fn(DVec3) -> DVec3, scale: f64) -> Shape {
    match *shape {
        Shape::Triangle(t) => Shape::Triangle(Triangle { vertices: t.vertices.map(place) }),
        Shape::Sphere(s) => {
            Shape::Sphere(Sphere { center: place(s.center), radius: s.radius * scale, ..s })
        }
        Shape::Disk(d) => {
            Shape::Disk(Disk { center: place(d.center), radius: d.radius * scale, ..d })
        }
        Shape::Quad(q) => Shape::Quad(Quad {
            origin: place(q.origin),
            edge_u: q.edge_u * scale,
            edge_v: q.edge_v * scale,
        }),
    }
}

/// Clusters of shapes in each other and side by side, with shapes of larger ones through smaller
/// ones, and rays within and between them.
#[test]
fn clusters_of_any_scale_agree_with_all_shapes_one_by_one() {
    let (seeds, rays) = if cfg!(debug_assertions) { (12, 200) } else { (60, 1500) };
    let (mut nested, mut wide, mut hits, mut blocked) = (0, 0, 0, 0);
    for seed in 0..seeds {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let (flat, single) = (seed % 3 == 0, seed % 4 == 0);
        let mut frames = vec![(DVec3::ZERO, 1.0)];
        let mut shapes: Vec<Shape> = Vec::new();
        for _ in 0..rng.random_range(1..if seed % 5 == 0 { 30 } else { 6 }) {
            let (center, scale) = frames[rng.random_range(0..frames.len())];
            let least: f64 = if seed % 7 == 0 { 1e-13 } else { 1e-8 };
            let smaller = (scale * 10f64.powf(rng.random_range(-9.0..-2.0))).max(least);
            frames.push((center + 0.8 * scale * point(&mut rng), smaller));
        }
        for (center, scale) in &mut frames {
            if single {
                *center = center.as_vec3().as_dvec3();
                *scale = scale.log2().round().exp2();
            }
        }
        for (i, &(center, scale)) in frames.iter().enumerate() {
            let place = |p: DVec3| {
                let p = if single { p.as_vec3().as_dvec3() } else { p };
                center + scale * p
            };
            let mut here: Vec<Shape> = Vec::new();
            for _ in 0..rng.random_range(4..if i % 3 == 0 { 300 } else { 40 }) {
                let shape = shape(&mut rng, &here);
                here.push(shape);
            }
            // Floors, walls and skies of what is around.
            if rng.random_range(0..2) == 0 {
                let grown = 10f64.powf(rng.random_range(0.0..6.0));
                let [x, y] = [direction(&mut rng), direction(&mut rng)].map(|d| grown * d);
                let corner = point(&mut rng) - 0.5 * (x + y);
                here.push(match rng.random_range(0..3) {
                    0 => Shape::Quad(Quad { origin: corner, edge_u: x, edge_v: y }),
                    1 => Shape::Triangle(Triangle { vertices: [corner, corner + x, corner + y] }),
                    _ => Shape::Sphere(Sphere::new(point(&mut rng) + x, grown)),
                });
            }
            shapes.extend(here.iter().map(|shape| placed(shape, place, scale)));
        }
        if flat {
            shapes.retain(is_flat);
        }
        let bounds =
            shapes.iter().fold(Bounds::EMPTY, |bounds, shape| bounds.union(shape.bounds()));
        let inside = |p: &DVec3| p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
        let rays: Vec<_> = (0..rays)
            .map(|_| {
                let (center, scale) = frames[rng.random_range(0..frames.len())];
                ray(&mut rng, &shapes, |p| center + scale * p)
            })
            .filter(|(origin, ..)| inside(origin))
            .collect();
        let trees = tree(&shapes).statistics().trees;
        nested += usize::from(trees > 1);
        wide = wide.max(trees);
        let found = compare(&shapes, &rays, &format!("clusters {seed}, {trees} trees"));
        hits += found.0;
        blocked += found.2;
    }
    assert!(nested > seeds as usize / 2 && wide > 9, "{nested} scenes, {wide} trees");
    let rays = seeds as usize * rays;
    assert!(hits > rays / 2 && blocked > rays / 4, "{hits} hits, {blocked} blocked of {rays}");
}

/// The tests of nodes, regions and shapes that a ray takes in a scene, on average, and the number
/// of trees: rays from point to point within a part of the scene, whose shapes are the first, and
/// from these shapes.
fn cost(shapes: &[Shape], center: DVec3, scale: f64, part: usize) -> (f64, usize) {
    let forest = tree(shapes);
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let rays = if cfg!(debug_assertions) { 200 } else { 1000 };
    TESTS.set(0);
    for _ in 0..rays {
        let origin = center + scale * point(&mut rng);
        let aim = center + scale * point(&mut rng);
        let (direction, length) = ((aim - origin).normalize(), aim.distance(origin));
        forest.closest(Query::free(origin, direction), |_| ());
        forest.is_free(&Segment::free(origin, direction, length));
        let on = rng.random_range(0..part);
        let x = shapes[on].sample_area(DVec2::new(rng.random(), rng.random()));
        let origin_primitive = on as u32;
        forest.closest(Query { origin: x.position, direction, origin_primitive }, |_| ());
    }
    (TESTS.get() as f64 / f64::from(8 * 3 * rays), forest.statistics().trees)
}

/// A ray among shapes takes as many tests when there is something far away in any direction.
#[test]
fn what_is_far_away_does_not_make_rays_test_more() {
    let mesh = crate::scene::Mesh::icosphere(4);
    let ball = |center: DVec3, radius: f64| {
        let corner = |i: u32| center + radius * mesh.positions[i as usize];
        let triangle = |t: &[u32; 3]| Shape::Triangle(Triangle { vertices: t.map(corner) });
        mesh.indices.iter().map(triangle).collect::<Vec<_>>()
    };
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut quad = || {
        let [edge_u, edge_v] = [direction(&mut rng), direction(&mut rng)].map(|d| 0.5 * d);
        Shape::Quad(Quad { origin: point(&mut rng), edge_u, edge_v })
    };
    let quads: Vec<Shape> = (0..12).map(|_| quad()).collect();
    // A rectangle, three balls, and a floor under a sky.
    let stages = |d: DVec3, offset: f64| {
        let floor = Quad {
            origin: DVec3::new(-0.4 * offset, -1.2, -0.6 * offset),
            edge_u: DVec3::Z * offset,
            edge_v: DVec3::X * offset,
        };
        let sky = Sphere::new(DVec3::new(0.1, -0.2, 0.0), 2.0 * offset);
        [
            vec![Shape::Quad(Quad { origin: d * offset, edge_u: DVec3::X, edge_v: DVec3::Y })],
            [d, d.yzx(), d.zxy()].map(|d| ball(d * offset, 1.0)).concat(),
            vec![Shape::Quad(floor), Shape::Sphere(sky)],
        ]
    };
    for (name, near) in [("ball", ball(DVec3::ZERO, 1.0)), ("quads", quads)] {
        let with =
            |far: Vec<Shape>| cost(&[&near[..], &far].concat(), DVec3::ZERO, 1.0, near.len());
        let close = stages(DVec3::X, 4.0).map(with);
        assert!(close.iter().all(|(_, trees)| *trees == 1), "{name}: {close:?}");
        let directions = [DVec3::X, DVec3::new(1.0, -1.0, 0.9), DVec3::new(-0.3, 1.0, 0.0)];
        for (i, offset) in
            [10.0, 1e2, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e12].into_iter().enumerate()
        {
            let d = directions[i % 3];
            let far = stages(d, offset).map(with);
            for ((found, trees), (expected, _)) in far.into_iter().zip(close) {
                assert!(
                    found <= 1.5 * expected && (offset < 1e6 || trees > 1),
                    "{name}, {d} · {offset:e}: {far:?}, not {close:?}"
                );
            }
        }
    }
    // A ball in a hall in a planet's orbit.
    let nested = |center: DVec3, sizes: [f64; 3]| {
        let balls = [ball(center, sizes[0]), ball(center, sizes[1]), ball(DVec3::ZERO, sizes[2])];
        [[0, 1, 2], [1, 0, 2], [2, 0, 1]].map(|order| {
            let shapes = order.map(|i| &balls[i][..]).concat();
            let center = if order[0] == 2 { DVec3::ZERO } else { center };
            cost(&shapes, center, sizes[order[0]], mesh.indices.len())
        })
    };
    let close = nested(DVec3::new(0.1, 0.2, -0.1), [1.0, 4.0, 16.0]);
    let far = nested(DVec3::new(3e8, 4e7, -2e8), [1e-3, 1e3, 1e9]);
    for ((found, trees), (expected, _)) in far.into_iter().zip(close) {
        assert!(found <= 1.5 * expected && trees == 3, "{far:?}, not {close:?}");
    }
}

/// The nearest of several triangles is found when all of them are certainly hit, but f32 cannot
/// tell their distances apart.
#[test]
fn sheets_closer_together_than_f32_resolves_are_told_apart() {
    let mut rng = Pcg64Mcg::seed_from_u64(8);
    let mut shapes = Vec::new();
    for _ in 0..12 {
        let vertices = [point(&mut rng), point(&mut rng), point(&mut rng)];
        for _ in 0..9 {
            let moved = direction(&mut rng) * 10f64.powf(rng.random_range(-9.0..-6.0));
            shapes.push(Shape::Triangle(Triangle { vertices: vertices.map(|v| v + moved) }));
        }
    }
    let rays = if cfg!(debug_assertions) { 300 } else { 4000 };
    let rays: Vec<_> = (0..rays)
        .map(|_| {
            let aim = shapes[rng.random_range(0..shapes.len())]
                .sample_area(DVec2::new(rng.random(), rng.random()))
                .position;
            let origin = point(&mut rng) * 0.9;
            (origin, (aim - origin).normalize(), aim.distance(origin))
        })
        .collect();
    let (hits, _, blocked) = compare(&shapes, &rays, "sheets");
    assert!(
        hits > rays.len() && blocked > rays.len(),
        "{hits} hits and {blocked} blocked of {}",
        rays.len()
    );
}

/// Answers to any number of queries are those of single queries, also for rays that are none, from
/// outside, or past the scene.
#[test]
fn queries_at_once_are_answered_like_single_ones() {
    let none = Ends::FREE;
    let none_sure = |p: DVec3| [p, p * 1e-3, p * 50.0, DVec3::ZERO, DVec3::NAN, DVec3::INFINITY];
    for shapes_count in [0, 1, 9, 30, 300] {
        let mut rng = Pcg64Mcg::seed_from_u64(shapes_count);
        let mut shapes: Vec<Shape> = Vec::new();
        for _ in 0..shapes_count {
            let shape = shape(&mut rng, &shapes);
            shapes.push(shape);
        }
        if shapes_count == 30 {
            shapes.retain(is_flat);
        }
        let mut bvh = tree(&shapes);
        assert_eq!(bvh.outermost().pays_to_take_turns(), shapes_count == 300);
        for level in levels() {
            bvh.set_level(level);
            let mut hits = [0; 2];
            for count in [0, 1, 2, 7, 8, 9, 15, 16, 17, 33, 1000] {
                let mut any = |p: DVec3| {
                    let kind = rng.random_range(0..40);
                    none_sure(p)[if kind < 6 { kind } else { 0 }]
                };
                let mut random = Pcg64Mcg::seed_from_u64(count as u64);
                let queries: Vec<Query> = (0..count)
                    .map(|i| Query {
                        origin: any(point(&mut random) * 1.2),
                        direction: any(direction(&mut random)),
                        origin_primitive: i as u32 % 7,
                    })
                    .collect();
                let single = |q: &Query| bvh.closest(*q, |hit| (hit.intersection.t, hit.primitive));
                let expected: Vec<_> = queries.iter().map(single).collect();
                assert_eq!(
                    closest_many(&bvh, &queries),
                    expected,
                    "{count} rays, {shapes_count} shapes, {level:?}"
                );
                hits[0] += expected.iter().flatten().count();

                let segment = |(i, q): (usize, &Query)| match i % 11 {
                    0 => Err(i % 2 == 0),
                    1 => Ok(Segment {
                        origin: q.origin,
                        direction: q.direction,
                        length: [0.0, f64::NAN, -1.0][i % 3],
                        ends: none,
                    }),
                    _ => Ok(Segment {
                        origin: q.origin,
                        direction: q.direction,
                        length: 2.0 * i as f64 / count as f64,
                        ends: none,
                    }),
                };
                let segments: Vec<_> = queries.iter().enumerate().map(segment).collect();
                let expected: Vec<_> = segments
                    .iter()
                    .map(|s| s.map_or_else(|free| free, |segment| bvh.is_free(&segment)))
                    .collect();
                assert_eq!(
                    are_free(&bvh, &segments),
                    expected,
                    "{count} segments, {shapes_count} shapes, {level:?}"
                );
                hits[1] += expected.iter().filter(|&&free| !free).count();
            }
            assert!(
                shapes_count < 9 || hits.into_iter().all(|hits| hits > 50),
                "{hits:?} with {shapes_count} shapes"
            );
        }
    }
}

/// A camera's rays: to the pixels of an image around a direction, which is an axis now and then so
/// that components are zero and change their sign; from one point, from a lens, or all into the
/// same direction.
fn fan(rng: &mut Pcg64Mcg, origin: DVec3, side: i32) -> Vec<Query> {
    let spread = [1e-6, 3e-3, 0.02, 0.06][rng.random_range(0..4)];
    let forward = if rng.random_range(0..3) == 0 {
        direction(rng)
    } else {
        DVec3::AXES[rng.random_range(0..3)] * [1.0, -1.0][rng.random_range(0..2)]
    };
    let (right, up) = forward.any_orthonormal_pair();
    let origin_primitive = [NONE, rng.random_range(0..7)][rng.random_range(0..2)];
    let middle = [-1, 0, side / 2][rng.random_range(0..3)];
    let [lens, parallel] =
        [[0.0, 0.0], [0.0, 0.0], [0.01, 0.0], [0.001, 1.0]][rng.random_range(0..4)];
    let pixel = |(x, y)| spread * (right * f64::from(x - middle) + up * f64::from(y - middle));
    // To and fro, so that each is beside the one before.
    let pixels = (0..side * side)
        .map(|i| (i / side, i % side))
        .map(|(y, x)| (if y % 2 == 0 { x } else { side - 1 - x }, y));
    let ray = |at| {
        let origin = origin + lens * point(rng) + parallel * pixel(at);
        Query {
            origin,
            direction: (forward + (1.0 - parallel) * pixel(at)).normalize(),
            origin_primitive,
        }
    };
    pixels.map(ray).collect()
}

/// Rays that follow one another, from inside and outside, to triangles of the same place and beside
/// each other, too.
#[test]
fn rays_of_a_camera_at_once_are_answered_like_single_ones() {
    for (seed, (count, flat)) in
        (0..).zip([(1, false), (35, true), (300, false), (700, true), (3000, true)])
    {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut shapes: Vec<Shape> = Vec::new();
        for _ in 0..count {
            let shape = shape(&mut rng, &shapes);
            shapes.push(shape);
        }
        if flat {
            shapes.retain(is_flat);
            // A wall of pairs of triangles, each of them twice.
            for i in (0..if count > 35 { 200 } else { 0 }).map(|i| i / 2) {
                let [x, y] = [i % 10, i / 10].map(|k| 0.1 * f64::from(k) - 0.5);
                let corner = |u: f64, v: f64| DVec3::new(x + u, y + v, 0.25);
                shapes.push(Shape::Triangle(Triangle {
                    vertices: [corner(0.0, 0.0), corner(0.1, 0.0), corner(0.1, 0.1)],
                }));
                shapes.push(Shape::Triangle(Triangle {
                    vertices: [corner(0.0, 0.0), corner(0.1, 0.1), corner(0.0, 0.1)],
                }));
            }
        }
        let mut bvh = tree(&shapes);
        for level in levels() {
            bvh.set_level(level);
            let fans = if cfg!(debug_assertions) { 10 } else { 200 };
            let queries: Vec<Query> = (0..fans)
                .flat_map(|i| {
                    let origin = match i % 4 {
                        0 => point(&mut rng),
                        1 => target(&mut rng, &shapes),
                        2 => {
                            DVec3::new(0.02, -0.05, [0.2, 0.3, 2.0, -30.0][rng.random_range(0..4)])
                        }
                        _ => direction(&mut rng) * 4.0,
                    };
                    fan(&mut rng, origin, [3, 4, 5, 9, 16][i % 5])
                })
                .collect();
            let single = |q: &Query| bvh.closest(*q, |hit| (hit.intersection.t, hit.primitive));
            let expected: Vec<_> = queries.iter().map(single).collect();
            assert_eq!(closest_many(&bvh, &queries), expected, "{count} shapes, {level:?}");
            let hits = expected.iter().flatten().count();
            assert!(
                count < 300 || hits > queries.len() / 8,
                "{hits} hits of {} rays, {count} shapes",
                queries.len()
            );

            let segment = |(i, q): (usize, &Query)| {
                let ends = Ends { origin: q.origin_primitive, end: i as u32 % 9 };
                Ok(Segment {
                    origin: q.origin,
                    direction: q.direction,
                    length: 0.1 + (i % 7) as f64,
                    ends,
                })
            };
            let segments: Vec<_> = queries.iter().enumerate().map(segment).collect();
            let expected: Vec<_> = segments
                .iter()
                .map(|s| s.map_or_else(|free| free, |segment| bvh.is_free(&segment)))
                .collect();
            assert_eq!(are_free(&bvh, &segments), expected, "{count} shapes, {level:?}");
            let blocked = expected.iter().filter(|free| !**free).count();
            assert!(
                count < 300 || blocked > queries.len() / 9,
                "{blocked} blocked of {} segments, {count} shapes",
                queries.len()
            );
        }
    }
}

#[test]
fn a_tree_deeper_than_the_stack_is_walked_all_the_same() {
    let vertices =
        [DVec3::new(-1.0, -1.0, 0.1), DVec3::new(1.0, -1.0, 0.2), DVec3::new(0.0, 1.0, -0.3)];
    let mut shapes = vec![Shape::Triangle(Triangle { vertices }); 3000];
    shapes.push(Shape::Sphere(Sphere::new(DVec3::ZERO, 2.0)));
    let rays: Vec<_> =
        [DVec3::new(0.01, 0.02, 1.0), DVec3::new(-0.9, 0.9, 1.0), DVec3::new(0.9, 0.95, 1.0)]
            .into_iter()
            .flat_map(|origin| {
                [
                    (origin, DVec3::NEG_Z, 1.5),
                    (origin, DVec3::new(-0.1, 0.0, -1.0).normalize(), 1.5),
                ]
            })
            .collect();
    compare(&shapes, &rays, "copies");
}

/// Bytes per triangle stay the same, whatever their number; `docs/performance.md` states them.
#[test]
fn memory_per_triangle_does_not_grow() {
    for level in [3, 5, 6] {
        let mesh = crate::scene::Mesh::icosphere(level);
        let corner = |i: u32| mesh.positions[i as usize];
        let shapes: Vec<Shape> = mesh
            .indices
            .iter()
            .map(|t| Shape::Triangle(Triangle { vertices: t.map(corner) }))
            .collect();
        let statistics = tree(&shapes).statistics();
        let share = statistics.bytes as f64 / shapes.len() as f64;
        assert!(
            (130.0..165.0).contains(&share),
            "{share} bytes per triangle of {}: {statistics:?}",
            shapes.len()
        );
        assert!(
            statistics.leaves * 4 >= shapes.len()
                && statistics.build_time > std::time::Duration::ZERO
        );
    }
}
