//! Verdicts on integrators that have met little: neither faults nor agreement, in every file.

use super::{Synthetic, against, contestants, cornell_box, exactly, go_on, readable};
use pathspace::endpoint::{Light, LightId, PinholeCamera, PointLight, ThinLensCamera};
use pathspace::geometry::{Quad, Sphere, SurfacePoint};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer, PathTracing};
use pathspace::material::SurfaceBsdf;
use pathspace::math::Rgb;
use pathspace::render::{Budget, Settings};
use pathspace::report::{
    Contestant, Method, Outcome, Plan, Reference, ReferencePlan, Report, ReportError, SceneInfo,
    Study, study,
};
use pathspace::sampler::Sampler;
use pathspace::scene::{Emission, Material, Needs, Scene, World, WorldBuilder};

const SIZE: u32 = 32;
const SEEDS: u32 = 8;
const SAMPLES: u32 = 64;
/// Samples of all runs of an integrator.
const ALL: f64 = SAMPLES as f64 * (SIZE * SIZE) as f64;

/// Contributions of equal size, so many expected in all runs, with a mean of `mean`.
fn rare(mean: f64, contributions: f64) -> Synthetic<impl Fn(&mut dyn Sampler) -> f64 + Sync> {
    let chance = contributions / ALL;
    Synthetic(
        move |sampler: &mut dyn Sampler| {
            if sampler.next_1d() < chance { mean / chance } else { 0.0 }
        },
    )
}

/// Noise of about a third of the mean.
fn honest(mean: f64) -> Synthetic<impl Fn(&mut dyn Sampler) -> f64 + Sync> {
    Synthetic(move |sampler: &mut dyn Sampler| mean * (0.5 + sampler.next_1d()))
}

fn study_of(methods: &[(&str, &dyn Method<World>)], reference: Reference) -> Study {
    let scene = cornell_box(SIZE);
    let plan = Plan { budget: Budget::Samples(SAMPLES), seeds: SEEDS, ..Plan::default() };
    let info = SceneInfo::default();
    study(&scene.world, &*scene.camera, &info, &contestants(methods), reference, &plan, &mut go_on)
        .unwrap()
}

fn reference_of(halves: [&dyn Method<World>; 2]) -> Result<Reference, ReportError> {
    let scene = cornell_box(SIZE);
    let all = contestants::<World>(&[("first", halves[0]), ("second", halves[1])]);
    let (budget, settings) = (Budget::Samples(SAMPLES), Plan::default().settings);
    let plan = ReferencePlan { budget, runs: SEEDS, settings };
    Reference::render(&scene.world, &*scene.camera, [&all[0], &all[1]], &plan, &mut go_on)
}

fn verdict<'a>(verdicts: &'a [String], start: &str) -> &'a str {
    verdicts.iter().find(|verdict| verdict.starts_with(start)).unwrap_or_else(|| {
        panic!("no verdict begins with {start:?}: {verdicts:#?}");
    })
}

/// No test speaks for or against an integrator, and nothing is made of its variance.
fn assert_undecided(report: &Report, name: &str, reason: &str) {
    let method = report.methods.iter().find(|m| m.name == name).unwrap();
    assert!(!method.bias.flagged && !report.is_decided(), "{:?}", method.bias);
    assert_eq!(method.verdict(), "undecided");
    assert!(method.effective_contributions < 64.0);
    assert!(method.undecided.as_ref().unwrap().contains(reason), "{:?}", method.undecided);
    assert!(method.speed_up.is_none() && method.time_to_target.is_none());
    assert!(method.slopes.is_empty() && report.setup.baseline.as_deref() != Some(name));
    for pair in report.pairs.iter().filter(|pair| pair.names.iter().any(|n| n == name)) {
        assert_eq!(pair.outcome(), Outcome::Undecided);
        assert!(!pair.agrees());
    }
    let verdicts = report.verdicts();
    let sentence = verdict(&verdicts, &format!("UNDECIDED: {name} "));
    assert!(sentence.contains(reason) && sentence.contains("8 runs of 8 per pixel"), "{sentence}");
    assert!(
        !verdicts.iter().any(|verdict| verdict.starts_with("BIAS: ") && verdict.contains(name))
    );
}

