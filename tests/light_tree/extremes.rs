//! Row S58 and more: powers over 24 decades, lights at one point, clusters far apart, receivers in
//! the middle of it all.

use crate::{Random, point};
use pathspace::geometry::SurfacePoint;
use pathspace::glam::DVec3;
use pathspace::light_tree::{LightBounds, LightTree};

fn check(name: &str, lights: &[LightBounds], receivers: &[SurfacePoint]) {
    let weights: Vec<f64> = lights.iter().map(|light| light.intensity).collect();
    let tree = LightTree::new(lights, &weights);
    assert_eq!(tree.len(), lights.len());
    let bytes = tree.bytes() / lights.len();
    assert!(bytes <= 150 || lights.len() < 1000, "{name}: {bytes} bytes a light");
    let mut random = Random::new(1);
    for x in receivers {
        let pmf = (0..lights.len() as u32).map(|item| tree.pmf(x, None, item));
        let sum: f64 = pmf.inspect(|p| assert!(*p > 0.0 && *p <= 1.0 + 1e-12, "{name}: {p}")).sum();
        assert!((sum - 1.0).abs() < 1e-10, "{name}: {sum} {x:?}");
        for u in [0.0, 0.1, 1.0f64.next_down(), random.number(), random.number()] {
            let (item, p) = tree.sample(x, None, u).expect("a light");
            assert_eq!(p, tree.pmf(x, None, item), "{name}");
        }
    }
}

#[test]
fn s58_extremes_of_many_lights() {
    let mut random = Random::new(58);
    let mut receivers: Vec<SurfacePoint> = (0..6).map(|_| random.receiver(1.5)).collect();
    receivers.push(SurfacePoint::dirac(DVec3::new(0.1, 0.2, 0.3)));
    receivers.push(SurfacePoint::infinite(DVec3::ZERO, DVec3::Z));
    receivers.extend([1e-9, 1e9, 1e45].map(|half| random.receiver(half)));

    let powers: Vec<LightBounds> = (0..100_000)
        .map(|_| point(random.in_cube(1.0), 10f64.powf(24.0 * random.number() - 12.0)))
        .collect();
    // On a light, and where its axis and that of another cross.
    receivers.push(SurfacePoint::on_surface(powers[7].bounds.min, 0.0, DVec3::X));
    check("powers", &powers, &receivers);

    let one: Vec<LightBounds> =
        (0..1000).map(|_| point(DVec3::ONE, random.number() + 0.1)).collect();
    receivers.push(SurfacePoint::on_surface(DVec3::ONE, 0.0, DVec3::X));
    check("at one point", &one, &receivers);

    let clusters: Vec<LightBounds> = (0..2000)
        .map(|i| point(random.in_cube(1.0) + DVec3::X * (f64::from(i % 2) * 1e6), 1.0))
        .collect();
    receivers.push(SurfacePoint::on_surface(DVec3::X * 1e6, 0.0, DVec3::Z));
    check("clusters", &clusters, &receivers);

    for scale in [1e-45, 1e45] {
        let lights: Vec<LightBounds> =
            (0..100).map(|_| point(random.in_cube(scale), 1e100 * random.number())).collect();
        let receivers: Vec<SurfacePoint> = (0..10).map(|_| random.receiver(scale)).collect();
        check("scale", &lights, &receivers);
    }
    // One after the other on a line, each twice as far: as deep as a tree gets.
    let line: Vec<LightBounds> =
        (0..300).map(|i| point(DVec3::X * 2f64.powi(i), 4f64.powi(i))).collect();
    check("line", &line, &receivers[..6]);
}

#[test]
fn lights_without_weight_and_none_at_all() {
    let x = SurfacePoint::on_surface(DVec3::ZERO, 0.0, DVec3::Z);
    let mut lights = vec![point(DVec3::ONE, 1.0); 100_000];
    let mut weights = vec![0.0; lights.len()];
    assert!(LightTree::new(&lights, &weights).sample(&x, None, 0.5).is_none());
    assert!(LightTree::new(&[], &[]).sample_regardless(None, 0.5).is_none());
    weights[777] = 1e-300;
    lights[777] = point(DVec3::NEG_ONE, 1e-300);
    let tree = LightTree::new(&lights, &weights);
    assert_eq!((tree.len(), tree.sample(&x, None, 0.3)), (1, Some((777, 1.0))));
    assert_eq!((tree.pmf(&x, None, 777), tree.pmf(&x, None, 3)), (1.0, 0.0));
}
