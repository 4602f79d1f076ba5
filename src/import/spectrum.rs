//! Spectra as linear RGB with the primaries of sRGB.
//!
//! The CIE 1931 standard observer (2°) sees a spectrum s as `XYZ = ∫ s(λ) (x̄, ȳ, z̄)(λ) dλ / ∫
//! ȳ(λ) dλ`. What emits is converted like this; a constant spectrum then has the colour of the
//! equal-energy illuminant, a little reddish. What reflects is seen under daylight, the standard
//! illuminant D65, so that a constant reflectance stays grey: `XYZ = ∫ s D65 (x̄, ȳ, z̄) dλ / ∫ D65
//! ȳ dλ`.

use crate::math::Rgb;

/// The illuminant under which a spectrum is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Illuminant {
    /// Emitted spectra: the same energy at all wavelengths.
    Equal,
    /// Reflectances and other factors: daylight.
    D65,
}

/// The colour of a spectrum that is linear between the given wavelengths (in nanometres, rising)
/// and nothing outside of them.
pub(super) fn to_rgb(spectrum: &[(f64, f64)], illuminant: Illuminant) -> Rgb {
    let (Some(first), Some(last)) = (spectrum.first(), spectrum.last()) else { return Rgb::BLACK };
    let mut knots: Vec<f64> = spectrum.iter().map(|(wavelength, _)| *wavelength).collect();
    knots.extend((0..OBSERVER.len()).map(|i| FIRST + STEP * i as f64));
    knots.sort_by(f64::total_cmp);
    let (mut xyz, mut white) = ([0.0; 3], 0.0);
    // Between knots everything is linear: Simpson's rule is exact for products of up to three
    // factors.
    for pair in knots.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let inside = from >= first.0 && to <= last.0;
        for (wavelength, weight) in [(from, 1.0), (0.5 * (from + to), 4.0), (to, 1.0)] {
            let Some([x, y, z, daylight]) = observer(wavelength) else { continue };
            let weight = (to - from) / 6.0
                * weight
                * if illuminant == Illuminant::D65 { daylight } else { 1.0 };
            let value = if inside { weight * at(spectrum, wavelength) } else { 0.0 };
            white += weight * y;
            xyz = [xyz[0] + value * x, xyz[1] + value * y, xyz[2] + value * z];
        }
    }
    from_xyz(xyz.map(|c| c / white))
}

/// Value of a piecewise linear function between its first and its last knot.
fn at(spectrum: &[(f64, f64)], wavelength: f64) -> f64 {
    let upper = spectrum.partition_point(|(knot, _)| *knot < wavelength).max(1);
    match (spectrum[upper - 1], spectrum.get(upper)) {
        ((x0, y0), Some(&(x1, y1))) => y0 + (y1 - y0) * (wavelength - x0) / (x1 - x0),
        ((_, y), None) => y,
    }
}

/// The same, going on as it begins and ends.
pub(super) fn extended(spectrum: &[(f64, f64)], wavelength: f64) -> f64 {
    match (spectrum.first(), spectrum.last()) {
        (Some(first), Some(last)) => at(spectrum, wavelength.clamp(first.0, last.0)),
        _ => 0.0,
    }
}

/// The wavelengths in nanometres that spectra are between, unless they say otherwise.
pub(super) const FIRST_VISIBLE: f64 = 360.0;
pub(super) const LAST_VISIBLE: f64 = 830.0;

/// The radiance of a black body (Planck's law) in W m⁻² sr⁻¹ nm⁻¹, for a wavelength in nanometres
/// and a temperature in kelvins.
pub(super) fn planck(wavelength: f64, temperature: f64) -> f64 {
    // 2 h c² in W nm⁴ m⁻² per steradian, and h c / k in nm K (CODATA 2018).
    const FIRST_CONSTANT: f64 = 1.191_042_972e20;
    const SECOND_CONSTANT: f64 = 1.438_776_877e7;
    FIRST_CONSTANT
        / (wavelength.powi(5) * libm::expm1(SECOND_CONSTANT / (wavelength * temperature)))
}

/// The visible wavelengths, nanometre by nanometre.
pub(super) fn wavelengths() -> impl Iterator<Item = f64> {
    let steps = (STEP * (OBSERVER.len() - 1) as f64) as u32;
    (0..=steps).map(|i| FIRST + f64::from(i))
}

fn observer(wavelength: f64) -> Option<[f64; 4]> {
    let position = (wavelength - FIRST) / STEP;
    let lower = position.floor();
    let row = |i: f64| OBSERVER.get(i as usize);
    if lower < 0.0 {
        return None;
    }
    let (a, f) = (row(lower)?, position - lower);
    let b = if f > 0.0 { row(lower + 1.0)? } else { a };
    Some(std::array::from_fn(|i| a[i] * (1.0 - f) + b[i] * f))
}

/// IEC 61966-2-1.
pub(super) fn from_xyz([x, y, z]: [f64; 3]) -> Rgb {
    Rgb::new(
        3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
        -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
        0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
    )
}

