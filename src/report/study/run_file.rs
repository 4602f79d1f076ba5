//! Renderings of a study in files, so that several machines can share them out.
//!
//! A file is a line of JSON and then 64-bit floats: ledger, images at checkpoints, images on the way,
//! blocks of batches. Its name has the integrator and the number of the run.

use super::numbers;
use super::watch::{Shot, Watch};
use crate::film::{Image, replace_file};
use crate::math::Rgb;
use crate::path::{Counters, Ledger};
use crate::render::{Identity, Rendering, Shard};
use crate::report::error::{ReportError, file_error};
use crate::report::result::{DecisionReport, FindingsReport};
use crate::report::stats::{Batch, Cost, Layout};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The format of the files that this version writes and reads.
const FORMAT: u32 = 1;

/// The yield of one rendering to a study.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    /// Samples per pixel, cost and image at each checkpoint; the last is the whole.
    pub checkpoints: Vec<(u32, Cost, Image)>,
    pub batches: Vec<Batch>,
    pub snapshots: Vec<Shot>,
    pub counters: Counters,
    pub first_non_finite: Option<String>,
    pub decision: Option<DecisionReport>,
    pub findings: Option<FindingsReport>,
    identity: Option<Identity>,
}

/// A file of a rendering.
pub(super) struct RunFile {
    pub name: String,
    /// The number of the run.
    pub run: u32,
    /// The part of the study that it was made for.
    pub shard: Shard,
    pub drawn: Drawn,
}

#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    name: String,
    run: u32,
    shard: [u32; 2],
    size: [u32; 2],
    rendering: Option<BTreeMap<String, String>>,
    checkpoints: Vec<(u32, Cost)>,
    /// Part, samples per pixel and wall-clock seconds.
    snapshots: Vec<(f64, u32, f64)>,
    /// Samples per pixel.
    batches: Vec<f64>,
    counters: Counters,
    first_non_finite: Option<String>,
    decision: Option<DecisionReport>,
    findings: Option<FindingsReport>,
}

impl Drawn {
    pub fn new(watch: Watch, rendering: &Rendering) -> Self {
        let Watch { checkpoints, batches, snapshots, .. } = watch;
        let first = rendering.non_finite().first().map(|first| {
            let [x, y] = first.pixel.to_array();
            let (pass, technique) = (first.pass, first.contribution.technique);
            format!("pixel ({x}, {y}), sample {pass}, technique {technique}")
        });
        Self {
            checkpoints,
            batches,
            snapshots,
            counters: rendering.counters,
            first_non_finite: first,
            decision: rendering.notes.decision.as_ref().map(DecisionReport::from),
            findings: FindingsReport::of(&rendering.notes),
            identity: rendering.checkpoint.as_ref().map(|checkpoint| checkpoint.identity.clone()),
        }
    }

    /// The first difference between what this is a rendering of and what it should be, as text:
    /// what the warm-up was of, but for seed and samples per pixel.
    pub fn difference(
        &self,
        warm_up: Option<&Identity>,
        seed: u64,
        samples: u32,
    ) -> Option<String> {
        let (found, mut expected) = (self.identity.as_ref()?, warm_up?.clone());
        expected.0.insert("seed".to_owned(), seed.to_string());
        expected.0.insert("samples per pixel".to_owned(), samples.to_string());
        let [name, there, here] = expected.difference(found)?;
        Some(format!("its {name} is {there}, here it is {here}"))
    }
}

impl RunFile {
    /// The name of the file of a run.
    pub fn file_name(name: &str, run: u32) -> String {
        let name: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        format!("{name}-{run:04}.run")
    }

    pub fn save(&self, directory: &Path) -> Result<PathBuf, ReportError> {
        let path = directory.join(Self::file_name(&self.name, self.run));
        replace_file(&path, &self.encode()).map_err(file_error(&path))?;
        Ok(path)
    }

    pub fn load(path: &Path) -> Result<Self, ReportError> {
        let bytes = std::fs::read(path).map_err(file_error(path))?;
        decode(&bytes).ok_or_else(|| ReportError::Run {
            path: path.to_owned(),
            reason: "it is no file of a run, or damaged, or of another version".to_owned(),
        })
    }

    fn encode(&self) -> Vec<u8> {
        let Drawn { checkpoints, batches, snapshots, counters, .. } = &self.drawn;
        let size = checkpoints.last().map_or([0; 2], |(_, _, i)| [i.width(), i.height()]);
        let header = Header {
            format: FORMAT,
            name: self.name.clone(),
            run: self.run,
            shard: [self.shard.index(), self.shard.count()],
            size,
            rendering: self.drawn.identity.as_ref().map(|identity| identity.0.clone()),
            checkpoints: checkpoints.iter().map(|(samples, cost, _)| (*samples, *cost)).collect(),
            snapshots: snapshots.iter().map(|s| (s.part, s.samples, s.wall)).collect(),
            batches: batches.iter().map(|batch| batch.samples).collect(),
            counters: *counters,
            first_non_finite: self.drawn.first_non_finite.clone(),
            decision: self.drawn.decision.clone(),
            findings: self.drawn.findings,
        };
        let images = checkpoints.iter().map(|(.., image)| image);
        let images = images.chain(snapshots.iter().map(|shot| &shot.image));
        let pixels = images.flat_map(|image| image.pixels());
        let colours = counters.ledger.to_array().into_iter().chain(pixels.copied());
        let blocks = batches.iter().flat_map(|batch| batch.blocks.iter().copied());
        numbers::encode(&header, colours.flat_map(|colour| colour.0).chain(blocks))
    }
}

