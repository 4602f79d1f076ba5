//! The book in `docs/book`: what its chapters include, name and link to is there. The tool that
//! builds it is silent about anchors that are missing.
#![allow(missing_docs, reason = "a test program")]

use pathspace::gallery;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const LARGEST_PICTURE: u64 = 80_000;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the root of the repository")
}

fn book() -> PathBuf {
    root().join("docs/book/src")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The names of the files in a directory.
fn files(directory: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(directory).expect("a directory").map(|entry| entry.expect("a file"));
    entries.map(|entry| entry.file_name().into_string().expect("a name")).collect()
}

/// The chapters by their file names, front page included.
fn chapters() -> BTreeMap<String, String> {
    let mut names = files(&book());
    names.retain(|name| name.ends_with(".md") && name != "SUMMARY.md");
    let text = |name: String| (name.clone(), read(&book().join(name)));
    names.into_iter().map(text).collect()
}

/// The texts between two marks.
fn between<'t>(text: &'t str, open: &'t str, close: &'t str) -> impl Iterator<Item = &'t str> {
    text.split(open).skip(1).filter_map(move |rest| Some(rest.split_once(close)?.0))
}

/// Fails with all complaints together.
#[track_caller]
fn assert_none(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn the_summary_lists_the_chapters() {
    let summary = read(&book().join("SUMMARY.md"));
    let listed: BTreeSet<String> = between(&summary, "](", ")").map(str::to_owned).collect();
    assert_eq!(listed, chapters().into_keys().collect());
}

#[test]
fn a_chapter_has_all_its_parts() {
    let parts = [
        ("a formula", "`$"),
        ("a picture", "](pictures/"),
        ("included code", "{{#include "),
        ("a test", ".rs::"),
        ("an exercise", "**Exercise.**"),
        ("an answer", "<details><summary>Answer</summary>"),
        ("a link to the page", "](../index.html#"),
    ];
    let mut missing = Vec::new();
    for (name, text) in chapters().iter().filter(|(name, _)| *name != "index.md") {
        let lacks = parts.iter().filter(|(_, sign)| !text.contains(sign));
        missing.extend(lacks.map(|(part, _)| format!("{name} lacks {part}")));
        if text.matches("<div").count() != text.matches("</div>").count() {
            missing.push(format!("{name} does not close what it opens"));
        }
    }
    assert_none(&missing);
}

/// Rust is included and nothing else, so that it compiles; the anchors have lines between them, and
/// none is left of what is not included any more.
#[test]
fn code_is_included_from_sources() {
    let (mut complaints, mut included) = (Vec::new(), BTreeSet::new());
    for (name, text) in chapters() {
        for block in between(&text, "```rust", "```") {
            let other = block.lines().skip(1).find(|l| !(l.is_empty() || l.starts_with("{{#")));
            complaints.extend(other.map(|line| format!("{name}: code of its own: {line}")));
        }
        for include in between(&text, "{{#include ", "}}") {
            let (path, anchor) = include.split_once(':').expect("a file and an anchor");
            let path = fs::canonicalize(book().join(path)).expect(path);
            let lines = between_anchors(&read(&path), anchor);
            if lines.iter().all(|line| line.trim().is_empty()) {
                complaints.push(format!("{name}: nothing to include as {include}"));
            }
            included.insert((path, anchor.to_owned()));
        }
    }
    for directory in ["src", "tests", "examples"] {
        each_source(&root().join(directory), &mut |path| {
            let text = read(path);
            for anchor in text.lines().filter_map(|l| l.trim().strip_prefix("// ANCHOR: ")) {
                let path = fs::canonicalize(path).expect("a file");
                if !included.contains(&(path, anchor.to_owned())) {
                    complaints.push(format!("{anchor} is not included"));
                }
            }
        });
    }
    assert_none(&complaints);
}

fn between_anchors(text: &str, anchor: &str) -> Vec<String> {
    let [first, last] = ["ANCHOR", "ANCHOR_END"].map(|mark| format!("// {mark}: {anchor}"));
    let inside = text.lines().skip_while(|line| line.trim() != first).skip(1);
    let lines: Vec<String> = inside.map(str::to_owned).collect();
    let end = lines.iter().position(|line| line.trim() == last);
    lines[..end.unwrap_or(0)].to_vec()
}

fn each_source(directory: &Path, visit: &mut impl FnMut(&Path)) {
    for name in files(directory) {
        let path = directory.join(&name);
        if path.is_dir() {
            each_source(&path, visit);
        } else if name.ends_with(".rs") {
            visit(&path);
        }
    }
}

/// `path.rs::name` is a test that is run by default, `path.rs` a file.
#[test]
fn tests_and_files_that_are_named_exist() {
    let mut complaints = Vec::new();
    for (name, text) in chapters() {
        for code in text.split('`').filter(|code| code.ends_with(".rs") || code.contains(".rs::")) {
            let (path, function) = code.split_once("::").unwrap_or((code, ""));
            let Ok(source) = fs::read_to_string(root().join(path)) else {
                complaints.push(format!("{name}: there is no file {path}"));
                continue;
            };
            let is_test = |before: &str| {
                let attributes = before.rsplit("\n\n").next().unwrap_or_default();
                attributes.contains("#[test]") && !attributes.contains("#[ignore")
            };
            let found = source.split_once(&format!("fn {function}("));
            if !(function.is_empty() || found.is_some_and(|(before, _)| is_test(before))) {
                complaints.push(format!("{name}: {path} has no test {function}"));
            }
        }
    }
    assert_none(&complaints);
}

/// The names of the command line, as it spells them.
fn integrators() -> BTreeSet<String> {
    let source = read(&root().join("examples/common/integrators.rs"));
    let (_, names) = source.split_once("fn name(self)").expect("the names of integrators");
    let (names, _) = names.split_once("\n    }\n").expect("the end of a function");
    between(names, "=> \"", "\"").map(str::to_owned).collect()
}

#[test]
fn links_lead_somewhere() {
    let (mut complaints, mut shown) = (Vec::new(), BTreeSet::new());
    let integrators = integrators();
    assert!(integrators.contains("path-tracing") && integrators.len() > 10, "{integrators:?}");
    for (name, text) in chapters() {
        for target in between(&text, "](", ")") {
            let is_there = match target.strip_prefix("../index.html#") {
                Some(settings) => {
                    settings.split('&').all(|setting| is_known(setting, &integrators))
                }
                None => book().join(target).exists(),
            };
            if !is_there {
                complaints.push(format!("{name}: {target}"));
            }
            shown.extend(target.strip_prefix("pictures/").map(str::to_owned));
        }
    }
    assert_none(&complaints);
    let pictures = book().join("pictures");
    assert_eq!(shown, files(&pictures), "pictures that are shown, and that are there");
    for picture in shown {
        let size = fs::metadata(pictures.join(&picture)).expect("a file").len();
        assert!(size <= LARGEST_PICTURE, "{picture} has {size} bytes");
    }
}

/// True if the interactive page understands a setting.
fn is_known(setting: &str, integrators: &BTreeSet<String>) -> bool {
    match setting.split_once('=') {
        Some(("scene", scene)) => gallery::NAMES.contains(&scene),
        Some(("integrators", names)) => names.split(',').all(|name| integrators.contains(name)),
        Some(("depth" | "seed", count)) => count.parse::<u32>().is_ok(),
        Some(("light" | "roughness" | "radius", value)) => value.parse::<f64>().is_ok(),
        Some(("board" | "pyramid", value)) => value == "1",
        _ => false,
    }
}

/// A formula is code between dollars. What looks like the beginning of a list, of a heading or of a
/// quotation would end it, and one that lacks a brace cannot be typeset.
#[test]
fn formulas_are_whole() {
    let mut complaints = Vec::new();
    for (name, text) in chapters() {
        let count = text.matches("$`").count();
        if count != text.matches("`$").count() {
            complaints.push(format!("{name}: a formula does not end"));
        }
        for formula in between(&text, "$`", "`$") {
            // Commands that go on, such as \leftrightarrow, are others.
            let count = |mark: &str| {
                let after = formula.split(mark).skip(1);
                after.filter(|rest| !rest.starts_with(|c: char| c.is_ascii_alphabetic())).count()
            };
            let is_paired = count("\\left") == count("\\right")
                && count("\\begin") == count("\\end")
                && formula.matches('{').count() == formula.matches('}').count();
            let breaks = formula.lines().skip(1).any(|line| {
                let first = line.split(' ').next().unwrap_or_default();
                matches!(first, "+" | "-" | "*" | "#" | ">")
            });
            if !is_paired || breaks || formula.contains("\n\n") {
                complaints.push(format!("{name}: {formula}"));
            }
        }
    }
    assert_none(&complaints);
}

/// The book can be read without a network.
#[test]
fn nothing_is_fetched() {
    let mut texts: Vec<(String, String)> = chapters().into_iter().collect();
    for path in ["book.toml", "book.css", "theme/head.hbs", "src/page.js", "src/SUMMARY.md"] {
        texts.push((path.to_owned(), read(&root().join("docs/book").join(path))));
    }
    for (name, text) in texts {
        assert!(!text.contains("://"), "{name} names a host");
    }
}
