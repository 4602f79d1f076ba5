//! Probabilities are those of the samples, and nothing that could contribute is left out.

use crate::{Random, mixed, point, some_arrival};
use pathspace::geometry::SurfacePoint;
use pathspace::glam::DVec3;
use pathspace::light_tree::{Arrival, LightBounds, LightTree, Trials};
use pathspace::math::statistics::chi_square;

/// δ.
const REGARDLESS: f64 = 0.1;

/// Probabilities of all items, and of choosing none.
fn probabilities(
    tree: &LightTree,
    x: &SurfacePoint,
    arrival: Option<&Arrival>,
    count: u32,
) -> (Vec<f64>, f64) {
    let pmf: Vec<f64> = (0..count).map(|item| tree.pmf(x, arrival, item)).collect();
    let none = 1.0 - pmf.iter().sum::<f64>();
    (pmf, none)
}

/// The sum is 1 where every light shines everywhere, for 10⁴ receivers; and never more.
#[test]
fn probabilities_sum_to_one() {
    for count in [1u32, 2, 3, 4, 5, 6, 17, 64, 257] {
        let mut random = Random::new(count.into());
        let lights: Vec<LightBounds> = (0..count)
            .map(|i| match i {
                3 => LightBounds::unbounded(0.1),
                _ => point(random.in_cube(5.0), 10f64.powf(12.0 * random.number())),
            })
            .collect();
        let weights: Vec<f64> = lights.iter().map(|light| light.intensity).collect();
        let tree = LightTree::new(&lights, &weights);
        let arrival = some_arrival(&tree, count);
        let mixed = mixed(count as usize, 3);
        let mixed = LightTree::new(&mixed.0, &mixed.1);
        for _ in 0..1200 {
            let x = random.receiver(7.0);
            for arrival in [None, Some(&arrival)] {
                let (_, none) = probabilities(&tree, &x, arrival, count);
                assert!(none.abs() < 1e-12, "{count} {none:e}");
            }
            let (_, none) = probabilities(&mixed, &x, None, count);
            assert!(none > -1e-12 && none < 1.0 - REGARDLESS + 1e-12, "{count} {none:e}");
        }
        let sum: f64 = (0..count).map(|item| tree.pmf_regardless(Some(&arrival), item)).sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }
}

/// Samples are as frequent as their probabilities say, none included, and each comes with the
/// probability that is asked for, to the bit.
#[test]
fn samples_have_their_probabilities() {
    let n = 200_000;
    for (count, seed) in [(3usize, 1), (9, 2), (60, 3)] {
        let (lights, weights) = mixed(count, seed);
        let tree = LightTree::new(&lights, &weights);
        let arrival = some_arrival(&tree, count as u32);
        let mut random = Random::new(seed + 100);
        for arrival in [None, Some(&arrival)] {
            for _ in 0..4 {
                let x = random.receiver(8.0);
                let (pmf, none) = probabilities(&tree, &x, arrival, count as u32);
                let mut counts = vec![0.0; count + 1];
                for i in 0..n {
                    // One in each part: clamped ends are met.
                    let u = (f64::from(i) + random.number()) / f64::from(n);
                    match tree.sample(&x, arrival, u) {
                        Some((item, p)) => {
                            assert_eq!(p, tree.pmf(&x, arrival, item));
                            assert!(p > 0.0 && weights[item as usize] > 0.0);
                            counts[item as usize] += 1.0;
                        }
                        None => counts[count] += 1.0,
                    }
                }
                // Stratified samples are closer than independent ones: three are enough to tell
                // a per cent.
                for (k, p) in counts.iter().zip(pmf.iter().chain([&none])) {
                    let expected = p * f64::from(n);
                    assert!((k - expected).abs() <= 8.0 + 0.002 * expected, "{k} {expected}");
                }
            }
            let mut counts = vec![0.0; count];
            let expected: Vec<f64> = (0..count as u32)
                .map(|item| tree.pmf_regardless(arrival, item) * f64::from(n))
                .collect();
            for _ in 0..n {
                let (item, p) = tree.sample_regardless(arrival, random.number()).expect("a light");
                assert_eq!(p, tree.pmf_regardless(arrival, item));
                counts[item as usize] += 1.0;
            }
            let p = chi_square(&counts, &expected, 5.0).p_value;
            assert!(p > 1e-4, "{count}: {p}");
        }
    }
}

