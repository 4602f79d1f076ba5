//! The models under test.

use pathspace::bsdf::fresnel::Reflectance;
use pathspace::bsdf::*;
use pathspace::math::Rgb;

const ROUGHNESS: [(f64, f64); 4] = [(0.05, 0.05), (0.3, 0.3), (1.0, 1.0), (0.1, 0.5)];

pub fn lambert() -> SimpleModel {
    Lambert::new(Rgb::new(0.2, 0.5, 0.9)).unwrap().into()
}

fn glass(relative_ior: f64) -> SimpleModel {
    Dielectric::new(relative_ior).unwrap().into()
}

fn gold() -> Reflectance {
    Reflectance::conductor(Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6)).unwrap()
}

pub fn rough_conductor(alpha: (f64, f64)) -> SimpleModel {
    RoughConductor::new(gold(), Ggx::new(alpha.0, alpha.1).unwrap()).into()
}

pub fn rough_glass(relative_ior: f64, alpha: (f64, f64)) -> SimpleModel {
    RoughDielectric::new(relative_ior, Ggx::new(alpha.0, alpha.1).unwrap()).unwrap().into()
}

fn beckmann(alpha: (f64, f64)) -> Beckmann {
    Beckmann::new(alpha.0, alpha.1).unwrap()
}

fn plastic(specular: Rgb, colour_shift: bool) -> SimpleModel {
    Plastic::new(Rgb::new(0.2, 0.5, 0.9), specular, 1.5, colour_shift).unwrap().into()
}

fn metallic_roughness(metalness: f64, roughness: f64) -> SimpleModel {
    MetallicRoughness::new(Rgb::new(0.2, 0.5, 0.9), metalness, roughness, 1.5).unwrap().into()
}

fn pane() -> SimpleModel {
    ThinDielectric::new(1.5).unwrap().into()
}

pub fn smooth_models() -> Vec<(String, Model)> {
    let mirror: SimpleModel = Mirror::new(Rgb::new(0.3, 0.6, 1.0)).unwrap().into();
    let conductor: SimpleModel =
        Conductor::new(Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6)).unwrap().into();
    let mixture = |components, weights| Mixture::new(components, weights).unwrap();
    let rough = rough_conductor((0.3, 0.3));
    let probabilities = Mixture::with_probabilities(
        [glass(1.5), rough_glass(1.5, (0.3, 0.2))],
        [0.6, 0.4],
        [3.0, 1.0],
    )
    .unwrap();
    [
        ("lambert", lambert().into()),
        ("mirror", mirror.into()),
        ("conductor", conductor.into()),
        ("glass 1.5", glass(1.5).into()),
        ("glass 1/1.33", glass(1.0 / 1.33).into()),
        ("glass 1", glass(1.0).into()),
        ("null", Null.into()),
        ("black", Model::BLACK),
        ("pane", pane().into()),
        ("smooth metallic-roughness", metallic_roughness(0.3, 0.0).into()),
        ("smooth metallic-roughness metal", metallic_roughness(1.0, 0.005).into()),
        (
            "smooth metallic-roughness + mirror",
            mixture([metallic_roughness(0.3, 0.0), mirror], [0.5, 0.5]).into(),
        ),
        ("plastic", plastic(Rgb::WHITE, false).into()),
        ("saturated plastic", plastic(Rgb::new(0.5, 1.0, 0.0), true).into()),
        ("plastic + pane", mixture([plastic(Rgb::WHITE, true), pane()], [0.5, 0.5]).into()),
        (
            "tinted conductor",
            Mixture::tinted([conductor], [Rgb::new(0.0, 0.3, 1.0)], [1.0]).unwrap().into(),
        ),
        (
            "tinted mixture",
            Mixture::tinted([lambert(), rough], [Rgb::new(0.0, 0.3, 1.0), Rgb::BLACK], [0.7, 0.2])
                .unwrap()
                .into(),
        ),
        ("lambert + mirror", mixture([lambert(), mirror], [0.5, 0.5]).into()),
        ("lambert + glass", mixture([lambert(), glass(1.5)], [0.3, 0.7]).into()),
        ("lambert + rough", mixture([lambert(), rough], [0.6, 0.4]).into()),
        ("mirror + glass", mixture([mirror, glass(1.5)], [0.5, 0.25]).into()),
        ("null + conductor", mixture([Null.into(), conductor], [0.5, 0.5]).into()),
        ("glass + rough glass", probabilities.into()),
    ]
    .map(|(name, model)| (name.to_owned(), model))
    .into()
}

pub fn rough_models() -> Vec<(String, Model)> {
    let mut models = Vec::new();
    for alpha in ROUGHNESS {
        models.push((format!("rough conductor {alpha:?}"), rough_conductor(alpha).into()));
        models.push((
            format!("Beckmann conductor {alpha:?}"),
            SimpleModel::from(RoughConductor::new(gold(), beckmann(alpha))).into(),
        ));
        let glass = RoughDielectric::new(1.5, beckmann(alpha)).unwrap();
        models.push((format!("Beckmann glass {alpha:?}"), SimpleModel::from(glass).into()));
        if alpha.0 == alpha.1 {
            for metalness in [0.0, 0.4, 1.0] {
                models.push((
                    format!("metallic-roughness {metalness} {alpha:?}"),
                    metallic_roughness(metalness, alpha.0.sqrt()).into(),
                ));
            }
        }
        // from both sides, so that the inverse indices are covered
        for relative_ior in [1.5, 1.05] {
            models.push((
                format!("rough glass {relative_ior} {alpha:?}"),
                rough_glass(relative_ior, alpha).into(),
            ));
        }
    }
    models
}
