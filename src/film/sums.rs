//! The film: sums of contributions per pixel, filled chunk by chunk in any order.

use super::image::Image;
use super::{Contribution, FilmRegion, Sink, Technique};
use crate::math::{ExactSums, Rgb};
use glam::UVec2;
use std::hint::black_box;
use std::ops::Range;

/// Sums of contributions over the window of a film.
///
/// Samples are grouped into chunks, each recorded by a [`ChunkFilm`], and merged into sums that
/// [never round](ExactSums): the image is the same to the bit in whatever order chunks come, and
/// however many threads or machines filled them. A pixel takes 48 bytes.
#[derive(Clone, Debug)]
pub struct Film {
    region: FilmRegion,
    /// Three for each pixel.
    sums: ExactSums,
    non_finite: NonFinite,
}

/// A region that no film can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The window is empty or not inside the film.
    #[error("{window} is empty or not inside the film of {film}", window = window(.0), film = size(.0))]
    Window(FilmRegion),
    /// There is not enough memory for the pixels of the window, or more than 2³² - 1 of them.
    #[error("{window} takes too much memory, on the film of {film}", window = window(.0), film = size(.0))]
    TooLarge(FilmRegion),
}

fn window(region: &FilmRegion) -> String {
    format!("window {} to {}", region.window_min, region.window_max)
}

fn size(region: &FilmRegion) -> String {
    format!("{} × {} pixels", region.resolution.x, region.resolution.y)
}

/// Entries of a chunk whose sums are fetched before they are added.
const LOOKED_AT: usize = 32;

impl Film {
    /// A black film.
    ///
    /// # Errors
    /// If the window is empty, not inside the film, or too large.
    pub fn new(region: FilmRegion) -> Result<Self, FilmError> {
        let FilmRegion { window_min, window_max, .. } = region;
        if !Self::contains_window(&region) {
            return Err(FilmError::Window(region));
        }
        let pixels =
            u64::from(window_max.x - window_min.x) * u64::from(window_max.y - window_min.y);
        let pixels = u32::try_from(pixels).map_err(|_| FilmError::TooLarge(region))? as usize;
        let sums = pixels.checked_mul(3).and_then(|count| ExactSums::new(count).ok());
        let sums = sums.ok_or(FilmError::TooLarge(region))?;
        Ok(Self { region, sums, non_finite: NonFinite::default() })
    }

    /// A film of these sums, three for each pixel of the window.
    ///
    /// # Errors
    /// If the window is empty, not inside the film, or too large.
    #[cfg(feature = "checkpoint")]
    pub(crate) fn of(
        region: FilmRegion,
        sums: ExactSums,
        non_finite: NonFinite,
    ) -> Result<Self, FilmError> {
        match Self::contains_window(&region) {
            true => Ok(Self { region, sums, non_finite }),
            false => Err(FilmError::Window(region)),
        }
    }

    /// The sums, three for each pixel.
    #[cfg(feature = "checkpoint")]
    pub(crate) fn exact_sums(&self) -> &ExactSums {
        &self.sums
    }

    /// True if the window has pixels and they are all inside the film.
    pub(super) fn contains_window(region: &FilmRegion) -> bool {
        region.window_min.cmplt(region.window_max).all()
            && region.window_max.cmple(region.resolution).all()
    }

    /// The film's resolution and window.
    #[must_use]
    pub fn region(&self) -> FilmRegion {
        self.region
    }

    /// Sums over all contributions per pixel of the window, row-major.
    pub fn sums(&self) -> impl ExactSizeIterator<Item = Rgb> {
        (0..self.region.pixels()).map(|pixel| self.sum(pixel))
    }

    fn sum(&self, pixel: u32) -> Rgb {
        let first = pixel as usize * 3;
        Rgb([0, 1, 2].map(|channel| self.sums.get(first + channel)))
    }

    /// The values that were not added because they were infinite or not a number.
    #[must_use]
    pub fn non_finite(&self) -> &NonFinite {
        &self.non_finite
    }

