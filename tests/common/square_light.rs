//! Variances of light from the square [-1, 1]² at height 2, of radiance 1, scattered at the origin by
//! a diffuse floor of albedo 0.5; by quadrature over the square.

use std::f64::consts::PI;

const ALBEDO: f64 = 0.5;

/// Variances of one sample of each technique.
pub struct Variances {
    /// The square sampled.
    pub light: f64,
    /// Directions by their cosine.
    pub cosine: f64,
    pub balance: f64,
    /// The power heuristic with exponent 2.
    pub power: f64,
    /// Optimal weights (Kondapaneni et al. 2019).
    pub optimal: f64,
    /// Their α, of the sample of the light and of the cosine sample.
    pub alpha: [f64; 2],
}

/// `∫ F dω` over the square, F a function of the distance r: `dω = 2/r³ dA`.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    const N: u32 = 600;
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(N) * 2.0 - 1.0;
    let cells = (0..N).flat_map(|i| (0..N).map(move |j| [i, j].map(at)));
    let values = cells.map(|[x, y]| (x * x + y * y + 4.0).sqrt()).map(|r| f(r) * 2.0 / r.powi(3));
    values.sum::<f64>() * 4.0 / f64::from(N * N)
}

/// Densities per solid angle at a distance: of points uniform by area, and uniform in solid angle.
pub fn by_area(r: f64) -> f64 {
    0.25 * r.powi(3) / 2.0
}

pub fn by_solid_angle() -> impl Fn(f64) -> f64 {
    let solid_angle = integral(|_| 1.0);
    move |_| 1.0 / solid_angle
}

impl Variances {
    /// For a density of the light's sample.
    pub fn of(density: impl Fn(f64) -> f64) -> Self {
        let cosine = |r: f64| 2.0 / r / PI;
        let value = |r: f64| ALBEDO * cosine(r);
        let mean = integral(value);
        let both = |weight: &dyn Fn(f64, f64) -> f64| {
            let w = |r: f64| weight(density(r), cosine(r));
            integral(|r| (w(r) * value(r)).powi(2) / density(r))
                + integral(|r| ((1.0 - w(r)) * value(r)).powi(2) / cosine(r))
                - integral(|r| w(r) * value(r)).powi(2)
                - integral(|r| (1.0 - w(r)) * value(r)).powi(2)
        };
        // α solves A α = b, A_ij = ∫ p_i p_j/(p_l + p_c), b_i = ∫ f p_i/(p_l + p_c). With f = ρ p_c on
        // the light, a = A_lc and the form factor F = ∫ p_c say everything.
        let a = integral(|r| density(r) * cosine(r) / (density(r) + cosine(r)));
        let form_factor = integral(cosine);
        let scale = ALBEDO / (1.0 - 2.0 * a);
        let alpha = [scale * a * (1.0 - form_factor), scale * (form_factor - a - a * form_factor)];
        let b = [ALBEDO * a, ALBEDO * (form_factor - a)];
        Self {
            light: integral(|r| value(r).powi(2) / density(r)) - mean * mean,
            cosine: integral(|r| value(r).powi(2) / cosine(r)) - mean * mean,
            balance: both(&|l, c| l / (l + c)),
            power: both(&|l, c| l * l / (l * l + c * c)),
            optimal: integral(|r| value(r).powi(2) / (density(r) + cosine(r)))
                - alpha[0] * b[0]
                - alpha[1] * b[1],
            alpha,
        }
    }
}
