//! Every scattering model against its own density, its reciprocity, its energy and the exact
//! answers; the rough ones against the micro-surfaces that they stand for.

#[path = "bsdf/coated.rs"]
mod coated;
#[path = "bsdf/culled.rs"]
mod culled;
#[path = "bsdf/every_model.rs"]
mod every_model;
#[path = "bsdf/exact.rs"]
mod exact;
#[path = "bsdf/faults.rs"]
mod faults;
#[path = "bsdf/images.rs"]
mod images;
#[path = "bsdf/microfacets.rs"]
mod microfacets;
#[path = "bsdf/models.rs"]
mod models;

use glam::DVec3;
use models::lambert;
use pathspace::bsdf::*;
use pathspace::math::Rgb;
use pathspace::sampler::Sampler;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

struct Independent(Pcg64Mcg);

impl Independent {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }
}

impl Sampler for Independent {
    fn next_1d(&mut self) -> f64 {
        self.0.random()
    }
}

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
}

#[test]
fn constructors_refuse_bad_parameters() {
    for bad in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(Lambert::new(Rgb::new(0.5, bad, 0.5)), Err(BsdfError::Reflectance(_))));
        assert!(matches!(Mirror::new(Rgb::splat(bad)), Err(BsdfError::Reflectance(_))));
    }
    for bad in [0.9, -1.5, f64::NAN, f64::INFINITY] {
        let ggx = Ggx::isotropic(0.1).unwrap();
        assert!(Plastic::new(Rgb::WHITE, Rgb::WHITE, bad, false).is_err());
        assert!(RoughPlastic::new(Rgb::WHITE, Rgb::WHITE, bad, false, ggx).is_err());
    }
    for bad in [0.0, -1.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(Dielectric::new(bad), Err(BsdfError::RelativeIor(_))));
        assert!(RoughDielectric::new(bad, Ggx::isotropic(0.1).unwrap()).is_err());
    }
    assert!(matches!(Conductor::new(Rgb::WHITE, Rgb::splat(-1.0)), Err(BsdfError::ComplexIor(..))));
    for bad in [-0.1, 10.5, f64::NAN] {
        assert!(matches!(Ggx::new(0.1, bad), Err(BsdfError::Roughness(..))));
    }
    let pair = [lambert(), lambert()];
    assert!(Mixture::new(pair, [0.0, 0.0]).is_err());
    assert!(Mixture::new(pair, [0.5, -0.1]).is_err());
    assert!(Mixture::new(pair, [0.5, f64::NAN]).is_err());
    assert!(Mixture::with_probabilities(pair, [0.5, 0.5], [1.0, 0.0]).is_err());
    assert!(Mixture::with_probabilities(pair, [0.5, 0.0], [0.0, 0.0]).is_err());
    assert!(Mixture::<Model, 0>::new([], []).is_err());
    assert_eq!(
        Dielectric::new(0.0).unwrap_err().to_string(),
        "relative index of refraction must be in [1e-6, 1e6], but is 0"
    );
}
