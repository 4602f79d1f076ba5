//! Rough plastic: a diffuse body under a rough dielectric coat.
//!
//! The coat is a micro-surface of smooth interfaces with masking and shadowing taken as independent,
//! `G2 = G1 G1` (Walter et al. 2007), and T is what of the light from one direction it lets in
//! without a second bounce. With the body's albedo a, the coat's relative index n, and its mean
//! reflectance from inside `R_i`,
//!
//! ```text
//! f    = F D G1(o) G1(i) / (4 o_z i_z) + a/(1 - a R_i) · T(o) T(i) / (π n²)
//! T(o) = ∫ (1 - F(o·h)) G1(t) D_o(h) dh        R_i = ∫ 2 μ R(μ) dμ,   R(o) = ∫ F(o·h) G1(r) D_o(h) dh
//! ```
//!
//! over the normals h seen from o, with t refracted and r mirrored by them. It is symmetric in both
//! directions. Each normal reflects and transmits at most everything, so R + T ≤ 1 on either side;
//! and the means of T from both sides differ by n², because a rough interface is reciprocal, so
//! that the body reflects at most T(o). This is the model of Mitsuba 3 (Jakob et al. 2022, plug-in
//! `roughplastic`), which sums R over 64 cosines and so makes the body up to 2.2 % darker. For small
//! roughness it becomes smooth [`Plastic`].

use super::rough_conductor::{Lobe, Pair, reflect, sample_reflection};
use super::rough_dielectric::refract;
use super::{
    Bsdf, BsdfError, BsdfSample, Lobes, Microfacets, Plastic, TransportMode, finite_sample,
    fresnel, same_side, sample_diffuse,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// Number of cosines at which T is tabulated, equidistant in their roots: by linear interpolation
/// it is then right to 0.3 % of the light everywhere, and never too large under nearly smooth coats.
const NODES: usize = 32;

/// Numbers of micro-normals that T at a cosine, and `R_i`, are means over: right to 0.1 %.
const NORMALS: [u32; 2] = [1024, 16384];

/// Glossy reflection of a rough clear coat and diffuse reflection of what is below, on both sides
/// of the surface. Single scattering in the coat's micro-surface.
///
/// A distribution that [is smooth](Microfacets::is_smooth) has the roughness
/// [`LEAST_ALPHA`](super::ggx::LEAST_ALPHA) here; [`Plastic`] is the model with a Dirac lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughPlastic {
    /// The body, and the coat's colour and index.
    plastic: Plastic,
    distribution: Microfacets,
    /// T at the cosines `(k / 31)²`.
    transmittance: [f32; NODES],
}

impl RoughPlastic {
    /// Plastic with a rough coat; for the first four parameters see [`Plastic::new`]. The
    /// distribution should be the same in all directions: of another one, T is that of directions
    /// in the plane of x and z. Takes a few milliseconds.
    ///
    /// # Errors
    /// If a channel of a colour is not in [0, 1], or `relative_ior` is not in [1, 1e6].
    pub fn new(
        albedo: Rgb,
        specular: Rgb,
        relative_ior: f64,
        colour_shift: bool,
        distribution: impl Into<Microfacets>,
    ) -> Result<Self, BsdfError> {
        let plastic = Plastic::new(albedo, specular, relative_ior, colour_shift)?;
        let distribution = distribution.into();
        let at = |k: usize| transmittance(&distribution, (k as f64 / LAST).powi(2), relative_ior);
        let transmittance = std::array::from_fn(|k| at(k) as f32);
        let rough = Self { plastic, distribution, transmittance };
        // Rounding must not let out more than came in.
        let most = 1.0 - rough.mean_transmittance() / (relative_ior * relative_ior);
        let [inside, _] = reflectances_inside(&distribution, relative_ior);
        Ok(Self { plastic: plastic.with_inside(inside.min(most), albedo), ..rough })
    }

