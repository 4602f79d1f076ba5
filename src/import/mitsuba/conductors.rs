//! Optical constants of metals, by name.
//!
//! Indices n + ik of gold, silver and copper by Johnson and Christy (1972), at photon energies, and of aluminium by Smith, Shiles and Inokuti (1985), at wavelengths.
//! Colour is what the eye sees of the *reflectance*, which is not linear in n and k. So the reflectance at normal incidence becomes RGB as reflectances
//! do, n becomes RGB, and k is chosen such that they fit together (Gulbrandsen 2014).

use super::spectrum::{Illuminant, to_rgb};
use crate::math::Rgb;

/// hc in eV nm.
const EV_NANOMETRES: f64 = 1_239.841_98;

/// Wavelength, n and k.
type Table = [(f64, f64, f64)];

#[rustfmt::skip]
/// Energy in eV, n and k.
const GOLD: [(f64, f64, f64); 17] = [
    (1.51, 0.16, 5.083), (1.64, 0.14, 4.542), (1.76, 0.13, 4.103), (1.88, 0.14, 3.697), (2.01, 0.21, 3.272), (2.14, 0.29, 2.863),
    (2.26, 0.43, 2.455), (2.38, 0.62, 2.081), (2.50, 1.04, 1.833), (2.63, 1.31, 1.849), (2.75, 1.38, 1.914), (2.88, 1.45, 1.948),
    (3.00, 1.46, 1.958), (3.12, 1.47, 1.952), (3.25, 1.46, 1.933), (3.37, 1.48, 1.895), (3.50, 1.50, 1.866),
];
#[rustfmt::skip]
const SILVER: [(f64, f64, f64); 17] = [
    (1.51, 0.04, 5.727), (1.64, 0.03, 5.242), (1.76, 0.04, 4.838), (1.88, 0.05, 4.483), (2.01, 0.06, 4.152), (2.14, 0.05, 3.858),
    (2.26, 0.06, 3.586), (2.38, 0.05, 3.324), (2.50, 0.05, 3.093), (2.63, 0.05, 2.869), (2.75, 0.04, 2.657), (2.88, 0.04, 2.462),
    (3.00, 0.05, 2.275), (3.12, 0.05, 2.070), (3.25, 0.05, 1.864), (3.37, 0.07, 1.657), (3.50, 0.10, 1.419),
];
#[rustfmt::skip]
const COPPER: [(f64, f64, f64); 17] = [
    (1.51, 0.26, 5.180), (1.64, 0.24, 4.665), (1.76, 0.21, 4.205), (1.88, 0.22, 3.747), (2.01, 0.30, 3.205), (2.14, 0.70, 2.704),
    (2.26, 1.02, 2.577), (2.38, 1.18, 2.608), (2.50, 1.22, 2.564), (2.63, 1.25, 2.483), (2.75, 1.24, 2.397), (2.88, 1.25, 2.305),
    (3.00, 1.28, 2.207), (3.12, 1.32, 2.116), (3.25, 1.33, 2.045), (3.37, 1.36, 1.975), (3.50, 1.37, 1.916),
];
/// At wavelengths in nanometres, not energies.
#[rustfmt::skip]
const ALUMINIUM: [(f64, f64, f64); 10] = [
    (350.0, 0.375, 4.24), (400.0, 0.490, 4.86), (450.0, 0.618, 5.47), (500.0, 0.769, 6.08), (550.0, 0.958, 6.69),
    (600.0, 1.20, 7.26), (650.0, 1.47, 7.79), (700.0, 1.83, 8.31), (750.0, 2.40, 8.62), (800.0, 2.80, 8.45),
];

/// eta and k of a metal by its name in Mitsuba; "none" is a perfect mirror, an index of 0 + i.
pub(super) fn by_name(name: &str) -> Option<[Rgb; 2]> {
    let from_energies = |table: &Table| {
        let wavelengths: Vec<_> = table.iter().rev().map(|(energy, n, k)| (EV_NANOMETRES / energy, *n, *k)).collect();
        colours(&wavelengths)
    };
    match name {
        "none" => Some([Rgb::BLACK, Rgb::WHITE]),
        "Au" => Some(from_energies(&GOLD)),
        "Ag" => Some(from_energies(&SILVER)),
        "Cu" => Some(from_energies(&COPPER)),
        "Al" => Some(colours(&ALUMINIUM)),
        _ => None,
    }
}

fn colours(table: &Table) -> [Rgb; 2] {
    let of = |pick: fn(&(f64, f64, f64)) -> f64| {
        let spectrum: Vec<(f64, f64)> = table.iter().map(|row| (row.0, pick(row))).collect();
        to_rgb(&spectrum, Illuminant::D65)
    };
    let normal: fn(&(f64, f64, f64)) -> f64 = |&(_, n, k)| ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
    // Gold's red is outside of the colours of sRGB; no channel reflects more than the metal does anywhere.
    let most = table.iter().map(normal).fold(0.0, f64::max);
    let reflectance = of(normal).map(|r| r.clamp(0.0, most));
    let eta = of(|row| row.1).map(|n| n.max(0.0));
    // R = ((n - 1)² + k²)/((n + 1)² + k²), solved for k
    let k = |n: f64, r: f64| ((r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r)).max(0.0).sqrt();
    [eta, Rgb::new(k(eta[0], reflectance[0]), k(eta[1], reflectance[1]), k(eta[2], reflectance[2]))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_have_their_colours() {
        let reflectance = |name: &str| {
            let [eta, k] = by_name(name).expect("known");
            let channel = |c: usize| crate::bsdf::fresnel::conductor(1.0, 0.0, eta[c], k[c]);
            [channel(0), channel(1), channel(2)]
        };
        let [r, g, b] = reflectance("Au");
        assert!(r > 0.9 && (0.7..0.85).contains(&g) && (0.25..0.45).contains(&b), "{r} {g} {b}");
        let [r, g, b] = reflectance("Cu");
        assert!(r > 0.9 && (0.55..0.75).contains(&g) && (0.45..0.6).contains(&b), "{r} {g} {b}");
        assert!(reflectance("Ag").iter().all(|c| (0.93..1.0).contains(c)));
        assert!(reflectance("Al").iter().all(|c| (0.88..0.94).contains(c)));
        assert_eq!(reflectance("none"), [1.0; 3]);
        assert_eq!(by_name("Unobtainium"), None);
    }
}
