//! Shading normals of maps: what is behind them, and where their light ends.
//!
//! Half of what a normal map shows at grazing angles has its shading normal turned away from the
//! camera, and would be black. Whoever looks from there sees the slope on the other side: the
//! shading normal `n_s` turned by 180° around the geometric one (Schüssler et al. 2017, figure 4b).
//! So with `R` that turn, the surface has the BSDF
//!
//! ```text
//! f'(to_light, to_camera) = g(to_light) f_s(to_light, to_camera)        if n_s faces to_camera
//!                         = g(to_light) f_s(R to_light, R to_camera)    otherwise
//! ```
//!
//! where `f_s` is what any shading normal makes of the model and `g` the shadow that slopes throw
//! (Conty Estevez, Lecocq and Stein 2019, equation 3): without it light would end along a hard edge
//! where it goes down behind the surface, not behind the slope. Both are as in the renderer
//! Mitsuba.
//!
//! The turn depends on the direction to the camera alone, of the labelled pair, and so it is the
//! same function whichever way a path is traced. A camera walk knows that direction; a light walk
//! turns with the probability `(1 - n_s · n_g) / 2`, the share of the projected hemisphere that
//! `n_s` faces away from, and ends where the direction that it finds is none of those that see
//! what it sampled.

use super::ShadedBsdf;
use crate::bsdf::{Bsdf, BsdfSample, DiracValue, TransportMode};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// The cosine of the angle below which a direction passes straight through: the surface is not
/// there, and its slopes throw no shadow.
const STRAIGHT: f64 = 1.0 - 1e-12;

/// Light and camera of a fixed and a sampled direction, or the other way round.
fn labelled<T>(fixed: T, next: T, mode: TransportMode) -> [T; 2] {
    match mode {
        TransportMode::Radiance => [next, fixed],
        TransportMode::Importance => [fixed, next],
    }
}

impl<B: Bsdf> ShadedBsdf<B> {
    #[inline(never)]
    pub(super) fn eval_mapped(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let is_turned = self.faces_away(to_camera);
        let [light, camera] = [to_light, to_camera].map(|w| self.turned_if(is_turned, w));
        self.eval_unmapped(light, camera) * self.lit_share(to_light, to_camera)
    }

    #[inline(never)]
    pub(super) fn pdf_mapped(
        &self,
        fixed: DVec3,
        next: DVec3,
        mode: TransportMode,
    ) -> PerProjected {
        let [_, to_camera] = labelled(fixed, next, mode);
        let is_turned = self.faces_away(to_camera);
        let [fixed, next] = [fixed, next].map(|w| self.turned_if(is_turned, w));
        self.pdf_unmapped(fixed, next, mode) * self.probability(is_turned, mode)
    }

    #[inline(never)]
    pub(super) fn sample_mapped(
        &self,
        fixed: DVec3,
        mode: TransportMode,
        u1: f64,
        u2: DVec2,
    ) -> Option<BsdfSample> {
        let (is_turned, u1) = match mode {
            TransportMode::Radiance => (self.faces_away(fixed), u1),
            TransportMode::Importance => {
                let turning = self.turning();
                let rest = |u: f64, share: f64| (u / share).min(1.0f64.next_down());
                if u1 < turning {
                    (true, rest(u1, turning))
                } else {
                    (false, rest(u1 - turning, 1.0 - turning))
                }
            }
        };
        let sample = self.sample_unmapped(self.turned_if(is_turned, fixed), mode, u1, u2)?;
        self.seen(sample, fixed, is_turned, mode)
    }

    pub(super) fn dirac_images_mapped(
        &self,
        fixed: DVec3,
        mode: TransportMode,
        image: &mut dyn FnMut(BsdfSample),
    ) {
        for is_turned in [false, true] {
            if mode == TransportMode::Importance || is_turned == self.faces_away(fixed) {
                let turned = self.turned_if(is_turned, fixed);
                self.dirac_images_unmapped(turned, mode, &mut |sample| {
                    self.seen(sample, fixed, is_turned, mode).into_iter().for_each(&mut *image);
                });
            }
        }
    }

    pub(super) fn eval_dirac_mapped(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let is_turned = self.faces_away(to_camera);
        let [light, camera] = [to_light, to_camera].map(|w| self.turned_if(is_turned, w));
        let DiracValue { value, pdf_to_light, pdf_to_camera } =
            self.eval_dirac_unmapped(light, camera);
        DiracValue {
            value: value * self.lit_share(to_light, to_camera),
            pdf_to_light,
            pdf_to_camera: pdf_to_camera * self.probability(is_turned, TransportMode::Importance),
        }
    }