    /// Adds what a chunk recorded.
    pub fn add(&mut self, chunk: &ChunkFilm) {
        for entries in chunk.entries.chunks(LOOKED_AT) {
            // Splats are anywhere: their memory is fetched together.
            let places = entries.iter().map(|(pixel, _)| *pixel as usize * 3);
            black_box(
                places
                    .map(|first| self.sums.rough(first) + self.sums.rough(first + 2))
                    .sum::<f64>(),
            );
            for &(pixel, value) in entries {
                self.sums.add_all(pixel as usize * 3, value.0);
            }
        }
        self.non_finite.merge(&chunk.non_finite);
    }

    /// Adds what another film of the same window recorded.
    pub(crate) fn merge(&mut self, other: &Self) {
        debug_assert_eq!(self.region, other.region);
        self.sums.merge(&other.sums);
        self.non_finite.merge(&other.non_finite);
    }

    /// The image after `samples` samples, spread evenly over the window: the sums times pixels /
    /// samples. Black if there are no samples.
    #[must_use]
    pub fn image(&self, samples: u64) -> Image {
        let pixels = f64::from(self.region.pixels());
        let scale = if samples == 0 { 0.0 } else { pixels / samples as f64 };
        let size = self.region.window_size();
        Image::from_fn(size.x, size.y, |x, y| self.sum(y * size.x + x) * scale)
    }
}

/// Contributions that were infinite or not a number. They are never added to a film and never
/// dropped silently.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NonFinite {
    counts: Vec<(Technique, u64)>,
    first: Option<NonFiniteContribution>,
}

/// One infinite or undefined contribution, and the sample that made it: ask the
/// [`SampleSource`](crate::sampler::SampleSource) for this pixel and pass to draw the path again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonFiniteContribution {
    /// Pixel of the full film that the sample belongs to.
    pub pixel: UVec2,
    /// Its number as the sample source counts it: row-major in the window.
    pub pixel_index: u32,
    /// Number of the sample within the pixel.
    pub pass: u32,
    /// The contribution itself.
    pub contribution: Contribution,
}

impl NonFinite {
    /// The number of all of them.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.counts.iter().map(|(_, n)| n).sum()
    }

    /// Their numbers per technique, ordered by (s, t).
    #[must_use]
    pub fn by_technique(&self) -> &[(Technique, u64)] {
        &self.counts
    }

    /// The first one in the order of samples.
    #[must_use]
    pub fn first(&self) -> Option<&NonFiniteContribution> {
        self.first.as_ref()
    }

    /// These counts and the first one.
    #[cfg(feature = "checkpoint")]
    pub(crate) fn of(counts: &[(Technique, u64)], first: Option<NonFiniteContribution>) -> Self {
        let mut non_finite = Self { counts: Vec::new(), first };
        counts.iter().for_each(|(technique, n)| non_finite.add(*technique, *n));
        non_finite
    }

    fn add(&mut self, technique: Technique, n: u64) {
        match self.counts.binary_search_by_key(&technique, |&(t, _)| t) {
            Ok(i) => self.counts[i].1 += n,
            Err(i) => self.counts.insert(i, (technique, n)),
        }
    }

    fn merge(&mut self, other: &Self) {
        for &(technique, n) in &other.counts {
            self.add(technique, n);
        }
        let order = |first: &NonFiniteContribution| (first.pass, first.pixel_index);
        self.first = [self.first, other.first].into_iter().flatten().min_by_key(order);
    }
}

/// Records the contributions of a chunk of samples to be merged into a [`Film`]. It is reused from
/// chunk to chunk.
///
/// Contributions of different samples may come in any order: they are recorded in that of the
/// samples.
#[derive(Clone, Debug)]
pub struct ChunkFilm {
    region: FilmRegion,
    entries: Vec<(u32, Rgb)>,
    /// The samples under way: the pixel of the first, those of the others follow, and what each
    /// added so far.
    first: u32,
    pass: u32,
    added: Vec<Added>,
    splats: Vec<Splat>,
    non_finite: NonFinite,
}

