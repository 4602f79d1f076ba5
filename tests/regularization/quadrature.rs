//! Means over discs.

use glam::DVec2;
use std::f64::consts::TAU;

/// Nodes and weights of Gauss and Legendre's rule of 8 points on [0, 1].
fn gauss() -> [(f64, f64); 8] {
    const HALF: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_27),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
    ];
    std::array::from_fn(|i| {
        let (node, weight) = HALF[i / 2];
        (0.5 * if i % 2 == 0 { 1.0 + node } else { 1.0 - node }, 0.5 * weight)
    })
}

/// The mean of a smooth function over the disc of a radius around the origin.
pub fn over_disc(radius: f64, f: impl Fn(DVec2) -> f64) -> f64 {
    const TURNS: i32 = 24;
    let on_circle = |r: f64| {
        let turn = |i: i32| DVec2::from_angle((f64::from(i) + 0.5) * TAU / f64::from(TURNS));
        (0..TURNS).map(|i| f(turn(i) * r)).sum::<f64>() / f64::from(TURNS)
    };
    // Uniform in r².
    gauss().iter().map(|(node, weight)| weight * on_circle(radius * node.sqrt())).sum()
}

/// The slope of a straight line through points (ln x, ln y), and the standard error that the scatter
/// about it gives.
pub fn exponent(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0.ln()), mean(&|p| p.1.ln()));
    let square: f64 = points.iter().map(|p| (p.0.ln() - x).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0.ln() - x) * (p.1.ln() - y)).sum::<f64>() / square;
    let rest: f64 = points.iter().map(|p| (p.1.ln() - y - slope * (p.0.ln() - x)).powi(2)).sum();
    (slope, (rest / (n - 2.0) / square).sqrt())
}