/// An integrator that has met nothing and one that has met ten contributions, beside two that
/// have met enough: of these one is noisy, and it agrees.
#[test]
fn who_has_met_little_is_undecided_and_the_others_agree() {
    let (black, few, enough, good) =
        (Synthetic(|_: &mut dyn Sampler| 0.0), rare(1.0, 10.0), rare(1.0, 1000.0), honest(1.0));
    let methods: [(&str, &dyn Method<World>); 4] =
        [("black", &black), ("few", &few), ("enough", &enough), ("good", &good)];
    for reference in
        [exactly(1.0, UVec2::splat(SIZE)), reference_of([&good, &honest(1.0)]).unwrap()]
    {
        let study = study_of(&methods, reference);
        let report = &study.report;
        assert_undecided(report, "black", &format!("contributed nothing in {ALL} samples"));
        assert_undecided(report, "few", "rests on some");
        assert!(report.is_clean(), "{:?}", report.verdicts());
        let few = report.methods[1].effective_contributions;
        assert!((2.0..30.0).contains(&few), "{few}");
        let enough = report.methods[2].effective_contributions;
        assert!((enough / 1000.0 - 1.0).abs() < 0.6, "{enough}");
        let outcomes: Vec<_> = report.pairs.iter().map(|pair| pair.outcome()).collect();
        assert_eq!(outcomes.iter().filter(|o| **o == Outcome::Undecided).count(), 5);
        assert_eq!(outcomes[5], Outcome::Agree);
        let verdicts = report.verdicts();
        let agreement = verdict(&verdicts, "The integrators agree");
        assert!(
            agreement.contains("but for black, few, which are undecided (1 pair tested"),
            "{agreement}"
        );
        // The same in all files.
        let json = report.to_json();
        assert_eq!(serde_json::from_str::<Report>(&json).unwrap().to_json(), json);
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert!(value["methods"][0]["undecided"].as_str().unwrap().contains("nothing"));
        assert!(value["methods"][3]["undecided"].is_null());
        assert_eq!(value["pairs"][0]["undecided"], serde_json::json!([true, true]));
        let csv = report.verdicts_to_csv();
        let column = |line: &str| line.split(',').nth(1).map(str::to_owned);
        assert_eq!(
            csv.lines().skip(1).filter_map(column).collect::<Vec<_>>(),
            ["undecided", "undecided", "no bias seen", "no bias seen"]
        );
        let page = readable(&study.page());
        assert!(page.contains("contributed nothing in") && page.contains(">undecided"));
        assert!(!page.contains("NaN") && !page.contains("DISAGREE"));
    }
}

#[test]
fn a_bias_is_flagged_beside_the_undecided() {
    let (black, good) = (Synthetic(|_: &mut dyn Sampler| 0.0), honest(1.0));
    let biased = honest(1.01);
    let methods: [(&str, &dyn Method<World>); 3] =
        [("black", &black), ("biased", &biased), ("good", &good)];
    let report = study_of(&methods, exactly(1.0, UVec2::splat(SIZE))).report;
    assert_undecided(&report, "black", "nothing");
    let verdicts = report.verdicts();
    verdict(&verdicts, "BIAS: biased is off by +1.");
    verdict(&verdicts, "INTEGRATORS DISAGREE: biased and good.");
    let words: Vec<_> = report.methods.iter().map(|m| m.verdict()).collect();
    assert_eq!(words, ["undecided", "biased", "no bias seen"]);
    assert!(!report.is_clean() && !report.is_decided());
}

#[test]
fn alone_or_all_together_they_decide_nothing() {
    let black = Synthetic(|_: &mut dyn Sampler| 0.0);
    for names in [&["a", "b"][..], &["a"]] {
        let methods: Vec<(&str, &dyn Method<World>)> =
            names.iter().map(|name| (*name, &black as _)).collect();
        let report = study_of(&methods, exactly(1.0, UVec2::splat(SIZE))).report;
        names.iter().for_each(|name| assert_undecided(&report, name, "nothing"));
        assert!(report.is_clean() && report.setup.baseline.is_none());
        let verdicts = report.verdicts();
        match names.len() {
            2 => verdict(&verdicts, "Whether the integrators agree is undecided, because of a, b."),
            _ => verdict(&verdicts, "Fewer than two unbiased integrators see every path"),
        };
    }
}

/// A scene without light: nobody is wrong, and who sees light in it is.
#[test]
fn a_black_reference_is_no_excuse() {
    let (black, good) = (Synthetic(|_: &mut dyn Sampler| 0.0), honest(1.0));
    let methods: [(&str, &dyn Method<World>); 2] = [("dark", &black), ("bright", &good)];
    let study = study_of(&methods, exactly(0.0, UVec2::splat(SIZE)));
    let report = &study.report;
    assert_undecided(report, "dark", "nothing");
    assert!(report.methods[1].bias.flagged && !report.is_clean());
    let verdicts = report.verdicts();
    let bias = verdict(&verdicts, "BIAS: bright has a mean of ");
    assert!(bias.contains("the reference is black") && !readable(&study.page()).contains("NaN"));
    // A rendered one has met nothing, too, and is no measure.
    let reference = reference_of([&black, &black]).unwrap();
    assert!(reference.undecided().is_some());
    let study = study_of(&methods, reference);
    assert!(study.report.is_clean() && !study.report.is_decided());
    verdict(&study.report.verdicts(), "UNDECIDED: the reference contributed nothing in ");
    assert!(!readable(&study.page()).contains("NaN"));
}