    /// The same plastic with a body of another albedo, which must be in [0, 1].
    pub(crate) fn with_albedo(self, albedo: Rgb) -> Self {
        Self { plastic: self.plastic.with_albedo(albedo), ..self }
    }

    /// T for light from a direction with this |z|.
    fn transmittance(&self, cosine: f64) -> f64 {
        let x = cosine.sqrt() * LAST;
        let k = (x as usize).min(NODES - 2);
        let [below, above] = [k, k + 1].map(|k| f64::from(self.transmittance[k]));
        below + (above - below) * (x - k as f64)
    }

    /// ∫ 2 μ T(μ) dμ, by Simpson's rule between the nodes.
    fn mean_transmittance(&self) -> f64 {
        let at = |x: f64| 4.0 * x.powi(3) * self.transmittance(x * x);
        let cell = |k: usize| {
            let [from, to] = [k, k + 1].map(|k| k as f64 / LAST);
            (at(from) + 4.0 * at(0.5 * (from + to)) + at(to)) / (6.0 * LAST)
        };
        (0..NODES - 1).map(cell).sum()
    }

    fn coat_value(&self, pair: &Pair, lobe: &Lobe) -> Rgb {
        let sine = pair.o.cross(pair.h).length();
        let interface = fresnel::dielectric(pair.cosine, sine, self.plastic.relative_ior);
        self.plastic.specular * (interface.reflectance * lobe.value_of_independent())
    }

    /// The density of a direction that has some density under the coat's reflection alone, given T
    /// for the fixed direction.
    fn mixed_pdf(&self, transmittance: f64, glossy: PerProjected) -> PerProjected {
        let coat = self.plastic.coat_probability(1.0 - transmittance, transmittance);
        PerProjected(coat * glossy.value() + (1.0 - coat) * FRAC_1_PI)
    }
}

impl Bsdf for RoughPlastic {
    #[inline]
    fn lobes(&self) -> Lobes {
        let smooth = self.plastic.lobes();
        let body = if smooth.intersects(Lobes::DIFFUSE_REFLECTION) {
            Lobes::DIFFUSE_REFLECTION
        } else {
            Lobes::NONE
        };
        if smooth.intersects(Lobes::DIRAC) { body | Lobes::GLOSSY_REFLECTION } else { body }
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.eval_and_pdf(to_light, to_camera).0
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _mode: TransportMode) -> PerProjected {
        if !same_side(fixed, next) {
            return PerProjected::ZERO;
        }
        let pair = Pair::new(fixed, next);
        let glossy = pair.map_or(PerProjected::ZERO, |pair| pair.pdf(&self.distribution));
        self.mixed_pdf(self.transmittance(fixed.z.abs()), glossy)
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        if !same_side(to_light, to_camera) {
            return (Rgb::BLACK, PerProjected::ZERO);
        }
        let ends = [to_light, to_camera].map(|w| self.transmittance(w.z.abs()));
        let pair = Pair::new(to_camera, to_light);
        let (glossy, pdf) = pair.map_or((Rgb::BLACK, PerProjected::ZERO), |pair| {
            let lobe = pair.lobe(&self.distribution);
            (self.coat_value(&pair, &lobe), lobe.pdf())
        });
        (glossy + self.plastic.body_value(ends), self.mixed_pdf(ends[1], pdf))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        if !same_side(fixed, fixed) {
            return None;
        }
        let transmittance = self.transmittance(fixed.z.abs());
        let coat = self.plastic.coat_probability(1.0 - transmittance, transmittance);
        let next = if u1 < coat {
            sample_reflection(&self.distribution, fixed, u2)?
        } else {
            sample_diffuse(fixed, u2)
        };
        finite_sample(self, fixed, next, mode)
    }
}

const LAST: f64 = (NODES - 1) as f64;

/// Points of the unit square, evenly spread: the k-th of n is `(k + 1/2)/n` with k golden ratios.
fn evenly_spread(n: u32) -> impl Iterator<Item = DVec2> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..n).map(move |k| {
        let k = f64::from(k);
        DVec2::new(((k + 0.5) * GOLDEN).fract(), (k + 0.5) / f64::from(n))
    })
}

