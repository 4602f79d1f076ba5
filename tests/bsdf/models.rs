//! The models under test.

use pathspace::bsdf::fresnel::Reflectance;
use pathspace::bsdf::*;
use pathspace::math::Rgb;

pub fn boxed(bsdf: impl Bsdf + 'static) -> Box<dyn Bsdf> {
    Box::new(bsdf)
}

const ROUGHNESS: [(f64, f64); 4] = [(0.05, 0.05), (0.3, 0.3), (1.0, 1.0), (0.1, 0.5)];

pub fn lambert() -> Model {
    Lambert::new(Rgb::new(0.2, 0.5, 0.9)).unwrap().into()
}

fn glass(relative_ior: f64) -> Model {
    Dielectric::new(relative_ior).unwrap().into()
}

fn gold() -> Reflectance {
    Reflectance::conductor(Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6)).unwrap()
}

pub fn rough_conductor(alpha: (f64, f64)) -> Model {
    RoughConductor::new(gold(), Ggx::new(alpha.0, alpha.1).unwrap()).into()
}

pub fn rough_glass(relative_ior: f64, alpha: (f64, f64)) -> Model {
    RoughDielectric::new(relative_ior, Ggx::new(alpha.0, alpha.1).unwrap()).unwrap().into()
}

fn beckmann(alpha: (f64, f64)) -> Beckmann {
    Beckmann::new(alpha.0, alpha.1).unwrap()
}

fn plastic(specular: Rgb, colour_shift: bool) -> Model {
    Plastic::new(Rgb::new(0.2, 0.5, 0.9), specular, 1.5, colour_shift).unwrap().into()
}

fn rough_plastic(colour_shift: bool, distribution: impl Into<Microfacets>) -> Model {
    let (albedo, specular) = (Rgb::new(0.2, 0.5, 0.9), Rgb::new(1.0, 0.8, 0.6));
    RoughPlastic::new(albedo, specular, 1.5, colour_shift, distribution).unwrap().into()
}

fn metallic_roughness(metalness: f64, roughness: f64) -> Model {
    MetallicRoughness::new(Rgb::new(0.2, 0.5, 0.9), metalness, roughness, 1.5).unwrap().into()
}

fn coated(base: Model, share: f64, roughness: f64) -> Coated<Model> {
    Coated::new(base, share, roughness).unwrap()
}

fn pane() -> Model {
    ThinDielectric::new(1.5).unwrap().into()
}

pub fn smooth_models() -> Vec<(String, Box<dyn Bsdf>)> {
    let mirror: Model = Mirror::new(Rgb::new(0.3, 0.6, 1.0)).unwrap().into();
    let conductor: Model =
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
        ("lambert", boxed(lambert())),
        ("mirror", boxed(mirror)),
        ("conductor", boxed(conductor)),
        ("glass 1.5", boxed(glass(1.5))),
        ("glass 1/1.33", boxed(glass(1.0 / 1.33))),
        ("glass 1", boxed(glass(1.0))),
        ("null", boxed(Null)),
        ("black", boxed(Model::Black)),
        ("pane", boxed(pane())),
        ("smooth metallic-roughness", boxed(metallic_roughness(0.3, 0.0))),
        ("smooth metallic-roughness metal", boxed(metallic_roughness(1.0, 0.005))),
        (
            "smooth metallic-roughness + mirror",
            boxed(mixture([metallic_roughness(0.3, 0.0), mirror], [0.5, 0.5])),
        ),
        ("smooth coat over lambert", boxed(coated(lambert(), 0.7, 0.0))),
        ("smooth coat over conductor", boxed(coated(conductor, 1.0, 0.0))),
        ("smooth coat over glass", boxed(coated(glass(1.5), 0.5, 0.0))),
        ("plastic", boxed(plastic(Rgb::WHITE, false))),
        ("saturated plastic", boxed(plastic(Rgb::new(0.5, 1.0, 0.0), true))),
        ("plastic + pane", boxed(mixture([plastic(Rgb::WHITE, true), pane()], [0.5, 0.5]))),
        (
            "tinted conductor",
            boxed(Mixture::tinted([conductor], [Rgb::new(0.0, 0.3, 1.0)], [1.0]).unwrap()),
        ),
        (
            "tinted mixture",
            boxed(
                Mixture::tinted(
                    [lambert(), rough],
                    [Rgb::new(0.0, 0.3, 1.0), Rgb::BLACK],
                    [0.7, 0.2],
                )
                .unwrap(),
            ),
        ),
        ("lambert + mirror", boxed(mixture([lambert(), mirror], [0.5, 0.5]))),
        ("lambert + glass", boxed(mixture([lambert(), glass(1.5)], [0.3, 0.7]))),
        ("lambert + rough", boxed(mixture([lambert(), rough], [0.6, 0.4]))),
        ("mirror + glass", boxed(mixture([mirror, glass(1.5)], [0.5, 0.25]))),
        ("null + conductor", boxed(mixture([Null.into(), conductor], [0.5, 0.5]))),
        ("glass + rough glass", boxed(probabilities)),
    ]
    .map(|(name, model)| (name.to_owned(), model))
    .into()
}