/// A half that has met too little has no part in a reference; two such are put together by their
/// samples, since their variances say nothing.
#[test]
fn a_reference_is_not_made_of_what_has_met_nothing() {
    let (black, few, good) = (Synthetic(|_: &mut dyn Sampler| 0.0), rare(1.0, 10.0), honest(1.0));
    for (starved, place) in [(&black as &dyn Method<World>, 0), (&few, 1)] {
        let halves = if place == 0 { [starved, &good] } else { [&good, starved] };
        let reference = reference_of(halves).unwrap();
        let mean = reference.image().mean().luminance();
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        let expected = ["first has met too little", "second has met too little"][place];
        assert!(reference.origin().contains(expected), "{}", reference.origin());
        assert!(reference.undecided().is_none());
    }
    let reference = reference_of([&few, &black]).unwrap();
    let mean = reference.image().mean().luminance();
    assert!(mean > 0.1 && reference.undecided().is_some(), "{mean}");
    assert!(reference.origin().contains("both have met too little"), "{}", reference.origin());
    let report = study_of(&[("good", &good)], reference).report;
    assert!(!report.methods[0].bias.flagged && report.is_clean() && !report.is_decided());
}

#[test]
fn a_reference_is_not_made_of_what_cannot_draw_every_path() {
    let (scene, good) = (cornell_box(SIZE), honest(1.0));
    let half = |complete| Contestant::<World>::new("half", &good, complete);
    let plan =
        ReferencePlan { budget: Budget::Samples(8), runs: 2, settings: Plan::default().settings };
    let halves = [&half(true), &half(false)];
    let error =
        Reference::render(&scene.world, &*scene.camera, halves, &plan, &mut go_on).unwrap_err();
    assert!(matches!(&error, ReportError::ReferenceIncomplete(name) if name == "half"), "{error}");
}

/// A room with a lamp, and a light outside of it that a choice of lights starves the lamp for.
struct Starved {
    world: World,
    lamp: LightId,
    chance: f64,
}

impl Scene for Starved {
    type Bsdf<'a> = SurfaceBsdf<'a>;
    type Light = dyn Light;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        self.world.intersect(from, direction)
    }
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.world.visible(a, b)
    }
    fn bsdf(&self, x: &SurfacePoint) -> SurfaceBsdf<'_> {
        self.world.bsdf(x)
    }
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.world.light_at(x)
    }
    fn light(&self, id: LightId) -> &Self::Light {
        self.world.light(id)
    }
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        let id = if u < self.chance { self.lamp } else { LightId(1 - self.lamp.0) };
        Some((id, self.pick_pmf(id)))
    }
    fn pick_pmf(&self, id: LightId) -> f64 {
        if id == self.lamp { self.chance } else { 1.0 - self.chance }
    }
    fn pick_light_for(&self, _: &SurfacePoint, _: f64) -> Option<(LightId, f64)> {
        Some((self.lamp, 1.0))
    }
    fn pick_pmf_for(&self, _: &SurfacePoint, id: LightId) -> f64 {
        f64::from(id == self.lamp)
    }
    fn needs(&self) -> Needs {
        self.world.needs()
    }
}

fn starved(chance: f64) -> (Starved, PinholeCamera) {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let room = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    builder.add_sphere("room", room, grey).unwrap();
    let quad = Quad {
        origin: DVec3::new(-0.2, -0.2, 0.6),
        edge_u: DVec3::Y * 0.4,
        edge_v: DVec3::X * 0.4,
    };
    let lamp = builder.add_quad("lamp", quad, grey).unwrap();
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    let outside = PointLight::new(DVec3::X * 3.0, Rgb::WHITE).unwrap();
    builder.add_light("outside", outside).unwrap();
    let world = builder.build().unwrap();
    let lamp = world.light_by_name("lamp").unwrap();
    let (eye, size) = (DVec3::new(0.0, -0.8, 0.1), UVec2::splat(SIZE));
    let camera = PinholeCamera::new(eye, DVec3::ZERO, DVec3::Z, 60.0, size).unwrap();
    (Starved { world, lamp, chance }, camera)
}