/// What the tree gives no chance sends nothing: neither through the cone of a spot, nor from the
/// back of a flat light.
#[test]
fn only_light_that_cannot_come_has_no_chance() {
    let mut dark = 0;
    for seed in 0..20 {
        let (lights, _) = mixed(200, seed);
        let weights = vec![1.0; lights.len()];
        let tree = LightTree::new(&lights, &weights);
        let mut random = Random::new(seed + 1);
        for _ in 0..50 {
            let x = random.receiver(11.0);
            for (item, light) in lights.iter().enumerate() {
                let share = tree.pmf(&x, None, item as u32) - REGARDLESS / weights.len() as f64;
                if share > 1e-15 || !light.is_bounded() {
                    continue;
                }
                dark += 1;
                // Any point of the box, any normal in the cone.
                for corner in [light.bounds.min, light.bounds.max, light.bounds.center()] {
                    let to_x = (x.position - corner).normalize();
                    let angle = light.axis.dot(to_x).clamp(-1.0, 1.0).acos() - light.theta_o;
                    let shines = angle < light.theta_e && angle.max(0.0).cos() > 1e-9;
                    let sends =
                        light.intensity * angle.max(0.0).cos() * f64::from(u8::from(shines));
                    let square = x.position.distance_squared(corner);
                    assert!(sends / square < 1e-9, "{light:?} {x:?} {share:e} {sends:e}");
                }
            }
        }
    }
    assert!(dark > 1000, "{dark}");
}

/// A branch that never arrives is hardly ever chosen, one that does keeps its share, and what was
/// not tried is not given up.
#[test]
fn what_does_not_arrive_is_left_alone() {
    let place = |i: u32| DVec3::new(f64::from(i % 10), f64::from(i / 10), 0.0);
    let lights: Vec<LightBounds> = (0..100).map(|i| point(place(i), 1.0)).collect();
    let tree = LightTree::new(&lights, &[1.0; 100]);
    let x = SurfacePoint::on_surface(DVec3::new(4.5, 4.5, 6.0), 0.0, DVec3::Z);
    let (mut connections, mut walks, mut random) =
        (Trials::default(), Trials::default(), Random::new(4));
    for _ in 0..20_000 {
        let (item, _) = tree.sample(&x, None, random.number()).expect("a light");
        connections.push(item, 1.0, f64::from(u8::from(item == 37)));
        let (item, _) = tree.sample_regardless(None, random.number()).expect("a light");
        walks.push(item, 1.0, f64::from(u8::from(item == 37)));
    }
    let arrival = Arrival::new(&tree, &connections, &walks);
    let before = tree.pmf(&x, None, 37);
    let after = tree.pmf(&x, Some(&arrival), 37);
    assert!(before < 0.02 && after > 0.85, "{before} {after}");
    let start = tree.pmf_regardless(Some(&arrival), 37);
    assert!(start > 0.7 && start < 0.92, "{start}");
    for item in 0..100 {
        assert!(tree.pmf_regardless(Some(&arrival), item) >= 0.001 - 1e-12);
        assert!(tree.pmf(&x, Some(&arrival), item) >= 2e-5 - 1e-12);
    }
    // Without trials nothing is known.
    let nothing = Arrival::new(&tree, &Trials::default(), &Trials::default());
    for item in 0..100 {
        let [with, without] = [Some(&nothing), None].map(|arrival| tree.pmf(&x, arrival, item));
        assert!((with / without - 1.0).abs() < 0.1);
    }
}
