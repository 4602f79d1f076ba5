//! What is left out, what it saves and what a pilot decided, in the report, in CSV and on the page.

use super::{cornell_box, exactly, go_on};
use pathspace::endpoint::{PinholeCamera, PointLight};
use pathspace::gallery;
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{Adaptive, Bidirectional, PathTracer, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::TechniqueSet;
use pathspace::render::Budget;
use pathspace::report::{
    Contestant, Everything, MethodReport, Plan, Report, ReportError, SceneInfo, Study, study,
};
use pathspace::scene::{Emission, Material, World, WorldBuilder};

const SIZE: UVec2 = UVec2::splat(12);

fn plan(everything: f64) -> Plan {
    Plan { budget: Budget::Samples(4 * 8), seeds: 4, everything, ..Plan::default() }
}

/// A lamp over a mirror: nothing to connect to.
fn mirror() -> (World, PinholeCamera) {
    let mut builder = WorldBuilder::new();
    let mirror =
        builder.add_material("mirror", Material::Mirror { reflectance: Rgb::splat(0.8) }).unwrap();
    let black = builder.add_material("black", Material::Black).unwrap();
    let quad = Quad {
        origin: DVec3::new(-2.0, -2.0, 0.0),
        edge_u: DVec3::X * 4.0,
        edge_v: DVec3::Y * 4.0,
    };
    builder.add_quad("floor", quad, mirror).unwrap();
    let lamp =
        builder.add_sphere("lamp", Sphere::new(DVec3::new(0.0, 0.0, 1.0), 0.4), black).unwrap();
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    let camera = PinholeCamera::new(
        DVec3::new(0.0, -3.0, 1.5),
        DVec3::new(0.0, 0.0, 0.5),
        DVec3::Z,
        50.0,
        SIZE,
    )
    .unwrap();
    (builder.build().unwrap(), camera)
}

fn mirror_study(everything: f64) -> Study {
    let (world, camera) = mirror();
    let (paths, both, area) =
        (PathTracer::up_to(4), Bidirectional::up_to(4), UniformArea::up_to(4));
    let (all_paths, all_both, all_area) = (Everything(paths), Everything(both), Everything(area));
    let all: [Contestant<'_, World>; 3] = [
        Contestant {
            everything: Some(&all_paths),
            ..Contestant::new("path-tracing", &paths, true)
        },
        Contestant { everything: Some(&all_both), ..Contestant::new("bidirectional", &both, true) },
        Contestant { everything: Some(&all_area), ..Contestant::new("uniform-area", &area, false) },
    ];
    study(
        &world,
        &camera,
        &SceneInfo::default(),
        &all,
        exactly(0.2, SIZE),
        &plan(everything),
        &mut go_on,
    )
    .unwrap()
}

fn method<'a>(report: &'a Report, name: &str) -> &'a MethodReport {
    report.methods.iter().find(|m| m.name == name).unwrap()
}

/// The cells of a row in the section about leaving out, without what is below the first line of
/// each.
fn row(page: &str, after: &str, name: &str) -> Vec<String> {
    let section = page
        .split("<h2>What is left out, and what that saves</h2>")
        .nth(1)
        .unwrap()
        .split("<h2>")
        .next()
        .unwrap();
    let table = section.split(after).nth(1).unwrap();
    let row = table
        .split(&format!("<tr><th scope=\"row\">{name}</th>"))
        .nth(1)
        .unwrap()
        .split("</tr>")
        .next()
        .unwrap();
    let cell = |text: &str| {
        text.split_once('>')
            .unwrap()
            .1
            .split("<br>")
            .next()
            .unwrap()
            .trim_end_matches("</td>")
            .to_owned()
    };
    row.split("<td").skip(1).map(cell).collect()
}

#[track_caller]
fn assert_shows(cell: &str, value: f64) {
    let shown: f64 = cell.replace('−', "-").trim_end_matches(" %").parse().unwrap();
    assert!((shown - value).abs() <= 0.006 * value.abs() + 0.0051, "{shown} for {value}");
}