    /// A sample of the turned surface or of the other one; `None` if whoever looks from there sees
    /// the one that was not sampled.
    fn seen(
        &self,
        sample: BsdfSample,
        fixed: DVec3,
        is_turned: bool,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        // Straight through stays the same to the last bit.
        let is_straight = sample.next == -self.turned_if(is_turned, fixed);
        let next = if is_straight { -fixed } else { self.turned_if(is_turned, sample.next) };
        let [to_light, to_camera] = labelled(fixed, next, mode);
        if self.faces_away(to_camera) != is_turned {
            return None;
        }
        let reverse = match mode {
            TransportMode::Radiance => TransportMode::Importance,
            TransportMode::Importance => TransportMode::Radiance,
        };
        let probability = self.probability(is_turned, mode);
        Some(BsdfSample {
            next,
            weight: sample.weight * (self.lit_share(to_light, to_camera) / probability),
            pdf: sample.pdf * probability,
            pdf_reverse: sample.pdf_reverse * self.probability(is_turned, reverse),
            ..sample
        })
    }

    /// True if the two normals see a direction on different sides.
    fn faces_away(&self, direction: DVec3) -> bool {
        self.frame.z.dot(direction) * self.geometric_normal.dot(direction) <= 0.0
    }

    fn turned_if(&self, is_turned: bool, direction: DVec3) -> DVec3 {
        let normal = self.geometric_normal;
        if is_turned { normal * (2.0 * normal.dot(direction)) - direction } else { direction }
    }

    /// The probability with which a light walk samples the turned surface.
    fn turning(&self) -> f64 {
        0.5 * (1.0 - self.frame.z.dot(self.geometric_normal)).max(0.0)
    }

    /// The probability of sampling the surface that is seen.
    fn probability(&self, is_turned: bool, mode: TransportMode) -> f64 {
        match (mode, is_turned) {
            (TransportMode::Radiance, _) => 1.0,
            (TransportMode::Importance, true) => self.turning(),
            (TransportMode::Importance, false) => 1.0 - self.turning(),
        }
    }