/// The sums of a sample: that of its own pixel, and the places of its first and last splat.
#[derive(Clone, Copy, Debug)]
struct Added {
    own: Rgb,
    splats: Option<(u32, u32)>,
}

/// A value that a sample adds to another pixel, and the place of its next one; 0 behind the last.
#[derive(Clone, Copy, Debug)]
struct Splat {
    pixel: u32,
    value: Rgb,
    next: u32,
}

impl ChunkFilm {
    /// An empty record of a region.
    #[must_use]
    pub fn new(region: FilmRegion) -> Self {
        Self {
            region,
            entries: Vec::new(),
            first: 0,
            pass: 0,
            added: Vec::new(),
            splats: Vec::new(),
            non_finite: NonFinite::default(),
        }
    }

    /// Forgets everything but keeps the memory.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.added.clear();
        self.splats.clear();
        self.non_finite = NonFinite::default();
    }

    /// Says which samples the next contributions come from: number `pass` of consecutive pixels,
    /// row-major in the window.
    #[inline]
    pub fn begin_samples(&mut self, pixels: Range<u32>, pass: u32) {
        self.finish();
        (self.first, self.pass) = (pixels.start, pass);
        self.added.resize(pixels.len(), Added { own: Rgb::BLACK, splats: None });
    }

    /// Ends the last samples. What they added is not merged before.
    #[inline]
    pub fn finish(&mut self) {
        for (Added { own, splats }, pixel) in self.added.drain(..).zip(self.first..) {
            if !own.is_black() {
                self.entries.push((pixel, own));
            }
            let mut next = splats.map(|(first, _)| first);
            while let Some(splat) = next.and_then(|place| self.splats.get(place as usize)) {
                self.entries.push((splat.pixel, splat.value));
                next = (splat.next > 0).then_some(splat.next);
            }
        }
        self.splats.clear();
    }

    /// The values that were not recorded because they were infinite or not a number.
    #[must_use]
    pub fn non_finite(&self) -> &NonFinite {
        &self.non_finite
    }

    #[cold]
    fn reject(&mut self, pixel_index: u32, contribution: &Contribution) {
        self.non_finite.add(contribution.technique, 1);
        let width = self.region.window_size().x.max(1);
        let pixel = self.region.window_min + UVec2::new(pixel_index % width, pixel_index / width);
        let rejected = NonFiniteContribution {
            pixel,
            pixel_index,
            pass: self.pass,
            contribution: *contribution,
        };
        let first = &mut self.non_finite.first;
        if first.is_none_or(|first| first.pass == self.pass && pixel_index < first.pixel_index) {
            *first = Some(rejected);
        }
    }
}

