//! Files of checkpoints: NumPy archives.
//!
//! | array | contents |
//! |---|---|
//! | `header` | text in JSON, as bytes: what is rendered, passes, counters, the caller's entries |
//! | `sums` | (height, width, 3): the film's sums, each the f64 nearest to it |
//! | `lost` | (height, width, 3): what rounding took from them |
//! | `rest_index`, `rest` | what it took from those, where it took anything, by the place in `sums` |
//! | `ledger` | (18, …): the energy ledger, each row numbers that add up to an entry |
//! | `preparation_ledger` | (18,): the ledger of what was done before the first pass |
//! | `earlier_image` | (height, width, 3): the image that the estimate of the error compares with |
//! | `first_non_finite` | (6,): position, value and weight of the first invalid contribution |
//!
//! The image is `sums / passes`. Sums that are the same make the same file but for its times.

use super::identity::Identity;
use super::state::{CounterSums, State, Times};
use super::target::Watch;
use super::{Checkpoint, Shard};
use crate::film::{
    Contribution, Film, FilmRegion, Image, NonFinite, NonFiniteContribution, Technique,
    replace_file_with,
};
use crate::math::{ExactSums, Rgb};
use crate::path::{Counters, Ledger};
use glam::{DVec2, UVec2};
use npyz::{NpyFile, WriterBuilder};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// The format of the files that this version writes and reads.
const FORMAT: u32 = 1;

/// The longest header of an array, in bytes.
const LONGEST_HEADER: u64 = 1 << 16;

/// A checkpoint could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("checkpoint {}: {reason}", path.display())]
pub struct CheckpointFileError {
    /// The file.
    pub path: PathBuf,
    /// The reason, in words.
    pub reason: String,
}

#[derive(Serialize, Deserialize)]
struct Format {
    format: u32,
}

/// All that is no array.
#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    rendering: BTreeMap<String, String>,
    shard: [u32; 2],
    passes: [u32; 2],
    resolution: [u32; 2],
    window: [[u32; 2]; 2],
    counters: Counters,
    preparation: Counters,
    non_finite: Vec<(Technique, u64)>,
    first_non_finite: Option<First>,
    /// The bits of the estimated error times passes.
    relative_variance: Option<u64>,
    /// On the wall, before the first pass, and of all threads.
    nanoseconds: [u64; 3],
    metadata: BTreeMap<String, String>,
}

/// The part of a contribution that is whole numbers.
#[derive(Serialize, Deserialize)]
struct First {
    pixel: [u32; 2],
    pixel_index: u32,
    pass: u32,
    technique: Technique,
}

impl Checkpoint {
    /// Writes a file, which replaces an older one only when it is whole.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), CheckpointFileError> {
        let path = path.as_ref();
        replace_file_with(path, |file| self.write(file)).map_err(|error| CheckpointFileError {
            path: path.to_owned(),
            reason: error.to_string(),
        })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, or has another format than that of this version.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, CheckpointFileError> {
        let path = path.as_ref();
        Archive::open(path).and_then(Archive::checkpoint).map_err(|error| CheckpointFileError {
            path: path.to_owned(),
            reason: error.to_string(),
        })
    }

    fn write(&self, file: &mut File) -> io::Result<()> {
        let State { passes, film, counters, prepared, watch, times } = &self.state;
        let region = film.region();
        let first = film.non_finite().first();
        let header = Header {
            format: FORMAT,
            rendering: self.identity.0.clone(),
            shard: [self.shard.index(), self.shard.count()],
            passes: [passes.start, passes.end],
            resolution: region.resolution.into(),
            window: [region.window_min.into(), region.window_max.into()],
            counters: counters.counts,
            preparation: *prepared,
            non_finite: film.non_finite().by_technique().to_vec(),
            first_non_finite: first.map(|first| First {
                pixel: first.pixel.into(),
                pixel_index: first.pixel_index,
                pass: first.pass,
                technique: first.contribution.technique,
            }),
            relative_variance: watch.as_ref().and_then(|watch| watch.variance).map(f64::to_bits),
            nanoseconds: [times.wall, times.preparation, times.threads]
                .map(|time| time.as_nanos() as u64),
            metadata: self.metadata.clone(),
        };
        let mut archive = ZipWriter::new(BufWriter::new(file));
        match self.fill(&mut archive, &header) {
            Ok(()) => archive.finish()?.flush(),
            Err(error) => {
                // Dropped, it would print that it is not finished.
                std::mem::forget(archive);
                Err(error)
            }
        }
    }