/// First wavelength of the table in nanometres.
const FIRST: f64 = FIRST_VISIBLE;
const STEP: f64 = 5.0;
/// x̄, ȳ, z̄ (CIE 1931) and the relative power of D65.
#[rustfmt::skip]
const OBSERVER: [[f64; 4]; 95] = [
    [0.0001299, 3.917e-06, 0.0006061, 46.6383],
    [0.0002321, 6.965e-06, 0.001086, 49.3637],
    [0.0004149, 1.239e-05, 0.001946, 52.0891],
    [0.0007416, 2.202e-05, 0.003486, 51.0323],
    [0.001368, 3.9e-05, 0.00645, 49.9755],
    [0.002236, 6.4e-05, 0.01055, 52.3118],
    [0.004243, 0.00012, 0.02005, 54.6482],
    [0.00765, 0.000217, 0.03621, 68.7015],
    [0.01431, 0.000396, 0.06785, 82.7549],
    [0.02319, 0.00064, 0.1102, 87.1204],
    [0.04351, 0.00121, 0.2074, 91.486],
    [0.07763, 0.00218, 0.3713, 92.4589],
    [0.13438, 0.004, 0.6456, 93.4318],
    [0.21477, 0.0073, 1.03905, 90.057],
    [0.2839, 0.0116, 1.3856, 86.6823],
    [0.3285, 0.01684, 1.62296, 95.7736],
    [0.34828, 0.023, 1.74706, 104.865],
    [0.34806, 0.0298, 1.7826, 110.936],
    [0.3362, 0.038, 1.77211, 117.008],
    [0.3187, 0.048, 1.7441, 117.41],
    [0.2908, 0.06, 1.6692, 117.812],
    [0.2511, 0.0739, 1.5281, 116.336],
    [0.19536, 0.09098, 1.28764, 114.861],
    [0.1421, 0.1126, 1.0419, 115.392],
    [0.09564, 0.13902, 0.81295, 115.923],
    [0.05795, 0.1693, 0.6162, 112.367],
    [0.03201, 0.20802, 0.46518, 108.811],
    [0.0147, 0.2586, 0.3533, 109.082],
    [0.0049, 0.323, 0.272, 109.354],
    [0.0024, 0.4073, 0.2123, 108.578],
    [0.0093, 0.503, 0.1582, 107.802],
    [0.0291, 0.6082, 0.1117, 106.296],
    [0.06327, 0.71, 0.07825, 104.79],
    [0.1096, 0.7932, 0.05725, 106.239],
    [0.1655, 0.862, 0.04216, 107.689],
    [0.22575, 0.91485, 0.02984, 106.047],
    [0.2904, 0.954, 0.0203, 104.405],
    [0.3597, 0.9803, 0.0134, 104.225],
    [0.43345, 0.99495, 0.00875, 104.046],
    [0.51205, 1.0, 0.00575, 102.023],
    [0.5945, 0.995, 0.0039, 100.0],
    [0.6784, 0.9786, 0.00275, 98.1671],
    [0.7621, 0.952, 0.0021, 96.3342],
    [0.8425, 0.9154, 0.0018, 96.0611],
    [0.9163, 0.87, 0.00165, 95.788],
    [0.9786, 0.8163, 0.0014, 92.2368],
    [1.0263, 0.757, 0.0011, 88.6856],
    [1.0567, 0.6949, 0.001, 89.3459],
    [1.0622, 0.631, 0.0008, 90.0062],
    [1.0456, 0.5668, 0.0006, 89.8026],
    [1.0026, 0.503, 0.00034, 89.5991],
    [0.9384, 0.4412, 0.00024, 88.6489],
    [0.85445, 0.381, 0.00019, 87.6987],
    [0.7514, 0.321, 0.0001, 85.4936],
    [0.6424, 0.265, 5e-05, 83.2886],
    [0.5419, 0.217, 3e-05, 83.4939],
    [0.4479, 0.175, 2e-05, 83.6992],
    [0.3608, 0.1382, 1e-05, 81.863],
    [0.2835, 0.107, 0.0, 80.0268],
    [0.2187, 0.0816, 0.0, 80.1207],
    [0.1649, 0.061, 0.0, 80.2146],
    [0.1212, 0.04458, 0.0, 81.2462],
    [0.0874, 0.032, 0.0, 82.2778],
    [0.0636, 0.0232, 0.0, 80.281],
    [0.04677, 0.017, 0.0, 78.2842],
    [0.0329, 0.01192, 0.0, 74.0027],
    [0.0227, 0.00821, 0.0, 69.7213],
    [0.01584, 0.005723, 0.0, 70.6652],
    [0.0113592, 0.004102, 0.0, 71.6091],
    [0.00811092, 0.002929, 0.0, 72.979],
    [0.00579035, 0.002091, 0.0, 74.349],
    [0.00410946, 0.001484, 0.0, 67.9765],
    [0.00289933, 0.001047, 0.0, 61.604],
    [0.00204919, 0.00074, 0.0, 65.7448],
    [0.00143997, 0.00052, 0.0, 69.8856],
    [0.000999949, 0.0003611, 0.0, 72.4863],
    [0.000690079, 0.0002492, 0.0, 75.087],
    [0.000476021, 0.0001719, 0.0, 69.3398],
    [0.000332301, 0.00012, 0.0, 63.5927],
    [0.000234826, 8.48e-05, 0.0, 55.0054],
    [0.00016615, 6e-05, 0.0, 46.4182],
    [0.000117413, 4.24e-05, 0.0, 56.6118],
    [8.30753e-05, 3e-05, 0.0, 66.8054],
    [5.87065e-05, 2.12e-05, 0.0, 65.0941],
    [4.15099e-05, 1.499e-05, 0.0, 63.3828],
    [2.93533e-05, 1.06e-05, 0.0, 63.8434],
    [2.06738e-05, 7.4657e-06, 0.0, 64.304],
    [1.45598e-05, 5.2578e-06, 0.0, 61.8779],
    [1.0254e-05, 3.7029e-06, 0.0, 59.4519],
    [7.22146e-06, 2.6078e-06, 0.0, 55.7054],
    [5.08587e-06, 1.8366e-06, 0.0, 51.959],
    [3.58165e-06, 1.2934e-06, 0.0, 54.6998],
    [2.52252e-06, 9.1093e-07, 0.0, 57.4406],
    [1.77651e-06, 6.4153e-07, 0.0, 58.8765],
    [1.25114e-06, 4.5181e-07, 0.0, 60.3125],
];
