//! Rough models against what defines them: the integral over micro-normals by quadrature, and a
//! walk on the micro-surface. Slopes, masking and Fresnel's equations are written anew here, from
//! the sources and not from the crate.

use crate::models::boxed;
use crate::{Independent, direction};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::fresnel::Reflectance;
use pathspace::bsdf::*;
use pathspace::math::Rgb;
use pathspace::math::statistics::Estimate;
use pathspace::sampler::Sampler;
use statrs::function::beta::beta;
use statrs::function::erf::erf;
use std::f64::consts::{PI, TAU};

/// A rough surface by the distribution of its slopes.
#[derive(Clone, Copy, Debug)]
struct Surface {
    alpha: (f64, f64),
    is_gaussian: bool,
}

/// An event of light on a facet.
#[derive(Clone, Copy, Debug)]
enum Facet {
    /// Reflectance at a cosine.
    Mirror(fn(f64) -> f64),
    /// Index on the far side over that on the near side.
    Glass(f64),
}

/// Light scattered to the same side and to the other side: its power, and the power times the
/// cosine and times x of its direction.
type Moments = [[f64; 3]; 2];

fn add(moments: &mut Moments, i: DVec3, power: f64) {
    let side = usize::from(i.z < 0.0);
    for (moment, g) in moments[side].iter_mut().zip([1.0, i.z.abs(), i.x]) {
        *moment += power * g;
    }
}

impl Surface {
    /// Isotropic and anisotropic ones of both distributions.
    fn all() -> impl Iterator<Item = Self> {
        let both = |alpha| [false, true].map(|is_gaussian| Self { alpha, is_gaussian });
        [(0.3, 0.3), (1.0, 1.0), (0.6, 0.2)].into_iter().flat_map(both)
    }

    /// The crate's distribution.
    fn microfacets(&self) -> Microfacets {
        let (x, y) = self.alpha;
        if self.is_gaussian {
            Beckmann::new(x, y).unwrap().into()
        } else {
            Ggx::new(x, y).unwrap().into()
        }
    }

    /// Heitz 2014, section 5, with a = 1/(α tan θ).
    fn lambda(&self, w: DVec3) -> f64 {
        let a = w.z.abs() / (self.alpha.0 * w.x).hypot(self.alpha.1 * w.y);
        if self.is_gaussian {
            0.5 * (erf(a) - 1.0) + (-a * a).exp() / (2.0 * a * PI.sqrt())
        } else {
            0.5 * ((1.0 + 1.0 / (a * a)).sqrt() - 1.0)
        }
    }

    /// The micro-normal of a point of the unit square, and its density among the visible normals
    /// of `o` over that of such normals for uniform points.
    fn visible_normal(&self, o: DVec3, DVec2 { x: u, y: v }: DVec2) -> (DVec3, f64) {
        let radius = u / (1.0 - u);
        let (sin, cos) = (TAU * v).sin_cos();
        let slope = (self.alpha.0 * radius * cos, self.alpha.1 * radius * sin);
        let squared = radius * radius;
        let density =
            if self.is_gaussian { (-squared).exp() } else { (1.0 + squared).powi(-2) } / PI;
        let towards = (o.z - o.x * slope.0 - o.y * slope.1).max(0.0);
        let jacobian = TAU * radius / (1.0 - u).powi(2);
        let visible = density * jacobian * towards / (o.z * (1.0 + self.lambda(o)));
        (DVec3::new(-slope.0, -slope.1, 1.0).normalize(), visible)
    }

    /// `G2 / G1(o)` for height-correlated masking and shadowing.
    fn unshadowed(&self, o: DVec3, i: DVec3) -> f64 {
        let (o, i, is_opposite) = (self.lambda(o), self.lambda(i), i.z < 0.0);
        (1.0 + o) * if is_opposite { beta(1.0 + o, 1.0 + i) } else { 1.0 / (1.0 + o + i) }
    }

