//! Paths that integrators cannot draw are named before a rendering, and in its report.

use super::{contestants, go_on};
use pathspace::endpoint::{Camera, PinholeCamera, PointLight, ThinLensCamera};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{
    Adaptive, Bidirectional, LightTracer, Merging, PathTracer, PathTracing, PhotonMapping,
    UniformArea, VertexConnectionMerging, WithNeeds,
};
use pathspace::math::Rgb;
use pathspace::path::DrawnBy;
use pathspace::render::{Budget, Render, Settings};
use pathspace::report::{
    Contestant, Method, Outcome, Plan, Reference, ReferencePlan, Report, SceneInfo, Study, study,
};
use pathspace::scene::{Emission, Material, World, WorldBuilder};

/// A diffuse floor and, if wanted, a mirror behind it, a point light and a square lamp.
fn room(mirror: bool, bulb: bool, lamp: bool) -> World {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let silver = Material::Mirror { reflectance: Rgb::splat(0.9) };
    let silver = builder.add_material("silver", silver).unwrap();
    let mut quad = |name: &str, origin: [f64; 3], edges: [[f64; 3]; 2], material| {
        let [edge_u, edge_v] = edges.map(DVec3::from_array);
        let quad = Quad { origin: DVec3::from_array(origin), edge_u, edge_v };
        builder.add_quad(name, quad, material).unwrap()
    };
    quad("floor", [-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], grey);
    if mirror {
        quad("mirror", [-1.0, 1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0]], silver);
    }
    if lamp {
        let edges = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let lamp = quad("lamp", [-0.5, -0.5, 1.9], edges, grey);
        builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    }
    if bulb {
        let light = PointLight::new(DVec3::new(0.0, 0.2, 0.7), Rgb::WHITE).unwrap();
        builder.add_light("bulb", light).unwrap();
    }
    builder.build().unwrap()
}

const EYE: DVec3 = DVec3::new(0.0, -2.5, 1.0);
const TARGET: DVec3 = DVec3::new(0.0, 0.5, 0.6);

fn pinhole() -> PinholeCamera {
    PinholeCamera::new(EYE, TARGET, DVec3::Z, 40.0, UVec2::splat(16)).unwrap()
}

fn lens() -> ThinLensCamera {
    ThinLensCamera::new(EYE, TARGET, DVec3::Z, 40.0, 0.3, 2.0, UVec2::splat(16)).unwrap()
}

fn missing(world: &World, camera: &dyn Camera, integrator: &dyn Render<World>) -> Vec<String> {
    let missing = integrator.blind_spots(world, camera).unwrap();
    missing.iter().map(ToString::to_string).collect()
}