    fn fill(&self, archive: &mut ZipWriter<impl Write + Seek>, header: &Header) -> io::Result<()> {
        let State { film, counters, prepared, watch, .. } = &self.state;
        let size = film.region().window_size();
        let pixels = [u64::from(size.y), u64::from(size.x), 3];
        let header = serde_json::to_vec_pretty(header)?;
        write_array(archive, "header", &[header.len() as u64], header)?;
        let sums = film.exact_sums();
        for (part, name) in ["sums", "lost"].into_iter().enumerate() {
            let numbers = (0..sums.len()).map(|index| sums.leading(index)[part]);
            write_array(archive, name, &pixels, numbers)?;
        }
        let (places, rest): (Vec<u64>, Vec<f64>) =
            sums.trailing().map(|(index, rest)| (index as u64, rest)).unzip();
        let length = [rest.len() as u64];
        write_array(archive, "rest_index", &length, places)?;
        write_array(archive, "rest", &length, rest)?;
        let ledger: Vec<Vec<f64>> =
            (0..counters.ledger.len()).map(|index| counters.ledger.parts(index)).collect();
        let width = ledger.iter().map(Vec::len).max().unwrap_or(0);
        let row = |parts: &Vec<f64>| {
            parts.clone().into_iter().chain(std::iter::repeat(0.0)).take(width).collect::<Vec<_>>()
        };
        let shape = [ledger.len() as u64, width as u64];
        write_array(archive, "ledger", &shape, ledger.iter().flat_map(row))?;
        let entries = prepared.ledger.to_array().into_iter().flat_map(|entry| entry.0);
        write_array(archive, "preparation_ledger", &[18], entries)?;
        if let Some(image) = watch.as_ref().and_then(|watch| watch.before.as_ref()) {
            let numbers = image.pixels().iter().flat_map(|pixel| pixel.0);
            write_array(archive, "earlier_image", &pixels, numbers)?;
        }
        let first = film.non_finite().first();
        if let Some(Contribution { raster, value, weight, .. }) = first.map(|f| f.contribution) {
            let [x, y] = raster.to_array();
            let [r, g, b] = value.0;
            write_array(archive, "first_non_finite", &[6], [x, y, r, g, b, weight])?;
        }
        Ok(())
    }
}

fn write_array<T: npyz::AutoSerialize>(
    archive: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[u64],
    numbers: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    archive.start_file(npyz::npz::file_name_from_array_name(name), options)?;
    let mut array =
        npyz::WriteOptions::new().default_dtype().shape(shape).writer(archive).begin_nd()?;
    array.extend(numbers)?;
    array.finish()
}

/// A file to be read.
struct Archive {
    zip: ZipArchive<BufReader<File>>,
    /// Bytes of the file.
    length: u64,
}

fn damaged(reason: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason.into())
}

