//! Leaving out, its savings and a pilot's decisions, in the report, in CSV and on the page.

use super::{cornell_box, exactly, go_on};
use pathspace::endpoint::{Camera, PinholeCamera, PointLight};
use pathspace::gallery;
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{Adaptive, Bidirectional, PathTracer, UniformArea, WithNeeds};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Settings};
use pathspace::report::{
    Contestant, Method, MethodReport, Omission, Plan, Report, ReportError, SceneInfo, Study, study,
};
use pathspace::scene::{Emission, Material, World, WorldBuilder};

const SIZE: UVec2 = UVec2::splat(12);

/// Speed-ups are relative to bidirectional path tracing that leaves nothing out.
fn plan() -> Plan {
    Plan {
        budget: Budget::Samples(4 * 8),
        seeds: 4,
        baseline: Some("bidirectional, unpruned".to_owned()),
        ..Plan::default()
    }
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

fn mirror_study() -> Study {
    let (world, camera) = mirror();
    let (paths, both, area) =
        (PathTracer::up_to(4), Bidirectional::up_to(4), UniformArea::up_to(4));
    let (all_paths, all_both) = (WithNeeds::all(paths), WithNeeds::all(both));
    let all: [Contestant<'_, World>; 5] = [
        Contestant::new("path-tracing", &paths, true),
        Contestant::new("path-tracing, unpruned", &all_paths, true),
        Contestant::new("bidirectional", &both, true),
        Contestant::new("bidirectional, unpruned", &all_both, true),
        Contestant::new("uniform-area", &area, false),
    ];
    study_of(&world, &camera, &all).unwrap()
}

fn study_of(
    world: &World,
    camera: &dyn Camera,
    all: &[Contestant<'_, World>],
) -> Result<Study, ReportError> {
    study(world, camera, &SceneInfo::default(), all, exactly(0.2, SIZE), &plan(), &mut go_on)
}

fn method<'a>(report: &'a Report, name: &str) -> &'a MethodReport {
    report.methods.iter().find(|m| m.name == name).unwrap()
}