/// With all of the samples again the variances are the same to the bit where what was left out
/// contributes nothing; what is saved is what rays and times say.
#[test]
fn what_leaving_out_saves_is_measured_on_the_same_seeds() {
    let study = mirror_study(1.0);
    let report = &study.report;
    let (paths, both) = (method(report, "path-tracing"), method(report, "bidirectional"));
    let [all_paths, all_both] = [paths, both].map(|m| m.everything.as_ref().unwrap());
    assert_eq!(all_paths.variance_per_sample, paths.variance_per_sample);
    assert_eq!((all_paths.runs, all_paths.samples_per_pixel), (4, 8));
    assert!(all_both.rays_per_sample > 1.3 * both.rays_per_sample);
    let gain = all_both.gain.unwrap();
    let exact = all_both.variance_times_rays.value / both.variance_times_rays.value;
    assert!((gain.rays.value / exact - 1.0).abs() < 0.1, "{gain:?} {exact}");
    assert_eq!(both.left_out.len(), 3);
    assert!(
        both.left_out[0].what.contains("emitter sampling")
            && both.left_out[0].why.contains("no surface has a lobe")
    );
    assert!(both.decisions.is_empty() && !both.techniques.contains("Left out"));
    // Nothing is ruled out for it, so nothing is measured again.
    assert!(method(report, "uniform-area").everything.is_none());

    let page = study.page();
    let cells = row(&page, "<table>", "bidirectional");
    assert!(
        cells[0].contains("s = 1 (emitter sampling): no surface has a lobe to connect to"),
        "{cells:?}"
    );
    let values = [
        all_both.rays_per_sample,
        both.rays_per_sample,
        1e6 * all_both.cpu_per_sample,
        1e6 * both.cpu_per_sample,
        all_both.variance_times_cpu.value,
        both.variance_times_cpu.value,
        gain.cpu.value,
        gain.rays.value,
    ];
    assert_eq!(cells.len(), 9);
    cells[1..].iter().zip(values).for_each(|(cell, value)| assert_shows(cell, value));
    let cells = row(&page, "<table>", "uniform-area");
    assert!(
        cells[0] == "nothing: the scene rules nothing out for it" && cells[1] == "–",
        "{cells:?}"
    );

    let csv = report.left_out_to_csv();
    let line = csv.lines().find(|line| line.starts_with("\"bidirectional\"")).unwrap();
    let fields: Vec<f64> =
        line.rsplit('"').next().unwrap().split(',').skip(1).map(|x| x.parse().unwrap()).collect();
    let [all_cpu, cpu] = [all_both.cpu_per_sample, both.cpu_per_sample];
    let product = [all_both.variance_times_cpu.value, both.variance_times_cpu.value];
    let expected = [
        both.rays_per_sample,
        all_both.rays_per_sample,
        cpu,
        all_cpu,
        product[1],
        product[0],
        gain.cpu.value,
        gain.rays.value,
    ];
    assert_eq!(fields, expected);
    let json: Report = serde_json::from_str(&report.to_json()).unwrap();
    assert_eq!(json.methods[1].everything, both.everything);
}