    /// The share of the light that no slope keeps off.
    fn lit_share(&self, to_light: DVec3, to_camera: DVec3) -> f64 {
        if -to_light.dot(to_camera) > STRAIGHT {
            return 1.0;
        }
        let squared_tangent = |cosine: f64| {
            let square = (cosine * cosine).min(1.0);
            (1.0 - square) / square.max(f64::MIN_POSITIVE)
        };
        let slope = squared_tangent(self.frame.z.dot(self.geometric_normal));
        let incidence = squared_tangent(self.geometric_normal.dot(to_light));
        2.0 / (1.0 + (1.0 + (0.125 * slope).min(1.0) * incidence).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{
        Dielectric, Ggx, Lambert, Microfacets, Mirror, Mixture, Model, Null, Plastic, Reflectance,
        RoughConductor, RoughDielectric,
    };
    use crate::geometry::{NormalOrigin, SurfacePoint};
    use crate::math::warp;
    use crate::sampler::{Independent, SampleSource, Sampler};
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn mapped<B: Bsdf>(model: B, tilt: f64) -> ShadedBsdf<B> {
        let (sin, cos) = tilt.to_radians().sin_cos();
        let point = SurfacePoint {
            shading_normal: DVec3::new(0.6 * sin, 0.8 * sin, cos),
            normal_origin: NormalOrigin::Map,
            ..SurfacePoint::on_surface(DVec3::ZERO, 0.0, DVec3::Z)
        };
        ShadedBsdf::new(model, &point)
    }

    fn models() -> Vec<(&'static str, Mixture<Model, 2>)> {
        let alone = |model: Model| Mixture::new([model, Model::Black], [1.0, 0.0]).expect("valid");
        let rough = |alpha| Microfacets::Ggx(Ggx::new(alpha, alpha).expect("valid"));
        let metal = Reflectance::constant(Rgb::splat(0.9)).expect("valid");
        let glass = Dielectric::new(1.4).expect("valid").into();
        let plastic = Plastic::new(Rgb::splat(0.7), Rgb::WHITE, 1.5, false).expect("valid");
        let frosted = RoughDielectric::new(1.4, rough(0.4)).expect("valid").into();
        vec![
            ("lambert", alone(Lambert::new(Rgb::splat(0.8)).expect("valid").into())),
            ("metal", alone(RoughConductor::new(metal, rough(0.3)).into())),
            ("mirror", alone(Mirror::new(Rgb::splat(0.9)).expect("valid").into())),
            ("plastic", alone(plastic.into())),
            ("frosted", alone(frosted)),
            ("veil", Mixture::new([Null.into(), glass], [0.4, 0.6]).expect("valid")),
        ]
    }

    /// The integral of f' and some function over both directions, per projected solid angle, from
    /// samples of walks of one kind: mean and variance of the mean.
    fn integral<B: Bsdf>(bsdf: &ShadedBsdf<B>, mode: TransportMode, seed: u64) -> (f64, f64) {
        const SAMPLES: u32 = 1_000_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for index in 0..SAMPLES {
            let mut sampler = Independent { seed }.sampler(index, 0);
            let up = warp::square_to_cosine_hemisphere(sampler.next_2d());
            let fixed = if sampler.next_1d() < 0.5 { up } else { -up };
            let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
            let Some(sample) = bsdf.sample(fixed, mode, u1, u2) else { continue };
            let [light, camera] = labelled(fixed, sample.next, mode);
            let value = sample.weight.g() * (1.0 + light.x * camera.y - 0.5 * camera.x + light.z);
            let value = 2.0 * PI * value;
            (sum, squares) = (sum + value, squares + value * value);
        }
        let n = f64::from(SAMPLES);
        let mean = sum / n;
        (mean, (squares / n - mean * mean) / n)
    }

    /// f' is one function: walks from the camera and from lights find the same integral.
    #[test]
    fn walks_from_both_ends_find_the_same() {
        for (name, model) in models() {
            for tilt in [5.0, 30.0, 60.0] {
                let bsdf = mapped(model, tilt);
                let (a, a_variance) = integral(&bsdf, TransportMode::Radiance, 1);
                let (b, b_variance) = integral(&bsdf, TransportMode::Importance, 2);
                let error = (a_variance + b_variance).sqrt();
                println!("{name} {tilt}: {a} {b} {:.4}", error / a);
                assert!((a - b).abs() < 4.0 * error, "{name} {tilt}: {a} {b} ± {error}");
                assert!(error < 0.004 * a, "{name} {tilt}: {a} ± {error}");
            }
        }
    }

    /// Samples carry the weights and densities that are given for their directions.
    #[test]
    fn samples_are_what_is_evaluated() {
        let mut sampler = Independent { seed: 3 }.sampler(0, 0);
        let mut found = [0, 0];
        for (name, model) in models() {
            let bsdf = mapped(model, 50.0);
            for _ in 0..20_000 {
                let fixed = warp::square_to_sphere(sampler.next_2d()).normalize();
                let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
                for (mode, reverse) in [
                    (TransportMode::Radiance, TransportMode::Importance),
                    (TransportMode::Importance, TransportMode::Radiance),
                ] {
                    let Some(sample) = bsdf.sample(fixed, mode, u1, u2) else { continue };
                    let [light, camera] = labelled(fixed, sample.next, mode);
                    let close = |a: f64, b: f64| {
                        assert_relative_eq!(a, b, max_relative = 1e-8, epsilon = 1e-12);
                    };
                    found[usize::from(bsdf.faces_away(camera))] += 1;
                    if sample.dirac {
                        let (own, there) =
                            (sample.dirac_value(mode), bsdf.eval_dirac(light, camera));
                        close(own.value.g(), there.value.g());
                        close(own.pdf_to_light.value(), there.pdf_to_light.value());
                        close(own.pdf_to_camera.value(), there.pdf_to_camera.value());
                        let mut total = 0;
                        bsdf.dirac_images(fixed, mode, &mut |image| {
                            total += usize::from(image.next.distance(sample.next) < 1e-12);
                        });
                        assert_eq!(total, 1, "{name}");
                    } else {
                        let value = sample.weight.g() * sample.pdf.value();
                        close(value, bsdf.eval(light, camera).g());
                        close(sample.pdf.value(), bsdf.pdf(fixed, sample.next, mode).value());
                        let back = bsdf.pdf(sample.next, fixed, reverse);
                        close(sample.pdf_reverse.value(), back.value());
                    }
                }
            }
        }
        assert!(found.iter().all(|count| *count > 1000), "{found:?}");
    }
}