fn decode(bytes: &[u8]) -> Option<RunFile> {
    let (header, mut numbers) = numbers::decode::<Header>(bytes)?;
    let [width, height] = header.size;
    let (layout, pixels) = (Layout { width, height }, u64::from(width) * u64::from(height));
    let images = (header.checkpoints.len() + header.snapshots.len()) as u64;
    let colours = pixels.checked_mul(images)?.checked_add(6)?;
    let blocks = (header.batches.len() as u64).checked_mul(layout.blocks() as u64)?;
    let expected = colours.checked_mul(3)?.checked_add(blocks)?;
    if header.format != FORMAT || numbers.len() as u64 != expected {
        return None;
    }
    let mut colour = || Some(Rgb([numbers.next()?, numbers.next()?, numbers.next()?]));
    let mut ledger = [Rgb::BLACK; 6];
    for entry in &mut ledger {
        *entry = colour()?;
    }
    let mut image = || {
        let pixels = (0..pixels).map(|_| colour()).collect::<Option<_>>()?;
        Image::new(width, height, pixels)
    };
    let mut checkpoints = Vec::new();
    for (samples, cost) in header.checkpoints {
        checkpoints.push((samples, cost, image()?));
    }
    let mut snapshots = Vec::new();
    for (part, samples, wall) in header.snapshots {
        snapshots.push(Shot { part, samples, wall, image: image()? });
    }
    let batch =
        |samples| Batch { samples, blocks: numbers.by_ref().take(layout.blocks()).collect() };
    let batches = header.batches.into_iter().map(batch).collect();
    let [index, count] = header.shard;
    let drawn = Drawn {
        checkpoints,
        batches,
        snapshots,
        counters: Counters { ledger: Ledger::from_array(ledger), ..header.counters },
        first_non_finite: header.first_non_finite,
        decision: header.decision,
        findings: header.findings,
        identity: header.rendering.map(Identity),
    };
    let shard = Shard::new(index, count)?;
    Some(RunFile { name: header.name, run: header.run, shard, drawn })
}

/// The runs of a study in files.
pub(super) struct RunFiles(BTreeMap<String, PathBuf>);

impl RunFiles {
    /// All files of runs in some directories.
    pub fn find(directories: &[PathBuf]) -> Result<Self, ReportError> {
        let mut files = BTreeMap::<String, PathBuf>::new();
        for directory in directories {
            let entries = std::fs::read_dir(directory).map_err(file_error(directory))?;
            for entry in entries {
                let path = entry.map_err(file_error(directory))?.path();
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                if path.extension().is_none_or(|extension| extension != "run") {
                    continue;
                }
                if let Some(first) = files.insert(name, path.clone()) {
                    let reason = format!("it is there already, as {}", first.display());
                    return Err(ReportError::Run { path, reason });
                }
            }
        }
        Ok(Self(files))
    }

    /// The file of a run, which is that of job number `job` of so many.
    pub fn load(
        &self,
        name: &str,
        run: u32,
        [job, jobs]: [u32; 2],
    ) -> Result<(PathBuf, RunFile), ReportError> {
        let file_name = RunFile::file_name(name, run);
        if let Some(path) = self.0.get(&file_name) {
            return Ok((path.clone(), RunFile::load(path)?));
        }
        // Any other file tells how many shards there are.
        let other = self.0.values().find_map(|path| RunFile::load(path).ok());
        let count = other.map_or(1, |file| file.shard.count());
        let shard = (1..=count)
            .filter_map(|index| Shard::new(index, count))
            .find(|shard| shard.part_of(jobs).contains(&job));
        let reason = match shard {
            Some(shard) if count > 1 => format!("the run is missing, which shard {shard} makes"),
            _ => "the run is missing".to_owned(),
        };
        Err(ReportError::Run { path: PathBuf::from(file_name), reason })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_survives_its_file() {
        let image = |seed: f64| Image::from_fn(9, 5, |x, y| Rgb::splat(f64::from(x * y) + seed));
        let cost = Cost { wall: 0.1, cpu: f64::NAN, rays: 3.0, scattered: 0.0 };
        let ledger = Ledger { escaped: Rgb::splat(0.1), ..Ledger::default() };
        let drawn = Drawn {
            checkpoints: vec![(1, cost, image(0.1)), (2, cost, image(f64::NAN))],
            batches: vec![Batch { samples: 2.0, blocks: vec![0.5, f64::INFINITY] }],
            snapshots: vec![Shot { part: 0.25, samples: 1, wall: 0.5, image: image(0.2) }],
            counters: Counters { samples: u64::MAX, ledger, ..Counters::default() },
            first_non_finite: Some("two\nlines".to_owned()),
            decision: None,
            findings: None,
            identity: None,
        };
        let file = RunFile { name: "a".into(), run: 7, shard: Shard::WHOLE, drawn };
        let bytes = file.encode();
        let read = decode(&bytes).unwrap();
        assert_eq!((read.name.as_str(), read.run, read.encode()), ("a", 7, bytes.clone()));
        assert_eq!(read.drawn.counters, file.drawn.counters);
        assert!(decode(&bytes[..bytes.len() - 1]).is_none());
        assert!(decode(b"").is_none() && decode(b"{}\n").is_none());
    }
}