/// The principled BSDF with all its lobes, of a colour that leaves room for them.
fn principled(metalness: f64, roughness: f64, lobes: PrincipledLobes) -> Model {
    Principled::new(Rgb::new(0.1, 0.3, 0.6), metalness, roughness, lobes).unwrap().into()
}

/// Principled models: everything that reflects, and glass that is also all the rest.
fn principled_models() -> Vec<(String, Box<dyn Bsdf>)> {
    let reflecting = PrincipledLobes {
        anisotropy: 0.6,
        specular_tint: 0.5,
        sheen: 0.3,
        sheen_tint: 0.5,
        flatness: 0.5,
        clearcoat: 0.8,
        ..PrincipledLobes::default()
    };
    let mixed = PrincipledLobes { transmission: 0.5, relative_ior: 1.4, ..reflecting };
    let glass = PrincipledLobes { transmission: 1.0, ..PrincipledLobes::default() };
    [
        ("principled", principled(0.3, 0.5, reflecting)),
        ("principled metal", principled(1.0, 0.4, PrincipledLobes::default())),
        ("principled body", principled(0.0, 0.9, PrincipledLobes::default())),
        ("principled with refraction", principled(0.2, 0.6, mixed)),
        ("principled glass", principled(0.0, 0.5, glass)),
        (
            "principled glass, thinner inside",
            principled(0.0, 0.7, PrincipledLobes { relative_ior: 0.8, ..glass }),
        ),
    ]
    .map(|(name, model)| (name.to_owned(), boxed(model)))
    .into()
}

pub fn rough_models() -> Vec<(String, Box<dyn Bsdf>)> {
    let mut models = principled_models();
    let coats = [
        ("smooth coat over metallic-roughness", metallic_roughness(0.4, 0.6), 0.0),
        ("coat over metallic-roughness", metallic_roughness(0.4, 0.6), 0.3),
        ("coat over smooth metallic-roughness", metallic_roughness(0.4, 0.0), 0.5),
        ("coat over rough glass", rough_glass(1.5, (0.3, 0.3)), 0.6),
        ("coat over black", Model::Black, 0.6),
    ];
    let coats =
        coats.map(|(name, base, roughness)| (name.to_owned(), boxed(coated(base, 0.8, roughness))));
    models.extend(coats);
    for alpha in ROUGHNESS {
        models.push((format!("rough conductor {alpha:?}"), boxed(rough_conductor(alpha))));
        models.push((
            format!("Beckmann conductor {alpha:?}"),
            boxed(RoughConductor::new(gold(), beckmann(alpha))),
        ));
        let independent = Ggx::new(alpha.0, alpha.1).unwrap().with_independent_masking();
        models.push((
            format!("conductor with independent masking {alpha:?}"),
            boxed(RoughConductor::new(gold(), independent)),
        ));
        let glass = RoughDielectric::new(1.5, independent).unwrap();
        models.push((format!("glass with independent masking {alpha:?}"), boxed(glass)));
        let glass = RoughDielectric::new(1.5, beckmann(alpha)).unwrap();
        models.push((format!("Beckmann glass {alpha:?}"), boxed(glass)));
        if alpha.0 == alpha.1 {
            let ggx = rough_plastic(false, Ggx::isotropic(alpha.0).unwrap());
            models.push((format!("rough plastic {alpha:?}"), boxed(ggx)));
            let plastic = rough_plastic(true, beckmann(alpha));
            models.push((format!("Beckmann plastic {alpha:?}"), boxed(plastic)));
            for metalness in [0.0, 0.4, 1.0] {
                models.push((
                    format!("metallic-roughness {metalness} {alpha:?}"),
                    boxed(metallic_roughness(metalness, alpha.0.sqrt())),
                ));
            }
        }
        // from both sides, so that the inverse indices are covered
        for relative_ior in [1.5, 1.05] {
            models.push((
                format!("rough glass {relative_ior} {alpha:?}"),
                boxed(rough_glass(relative_ior, alpha)),
            ));
        }
    }
    models
}