impl Sink for ChunkFilm {
    #[inline]
    fn add(&mut self, sample: usize, contribution: &Contribution) {
        let own = self.first + sample as u32;
        let value = contribution.value * contribution.weight;
        // A weight of 0 does not excuse an infinite value: the product is not a number.
        if !(value.is_finite() && contribution.value.is_finite() && contribution.raster.is_finite())
        {
            return self.reject(own, contribution);
        }
        if value.is_black() {
            return;
        }
        let Some(pixel) = self.region.pixel_index(contribution.raster) else { return };
        let Some(added) = self.added.get_mut(sample) else {
            return self.entries.push((pixel, value));
        };
        if pixel == own {
            added.own += value;
            return;
        }
        let place = self.splats.len() as u32;
        self.splats.push(Splat { pixel, value, next: 0 });
        if let Some((_, last)) = &mut added.splats {
            self.splats[*last as usize].next = place;
            *last = place;
        } else {
            added.splats = Some((place, place));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn region(resolution: [u32; 2], min: [u32; 2], max: [u32; 2]) -> FilmRegion {
        FilmRegion { resolution: resolution.into(), window_min: min.into(), window_max: max.into() }
    }

    fn contribution(x: f64, y: f64, value: f64, weight: f64) -> Contribution {
        Contribution {
            raster: DVec2::new(x, y),
            value: Rgb::splat(value),
            weight,
            technique: Technique::new(1, 2),
        }
    }

    #[test]
    fn sums_are_per_pixel_of_the_window() {
        let mut film = Film::new(region([8, 8], [2, 3], [5, 5])).unwrap();
        let mut chunk = ChunkFilm::new(film.region());
        chunk.begin_samples(0..2, 0);
        for (x, y) in [
            (2.0, 3.0),
            (4.999, 4.999),
            (2.5, 3.5),
            (5.0, 4.0),
            (1.999, 3.0),
            (2.0, 2.999),
            (-1e300, 4.0),
            (3.0, 5.0),
        ] {
            chunk.add(0, &contribution(x, y, 2.0, 0.5));
        }
        chunk.add(1, &contribution(2.1, 3.1, 1.0, 0.0));
        chunk.add(1, &contribution(4.5, 4.5, 10.0, 1.0));
        chunk.finish();
        film.add(&chunk);
        let sums: Vec<f64> = film.sums().map(|s| s.g()).collect();
        assert_eq!(sums, [2.0, 0.0, 0.0, 0.0, 0.0, 11.0]);
        assert_eq!(film.non_finite().count(), 0);
        let image = film.image(12);
        assert_eq!((image.width(), image.height(), image.get(2, 1)), (3, 2, Some(Rgb::splat(5.5))));
        assert_eq!(film.image(0).mean(), Rgb::BLACK);
    }

    #[test]
    fn non_finite_contributions_are_counted_where_they_happened() {
        let mut film = Film::new(region([4, 4], [1, 1], [4, 4])).unwrap();
        let mut chunk = ChunkFilm::new(film.region());
        let invalid = [
            contribution(1.5, 1.5, f64::NAN, 1.0),
            contribution(1.5, 1.5, f64::INFINITY, 0.0),
            contribution(1.5, 1.5, 1.0, f64::NAN),
            contribution(1.5, 1.5, 0.0, f64::INFINITY),
            contribution(1.5, 1.5, 1e200, 1e200),
            contribution(f64::NAN, 1.5, 1.0, 1.0),
        ];
        chunk.begin_samples(5..6, 9);
        chunk.add(0, &contribution(3.5, 3.5, 1.0, 1.0));
        invalid.iter().for_each(|c| chunk.add(0, c));
        chunk.add(0, &Contribution { technique: Technique::new(0, 3), ..invalid[1] });
        chunk.finish();
        film.add(&chunk);
        let lost = film.non_finite();
        assert_eq!(lost.by_technique(), [(Technique::new(0, 3), 1), (Technique::new(1, 2), 6)]);
        let first = lost.first().unwrap();
        assert_eq!((first.pixel, first.pass, first.pixel_index), (UVec2::new(3, 2), 9, 5));
        assert!(first.contribution.value.r().is_nan());
        assert_eq!(film.sums().sum::<Rgb>(), Rgb::WHITE);
        chunk.clear();
        assert_eq!(chunk.non_finite().count(), 0);
    }

    #[test]
    fn impossible_regions_are_refused() {
        for r in [
            region([0, 0], [0, 0], [0, 0]),
            region([4, 4], [2, 2], [2, 3]),
            region([4, 4], [3, 0], [2, 4]),
            region([4, 4], [0, 0], [5, 4]),
        ] {
            assert_eq!(Film::new(r).unwrap_err(), FilmError::Window(r));
        }
        let huge = FilmRegion::full(UVec2::MAX);
        assert_eq!(Film::new(huge).unwrap_err(), FilmError::TooLarge(huge));
    }

    /// 2²⁶ ones in f32 would stall at 2²⁴.
    #[test]
    fn many_small_contributions_do_not_stall() {
        let mut film = Film::new(FilmRegion::full(UVec2::ONE)).unwrap();
        let mut chunk = ChunkFilm::new(film.region());
        for i in 0..1024 {
            chunk.begin_samples(0..1, i);
            chunk.add(0, &contribution(0.5, 0.5, 1.0, 1.0));
        }
        chunk.finish();
        for _ in 0..1 << 16 {
            film.add(&chunk);
        }
        assert_eq!(film.image(1 << 26).get(0, 0), Some(Rgb::WHITE));
    }
}