impl Archive {
    fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { zip: ZipArchive::new(BufReader::new(file))?, length })
    }

    /// The numbers of an array, and its shape.
    fn array<T: npyz::Deserialize>(&mut self, name: &str) -> io::Result<(Vec<T>, Vec<u64>)> {
        let in_array = |error: &dyn std::fmt::Display| damaged(format!("array {name}: {error}"));
        let mut entry = self
            .zip
            .by_name(&npyz::npz::file_name_from_array_name(name))
            .map_err(|error| in_array(&error))?;
        // Nothing that the file is too short for is believed.
        let bytes = entry.size();
        if bytes > self.length {
            return Err(in_array(&"it is longer than the file"));
        }
        let array = NpyFile::new((&mut entry).take(bytes)).map_err(|error| in_array(&error))?;
        let shape = array.shape().to_vec();
        let count = shape.iter().try_fold(1u64, |count, side| count.checked_mul(*side));
        let most = bytes / size_of::<T>() as u64;
        if count.is_none_or(|count| count > most) || array.order() != npyz::Order::C {
            return Err(in_array(&format!("its shape {shape:?} does not fit its length")));
        }
        let numbers = array.into_vec().map_err(|error| in_array(&error))?;
        // At the end of an entry its checksum is compared.
        match io::copy(&mut entry, &mut io::sink()).map_err(|error| in_array(&error))? {
            0..LONGEST_HEADER => Ok((numbers, shape)),
            _ => Err(in_array(&"there is more in it than its shape says")),
        }
    }

    /// An array of a known shape.
    fn numbers(&mut self, name: &str, shape: &[u64]) -> io::Result<Vec<f64>> {
        let (numbers, found) = self.array(name)?;
        match found == shape {
            true => Ok(numbers),
            false => Err(damaged(format!("array {name} is {found:?} and not {shape:?}"))),
        }
    }

    fn header(&mut self) -> io::Result<Header> {
        let (text, _) = self.array::<u8>("header")?;
        let in_header = |error: serde_json::Error| damaged(format!("array header: {error}"));
        let Format { format } = serde_json::from_slice(&text).map_err(in_header)?;
        match format {
            FORMAT => serde_json::from_slice(&text).map_err(in_header),
            _ => Err(damaged(format!("its format is {format}, this version has {FORMAT}"))),
        }
    }

    fn checkpoint(mut self) -> io::Result<Checkpoint> {
        let header = self.header()?;
        let [window_min, window_max] = header.window.map(UVec2::from);
        let region = FilmRegion { resolution: header.resolution.into(), window_min, window_max };
        let size = (region.window_min.cmplt(region.window_max).all())
            .then(|| region.window_size())
            .ok_or_else(|| damaged("its window is empty"))?;
        let pixels = [u64::from(size.y), u64::from(size.x), 3];
        let sums = self.numbers("sums", &pixels)?;
        let lost = self.numbers("lost", &pixels)?;
        let mut sums: ExactSums = sums.into_iter().zip(lost).map(<[f64; 2]>::from).collect();
        let (places, _) = self.array::<u64>("rest_index")?;
        let rest = self.numbers("rest", &[places.len() as u64])?;
        for (place, rest) in places.into_iter().zip(rest) {
            sums.add(usize::try_from(place).unwrap_or(usize::MAX), rest);
        }
        let non_finite = self.non_finite(&header)?;
        let film = Film::of(region, sums, non_finite).map_err(|e| damaged(e.to_string()))?;

        let mut counters = CounterSums { counts: header.counters, ..CounterSums::default() };
        let (parts, shape) = self.array::<f64>("ledger")?;
        let entries = counters.ledger.len();
        if shape.len() != 2 || shape[0] != entries as u64 {
            return Err(damaged(format!("array ledger is {shape:?} and not of {entries} rows")));
        }
        for (index, part) in parts.iter().enumerate() {
            counters.ledger.add(index / (parts.len() / entries).max(1), *part);
        }
        let prepared = self.numbers("preparation_ledger", &[entries as u64])?;
        let prepared: Vec<Rgb> =
            prepared.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect();
        let prepared = <[Rgb; 6]>::try_from(prepared).map(Ledger::from_array).unwrap_or_default();
        let prepared = Counters { ledger: prepared, ..header.preparation };

        let watch = self.watch(&header, size, &pixels)?;
        let [index, count] = header.shard;
        let shard = Shard::new(index, count)
            .ok_or_else(|| damaged(format!("there is no shard {index}/{count}")))?;
        let [start, end] = header.passes;
        if start > end {
            return Err(damaged(format!("its passes end before they begin, {start} to {end}")));
        }
        let [wall, preparation, threads] = header.nanoseconds.map(Duration::from_nanos);
        let times = Times { wall, preparation, threads };
        let film = Arc::new(film);
        let state = State { passes: start..end, film, counters, prepared, watch, times };
        let identity = Identity(header.rendering);
        Ok(Checkpoint { identity, shard, state, metadata: header.metadata })
    }

    fn watch(&mut self, header: &Header, size: UVec2, pixels: &[u64]) -> io::Result<Option<Watch>> {
        let target = header.rendering.get("target error").and_then(|target| target.parse().ok());
        let Some(target) = target else { return Ok(None) };
        let mut watch = Watch::new(target);
        watch.variance = header.relative_variance.map(f64::from_bits);
        if self.zip.index_for_name("earlier_image.npy").is_some() {
            let numbers = self.numbers("earlier_image", pixels)?;
            let image = numbers.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect();
            watch.before = Image::new(size.x, size.y, image).map(Arc::new);
        }
        Ok(Some(watch))
    }

    fn non_finite(&mut self, header: &Header) -> io::Result<NonFinite> {
        let first = header.first_non_finite.as_ref().map(|first| {
            let numbers = self.numbers("first_non_finite", &[6])?;
            let contribution = Contribution {
                raster: DVec2::new(numbers[0], numbers[1]),
                value: Rgb::new(numbers[2], numbers[3], numbers[4]),
                weight: numbers[5],
                technique: first.technique,
            };
            let First { pixel, pixel_index, pass, .. } = *first;
            io::Result::Ok(NonFiniteContribution {
                pixel: pixel.into(),
                pixel_index,
                pass,
                contribution,
            })
        });
        Ok(NonFinite::of(&header.non_finite, first.transpose()?))
    }
}
