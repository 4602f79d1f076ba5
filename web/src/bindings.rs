//! The engine as JavaScript sees it.
#![allow(missing_docs, reason = "the functions of the engine, which are documented")]

use crate::{Fallible, lesson};
use js_sys::{Error, Float32Array, Function};
use serde::Serialize;
use serde::de::DeserializeOwned;
use wasm_bindgen::prelude::*;

fn read<T: DeserializeOwned>(json: &str) -> Fallible<T> {
    serde_json::from_str(json).map_err(|error| format!("the request is no such job: {error}"))
}

fn write<T: Serialize>(value: &T) -> Fallible<String> {
    serde_json::to_string(value).map_err(|error| error.to_string())
}

fn thrown(reason: String) -> Error {
    Error::new(&reason)
}

/// Tells a callback; true if it wants to stop.
fn tell<T: Serialize>(progress: &Function, report: &T, image: &[f32]) -> bool {
    let Ok(report) = write(report) else { return true };
    let image = Float32Array::from(image);
    match progress.call2(&JsValue::NULL, &report.into(), &image.into()) {
        Ok(answer) => answer.is_truthy(),
        // Nobody listens any more.
        Err(_) => true,
    }
}

#[wasm_bindgen]
pub fn catalogue() -> Result<String, Error> {
    write(&crate::catalogue()).map_err(thrown)
}

#[wasm_bindgen]
#[derive(Debug)]
pub struct Lesson(lesson::Lesson);

#[wasm_bindgen]
impl Lesson {
    #[wasm_bindgen(constructor)]
    pub fn new(scene: &str, file: Option<Box<[u8]>>) -> Result<Self, Error> {
        let job = read(scene).map_err(thrown)?;
        lesson::Lesson::new(&job, file.as_deref()).map(Self).map_err(thrown)
    }

    pub fn describe(&self) -> Result<String, Error> {
        write(&self.0.summary()).map_err(thrown)
    }

    pub fn outline(&self) -> Box<[f32]> {
        self.0.outline().into()
    }

    pub fn project(&self, points: &[f64]) -> Box<[f64]> {
        self.0.project(points).into()
    }

    pub fn render(&self, job: &str, progress: &Function) -> Result<String, Error> {
        let rendered =
            |job| self.0.render(&job, &mut |report, image| tell(progress, report, image));
        read(job).and_then(rendered).and_then(|result| write(&result)).map_err(thrown)
    }

    pub fn techniques(&self, job: &str, progress: &Function) -> Result<String, Error> {
        let drawn =
            |job| self.0.techniques(&job, &mut |report, image| tell(progress, report, image));
        read(job).and_then(drawn).and_then(|result| write(&result)).map_err(thrown)
    }

    pub fn path(&self, job: &str) -> Result<String, Error> {
        read(job).and_then(|job| self.0.path(&job)).and_then(|path| write(&path)).map_err(thrown)
    }
}