    /// `∫ D_o(m) F G2/G1(o) g dm` over n² micro-normals (Walter et al. 2007, eqs. 20 and 21, with
    /// the directions that follow from m as variables), for the midpoints of a grid.
    fn moments(&self, facet: Facet, o: DVec3) -> Moments {
        const N: usize = 500;
        let at = |k: usize| (k as f64 + 0.5) / N as f64;
        let (mut moments, mut seen) = (Moments::default(), 0.0);
        for cell in 0..N * N {
            let (m, visible) = self.visible_normal(o, DVec2::new(at(cell / N), at(cell % N)));
            seen += visible;
            for event in facet.scatter(o, m).into_iter().filter(Event::leaves) {
                let power = visible * event.share * self.unshadowed(o, event.i);
                add(&mut moments, event.i, power);
            }
        }
        let cells = (N * N) as f64;
        // Masking is that of the slopes.
        assert_relative_eq!(seen / cells, 1.0, max_relative = 1e-4);
        moments.map(|side| side.map(|moment| moment / cells))
    }

    /// The first events of walks, one for each micro-normal of a jittered grid. A walk meets the
    /// surface at the height below which the share x of all points lies, distributed as
    /// `x^(1 + Λ(o))`, and what the facet scatters leaves without another event upwards with
    /// probability `x^Λ(i)` and downwards with `(1 - x)^Λ(i)` (Heitz, Hanika, d'Eon and Dachsbacher
    /// 2016, section 4).
    fn walks(&self, facet: Facet, o: DVec3, sampler: &mut Independent) -> Moments {
        let mut moments = Moments::default();
        for u2 in jittered(WALKS, sampler) {
            let (m, visible) = self.visible_normal(o, u2);
            let x = sampler.next_1d().powf(1.0 / (1.0 + self.lambda(o)));
            for event in facet.scatter(o, m).into_iter().filter(Event::leaves) {
                let open = if event.is_reflection { x } else { 1.0 - x };
                if sampler.next_1d() < open.powf(self.lambda(event.i)) {
                    let power = visible * event.share / f64::from(WALKS * WALKS);
                    add(&mut moments, event.i, power);
                }
            }
        }
        moments
    }
}

/// Square root of the number of walks of a replication.
const WALKS: u32 = 256;

/// A point in each cell of a grid over the unit square.
fn jittered(n: u32, sampler: &mut Independent) -> Vec<DVec2> {
    let corner = |cell: u32| DVec2::new(f64::from(cell % n), f64::from(cell / n));
    (0..n * n).map(|cell| (corner(cell) + sampler.next_2d()) / f64::from(n)).collect()
}

/// A direction into which a facet sends a share of the power.
#[derive(Clone, Copy)]
struct Event {
    i: DVec3,
    share: f64,
    is_reflection: bool,
}

impl Event {
    /// True if the direction is not into the surface, which it would meet again.
    fn leaves(&self) -> bool {
        (self.i.z > 0.0) == self.is_reflection && self.share > 0.0
    }
}

impl Facet {
    /// Reflection and refraction; nothing where the facet is seen from behind.
    fn scatter(self, o: DVec3, m: DVec3) -> [Event; 2] {
        let cosine = o.dot(m);
        let (reflectance, refracted) = match self {
            Self::Mirror(reflectance) => (reflectance(cosine), DVec3::ZERO),
            Self::Glass(eta) => {
                let squared = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
                let far = squared.max(0.0).sqrt();
                let s = (cosine - eta * far) / (cosine + eta * far);
                let p = (eta * cosine - far) / (eta * cosine + far);
                (0.5 * (s * s + p * p), (cosine / eta - far) * m - o / eta)
            }
        };
        let transmittance = if matches!(self, Self::Glass(_)) { 1.0 - reflectance } else { 0.0 };
        [(2.0 * cosine * m - o, reflectance, true), (refracted, transmittance, false)].map(
            |(i, share, is_reflection)| Event {
                i,
                share: if cosine > 0.0 { share } else { 0.0 },
                is_reflection,
            },
        )
    }
}

