//! The check itself: it finds deliberate faults, and copes with a model that scatters nothing.

use crate::models::rough_glass;
use crate::{Independent, direction};
use glam::{DVec2, DVec3};
use pathspace::bsdf::check::{Failure, Report, check};
use pathspace::bsdf::*;
use pathspace::math::{PerProjected, Rgb};

/// A model with one deliberate fault, which the check must find.
#[derive(Clone, Copy)]
enum Fault {
    Density,
    SampledDensity,
    Squeeze,
    Weight,
    Direction,
    Energy,
    Reverse,
    ValueTogether,
    DensityTogether,
}

struct Faulty(Model, Fault);

impl Bsdf for Faulty {
    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let value = self.0.eval(to_light, to_camera);
        match self.1 {
            // refraction without n_c²: 1.5 inside
            Fault::Squeeze if to_camera.z < 0.0 && to_light.z > 0.0 => value / 2.25,
            Fault::Energy => value * 1.2,
            _ => value,
        }
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        let pdf = self.0.pdf(fixed, next, mode);
        if matches!(self.1, Fault::Density | Fault::SampledDensity) { pdf * 1.01 } else { pdf }
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let (value, pdf) = (
            self.eval(to_light, to_camera),
            self.pdf(to_camera, to_light, TransportMode::Radiance),
        );
        match self.1 {
            Fault::ValueTogether => (value * 1.00001, pdf),
            Fault::DensityTogether => (value, pdf * 1.00001),
            _ => (value, pdf),
        }
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let u2 =
            if matches!(self.1, Fault::Direction) { DVec2::new(u2.x, u2.y.powf(1.1)) } else { u2 };
        let mut sample = self.0.sample(fixed, mode, u1, u2)?;
        match self.1 {
            Fault::SampledDensity => {
                sample.pdf = sample.pdf * 1.01;
                sample.pdf_reverse = sample.pdf_reverse * 1.01;
                sample.weight = sample.weight / 1.01;
            }
            Fault::Weight => sample.weight *= 1.00001,
            Fault::Energy => sample.weight *= 1.2,
            Fault::Reverse => sample.pdf_reverse = sample.pdf,
            _ => {}
        }
        Some(sample)
    }
}

#[test]
fn faults_are_found() {
    let faults = |relative_ior: f64, fault: Fault, cosine: f64| -> Option<Failure> {
        let model = Faulty(rough_glass(relative_ior, (0.3, 0.3)), fault);
        check(
            &model,
            direction(cosine, 0.4),
            TransportMode::Importance,
            &mut Independent::new(1),
            100_000,
        )
        .verdict(0.01, 1)
        .err()
    };
    assert!(matches!(faults(1.5, Fault::Density, 0.7), Some(Failure::Pdf(_))));
    assert!(matches!(
        faults(1.5, Fault::SampledDensity, 0.7),
        Some(Failure::Density(_) | Failure::Normalization(_))
    ));
    assert!(matches!(
        faults(1.5, Fault::Squeeze, 0.7),
        Some(Failure::Weight(_) | Failure::Reciprocity(_))
    ));
    assert!(matches!(faults(1.5, Fault::Weight, 0.7), Some(Failure::Weight(_))));
    assert!(matches!(faults(1.5, Fault::Direction, 0.7), Some(Failure::Density(_))));
    assert!(matches!(faults(1.5, Fault::Energy, 0.7), Some(Failure::Energy(..))));
    assert!(matches!(faults(1.5, Fault::Reverse, 0.7), Some(Failure::PdfReverse(_))));
    assert!(matches!(faults(1.5, Fault::ValueTogether, 0.7), Some(Failure::Weight(_))));
    assert!(matches!(faults(1.5, Fault::DensityTogether, 0.7), Some(Failure::Pdf(_))));
}

/// Smooth refraction without n² in the weight of a camera walk.
struct Unsqueezed(Dielectric);

impl Bsdf for Unsqueezed {
    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        self.0.sample(fixed, mode, u1, u2).map(|sample| BsdfSample { weight: Rgb::WHITE, ..sample })
    }
    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        self.0.dirac_images(fixed, mode, image);
    }
}

#[test]
fn missing_squeeze_of_smooth_glass_is_found() {
    let model = Unsqueezed(Dielectric::new(1.5).unwrap());
    let report = |mode| {
        check(&model, direction(0.7, 0.0), mode, &mut Independent::new(1), 1000).verdict(0.01, 1)
    };
    assert!(matches!(report(TransportMode::Radiance), Err(Failure::Weight(_))));
    assert_eq!(report(TransportMode::Importance), Ok(()));
}

#[test]
fn report_of_an_absorber_is_empty() {
    let report: Report =
        check(&Model::Black, DVec3::Z, TransportMode::Radiance, &mut Independent::new(1), 100);
    assert_eq!(
        (report.pdf_integral, report.finite_share.mean(), report.verdict(0.01, 1)),
        (0.0, 0.0, Ok(()))
    );
}