/// The cells of a row in the section about leaving out, without what is below the first line of
/// each.
fn row(page: &str, after: &str, name: &str) -> Vec<String> {
    let section =
        page.split("<h2>What is left out</h2>").nth(1).unwrap().split("<h2>").next().unwrap();
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

/// Images are the same to the bit where what was left out contributes nothing and what is left
/// takes the same random numbers.
#[test]
fn the_image_of_the_unpruned_integrator_is_the_same_to_the_bit() {
    let (world, camera) = mirror();
    let settings = Settings { budget: Budget::Samples(8), ..Plan::default().settings };
    let render = |method: &dyn Method<World>| method.render(&world, &camera, &settings).unwrap();
    let paths = PathTracer::up_to(4);
    let [pruned, unpruned] = [render(&paths), render(&WithNeeds::all(paths))];
    assert_eq!(pruned.image, unpruned.image);
    assert!(pruned.counters.rays() <= unpruned.counters.rays());
    assert!(!pruned.notes.left_out.is_empty() && unpruned.notes.left_out.is_empty());
}

/// The savings are those that rays and times tell.
#[test]
fn what_leaving_out_saves_is_measured_between_two_contestants() {
    let study = mirror_study();
    let report = &study.report;
    let [paths, all_paths] =
        ["path-tracing", "path-tracing, unpruned"].map(|name| method(report, name));
    let [both, all_both] =
        ["bidirectional", "bidirectional, unpruned"].map(|name| method(report, name));
    // Contestants have seeds of their own.
    let [variance, all_variance] = [paths, all_paths].map(|m| m.variance_per_sample);
    assert!(
        variance.low < all_variance.high && all_variance.low < variance.high,
        "{variance:?} {all_variance:?}"
    );
    assert_eq!((all_paths.runs, all_paths.samples_per_pixel), (4, 8));
    assert!(all_both.rays_per_sample > 1.3 * both.rays_per_sample);
    assert_eq!(report.setup.baseline.as_deref(), Some("bidirectional, unpruned"));
    let gain = both.speed_up.unwrap();
    let exact = all_both.variance_times_rays.value / both.variance_times_rays.value;
    assert!((gain.rays.value / exact - 1.0).abs() < 0.1, "{gain:?} {exact}");
    assert_eq!(both.left_out.len(), 3);
    assert!(
        both.left_out[0].what.contains("next event estimation")
            && both.left_out[0].why.contains("no surface has a lobe")
    );
    assert!(both.decisions.is_empty() && !both.techniques.contains("Left out"));
    // Nothing is ruled out for it.
    assert!(method(report, "uniform-area").left_out.is_empty() && all_both.left_out.is_empty());

    let page = study.page();
    let reasons = &row(&page, "<table>", "bidirectional")[0];
    assert!(
        reasons.contains("s = 1 (next event estimation): no surface has a lobe to connect to"),
        "{reasons}"
    );
    for name in ["uniform-area", "bidirectional, unpruned"] {
        let reasons = &row(&page, "<table>", name)[0];
        assert_eq!(reasons, "nothing: the scene rules nothing out for it");
    }

    let csv = report.left_out_to_csv();
    let lines: Vec<&str> = csv.lines().filter(|line| line.contains("bidirectional")).collect();
    assert_eq!(lines.len(), 3);
    for (line, Omission { what, why }) in lines.into_iter().zip(&both.left_out) {
        assert!(line.starts_with("bidirectional,"), "{line}");
        assert!(line.contains(what) && line.contains(why), "{line}");
    }
    let json: Report = serde_json::from_str(&report.to_json()).unwrap();
    assert_eq!(json.methods[2].left_out, both.left_out);
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
    let study = study_of(&world, &camera, &all).unwrap();
    assert_eq!(study.report.left_out[0].name, "uniform-area");
    assert!(study.report.left_out[0].left_out.iter().any(|o| o.why == "no ray can hit a light"));
    let reasons = &row(&study.page(), "<table>", "uniform-area")[0];
    assert!(reasons.contains("no ray can hit a light"), "{reasons}");
    assert!(study.page().contains("<br>no technique is left"));
    assert!(study.report.left_out_to_csv().contains(",no ray can hit a light\n"));
}

#[test]
fn decisions_are_shown_run_by_run_and_set_by_set() {
    let scene: gallery::GalleryScene = cornell_box(SIZE.x);
    let adaptive = Adaptive::up_to(3);
    let paths = PathTracer::up_to(3);
    let all: [Contestant<'_, World>; 2] = [
        Contestant::new("adaptive", &adaptive, true),
        Contestant::new("path-tracing", &paths, true),
    ];
    let study = study_of(&scene.world, &*scene.camera, &all).unwrap();
    let (method, page) = (method(&study.report, "adaptive"), study.page());
    assert!(row(&page, "<table>", "path-tracing")[0].starts_with("nothing"));
    assert!(row(&page, "<table>", "adaptive")[0].starts_with("what its pilot found"));
    assert_eq!(method.decisions.len(), 4);
    for (run, decision) in method.decisions.iter().enumerate() {
        let cells = row(&page, "<h3>What adaptive decided</h3>", &(run + 1).to_string());
        assert_eq!(
            (cells[0].parse(), cells[1].parse()),
            (Ok(decision.pilot_samples), Ok(decision.candidates.len()))
        );
        assert_shows(&cells[2], decision.expected_gain);
        assert_eq!(cells[3], decision.techniques);
        let chosen: Vec<_> = decision.candidates.iter().filter(|c| c.chosen).collect();
        assert!(matches!(chosen[..], [set] if set.techniques == decision.techniques));
    }
    for candidate in &method.decisions[0].candidates {
        let cells = row(&page, "The sets that the first run chose from", &candidate.techniques);
        assert_shows(&cells[0], candidate.variance);
        assert_shows(&cells[1], candidate.cost);
        assert_shows(&cells[2], candidate.variance * candidate.cost);
        assert_eq!(cells[3].parse(), Ok(candidate.samples));
    }
    let csv = study.report.decisions_to_csv();
    let candidates = || method.decisions.iter().flat_map(|d| &d.candidates);
    assert_eq!(csv.lines().count(), 1 + candidates().count());
    let last: Vec<&str> = csv.lines().last().unwrap().rsplit(',').take(4).collect();
    let candidate = candidates().last().unwrap();
    let numbers: Vec<f64> = last[1..].iter().map(|x| x.parse().unwrap()).collect();
    let expected = [candidate.samples as f64, candidate.cost, candidate.variance];
    assert_eq!((last[0], &numbers[..]), (candidate.chosen.to_string().as_str(), &expected[..]));
}