/// A metal of index 0.4 + 2.5 i (Born and Wolf 1999, section 14.2).
fn metal(cosine: f64) -> f64 {
    let (eta, k): (f64, f64) = (0.4, 2.5);
    let (c, s) = (cosine, 1.0 - cosine * cosine);
    let difference = eta * eta - k * k - s;
    let sum = (difference * difference + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (sum + difference)).sqrt();
    let perpendicular = (sum - 2.0 * a * c + c * c) / (sum + 2.0 * a * c + c * c);
    let (t, d) = (c * c * sum + s * s, 2.0 * a * c * s);
    0.5 * perpendicular * (1.0 + (t - d) / (t + d))
}

/// The reflection of [`metallic_roughness`]: Schlick's approximation.
fn schlick(cosine: f64) -> f64 {
    0.28 + 0.72 * (1.0 - cosine).powi(5)
}

/// A third of metal with base colour 0.76: f0 = 2/3 · 0.04 + 1/3 · 0.76 = 0.28.
fn metallic_roughness(alpha: f64) -> MetallicRoughness {
    MetallicRoughness::new(Rgb::splat(0.76), 1.0 / 3.0, alpha.sqrt(), 1.5).unwrap()
}

/// The diffuse part of it under the coat of 0.04, integrated by hand.
fn under_the_coat(cosine: f64) -> Moments {
    let body = 0.76 * (2.0 / 3.0) * 0.997 * 0.96 * (21.0 / 20.0);
    let leaves = body * (1.0 - (1.0 - cosine).powi(5));
    // ∫ 2 z (1 - (1 - z)⁵) dz and ∫ 2 z² (1 - (1 - z)⁵) dz
    [[leaves * 20.0 / 21.0, leaves * 2.0 * (1.0 / 3.0 - 1.0 / 168.0), 0.0], [0.0; 3]]
}

/// All rough models of a surface from above, with facets and with what they have besides.
fn models(surface: Surface, o: DVec3) -> Vec<(Box<dyn Bsdf>, Facet, Moments)> {
    let distribution = surface.microfacets();
    let conductor = Reflectance::conductor(Rgb::splat(0.4), Rgb::splat(2.5)).unwrap();
    let glass = |eta| RoughDielectric::new(eta, distribution).unwrap();
    let plain = Moments::default();
    let mut models = vec![
        (boxed(RoughConductor::new(conductor, distribution)), Facet::Mirror(metal), plain),
        (boxed(glass(1.5)), Facet::Glass(1.5), plain),
        (boxed(glass(1.0 / 1.5)), Facet::Glass(1.0 / 1.5), plain),
    ];
    let (x, y) = surface.alpha;
    if x == y && !surface.is_gaussian {
        let coated = boxed(metallic_roughness(x));
        models.push((coated, Facet::Mirror(schlick), under_the_coat(o.z)));
    }
    models
}

/// Moments of the power that samples carry, from independent replications of a jittered grid.
fn sampled(bsdf: &dyn Bsdf, fixed: DVec3, mode: TransportMode, seed: u64) -> [[Estimate; 3]; 2] {
    const N: u32 = 64;
    let mut sampler = Independent::new(seed);
    let mut estimates = Default::default();
    for _ in 0..32 {
        let mut moments = Moments::default();
        let shift = sampler.next_1d();
        for (k, u2) in (0..N * N).zip(jittered(N, &mut sampler)) {
            // multiples of the golden ratio, spread over any part of the grid
            let u1 = (shift + 0.618_033_988_749_894_9 * f64::from(k)).fract();
            if let Some(sample) = bsdf.sample(fixed, mode, u1, u2) {
                let squared = sample.relative_ior * sample.relative_ior;
                let n2 = if mode == TransportMode::Radiance { squared } else { 1.0 };
                add(&mut moments, sample.next, sample.weight.g() * n2 / f64::from(N * N));
            }
        }
        push(&mut estimates, &moments);
    }
    estimates
}