/// A direction in the plane of x and z, at a cosine where normals can be sampled.
fn towards(cosine: f64) -> DVec3 {
    let z = cosine.clamp(1e-6, 1.0);
    DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z)
}

/// T for light from outside.
fn transmittance(distribution: &Microfacets, cosine: f64, relative_ior: f64) -> f64 {
    let o = towards(cosine);
    let let_in = |u: DVec2| {
        let h = distribution.sample_visible(o, u)?;
        let interface = fresnel::dielectric(o.dot(h).max(0.0), o.cross(h).length(), relative_ior);
        let t = refract(o, h, relative_ior, interface.refracted_cosine)?;
        Some(interface.transmittance * distribution.masking(t.with_z(-t.z)))
    };
    evenly_spread(NORMALS[0]).filter_map(let_in).sum::<f64>() / f64::from(NORMALS[0])
}

/// `R_i`, over directions that follow Lambert's law, and R from inside at normal incidence.
pub(crate) fn reflectances_inside(distribution: &Microfacets, relative_ior: f64) -> [f64; 2] {
    // Steps by powers of the plastic number fill the square of normals for strata of μ².
    const STEPS: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    let thrown_back = |o: DVec3, u: DVec2| {
        let h = distribution.sample_visible(o, u)?;
        let (cosine, sine) = (o.dot(h).max(0.0), o.cross(h).length());
        let interface = fresnel::dielectric(cosine, sine, 1.0 / relative_ior);
        Some(interface.reflectance * distribution.masking(reflect(o, h)?))
    };
    let n = f64::from(NORMALS[1]);
    let anywhere = (0..NORMALS[1]).map(|k| f64::from(k) + 0.5);
    let anywhere =
        anywhere.filter_map(|k| thrown_back(towards((k / n).sqrt()), (k * STEPS).fract()));
    let normal = evenly_spread(NORMALS[0]).filter_map(|u| thrown_back(DVec3::Z, u));
    [anywhere.sum::<f64>() / n, normal.sum::<f64>() / f64::from(NORMALS[0])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Beckmann, Ggx};
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    const N: f64 = 1.49;

    fn distributions() -> impl Iterator<Item = (f64, Microfacets)> {
        [0.02, 0.1, 0.3, 1.0].into_iter().flat_map(|alpha| {
            let (ggx, beckmann) = (Ggx::isotropic(alpha), Beckmann::new(alpha, alpha));
            [(alpha, ggx.unwrap().into()), (alpha, beckmann.unwrap().into())]
        })
    }

    fn plastic(distribution: Microfacets) -> RoughPlastic {
        RoughPlastic::new(Rgb::WHITE, Rgb::WHITE, N, false, distribution).unwrap()
    }

    /// What the interface reflects and transmits of the light from one direction, by the midpoint
    /// rule over micro-normals and not over those that are sampled.
    fn scattered(distribution: &Microfacets, alpha: f64, cosine: f64, eta: f64) -> [f64; 2] {
        const CELLS: [u32; 2] = [400, 48];
        let o = towards(cosine);
        let mut sums = [0.0; 2];
        for cell in 0..CELLS[0] * CELLS[1] {
            let t = (f64::from(cell / CELLS[1]) + 0.5) / f64::from(CELLS[0]);
            // tan θ = α t/(1 - t), so that the peak is resolved
            let tangent = alpha * t / (1.0 - t);
            let z = 1.0 / tangent.hypot(1.0);
            let phi = TAU * (f64::from(cell % CELLS[1]) + 0.5) / f64::from(CELLS[1]);
            let h = DVec3::new(tangent * z * phi.cos(), tangent * z * phi.sin(), z);
            let c = o.dot(h);
            if c <= 0.0 {
                continue;
            }
            let measure = tangent * z.powi(3) * alpha / ((1.0 - t) * (1.0 - t)) * TAU
                / f64::from(CELLS[0] * CELLS[1]);
            let seen = measure * distribution.density(h) * distribution.masking(o) * c / o.z;
            let far = 1.0 - (1.0 - c * c) / (eta * eta);
            let q = far.max(0.0).sqrt();
            let (s, p) = ((c - eta * q) / (c + eta * q), (eta * c - q) / (eta * c + q));
            let reflectance = if far <= 0.0 { 1.0 } else { 0.5 * (s * s + p * p) };
            let (r, t) = (2.0 * c * h - o, (c / eta - q) * h - o / eta);
            if r.z > 0.0 {
                sums[0] += seen * reflectance * distribution.masking(r);
            }
            if t.z < 0.0 {
                sums[1] += seen * (1.0 - reflectance) * distribution.masking(t.with_z(-t.z));
            }
        }
        sums
    }

    #[test]
    fn tables_are_integrals_over_micro_normals() {
        for (alpha, distribution) in distributions() {
            let plastic = plastic(distribution);
            for cosine in [1.0, 0.72, 0.5, 0.21, 0.053] {
                let [_, expected] = scattered(&distribution, alpha, cosine, N);
                assert_relative_eq!(plastic.transmittance(cosine), expected, epsilon = 1e-3);
            }
            let strata = 120;
            let inside = (0..strata).map(|k| {
                let cosine = ((f64::from(k) + 0.5) / f64::from(strata)).sqrt();
                scattered(&distribution, alpha, cosine, 1.0 / N)[0]
            });
            let expected = inside.sum::<f64>() / f64::from(strata);
            assert_relative_eq!(plastic.plastic.inside, expected, max_relative = 3e-3);
        }
    }

    /// The albedo of a white body with its coat, which loses what hits the micro-surface twice, up to the
    /// error of both quadratures.
    #[test]
    fn white_bodies_never_reflect_more_than_everything() {
        let smooth = Ggx::isotropic(1e-4).unwrap().into();
        for (alpha, distribution) in distributions().chain([(1e-4, smooth)]) {
            let plastic = plastic(distribution);
            let body = plastic.plastic.body_value([1.0; 2]).mean() / FRAC_1_PI;
            for k in 1..=20 {
                let cosine = f64::from(k) / 20.0;
                let diffuse = body * plastic.transmittance(cosine) * plastic.mean_transmittance();
                let [coat, _] = scattered(&distribution, alpha, cosine, N);
                let albedo = coat + diffuse;
                assert!(albedo <= 1.0 + 1e-4, "{distribution:?} {cosine}: {albedo}");
                assert!(alpha > 1e-3 || albedo > 0.995, "{distribution:?} {cosine}: {albedo}");
            }
        }
    }

    #[test]
    fn values_are_those_of_the_formula() {
        let (o, i) = (DVec3::new(0.48, 0.36, 0.8), DVec3::new(-0.6, 0.0, 0.8));
        let h = (o + i).normalize();
        let distribution = Ggx::isotropic(0.4).unwrap();
        let (albedo, specular) = (Rgb::new(0.9, 0.5, 0.1), Rgb::new(0.2, 0.6, 1.0));
        for colour_shift in [false, true] {
            let bsdf = RoughPlastic::new(albedo, specular, N, colour_shift, distribution).unwrap();
            let fresnel = fresnel::dielectric(o.dot(h), o.cross(h).length(), N).reflectance;
            let masking = distribution.masking(o) * distribution.masking(i);
            let coat = fresnel * distribution.density(h) * masking / (4.0 * o.z * i.z);
            let [t_o, t_i] = [o, i].map(|w| scattered(&distribution.into(), 0.4, w.z, N)[1]);
            for c in 0..3 {
                let again = if colour_shift { albedo[c] } else { 1.0 };
                let body = albedo[c] / (1.0 - again * bsdf.plastic.inside);
                let value = specular[c] * coat + body * t_o * t_i * FRAC_1_PI / (N * N);
                assert_relative_eq!(bsdf.eval(i, o)[c], value, max_relative = 2e-3);
            }
        }
    }
}
