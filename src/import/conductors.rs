//! Optical constants of conductors: by name, and from spectra.
//!
//! Colour is what the eye sees of the *reflectance*, which is not linear in n and k, and an index
//! that is converted like a light would be reddish where it is constant. So the reflectance at
//! normal incidence under daylight becomes RGB as reflectances do, n becomes RGB, and k is chosen
//! such that they fit together (the parameters of Gulbrandsen 2014); where n alone reflects more, n
//! is chosen instead.

use super::spectrum::{self, Illuminant, to_rgb};
use crate::math::Rgb;

/// Wavelengths in nanometres, rising, and values between which it is linear.
type Spectrum = [(f64, f64)];

/// n and k of a material by its name in Mitsuba; "none" is a perfect mirror, an index of 0 + i.
pub(super) fn by_name(name: &str) -> Option<[Rgb; 2]> {
    if name == "none" {
        return Some([Rgb::BLACK, Rgb::WHITE]);
    }
    let row = |name: &str| CONDUCTORS.iter().find(|row| row.0 == name);
    // Most materials have a second name with the author of the measurement.
    let (_, n, k) = row(name)
        .or_else(|| row(name.strip_suffix("_palik")?).filter(|row| !ONLY_PLAIN.contains(&row.0)))?;
    Some([Rgb(*n), Rgb(*k)])
}

/// n and k of a material with these spectra, which go on as they end. There must be values, none of
/// them negative.
pub(super) fn from_spectra(n: &Spectrum, k: &Spectrum) -> [Rgb; 2] {
    let table: Vec<[f64; 3]> = spectrum::wavelengths()
        .map(|at| [at, spectrum::extended(n, at), spectrum::extended(k, at)])
        .collect();
    let normal = |n: f64, k: f64| ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
    let seen = |of: &dyn Fn(f64, f64) -> f64| {
        let values: Vec<(f64, f64)> = table.iter().map(|&[at, n, k]| (at, of(n, k))).collect();
        let (least, most) = values
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(least, most), (_, v)| (least.min(*v), most.max(*v)));
        // Gold's red is outside of the colours of sRGB; no channel has more than the material has
        // anywhere.
        to_rgb(&values, Illuminant::D65).map(|c| c.clamp(least, most))
    };
    let (eta, reflectance) = (seen(&|n, _| n), seen(&normal));
    let mut indices = [eta, Rgb::BLACK];
    for channel in 0..3 {
        let (n, r) = (eta[channel], reflectance[channel]);
        if r >= 1.0 {
            // Everything is reflected by what has no real part.
            indices[0].0[channel] = 0.0;
            indices[1].0[channel] = 1.0;
            continue;
        }
        // R = ((n - 1)² + k²)/((n + 1)² + k²), solved for k²
        let square = (r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r);
        if square >= 0.0 {
            indices[1].0[channel] = square.sqrt();
        } else {
            indices[0].0[channel] = (1.0 + r.sqrt()) / (1.0 - r.sqrt());
        }
    }
    indices
}

/// Materials that have no second name.
const ONLY_PLAIN: [&str; 6] = ["Ag", "Al", "Au", "Cr", "W", "a-C"];