#[test]
fn what_an_image_will_lack_is_named_before_it_is_rendered() {
    let (pinhole, lens) = (pinhole(), lens());
    let (paths, light, both) =
        (PathTracer::default(), LightTracer::default(), Bidirectional::default());
    let (adaptive, map) = (Adaptive::default(), PhotonMapping::default());
    let merging = VertexConnectionMerging { bidirectional: both, ..Default::default() };
    let area = UniformArea::default();

    let all = room(true, true, true);
    let bulb = "the point light \"bulb\"";
    let image = format!("specular images of {bulb} (L S E, drawn by no integrator here)");
    let images = "specular images of";
    assert_eq!(
        missing(&all, &pinhole, &paths),
        [
            format!("{bulb} seen directly through the lens (L E, drawn by no integrator here)"),
            image.clone(),
            format!("caustics of {bulb} (L S D E)"),
            format!("{images} caustics of {bulb} (L S D S E, drawn by merging alone)"),
            format!("{images} caustics of {bulb} (L S D D S E)"),
        ]
    );
    assert_eq!(
        missing(&all, &pinhole, &light),
        [
            "specular images of the area light \"lamp\" (L S E)".to_owned(),
            format!("{images} surfaces in the light of the area light \"lamp\" (L D S E)"),
            format!("{images} caustics of the area light \"lamp\" (L S D S E)"),
            format!("{bulb} seen directly through the lens (L E, drawn by no integrator here)"),
            image.clone(),
            format!("{images} surfaces in the light of {bulb} (L D S E)"),
            format!("{images} caustics of {bulb} (L S D S E, drawn by merging alone)"),
            format!("{images} caustics of {bulb} (L S D D S E)"),
        ]
    );
    for integrator in [&both as &dyn Render<World>, &adaptive] {
        assert_eq!(
            missing(&all, &pinhole, integrator),
            [
                format!("{bulb} seen directly through the lens (L E, drawn by no integrator here)"),
                image.clone(),
                format!("{images} caustics of {bulb} (L S D S E, drawn by merging alone)"),
            ]
        );
    }
    // A lens of finite area sees it, and merging draws the rest.
    assert_eq!(missing(&all, &lens, &merging), [image.as_str()]);
    assert_eq!(
        missing(&all, &lens, &map),
        [format!("{bulb} seen directly through the lens (L E)"), image.clone()]
    );

    // What a scene does not have is not named: no caustics without Dirac lobes, no lamp without a
    // lamp, and nothing longer than the paths that count.
    let plain = room(false, true, false);
    let directly = format!("{bulb} seen directly through the lens (L E)");
    assert_eq!(missing(&plain, &lens, &paths), [directly.as_str()]);
    assert_eq!(missing(&plain, &lens, &light), <[&str; 0]>::default());
    assert_eq!(missing(&all, &lens, &PathTracer::up_to(0)), [directly.as_str()]);
    let without_bulb = room(true, false, true);
    for integrator in [&paths as &dyn Render<World>, &both, &adaptive, &merging, &map] {
        assert_eq!(missing(&without_bulb, &lens, integrator), <[&str; 0]>::default());
    }
    let hits = PathTracer { mode: PathTracing::EmissionOnly, ..paths };
    assert_eq!(
        missing(&plain, &lens, &hits),
        [directly, format!("light of {bulb} on diffuse and glossy surfaces (L D E)")]
    );
    let lamp = "the area light \"lamp\"";
    assert_eq!(
        missing(&without_bulb, &pinhole, &area),
        [
            format!("specular images of {lamp} (L S E)"),
            format!("caustics of {lamp} (L S D E)"),
            format!("{images} surfaces in the light of {lamp} (L D S E)"),
            format!("light of {lamp} that specular surfaces hand on between others (L D S D E)"),
            format!("{images} caustics of {lamp} (L S D S E)"),
        ]
    );
    // Needs that a scene states without having them name no light that is not there.
    assert_eq!(missing(&without_bulb, &lens, &WithNeeds::all(paths)), <[&str; 0]>::default());

    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 0.2), grey).unwrap();
    for i in 0..7 {
        let light = PointLight::new(DVec3::X * f64::from(i), Rgb::WHITE).unwrap();
        builder.add_light(format!("lamp {i}"), light).unwrap();
    }
    assert_eq!(
        missing(&builder.build().unwrap(), &lens, &paths),
        ["the point lights \"lamp 0\", \"lamp 1\", \"lamp 2\", \"lamp 3\" and 3 more seen \
             directly \
          through the lens (L E)"]
    );
}

