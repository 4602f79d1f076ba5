//! References on disk, so that a scene's is rendered once.
//!
//! A file is a line of JSON and then 64-bit floats: the image, its variance, and the blocks of each
//! batch. Its name has a hash of everything that the reference depends on, the image of one sample
//! per pixel included: a scene or a renderer that has changed is noticed.

use super::method::Contestant;
use super::numbers;
use super::plan::{ReferencePlan, Step};
use crate::endpoint::Camera;
use crate::film::{Image, replace_file};
use crate::math::{Fingerprint, Rgb};
use crate::render::{Budget, Settings};
use crate::report::error::{ReportError, file_error};
use crate::report::stats::{Batch, Layout, Reference};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// The number of the rules that halves are put together by.
const RULES: u32 = 2;

#[derive(Serialize, Deserialize)]
struct Header {
    width: u32,
    height: u32,
    origin: String,
    missing: Vec<String>,
    /// Weight and samples of each batch, for each half.
    halves: Vec<(f64, Vec<f64>)>,
}

/// The reference of this plan from `directory`, or rendered and put there. `key` names the scene
/// and its depth; film, plan, integrators and an image of one sample per pixel become part of the
/// file's name. A file that cannot be read is rendered anew.
///
/// # Errors
/// As [`Reference::render`], or if the directory or the file cannot be written.
pub fn cached_reference<S: Scene + ?Sized>(
    directory: &Path,
    key: &str,
    scene: &S,
    camera: &dyn Camera,
    halves: [&Contestant<'_, S>; 2],
    plan: &ReferencePlan,
    progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Reference, ReportError> {
    let path = path_of(directory, key, scene, camera, halves, plan)?;
    if let Some(reference) = std::fs::read(&path).ok().and_then(|bytes| decode(&bytes)) {
        return Ok(reference);
    }
    let mut stopped = false;
    let reference = Reference::render(scene, camera, halves, plan, &mut |step| {
        let flow = progress(step);
        stopped |= flow.is_break();
        flow
    })?;
    if !stopped {
        std::fs::create_dir_all(directory).map_err(file_error(directory))?;
        replace_file(&path, &encode(&reference)).map_err(file_error(&path))?;
    }
    Ok(reference)
}

fn path_of<S: Scene + ?Sized>(
    directory: &Path,
    key: &str,
    scene: &S,
    camera: &dyn Camera,
    halves: [&Contestant<'_, S>; 2],
    plan: &ReferencePlan,
) -> Result<PathBuf, ReportError> {
    let Settings { seed, filter, sampler, .. } = plan.settings;
    let of = (RULES, key, camera.film(), plan.budget, plan.runs, seed, filter, sampler);
    let mut print = Fingerprint::default().with(of);
    for half in halves {
        let settings = Settings { budget: Budget::Samples(1), ..plan.settings };
        let rendering = half.method.render(scene, camera, &settings);
        let image = rendering
            .map_err(|source| ReportError::Render { name: half.name.clone(), source })?
            .image;
        print = print.with(&half.name).with(image);
    }
    let name: String =
        key.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).take(64).collect();
    Ok(directory.join(format!("{name}-{:016x}.reference", print.get())))
}

fn encode(reference: &Reference) -> Vec<u8> {
    let (image, halves) = (reference.image(), reference.halves());
    let header = Header {
        width: image.width(),
        height: image.height(),
        origin: reference.origin().to_owned(),
        missing: reference.missing().to_vec(),
        halves: halves
            .iter()
            .map(|(w, batches)| (*w, batches.iter().map(|b| b.samples).collect()))
            .collect(),
    };
    let images =
        [image, reference.variance()].into_iter().flat_map(|i| i.pixels().iter().flat_map(|p| p.0));
    let blocks = halves
        .iter()
        .flat_map(|(_, batches)| batches.iter().flat_map(|b| b.blocks.iter().copied()));
    numbers::encode(&header, images.chain(blocks))
}

fn decode(bytes: &[u8]) -> Option<Reference> {
    let (header, mut numbers) = numbers::decode::<Header>(bytes)?;
    let pixels = (u64::from(header.width) * u64::from(header.height)) as usize;
    let layout = Layout { width: header.width, height: header.height };
    let batches: usize = header.halves.iter().map(|(_, samples)| samples.len()).sum();
    let expected = pixels.checked_mul(6)?.checked_add(batches.checked_mul(layout.blocks())?)?;
    if numbers.len() != expected {
        return None;
    }
    let mut image = || {
        let pixels =
            (0..pixels).map(|_| Some(Rgb([numbers.next()?, numbers.next()?, numbers.next()?])));
        Image::new(header.width, header.height, pixels.collect::<Option<_>>()?)
    };
    let (mean, variance) = (image()?, image()?);
    let mut half = |(weight, samples): &(f64, Vec<f64>)| {
        let batch = |n: &f64| Batch {
            samples: *n,
            blocks: numbers.by_ref().take(layout.blocks()).collect(),
        };
        (*weight, samples.iter().map(batch).collect())
    };
    let halves = header.halves.iter().map(&mut half).collect();
    Some(Reference::new(mean, variance, header.origin, halves).ok()?.without(header.missing))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_survives_its_file() {
        let image =
            Image::from_fn(9, 5, |x, y| Rgb::new(f64::from(x) / 3.0, f64::from(y) * 0.1, 1e-300));
        let batch = |n: f64| Batch { samples: n, blocks: vec![n / 7.0, 0.1] };
        let halves = vec![(0.25, vec![batch(1.0), batch(2.0)]), (0.75, vec![batch(3.0)])];
        let reference =
            Reference::new(image.clone(), image, "two\nlines".to_owned(), halves).unwrap();
        let reference = reference.without(vec!["caustics".to_owned()]);
        let bytes = encode(&reference);
        assert_eq!(decode(&bytes), Some(reference));
        assert!(
            decode(&bytes[..bytes.len() - 1]).is_none()
                && decode(b"").is_none()
                && decode(b"{}\n").is_none()
        );
    }
}