/// The lights that a host chooses for walks are those of a closed room hardly ever: light tracing
/// meets nothing, or a few contributions that are very bright. It is right all the same.
#[test]
fn light_tracing_that_starves_is_not_wrong() {
    let (paths, light, both) =
        (PathTracer::up_to(4), LightTracer::up_to(4), Bidirectional::up_to(4));
    let methods = [
        ("path-tracing", &paths as &dyn Method<Starved>),
        ("light-tracing", &light),
        ("bidirectional", &both),
    ];
    for (chance, decided) in [(1e-9, false), (1e-4, false), (0.5, true)] {
        let (scene, camera) = starved(chance);
        let all = contestants(&methods);
        let settings = Settings { seed: 3, ..Plan::default().settings };
        let plan = ReferencePlan { budget: Budget::Samples(128), runs: 16, settings };
        for halves in [[&all[0], &all[2]], [&all[0], &all[1]], [&all[1], &all[2]]] {
            let reference = Reference::render(&scene, &camera, halves, &plan, &mut go_on).unwrap();
            let plan = Plan { budget: Budget::Samples(SAMPLES), settings, ..Plan::default() };
            let info = SceneInfo::default();
            let report =
                study(&scene, &camera, &info, &all, reference, &plan, &mut go_on).unwrap().report;
            assert!(report.is_clean(), "{chance}: {:#?}", report.verdicts());
            assert_eq!(report.methods[1].undecided.is_none(), decided, "{:?}", report.methods[1]);
            assert_eq!(report.is_decided(), decided);
            assert!(report.methods[0].undecided.is_none() && report.methods[2].undecided.is_none());
        }
    }
}

/// A host that does not name its lights gets general words.
#[test]
fn lights_without_names_are_named_by_their_kind() {
    let (scene, _) = starved(0.5);
    let (eye, size) = (DVec3::new(0.0, -0.8, 0.1), UVec2::splat(SIZE));
    let lens = ThinLensCamera::new(eye, DVec3::ZERO, DVec3::Z, 60.0, 0.1, 1.0, size).unwrap();
    let words = |integrator: &dyn Method<Starved>| -> Vec<String> {
        integrator.blind_spots(&scene, &lens).unwrap().iter().map(ToString::to_string).collect()
    };
    let seen = "Dirac lights seen directly through the lens (L E)";
    assert_eq!(words(&PathTracer::default()), [seen]);
    let next_event = PathTracer { mode: PathTracing::NextEventOnly, ..PathTracer::default() };
    assert_eq!(words(&next_event), ["area lights seen directly through the lens (L E)", seen]);
}

/// Blocks of which one of two has met nothing are told, and do not make a pair agree or disagree.
#[test]
fn blocks_that_one_has_met_nothing_of_are_undecided() {
    let (world, camera) = half_lit();
    let (paths, light) = (PathTracer::up_to(1), LightTracer::up_to(1));
    let report = against(
        &world,
        &camera,
        &[("path-tracing", &paths as &dyn Method<World>), ("light-tracing", &light)],
        0.0,
        64,
        8,
    );
    let pair = &report.pairs[0];
    assert!(pair.undecided == [false; 2] && pair.undecided_blocks > 0, "{pair:?}");
    assert!(pair.undecided_light > 0.0 && pair.undecided_light < 0.05, "{pair:?}");
    assert_eq!(pair.outcome(), Outcome::Agree, "{pair:?}");
    let verdicts = report.verdicts();
    assert!(verdict(&verdicts, "The integrators agree").contains("of the light are undecided"));
}

/// A floor under a lamp, and a wall far off in its light that light tracing hits hardly ever.
fn half_lit() -> (World, PinholeCamera) {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let mut quad = |name: &str, origin: DVec3, edge_u: DVec3, edge_v: DVec3| {
        builder.add_quad(name, Quad { origin, edge_u, edge_v }, grey).unwrap()
    };
    quad("floor", DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0);
    let near = DVec3::new(-0.002, 3.0, 0.998);
    quad("far", near, DVec3::X * 0.004, DVec3::Z * 0.004);
    let lamp = quad("lamp", DVec3::new(-0.5, -0.5, 1.5), DVec3::Y, DVec3::X);
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    let eye = DVec3::new(0.0, -3.0, 1.0);
    let camera = PinholeCamera::new(eye, DVec3::Y, DVec3::Z, 40.0, UVec2::splat(SIZE)).unwrap();
    (builder.build().unwrap(), camera)
}
