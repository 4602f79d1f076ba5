//! The engine as the page asks it: jobs in JSON, and what they answer.

use pathspace_web::{Lesson, catalogue};
use serde::Serialize;
use serde_json::{Value, from_value, json, to_value};

fn value(thing: impl Serialize) -> Value {
    to_value(thing).expect("made of numbers and text")
}

fn lesson(scene: &str, size: u32) -> Lesson {
    open(json!({ "scene": scene, "width": size, "height": size })).expect("a scene of the gallery")
}

fn open(job: Value) -> Result<Lesson, String> {
    Lesson::new(&from_value(job).expect("a job"), None)
}

fn numbers(array: &Value) -> Vec<f64> {
    array.as_array().expect("numbers").iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn every_integrator_of_the_catalogue_renders() {
    let lesson = lesson("cornell-box", 8);
    let catalogue = value(catalogue());
    let names = catalogue["integrators"].as_array().expect("a list");
    assert_eq!(names.len(), 14);
    for entry in names {
        let job = json!({ "integrator": entry["name"], "samples": 3, "seed": 1 });
        let mut images = Vec::new();
        let finished = lesson
            .render(&from_value(job).expect("a job"), &mut |report, image| {
                images.push((value(report)["passes"].as_u64(), image.to_vec()));
                false
            })
            .unwrap_or_else(|error| panic!("{entry}: {error}"));
        let finished = value(finished);
        // The box needs neither merges nor blurred mirrors: without them nothing is biased.
        let leaves_out = entry["name"] == "vcm" || entry["name"] == "regularized";
        let expected = if leaves_out { &json!("unbiased") } else { &entry["estimator"] };
        assert_eq!(finished["estimator"], *expected, "{entry}");
        assert_eq!((finished["passes"].as_u64(), &finished["stopped"]), (Some(3), &json!(false)));
        let (passes, last) = images.last().expect("the end is shown");
        assert!(*passes == Some(3) && last.len() == 3 * 64, "{entry}");
        assert!(last.iter().all(|x| x.is_finite()) && last.iter().any(|x| *x > 0.0), "{entry}");
    }
    let claimed = &catalogue["scenes"][0]["sees"];
    assert_eq!(claimed.as_array().map(Vec::len), Some(14), "all see the Cornell box: {claimed}");
}

#[test]
fn progress_stops_a_rendering() {
    let job = json!({ "integrator": "path-tracing" });
    let finished =
        lesson("cornell-box", 8).render(&from_value(job).expect("a job"), &mut |_, _| true);
    let finished = value(finished.expect("valid"));
    assert_eq!((&finished["stopped"], &finished["passes"]), (&json!(true), &json!(1)));
}

#[test]
fn bad_jobs_are_refused_with_a_reason() {
    for (job, reason) in [
        (json!({ "scene": "nowhere", "width": 8, "height": 8 }), "nowhere"),
        (json!({ "scene": "file", "width": 8, "height": 8 }), "no file"),
        (json!({ "scene": "cornell-box", "width": 0, "height": 8 }), "0"),
        (json!({ "scene": "caustic", "width": 8, "height": 8, "roughness": -1 }), "-1"),
        (json!({ "scene": "caustic", "width": 8, "height": 8, "light_size": 0 }), "light_size"),
    ] {
        let error = open(job.clone()).expect_err("refused");
        assert!(error.contains(reason), "{job}: {error}");
    }
    let file = json!({ "scene": "file", "name": "x.glb", "width": 8, "height": 8 });
    let error =
        Lesson::new(&from_value(file).expect("a job"), Some(b"glTF?")).expect_err("no glTF");
    assert!(error.starts_with("x.glb: "), "{error}");

    let lesson = lesson("cornell-box", 8);
    let nothing = &mut |_: &_, _: &[f32]| false;
    for (job, reason) in [
        (json!({ "integrator": "ray-casting" }), "ray-casting"),
        (json!({ "integrator": "photon-mapping", "radius": -1, "samples": 1 }), "radius"),
        (json!({ "integrator": "vcm", "seconds": -1 }), "-1"),
        (json!({ "integrator": "vcm", "samples": 0 }), "zero samples"),
    ] {
        let error = lesson.render(&from_value(job).expect("a job"), nothing).expect_err("refused");
        assert!(error.contains(reason), "{error}");
    }
    let nothing = &mut |_: &_, _: &[f32]| false;
    for (job, reason) in [
        (json!({ "bounces": 9, "samples": 1 }), "9 bounces"),
        (json!({ "bounces": 2, "off": ["2;2"], "samples": 1 }), "2;2"),
        (json!({ "bounces": 2, "merges": true, "radius": -1, "samples": 1 }), "radius"),
        (json!({ "bounces": 2, "off": ["1,0"], "samples": 1 }), "(1, 0)"),
        (json!({ "bounces": 2, "off": ["merge 1,4"], "samples": 1 }), "(1, 4)"),
    ] {
        let job = from_value(job).expect("a job");
        let error = lesson.techniques(&job, nothing).expect_err("refused");
        assert!(error.contains(reason), "{error}");
    }
    let job = from_value(json!({ "x": 8, "y": 0 })).expect("a job");
    assert!(lesson.path(&job).expect_err("not in the picture").contains("8,0"));
    let job = json!({ "x": 4, "y": 4, "bounces": 1, "technique": "3,3" });
    assert!(lesson.path(&from_value(job).expect("a job")).is_err());
}

/// The pyramid of some techniques: its report, and the mean of the sum and of each layer.
fn pyramid(lesson: &Lesson, job: Value) -> (Value, Vec<f64>) {
    let mut means = Vec::new();
    let report = lesson.techniques(&from_value(job).expect("a job"), &mut |_, images| {
        let mean = |layer: &[f32]| layer.iter().map(|x| f64::from(*x)).sum::<f64>();
        means = images.chunks(3 * 16 * 16).map(|layer| mean(layer) / (3.0 * 256.0)).collect();
        false
    });
    (value(report.expect("valid")), means)
}

#[test]
fn layers_add_up_to_the_sum() {
    let lesson = lesson("caustic", 16);
    let off = ["1,3", "2,2", "merge 2,2", "0,2"];
    let job = json!({ "bounces": 3, "merges": true, "weighted": true, "off": off, "samples": 8 });
    let (report, means) = pyramid(&lesson, job);
    let layers = report["techniques"].as_array().expect("a list");
    assert_eq!(layers.len(), 2 + 3 + 4 + 5 + 1 + 2 + 3);
    assert_eq!(means.len(), 1 + layers.len());
    let sum: f64 = means[1..].iter().sum();
    assert!((sum / means[0] - 1.0).abs() < 1e-5, "{sum} {}", means[0]);
    let shares: f64 = layers.iter().map(|layer| layer["share"].as_f64().expect("a number")).sum();
    assert!((shares - 1.0).abs() < 1e-12, "{shares}");
    for (layer, mean) in layers.iter().zip(&means[1..]) {
        let is_off = off.contains(&layer["name"].as_str().expect("a name"));
        assert_eq!(layer["on"], json!(!is_off));
        assert!(!is_off || *mean == 0.0, "{layer}");
    }
}

/// Techniques are switched off, and those that are left draw the same image: means of 24 seeds,
/// within 4 standard errors of about 0.2 %.
#[test]
fn the_sum_stays_when_techniques_are_switched_off() {
    let lesson = lesson("cornell-box", 16);
    let moments = |off: &[&str], first: u64| {
        let means: Vec<f64> = (first..first + 24)
            .map(|seed| {
                let job = json!({ "bounces": 3, "off": off, "samples": 16, "seed": seed });
                pyramid(&lesson, job).1[0]
            })
            .collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let (all, v) = moments(&[], 0);
    for off in [&["1,2", "2,2"][..], &["0,3", "0,4", "1,4", "3,2"], &["2,1", "3,1", "4,1"]] {
        let (rest, w) = moments(off, 100);
        let error = (v + w).sqrt();
        assert!(error < 0.0025 * all, "{error} of {all}");
        assert!((rest - all).abs() < 4.0 * error, "{off:?}: {rest} {all} ± {error}");
    }
}

#[test]
fn a_path_on_the_board_is_whole() {
    let lesson = lesson("caustic", 16);
    let mut found = 0;
    for (x, y, merges) in [(8, 8, false), (4, 12, false), (8, 12, true), (12, 10, true)] {
        let job = json!({ "x": x, "y": y, "merges": merges, "seed": 3 });
        let board = value(lesson.path(&from_value(job).expect("a job")).expect("valid"));
        if board["found"] == json!(false) {
            assert!(board["reason"].is_string());
            continue;
        }
        found += 1;
        let vertices = board["vertices"].as_array().expect("a list");
        let steps = board["steps"].as_array().expect("a list");
        assert_eq!(steps.len() + 2, vertices.len());
        // T_k = f(x_k) G(x_k, x_(k+1)) T_(k-1), here without media.
        let mut throughput = [1.0; 3];
        for step in steps {
            let (f, g) = (numbers(&step["factor"]), step["g"].as_f64().expect("a number"));
            let expected = numbers(&step["throughput"]);
            for c in 0..3 {
                throughput[c] *= f[c] * g;
                assert!((throughput[c] - expected[c]).abs() <= 1e-12 * expected[c], "{step}");
            }
        }
        let ends = [&vertices[0], &vertices[vertices.len() - 1]].map(|x| numbers(&x["factor"]));
        let g = vertices[0]["g"].as_f64().expect("a number");
        for (c, contribution) in numbers(&board["contribution"]).iter().enumerate() {
            let product = ends[0][c] * g * throughput[c] * ends[1][c];
            assert!((product - contribution).abs() <= 1e-12 * contribution, "{board}");
        }
        let techniques = board["techniques"].as_array().expect("a list");
        let weights = techniques.iter().map(|t| t["weight"].as_f64().expect("a number"));
        assert!((weights.sum::<f64>() - 1.0).abs() < 1e-9, "{board}");
        for error in ["value_error", "weight_error", "weight_sum_error"] {
            assert!(board["verification"][error].as_f64().is_some_and(|e| e < 1e-6), "{board}");
        }
        let [column, row] = numbers(&vertices[1]["raster"])[..] else { panic!("{board}") };
        assert!((column.floor(), row.floor()) == (x.into(), y.into()), "{column} {row}");
    }
    assert!(found >= 2, "{found} of 4");
}

#[test]
fn points_are_projected_where_they_are_seen() {
    let lesson = lesson("cornell-box", 100);
    // The camera looks along z through the middle of the box.
    let points = [278.0, 273.0, 100.0, 278.0, 273.0, -1000.0];
    let raster = lesson.project(&points);
    assert!((raster[0] - 50.0).abs() < 1e-9 && (raster[1] - 50.0).abs() < 1e-9, "{raster:?}");
    assert!(raster[2].is_nan() && raster[3].is_nan(), "{raster:?}");
    let outline = lesson.outline();
    assert!(outline.len().is_multiple_of(6) && outline.iter().all(|x| (-1.0..600.0).contains(x)));
}
