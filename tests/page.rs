//! The page in a real browser: it loads, two images are flipped, and the console stays empty.
//! Without Chromium the test says so and passes.
#![allow(missing_docs, reason = "a test program")]

use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, PathTracer};
use pathspace::render::{Budget, Settings};
use pathspace::report::{Contestant, Plan, Reference, ReferencePlan, SceneInfo, Step, study};
use pathspace::scene::World;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Output};

const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Clicks through the page and leaves the outcome in an attribute of the document.
const PROBE: &str = "<script>
const outcome = [];
const check = (name, ok) => { if (!ok) outcome.push(name); };
const $ = (id) => document.getElementById(id);
check('images', [...document.images].every((i) => i.complete && i.naturalWidth > 0));
const [first, second] = [$('flip-first'), $('flip-second')];
check('choices', first.options.length > 4 && first.value !== second.value);
check('start', $('flip-a').src === $(first.value).src && $('flip-b').src === $(second.value).src && $('flip-a').src !== $('flip-b').src);
const clip = () => $('flip-b').style.clipPath;
const before = clip();
$('flip-button').click();
const after = clip();
$('flip-button').click();
check('flip', before !== after && after !== clip());
first.selectedIndex = 0;
first.dispatchEvent(new Event('change'));
check('change', $('flip-a').src === $('image-0').src);
check('width', document.documentElement.scrollWidth <= document.documentElement.clientWidth);
document.documentElement.dataset.outcome = outcome.length ? 'failed: ' + outcome.join(', ') : 'passed';
</script></body>";

fn browse(browser: &str, page: &Path, profile: &Path, width: u32) -> std::io::Result<Output> {
    Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
        ])
        .args([
            "--disable-component-update",
            "--disable-sync",
            "--enable-logging=stderr",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--window-size={width},800"))
        .arg(format!("file://{}", page.display()))
        .output()
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(browser) =
        BROWSERS.into_iter().find(|b| Command::new(b).arg("--version").output().is_ok())
    else {
        eprintln!("skipped: none of {} is installed", BROWSERS.join(", "));
        return;
    };
    let scene = gallery::build("cornell-box", UVec2::splat(32)).unwrap();
    let (paths, both) = (PathTracer::up_to(2), Bidirectional::up_to(2));
    let all: [Contestant<'_, World>; 2] = [
        Contestant::new("path-tracing", &paths, true),
        Contestant::new("bidirectional", &both, true),
    ];
    let quiet = &mut |_: &Step<'_>| ControlFlow::Continue(());
    let plan =
        ReferencePlan { budget: Budget::Samples(32), runs: 4, settings: Settings::default() };
    let reference =
        Reference::render(&scene.world, &*scene.camera, [&all[0], &all[1]], &plan, quiet).unwrap();
    let plan =
        Plan { budget: Budget::Samples(32), seeds: 4, pyramid: Some(both), ..Plan::default() };
    let info = SceneInfo { name: scene.name.to_owned(), ..SceneInfo::default() };
    let study = study(&scene.world, &*scene.camera, &info, &all, reference, &plan, quiet).unwrap();

    let directory = std::env::temp_dir().join(format!("pathspace-page-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let page = directory.join("index.html");
    std::fs::write(&page, study.page().replace("</body>", PROBE)).unwrap();
    for width in [400, 1200] {
        let output =
            browse(browser, &page, &directory.join(format!("profile-{width}")), width).unwrap();
        let (dom, log) =
            (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let console: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
        assert!(console.is_empty(), "{console:?}");
        let outcome = dom.split("data-outcome=\"").nth(1).and_then(|rest| rest.split('"').next());
        assert_eq!(outcome, Some("passed"), "at a width of {width}: {log}");
    }
    std::fs::remove_dir_all(&directory).unwrap();
}