fn push(estimates: &mut [[Estimate; 3]; 2], moments: &Moments) {
    for (estimate, moment) in estimates.iter_mut().flatten().zip(moments.iter().flatten()) {
        estimate.push(*moment);
    }
}

/// Moments of `∫ f dσ⊥` over both hemispheres by the midpoint rule, refraction's n² taken out.
fn integrated(bsdf: &dyn Bsdf, to_camera: DVec3, n2: f64) -> Moments {
    const N: u32 = 300;
    let mut moments = Moments::default();
    for cell in 0..2 * N * N {
        let z = (f64::from(cell / N) + 0.5) / f64::from(N) - 1.0;
        let to_light = direction(z, TAU * (f64::from(cell % N) + 0.5) / f64::from(N));
        let power = bsdf.eval(to_light, to_camera).g() * z.abs() * TAU / f64::from(N * N);
        add(&mut moments, to_light, power * if z < 0.0 { n2 } else { 1.0 });
    }
    moments
}

/// Samples within 4 standard errors, of 0.1 % of what is scattered at most; values within 0.1 % of
/// it. On a walk from a light, too, where the same power is carried.
#[test]
fn rough_models_are_the_integral_over_micro_normals() {
    let mut seed = 0;
    for surface in Surface::all() {
        for cosine in [0.9, 0.5, 0.2] {
            let o = direction(cosine, 0.4);
            for (bsdf, facet, rest) in models(surface, o) {
                let mut expected = surface.moments(facet, o);
                for (moment, rest) in expected.iter_mut().flatten().zip(rest.iter().flatten()) {
                    *moment += rest;
                }
                let n2 = if let Facet::Glass(eta) = facet { eta * eta } else { 1.0 };
                let values = integrated(&*bsdf, o, n2);
                let all = expected[0][0] + expected[1][0];
                for mode in [TransportMode::Radiance, TransportMode::Importance] {
                    seed += 1;
                    let samples = sampled(&*bsdf, o, mode, seed);
                    for k in 0..6 {
                        let (side, g) = (k / 3, k % 3);
                        let (expected, sample) = (expected[side][g], samples[side][g]);
                        let what = || {
                            format!(
                                "{surface:?} {facet:?} {cosine} {mode:?}, moment {k}: {expected}"
                            )
                        };
                        let (off, error) = (sample.mean() - expected, sample.standard_error());
                        assert!(off.abs() < 4.0 * error + 1e-6 * all, "{} {sample:?}", what());
                        assert!(error < 1e-3 * all, "{} {sample:?}", what());
                        let value = values[side][g];
                        assert!((value - expected).abs() < 1e-3 * all, "{} {value}", what());
                    }
                }
            }
        }
    }
}

/// Reflected and refracted power within 4 standard errors, of 0.2 % of their sum at most.
#[test]
fn rough_glass_is_the_first_event_of_walks_on_the_surface() {
    let mut seed = 100;
    for surface in Surface::all() {
        for (cosine, eta) in [(0.2, 1.5), (0.5, 1.5), (0.7, 1.0 / 1.5)] {
            seed += 1;
            let (o, mut sampler) = (direction(cosine, 0.4), Independent::new(seed));
            let mut walks = <[[Estimate; 3]; 2]>::default();
            for _ in 0..32 {
                push(&mut walks, &surface.walks(Facet::Glass(eta), o, &mut sampler));
            }
            let glass = RoughDielectric::new(eta, surface.microfacets()).unwrap();
            let samples = sampled(&glass, o, TransportMode::Importance, seed);
            let all = walks[0][0].mean() + walks[1][0].mean();
            for side in 0..2 {
                let (walk, sample) = (walks[side][0], samples[side][0]);
                let error = walk.standard_error().hypot(sample.standard_error());
                let what = format!("{surface:?} {cosine} {eta} {side}: {walk:?} {sample:?}");
                assert!((walk.mean() - sample.mean()).abs() < 4.0 * error, "{what}");
                assert!(error < 2e-3 * all, "{what}");
            }
        }
    }
}