fn study_of(
    world: &World,
    camera: &dyn Camera,
    methods: &[(&str, &dyn Method<World>)],
    halves: [usize; 2],
    samples: u32,
) -> Study {
    let mut all = contestants(methods);
    for contestant in &mut all {
        let missing = contestant.method.blind_spots(world, camera).unwrap();
        contestant.complete = missing.iter().all(|paths| paths.drawn_by != DrawnBy::Connections);
    }
    let settings = Settings { seed: 5, ..Plan::default().settings };
    let plan = ReferencePlan { budget: Budget::Samples(2 * samples), runs: 8, settings };
    let halves: [&Contestant<'_, World>; 2] = halves.map(|i| &all[i]);
    let reference = Reference::render(world, camera, halves, &plan, &mut go_on).unwrap();
    let plan = Plan { budget: Budget::Samples(samples), settings, ..Plan::default() };
    study(world, camera, &SceneInfo::default(), &all, reference, &plan, &mut go_on).unwrap()
}

/// The point light that a lens sees directly is drawn by (1, 1) alone: path tracing lacks it, and
/// nobody is blamed.
#[test]
fn a_light_that_only_the_lens_finds_is_no_bias_of_those_that_draw_it() {
    let (paths, light, both) =
        (PathTracer::default(), LightTracer::default(), Bidirectional::default());
    let methods: [(&str, &dyn Method<World>); 3] =
        [("path-tracing", &paths), ("light-tracing", &light), ("bidirectional", &both)];
    let study = study_of(&room(false, true, false), &lens(), &methods, [1, 2], 256);
    let report = &study.report;
    assert!(report.is_clean() && report.is_decided(), "{:#?}", report.verdicts());
    assert_eq!(report.pairs.len(), 1);
    assert_eq!(report.pairs[0].outcome(), Outcome::Agree);
    // Most of the light is the light itself.
    assert!(report.methods[0].mean < 0.5 * report.reference.mean);
    assert_eq!(report.methods[0].verdict(), "not tested");
    let bulb = "the point light \"bulb\" seen directly through the lens (L E)";
    let sentence = format!("path-tracing is shown, but not tested, since it cannot draw: {bulb}.");
    assert!(report.verdicts().contains(&sentence), "{:#?}", report.verdicts());
    let csv = report.missing_to_csv();
    let quoted = bulb.replace('"', "\"\"");
    assert_eq!(
        csv.lines().collect::<Vec<_>>(),
        ["integrator,missing,drawn_by", &format!("path-tracing,\"{quoted}\",connections")]
    );
    assert!(study.page().contains(&bulb.replace('"', "&quot;")));
    let json = report.to_json();
    assert!(serde_json::from_str::<Report>(&json).unwrap().to_json() == json);
}

/// What no integrator draws is said once, and does not keep those from being tested that draw all
/// else; what only merging draws is missing in the reference, and counted as its bias.
#[test]
fn what_the_reference_lacks_is_said() {
    let both = Bidirectional::up_to(4);
    let hits = WithNeeds::all(both);
    let merging = VertexConnectionMerging {
        bidirectional: both,
        merging: Merging::from_radius(0.1),
        ..VertexConnectionMerging::default()
    };
    let methods: [(&str, &dyn Method<World>); 3] =
        [("bidirectional", &both), ("unpruned", &hits), ("vcm", &merging)];
    let study = study_of(&room(true, true, false), &pinhole(), &methods, [0, 1], 128);
    let report = &study.report;
    assert!(report.is_clean(), "{:#?}", report.verdicts());
    assert!(report.methods.iter().all(|m| m.complete) && report.pairs.len() == 1);
    let merged = "specular images of caustics of the point light \"bulb\" (L S D S E, drawn by \
                  merging alone)";
    assert_eq!(report.reference.missing, [merged]);
    let verdicts = report.verdicts();
    let starts = |start: &str| verdicts.iter().filter(|v| v.starts_with(start)).collect::<Vec<_>>();
    let [nowhere] = starts("In no image: ")[..] else { panic!("{verdicts:#?}") };
    assert!(nowhere.contains("specular images of the point light \"bulb\" (L S E"), "{nowhere}");
    assert!(nowhere.contains("seen directly through the lens"), "{nowhere}");
    assert_eq!(
        *starts("Not in the image of bidirectional: ")[0],
        format!("Not in the image of bidirectional: {merged}.")
    );
    assert!(starts("Not in the image of vcm").is_empty());
    let stated = starts("vcm is consistent")[0];
    assert!(stated.ends_with(&format!("Counted as bias is what the reference misses: {merged}.")));
}
