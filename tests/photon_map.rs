//! Photon maps against the definition of what they find.
#![allow(missing_docs, reason = "a test program")]

use glam::DVec3;
use pathspace::geometry::SurfacePoint;
use pathspace::math::Rgb;
use pathspace::photon_map::{Photon, PhotonMap, PhotonMapError};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

fn photon(position: DVec3, normal: DVec3) -> Photon {
    Photon { position, normal, to_previous: normal, flux: Rgb::WHITE, s: 2 }
}

fn point(position: DVec3, normal: DVec3) -> SurfacePoint {
    SurfacePoint::on_surface(position, 0.0, normal)
}

/// Positions in a cube of side 2: anywhere, on a lattice, and in a cluster.
fn in_cube() -> impl Strategy<Value = DVec3> {
    let coordinate =
        || prop_oneof![3 => -1.0..1.0f64, 2 => (-4..=4i32).prop_map(|i| f64::from(i) / 4.0)];
    let anywhere = (coordinate(), coordinate(), coordinate());
    prop_oneof![
        2 => anywhere.prop_map(DVec3::from),
        1 => (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|p| 0.3 + 0.01 * DVec3::from(p)),
    ]
}

fn on_sphere() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64)
        .prop_map(DVec3::from)
        .prop_filter_map("a direction", DVec3::try_normalize)
}

proptest! {
    /// At scales from 1e-6 to 1e6 and offsets up to 1e6 times as large.
    #[test]
    fn what_is_found_is_what_the_definition_says(
        scale in -6.0..6.0f64,
        offset in (-1.0..6.0f64, on_sphere()),
        radius in prop_oneof![
            4 => (-3.0..1.0f64).prop_map(|e| 10f64.powf(e)),
            1 => prop::sample::select(vec![0.125, 0.25, 0.5, 1.0]),
        ],
        photons in prop::collection::vec((in_cube(), on_sphere()), 0..200),
        points in prop::collection::vec((in_cube(), on_sphere()), 20),
    ) {
        let scale = 10f64.powf(scale);
        let place = |p: DVec3| scale * (p + 10f64.powf(offset.0) * offset.1);
        let numbered: Vec<Photon> = photons
            .iter()
            .zip(0..)
            .map(|(&(position, normal), s)| Photon { s, ..photon(place(position), normal) })
            .collect();
        let radius = scale * radius;
        let map = PhotonMap::build(numbered.clone(), radius).expect("enough memory");
        for (position, normal) in points.iter().chain(&photons) {
            let y = point(place(*position), *normal);
            let mut found = Vec::new();
            map.within(&y, |z| found.push(z.s));
            found.sort_unstable();
            let expected: Vec<u16> = numbered
                .iter()
                .filter(|z| z.position.distance_squared(y.position) < radius * radius)
                .filter(|z| z.normal.dot(y.geometric_normal) > 0.5)
                .map(|z| z.s)
                .collect();
            prop_assert_eq!(found, expected);
        }
    }
}

/// The share of the kernel that meets photons of uniform density, at the distance `u` radii from
/// the edge of a floor, where a wall of photons with the given normal stands; and one standard
/// error of it.
fn share(u: f64, wall: DVec3) -> (f64, f64) {
    const COUNT: u32 = 500_000;
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut uniform = |edge: DVec3, normal: DVec3| {
        let across = rng.random_range(-1.0..1.0);
        photon(rng.random_range(0.0..2.0) * edge + across * DVec3::Y, normal)
    };
    let photons =
        (0..COUNT).flat_map(|_| [uniform(DVec3::X, DVec3::Z), uniform(DVec3::Z, wall)]).collect();
    let map = PhotonMap::build(photons, 1.0).expect("enough memory");
    let mut found = 0;
    map.within(&point(u * DVec3::X, DVec3::Z), |_| found += 1);
    let kernel_sum = f64::from(found) / map.area();
    // Floor and wall measure 2 by 2 each.
    let density = f64::from(COUNT) / 4.0;
    (kernel_sum / density, f64::from(found).sqrt() / map.area() / density)
}