/// Name, n and k as [`from_spectra`] gives them; `tests/peers/conductors.py` prints the table. The
/// spectra are those that Mitsuba 3.9 comes with: measurements that Palik (1985, 1991) collected,
/// and for Au, Ag, Al, Cu, Cr, W and a-C others, all as the database luxpop gives them, with gaps
/// closed linearly and continued as they end.
#[rustfmt::skip]
const CONDUCTORS: [(&str, [f64; 3], [f64; 3]); 41] = [
    ("Ag", [0.12849, 0.12353, 0.15088], [4.1011, 3.3265, 2.4071]),
    ("Al", [1.4075, 0.92664, 0.58403], [7.6881, 6.5952, 5.3275]),
    ("AlAs", [3.1129, 3.2553, 3.6621], [0.0, 0.066176, 0.046924]),
    ("AlSb", [3.9052, 4.27, 5.044], [0.0, 0.0, 1.445]),
    ("Au", [0.16001, 0.40508, 1.5607], [4.9682, 2.3382, 1.7182]),
    ("Be", [3.4699, 3.3563, 3.0722], [3.1839, 3.1739, 3.1552]),
    ("Cr", [3.6818, 3.0659, 1.8561], [4.2894, 4.4467, 4.1138]),
    ("CsI", [1.7788, 1.7955, 1.8269], [0.0, 0.0046401, 0.011054]),
    ("Cu", [0.2093, 0.97792, 1.2046], [4.15, 2.6237, 2.3604]),
    ("Cu2O", [2.939, 3.1096, 3.0333], [0.121, 0.17154, 0.6496]),
    ("CuO", [2.7033, 2.5807, 2.4364], [0.40654, 0.6, 0.78484]),
    ("Cu_palik", [0.21301, 0.97362, 1.2048], [4.0849, 2.6266, 2.3548]),
    ("Hg", [2.0278, 1.5152, 1.0162], [5.2881, 4.6006, 3.7783]),
    ("HgTe", [3.929, 3.4032, 2.9503], [1.4523, 1.6482, 1.8945]),
    ("Ir", [2.5939, 2.192, 1.7905], [4.6653, 4.2875, 3.6136]),
    ("K", [0.053689, 0.048839, 0.042147], [1.7786, 1.4232, 1.0188]),
    ("Li", [0.22098, 0.20666, 0.24121], [3.0018, 2.4478, 1.8658]),
    ("MgO", [1.7338, 1.7409, 1.7534], [0.0, 0.0049472, 0.010758]),
    ("Mo", [3.7337, 3.7127, 3.065], [3.3803, 3.6155, 3.4655]),
    ("Na_palik", [0.049245, 0.059286, 0.067954], [2.7401, 2.2333, 1.765]),
    ("Nb", [2.8376, 2.93, 2.6452], [2.8544, 2.8856, 2.8425]),
    ("Ni_palik", [1.9795, 1.7536, 1.6171], [3.7906, 3.2155, 2.6058]),
    ("Rh", [2.1597, 1.9601, 1.7222], [5.709, 4.9535, 4.3973]),
    ("Se", [3.3799, 2.9947, 3.0946], [0.759, 0.66665, 0.56638]),
    ("Se-e", [4.7895, 4.3858, 4.4894], [0.80334, 1.1518, 1.6894]),
    ("SiC", [2.6303, 2.6643, 2.7243], [0.0, 0.010008, 0.016091]),
    ("SnTe", [3.8881, 2.0734, 1.4246], [0.77417, 0.0, 0.0]),
    ("Ta", [1.6545, 2.5257, 2.8499], [1.9465, 1.8339, 2.1379]),
    ("Te", [6.1199, 4.7096, 2.9563], [2.561, 3.7025, 3.5772]),
    ("Te-e", [6.3777, 4.5129, 2.6618], [4.4575, 5.2029, 4.367]),
    ("ThF4", [1.5193, 1.521, 1.5257], [0.0, 0.0042179, 0.0091658]),
    ("TiC", [3.0767, 2.9917, 2.8455], [2.7316, 2.4787, 2.3917]),
    ("TiN", [1.3776, 1.2149, 1.5032], [2.935, 2.0292, 1.2533]),
    ("TiO2", [2.8605, 2.9565, 3.1853], [0.0, 0.034314, 0.026398]),
    ("TiO2-e", [2.5714, 2.6518, 2.8325], [0.0, 0.024611, 0.020341]),
    ("VC", [3.0459, 2.9022, 2.7888], [2.5691, 2.3172, 2.1638]),
    ("VN", [2.3893, 2.2342, 2.1361], [2.5548, 2.1655, 1.7919]),
    ("V_palik", [3.5491, 3.68, 3.0618], [2.8886, 3.0445, 3.4143]),
    ("W", [3.6376, 3.4803, 3.3003], [2.9184, 2.7468, 2.51]),
    ("a-C", [2.43, 2.3469, 2.1705], [0.75171, 0.84337, 0.89368]),
    ("d-C", [2.4111, 2.4237, 2.4486], [0.0, 0.0070792, 0.014171]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn reflectance([eta, k]: [Rgb; 2]) -> [f64; 3] {
        [0, 1, 2].map(|c| crate::bsdf::fresnel::conductor(1.0, 0.0, eta[c], k[c]))
    }

    /// The reflectance of the spectra in daylight, integrated by another program, which Mitsuba's
    /// spectral mode renders as well, to 5e-4.
    #[test]
    fn conductors_have_their_colours() {
        // Gold's red would be 1.0219.
        let cases = [
            ("Au", [0.97541, 0.78224, 0.34351]),
            ("Cu", [0.95519, 0.63767, 0.53809]),
            ("MgO", [0.07204, 0.07307, 0.07489]),
        ];
        for (name, expected) in cases {
            let found = reflectance(by_name(name).expect("known"));
            (0..3).for_each(|c| assert_relative_eq!(found[c], expected[c], max_relative = 2e-4));
        }
        for (name, ..) in CONDUCTORS {
            assert!(
                reflectance(by_name(name).expect("known")).iter().all(|r| (0.03..1.0).contains(r)),
                "{name}"
            );
        }
        assert_eq!(reflectance(by_name("none").expect("known")), [1.0; 3]);
        assert_eq!(
            (by_name("Be_palik"), by_name("Unobtainium"), by_name("Au_palik")),
            (by_name("Be"), None, None)
        );
        assert_ne!(by_name("Cu_palik"), by_name("Cu"));
    }

    #[test]
    fn the_table_is_what_spectra_give() {
        let at = [309.95, 354.229, 413.267, 495.92, 619.9, 826.533];
        let with = |values: [f64; 6]| std::array::from_fn::<_, 6, _>(|i| (at[i], values[i]));
        let (n, k) =
            (with([2.27, 2.14, 1.74, 1.2, 1.32, 1.82]), with([1.23, 1.06, 1.04, 1.65, 2.69, 3.81]));
        let (found, expected) = (from_spectra(&n, &k), by_name("TiN").expect("known"));
        for (a, b) in found.iter().zip(expected) {
            (0..3).for_each(|c| assert_relative_eq!(a[c], b[c], max_relative = 5e-5));
        }
        // What has no colour stays grey, with both solutions: of k, and of n.
        let (flat, none) = ([(500.0, 1.5)], [(500.0, 0.0)]);
        for (k, expected) in [(&none, 0.04), (&flat, (0.25 + 2.25) / (6.25 + 2.25))] {
            reflectance(from_spectra(&flat, k))
                .iter()
                .for_each(|r| assert_relative_eq!(*r, expected, max_relative = 2e-4));
        }
    }
}
