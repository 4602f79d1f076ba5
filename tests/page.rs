//! The page in a real browser: it loads, pictures are flipped, zoomed, exposed, compared and
//! measured, and the console stays empty.
//! Without Chromium the test says so and passes.
#![allow(missing_docs, reason = "a test program")]

use pathspace::film::Image;
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, PathTracer};
use pathspace::render::{Budget, Settings};
use pathspace::report::{
    Contestant, Plan, Reference, ReferencePlan, SceneInfo, Step, Study, exposure, signed_error_map,
    study,
};
use pathspace::scene::World;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Output};

const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Works with the page as a reader does, and leaves the outcome in an attribute of the document.
const PROBE: &str = r#"<script>
const outcome = [];
const check = (name, ok) => { if (!ok) outcome.push(name); };
const $ = (id) => document.getElementById(id);
const view = document.querySelector('#stage .view');
const image = (name, row) => document.querySelector(`img[data-name="${name}"][data-row="${row}"]`);
const shown = () => view.querySelector('img').src;
const press = (key, more) => {
  const options = { key, bubbles: true, cancelable: true, ...more };
  view.dispatchEvent(new KeyboardEvent('keydown', options));
};
const until = async (name, done) => {
  for (let i = 0; i < 200 && !done(); i++) await new Promise((go) => setTimeout(go, 10));
  check(name, done());
};
const seen = (img) => {
  const [a, b] = [img, img.parentElement].map((element) => element.getBoundingClientRect());
  return [(b.left - a.left) / a.width, (b.top - a.top) / a.height, a.width / b.width];
};
const same = (a, b) => a.every((x, i) => Math.abs(x - b[i]) < 0.02);
const result = () => outcome.length ? 'failed: ' + outcome.join(', ') : 'passed';
(async () => {
  await until('images', () => [...document.images].every((i) => i.complete && i.naturalWidth > 0));
  if (history.state) {
    outcome.push(...JSON.parse(window.name));
    check('kept picture', shown() === image('path-tracing', '1/16 of a run').src);
    check('kept stops', $('stops').value === '0.5' && $('against').value === '0');
    check('kept zoom', same(seen(image('reference', 'all runs')), [0.25, 0.25, 2]));
    check('kept focus', document.activeElement === view);
    return result();
  }
  check('choices', $('choices').children.length === 3 && $('row').options.length === 4);
  const [reference, best] = [image('reference', 'all runs'), image('bidirectional', 'all runs')];
  press('1');
  check('first', shown() === reference.src);
  press('ArrowRight');
  check('next', shown() === image('path-tracing', 'all runs').src);
  press('3');
  check('third', shown() === best.src);
  press(' ');
  check('flip', shown() === image('path-tracing', 'all runs').src);
  press('ArrowDown');
  check('budget', shown() === image('path-tracing', '1/16 of a run').src);
  press('ArrowUp');
  $('choices').children[2].click();
  check('click', shown() === best.src);
  check('pressed', $('choices').children[2].getAttribute('aria-pressed') === 'true');
  press('+');
  press('+');
  press('ArrowRight', { shiftKey: true });
  const parts = [...document.querySelectorAll('.view img')].map(seen);
  check('zoom', parts.every((part) => same(part, [0.4375, 0.375, 4])));
  await until('values', () => $('readout').innerText.includes('(18, 16)'));
  const cells = [...$('readout').querySelectorAll('tr')].map((row) => row.innerText.split(/\s+/));
  const values = VALUES;
  check('pixel', values.every(([red, green, blue], i) =>
    [red, green, blue].every((x, c) => Math.abs(cells[i + 1][c + 1] / x - 1) < 0.006)));
  press('ArrowDown');
  press('e');
  press('e');
  await until('exposure', () => document.querySelectorAll('.view canvas').length === 10);
  const canvas = view.querySelector('canvas');
  const pixel = (canvas) => [...canvas.getContext('2d').getImageData(18, 16, 1, 1).data];
  check('brighter', pixel(canvas).every((x, i) => Math.abs(x - EXPOSED[i]) <= 1));
  press('d');
  const other = () => view.querySelector('canvas');
  await until('difference', () => other() && other() !== canvas);
  check('error', pixel(other()).every((x, i) => Math.abs(x - ERROR[i]) <= 2));
  press('0');
  await until('reset', () => !document.querySelector('.view canvas'));
  press('ArrowUp');
  check('whole', same(seen(best), [0, 0, 1]));
  const focused = document.querySelectorAll('.strip .view')[1];
  focused.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
  check('brought', shown() === focused.querySelector('img').src);
  check('focus', document.activeElement === view);
  check('width', document.documentElement.scrollWidth <= document.documentElement.clientWidth);
  check('labels', [...document.querySelectorAll('img')].every((i) => i.alt)
    && [...document.querySelectorAll('select, input')].every((i) => i.closest('label')));
  for (const key of ['2', 'ArrowDown', '+', 'e', 'd']) press(key);
  window.name = JSON.stringify(outcome);
  location.reload();
  await new Promise(() => {});
})().catch(String).then((text) => { document.documentElement.dataset.outcome = text; });
</script></body>"#;

/// The probe, with what is expected at pixel (18, 16): values of a row, and colours of an image
/// after one sample, which is far from the reference.
fn probe(study: &Study) -> String {
    let (reference, shot) = (study.reference.image(), &study.images[1].snapshots[0].image);
    let row = [reference, &study.images[0].mean, &study.images[1].mean];
    let luminance = |image: &Image| image.get(18, 16).unwrap().luminance();
    assert!((luminance(shot) / luminance(reference) - 1.0).abs() > 0.01);
    let colours = |image: &Image, stops| {
        let bytes = image.to_srgb8(stops);
        let [r, g, b] = [0, 1, 2].map(|channel| bytes[3 * (16 * 32 + 18) + channel]);
        format!("[{r}, {g}, {b}, 255]")
    };
    PROBE
        .replace("VALUES", &format!("{:?}", row.map(|image| image.get(18, 16).unwrap().0)))
        .replace("EXPOSED", &colours(shot, exposure(reference) + 1.0))
        .replace("ERROR", &colours(&signed_error_map(shot, reference), 0.0))
}

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
            "--virtual-time-budget=20000",
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
    std::fs::write(&page, study.page().replace("</body>", &probe(&study))).unwrap();
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