/// `1 - (acos u - u √(1 - u²))/π` of the kernel are on the floor, `(1 - u²)/2` on the wall.
#[test]
fn edges_and_corners_lose_and_gain_what_they_must() {
    for (u, floor, corner) in
        [(0.0, 0.5, 1.0), (0.25, 0.657_481, 1.126_231), (0.5, 0.804_499, 1.179_499)]
    {
        let formula = 1.0 - (f64::acos(u) - u * (1.0 - u * u).sqrt()) / PI;
        assert!(
            (formula - floor).abs() < 1e-6 && (corner - floor - 0.5 * (1.0 - u * u)).abs() < 1e-6
        );
        // The normal of a wall takes its photons out; with the floor's they stay in.
        for (wall, expected) in [(DVec3::X, floor), (DVec3::Z, corner)] {
            let (share, error) = share(u, wall);
            assert!(error < 0.0025 * expected, "1 % is four standard errors");
            assert!((share - expected).abs() < 3.0 * error, "{u}: {share} ± {error}, {expected}");
        }
    }
}

#[test]
fn photons_of_other_surfaces_are_left_out() {
    let tilted = |degrees: f64| {
        DVec3::Z * degrees.to_radians().cos() + DVec3::X * degrees.to_radians().sin()
    };
    let angles = [0.0, 59.9, 60.1, 90.0, 180.0];
    let photons =
        angles.iter().zip(0..).map(|(a, s)| Photon { s, ..photon(DVec3::ZERO, tilted(*a)) });
    let map = PhotonMap::build(photons.collect(), 1e-3).expect("enough memory");
    let mut found = Vec::new();
    map.within(&point(DVec3::ZERO, DVec3::Z), |z| found.push(z.s));
    assert_eq!(found, [0, 1]);
}

/// A photon with something else about its walk.
#[derive(Clone, Copy, Debug)]
struct Weighed(Photon, f64);

impl AsRef<Photon> for Weighed {
    fn as_ref(&self) -> &Photon {
        &self.0
    }
}

#[test]
fn maps_are_plain_data_of_anything_with_a_photon() {
    fn shared<T: Send + Sync + 'static>(_: &T) {}
    let floor = |x: f64| photon(DVec3::X * x, DVec3::Z);
    let photons = (0..100).map(|i| Weighed(floor(f64::from(i)), f64::from(i))).collect();
    let map = PhotonMap::build(photons, 1.5).expect("enough memory");
    shared(&map);
    let mut found = Vec::new();
    map.within(&point(DVec3::X * 7.0, DVec3::Z), |z| found.push(z.1));
    found.sort_by(f64::total_cmp);
    assert_eq!(found, [6.0, 7.0, 8.0]);
    assert_eq!(map.photons().len(), 100);
    assert_eq!((map.radius(), map.area(), map.is_empty()), (1.5, PI * 2.25, false));
    let each = size_of::<Weighed>() + size_of::<DVec3>();
    assert_eq!(map.bytes(), 100 * each + 4 * (128 + 1));
}

/// A carrier of a photon that takes no memory.
#[derive(Clone, Copy)]
struct Nowhere;

impl AsRef<Photon> for Nowhere {
    fn as_ref(&self) -> &Photon {
        unreachable!("refused before")
    }
}

#[test]
fn stress_s54_no_photons_and_too_many() {
    let empty = PhotonMap::build(Vec::<Photon>::new(), 1.0).expect("enough memory");
    empty.within(&point(DVec3::ZERO, DVec3::Z), |_| unreachable!());
    assert!(empty.is_empty());
    let error = PhotonMap::build(Vec::from([Nowhere; 1 << 32]), 1.0).map(|map| map.radius());
    assert_eq!(error, Err(PhotonMapError { photons: 1 << 32 }));
}

/// Radii that make no disc make no map, and the smallest that do find what lies on the point.
#[test]
fn stress_s53_extreme_radii() {
    let photons = vec![photon(DVec3::ONE, DVec3::Z); 3];
    let found = |radius: f64| {
        let map = PhotonMap::build(photons.clone(), radius).expect("enough memory");
        let mut found = 0;
        map.within(&point(DVec3::ONE, DVec3::Z), |_| found += 1);
        assert_eq!(map.is_empty(), found == 0);
        found
    };
    for radius in [0.0, -1.0, 1e-300, 1e300, f64::INFINITY, f64::NAN] {
        assert_eq!(found(radius), 0, "{radius}");
    }
    for radius in [1e-150, 1e-12, 1.0, 1e3, 1e150] {
        assert_eq!(found(radius), 3, "{radius}");
    }
}