#[test]
fn a_part_is_drawn_again_or_nothing() {
    let study = mirror_study(0.25);
    let all = method(&study.report, "bidirectional").everything.as_ref().unwrap();
    assert_eq!((all.runs, all.samples_per_pixel), (4, 2));
    let study = mirror_study(0.0);
    assert!(study.report.methods.iter().all(|m| m.everything.is_none()));
    assert_eq!(row(&study.page(), "<table>", "bidirectional")[1], "–");
    let (world, camera) = mirror();
    let paths = PathTracer::up_to(2);
    let all: [Contestant<'_, World>; 1] = [Contestant::new("a", &paths, true)];
    let refused = study_of(&world, &camera, &all, &plan(1.5));
    assert!(matches!(refused, Err(ReportError::Everything(part)) if part == 1.5));
}

fn study_of(
    world: &World,
    camera: &PinholeCamera,
    all: &[Contestant<'_, World>],
    plan: &Plan,
) -> Result<Study, ReportError> {
    study(world, camera, &SceneInfo::default(), all, exactly(0.2, SIZE), plan, &mut go_on)
}

/// An integrator without a technique is in no table but this one, with the reason.
#[test]
fn an_integrator_without_a_technique_has_a_reason() {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let quad = Quad {
        origin: DVec3::new(-2.0, -2.0, 0.0),
        edge_u: DVec3::X * 4.0,
        edge_v: DVec3::Y * 4.0,
    };
    builder.add_quad("floor", quad, grey).unwrap();
    builder.add_light("lamp", PointLight::new(DVec3::Z, Rgb::WHITE).unwrap()).unwrap();
    let (world, camera) = (builder.build().unwrap(), mirror().1);
    let (area, paths) = (UniformArea::up_to(2), PathTracer::up_to(2));
    let all: [Contestant<'_, World>; 2] = [
        Contestant::new("uniform-area", &area, false),
        Contestant::new("path-tracing", &paths, true),
    ];
    let study = study_of(&world, &camera, &all, &plan(0.5)).unwrap();
    assert_eq!(study.report.left_out[0].name, "uniform-area");
    assert!(study.report.left_out[0].left_out.iter().any(|o| o.why == "no ray can hit a light"));
    let cells = row(&study.page(), "<table>", "uniform-area");
    assert!(
        cells[0].contains("no ray can hit a light") && cells[1] == "no technique is left",
        "{cells:?}"
    );
    assert!(study.report.left_out_to_csv().contains("no ray can hit a light\",0,"));
}

#[test]
fn decisions_are_shown_run_by_run_and_technique_by_technique() {
    let scene: gallery::GalleryScene = cornell_box(SIZE.x);
    let adaptive = Adaptive::up_to(3);
    let everything =
        Everything(Adaptive { techniques: Some(TechniqueSet::BIDIRECTIONAL), ..adaptive });
    let paths = PathTracer::up_to(3);
    let all: [Contestant<'_, World>; 2] = [
        Contestant {
            everything: Some(&everything),
            ..Contestant::new("adaptive", &adaptive, true)
        },
        Contestant {
            everything: Some(&Everything(paths)),
            ..Contestant::new("path-tracing", &paths, true)
        },
    ];
    let info = SceneInfo::default();
    let study = study(
        &scene.world,
        &*scene.camera,
        &info,
        &all,
        exactly(0.15, SIZE),
        &plan(0.5),
        &mut go_on,
    )
    .unwrap();
    let (method, page) = (method(&study.report, "adaptive"), study.page());
    assert!(study.report.methods[1].everything.is_none());
    assert!(row(&page, "<table>", "path-tracing")[0].starts_with("nothing"));
    assert!(row(&page, "<table>", "adaptive")[0].starts_with("what its pilot found"));
    let all = method.everything.as_ref().unwrap();
    assert!(all.techniques.contains("connections") && all.samples_per_pixel == 4);
    assert_eq!(method.decisions.len(), 4);
    for (run, decision) in method.decisions.iter().enumerate() {
        let cells = row(&page, "<h3>What adaptive decided</h3>", &(run + 1).to_string());
        assert_eq!(
            (cells[0].parse(), cells[1].parse()),
            (Ok(decision.pilot_samples), Ok(decision.candidates))
        );
        assert_shows(&cells[2], decision.expected_gain);
        assert_shows(&cells[3], decision.achieved_gain);
        assert_eq!(cells[4], decision.techniques);
    }
    let shares = &method.decisions[0].shares;
    for share in shares.iter().filter(|share| share.energy > 0.001) {
        let same = |other: &&pathspace::report::TechniqueDecision| {
            (other.s, other.t) == (share.s, share.t)
        };
        let of_runs: Vec<_> = method
            .decisions
            .iter()
            .map(|decision| decision.shares.iter().find(same).unwrap())
            .collect();
        let mean = |f: fn(&pathspace::report::TechniqueDecision) -> f64| {
            100.0 * of_runs.iter().map(|x| f(x)).sum::<f64>() / 4.0
        };
        let cells = row(&page, "Shares of the techniques", &format!("({}, {})", share.s, share.t));
        assert_eq!(cells[0].parse(), Ok(share.s + share.t - 2));
        [mean(|x| x.energy), mean(|x| x.variance), mean(|x| x.cost)]
            .into_iter()
            .zip(&cells[1..])
            .for_each(|(x, cell)| assert_shows(cell, x));
        let verdict = match of_runs.iter().filter(|x| x.kept).count() {
            0 => "left out".to_owned(),
            4 => "kept".to_owned(),
            n => format!("kept in {n} of 4 runs"),
        };
        assert_eq!(cells[4], verdict);
    }
    let csv = study.report.decisions_to_csv();
    assert_eq!(
        csv.lines().count(),
        1 + method.decisions.iter().map(|d| d.shares.len()).sum::<usize>()
    );
    let last: Vec<&str> = csv.lines().last().unwrap().rsplit(',').take(6).collect();
    let share = method.decisions[3].shares.last().unwrap();
    assert_eq!(
        last,
        [
            share.kept.to_string(),
            share.cost.to_string(),
            share.variance.to_string(),
            share.energy.to_string(),
            share.t.to_string(),
            share.s.to_string()
        ]
    );
}
