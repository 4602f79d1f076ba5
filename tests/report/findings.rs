//! The findings of runs beside their images, in the report and on the page.

use super::{contestants, cornell_box, exactly, go_on};
use glam::UVec2;
use pathspace::integrator::{Guiding, Metropolis, PathTracer};
use pathspace::render::Budget;
use pathspace::report::text::{number, percent};
use pathspace::report::{FindingsReport, Plan, SceneInfo, study};
use pathspace::scene::World;

#[test]
fn findings_are_shown_run_by_run() {
    let size = UVec2::splat(16);
    let scene = cornell_box(size.x);
    let paths = PathTracer::up_to(2);
    let (chains, guided) = (Metropolis::over(paths), Guiding::new(paths));
    let methods = contestants::<World>(&[
        ("path-tracing", &paths),
        ("metropolis", &chains),
        ("guided", &guided),
    ]);
    let plan = Plan { budget: Budget::Samples(256), seeds: 2, ..Plan::default() };
    let study = study(
        &scene.world,
        &*scene.camera,
        &SceneInfo::default(),
        &methods,
        exactly(0.1, size),
        &plan,
        &mut go_on,
    )
    .unwrap();
    let [plain, chains, guided] = &study.report.methods[..] else { panic!("three methods") };
    assert!(plain.findings.is_empty());
    let page = study.page();
    let section = page.split("<h2>What runs found out</h2>").nth(1).unwrap();
    let row = |name: &str, run: usize, cells: [String; 4]| {
        let row: String = cells.map(|cell| format!("<td>{cell}</td>")).concat();
        let row = format!("<tr><th scope=\"row\">{name}, {run}</th>{row}</tr>");
        assert!(section.contains(&row), "{row} is not in {section}");
    };
    assert_eq!((chains.findings.len(), guided.findings.len()), (2, 2));
    for (run, found) in (1..).zip(&chains.findings) {
        let FindingsReport { normalization: Some(b), guidance: None } = found else {
            panic!("{found:?}")
        };
        // 4096 candidates for one set of chains.
        assert_eq!((b.candidates, b.black), (4096, 0));
        let z = (b.mean / (study.images[1].mean.mean().0.iter().sum::<f64>() / 3.0) - 1.0)
            / b.relative_standard_error;
        assert!(z.abs() < 4.0, "{z} standard errors from the image");
        let error = percent(b.relative_standard_error);
        row("metropolis", run, [number(b.mean), error, "4096".to_owned(), "0".to_owned()]);
    }
    for (run, found) in (1..).zip(&guided.findings) {
        let FindingsReport { normalization: None, guidance: Some(g) } = found else {
            panic!("{found:?}")
        };
        let is_guided = if g.is_used { "yes" } else { "no" };
        let gain = if g.expected_gain > 0.0 { number(g.expected_gain) } else { "–".to_owned() };
        row("guided", run, [is_guided.into(), gain, g.parts.to_string(), g.samples.to_string()]);
    }
}
