//! The film: the contributions of integrators, and the image that is made of them.
//!
//! A path adds its weighted estimate `w f/p` to the pixel that it is seen in, so pixel j averages
//! `I_j = ∫ h_j(x̄) f(x̄) dμ(x̄)`, h_j the pixel's filter.
//!
//! | what | item |
//! |---|---|
//! | resolution and rendered window | [`FilmRegion`] |
//! | position of a sample, with the filter's displacement | [`FilmSample`], [`Sample`] |
//! | pixel filter | [`Filter`], [`Kernel`] |
//! | estimate of one path, and the technique that drew it | [`Contribution`], [`Technique`] |
//! | receiver of contributions, splats included | [`Sink`] |
//! | sums per pixel, which no order of contributions changes | [`Film`], [`ChunkFilm`] |
//! | contributions that are infinite or not a number | [`NonFinite`] |
//! | finished image, and its files (feature `image`) | [`Image`], `ImageFile` |
//!
//! Filters are sampled and not evaluated (filter importance sampling: Ernst, Stamminger and
//! Greiner 2006), so neither contributions nor their weights need to know them.

mod filter;
mod image;
#[cfg(feature = "image")]
mod output;
mod sums;
#[cfg(any(feature = "image", feature = "checkpoint"))]
mod whole;

pub use filter::{Filter, FilterError, Kernel};
pub use image::{Image, linear_from_srgb, srgb_from_linear};
#[cfg(feature = "image")]
pub use output::{ImageFile, OutputError};
pub use sums::{ChunkFilm, Film, FilmError, NonFinite, NonFiniteContribution};
#[cfg(any(feature = "image", feature = "checkpoint"))]
pub use whole::{check_replaceable, replace_file, replace_file_with};

use crate::math::Rgb;
use crate::sampler::{Sampler, Stream};
use glam::{DVec2, UVec2};
use std::fmt;

/// A film's resolution and the window of it that is rendered, in pixels; (0, 0) is the upper left
/// corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FilmRegion {
    /// Full resolution.
    pub resolution: UVec2,
    /// First rendered pixel.
    pub window_min: UVec2,
    /// One past the last rendered pixel.
    pub window_max: UVec2,
}

impl FilmRegion {
    /// The whole film of the given resolution.
    #[must_use]
    pub fn full(resolution: UVec2) -> Self {
        Self { resolution, window_min: UVec2::ZERO, window_max: resolution }
    }

    /// Width and height of the window in pixels.
    #[inline]
    #[must_use]
    pub fn window_size(&self) -> UVec2 {
        self.window_max - self.window_min
    }

    /// Number of pixels in the window.
    #[must_use]
    pub fn pixels(&self) -> u32 {
        let size = self.window_size();
        size.x * size.y
    }

    /// Window coordinates, (0, 0) to (1, 1), of a point in pixels of the full film.
    #[inline]
    #[must_use]
    pub fn to_window(&self, raster: DVec2) -> DVec2 {
        (raster - self.window_min.as_dvec2()) / self.window_size().as_dvec2()
    }

    /// The point, in pixels of the full film, of window coordinates.
    #[must_use]
    pub fn from_window(&self, u: DVec2) -> DVec2 {
        self.window_min.as_dvec2() + u * self.window_size().as_dvec2()
    }

    /// Index (row-major in the window) of the pixel that contains a point of the film, `None`
    /// outside the window.
    #[inline]
    #[must_use]
    pub fn pixel_index(&self, raster: DVec2) -> Option<u32> {
        let (min, max) = (self.window_min.as_dvec2(), self.window_max.as_dvec2());
        (raster.cmpge(min).all() && raster.cmplt(max).all()).then(|| {
            let cell = raster.as_uvec2() - self.window_min;
            cell.y * self.window_size().x + cell.x
        })
    }
}

/// The view of one sample: its position on the film, and the displacement of its filter.
///
/// The pixel filter is the pixel's box convolved with a kernel. A sample draws an offset from that
/// kernel and everything it does is as if the film were displaced by it: camera subpaths start at
/// `raster + offset`, and a light subpath's splat at a point `p` of the film is recorded at `p -
/// offset`. For a given offset all techniques see the same box-filtered film, so their weights need
/// not know the filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmSample {
    /// Position inside the window, in pixels of the full film: decides the pixel.
    pub raster: DVec2,
    /// Offset drawn from the filter's kernel, in pixels.
    pub offset: DVec2,
}

impl FilmSample {
    /// Draws a point of a pixel, row-major in the window, and an offset from the filter's kernel:
    /// the first numbers that a sample takes.
    #[inline]
    #[must_use]
    pub fn draw<P: Sampler>(
        region: &FilmRegion,
        pixel: u32,
        kernel: &Kernel,
        sampler: &mut P,
    ) -> Self {
        sampler.stream(Stream::Film);
        let width = region.window_size().x.max(1);
        let corner = region.window_min.as_dvec2()
            + DVec2::new(f64::from(pixel % width), f64::from(pixel / width));
        Self::within(corner, DVec2::ONE, kernel, sampler)
    }

    /// Draws a point of the whole window, and an offset from the filter's kernel.
    #[must_use]
    pub fn draw_anywhere<P: Sampler>(
        region: &FilmRegion,
        kernel: &Kernel,
        sampler: &mut P,
    ) -> Self {
        sampler.stream(Stream::Film);
        let size = region.window_size().as_dvec2();
        Self::within(region.window_min.as_dvec2(), size, kernel, sampler)
    }

    #[inline]
    fn within<P: Sampler>(corner: DVec2, size: DVec2, kernel: &Kernel, sampler: &mut P) -> Self {
        // Rounding must not carry the point beyond the end.
        let end = corner + size;
        let end = DVec2::new(end.x.next_down(), end.y.next_down());
        let raster = (corner + size * sampler.next_2d()).min(end);
        Self { raster, offset: kernel.sample(sampler) }
    }
}

/// A sample of the image to be drawn: one camera subpath, one light subpath, or one of each.
#[derive(Clone, Debug)]
pub struct Sample<P> {
    /// The position on the film.
    pub film: FilmSample,
    /// The random numbers of the sample.
    pub sampler: P,
}

/// One way to draw a path: `s` vertices from the light, `t` from the camera.
///
/// A technique connects the two subpaths by an edge, or merges their ends: then both have found the
/// vertex where they meet, and the path has one vertex less.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "checkpoint", derive(serde::Serialize, serde::Deserialize))]
pub struct Technique {
    /// Number of vertices drawn from the light.
    pub s: u16,
    /// Number of vertices drawn from the camera.
    pub t: u16,
    /// True if the last vertices of the subpaths are taken as one.
    pub merged: bool,
}

impl Technique {
    /// The technique (s, t): s + t vertices, the two ends connected if s > 0.
    #[inline]
    #[must_use]
    pub const fn new(s: u16, t: u16) -> Self {
        Self { s, t, merged: false }
    }

    /// The technique that merges the ends of subpaths of s and t vertices, both at least 2.
    #[inline]
    #[must_use]
    pub const fn merge(s: u16, t: u16) -> Self {
        Self { s, t, merged: true }
    }

    /// All techniques (s, t) with t ≥ 1 of paths with so many scattering events at most, by path
    /// length and then s.
    pub fn up_to(bounces: u16) -> impl Iterator<Item = Self> {
        (0..=bounces).flat_map(|n| (0..=n + 1).map(move |s| Self::new(s, n + 2 - s)))
    }

    /// All merges of paths with so many scattering events at most, by path length and then s.
    pub fn merges_up_to(bounces: u16) -> impl Iterator<Item = Self> {
        (1..=bounces).flat_map(|n| (2..=n + 1).map(move |s| Self::merge(s, n + 3 - s)))
    }

    /// True if there is such a technique: t ≥ 1, since the lens is never hit by chance, and both
    /// subpaths of a merge have found the vertex where they meet.
    #[inline]
    #[must_use]
    pub const fn exists(self) -> bool {
        self.t > 0 && (!self.merged || (self.s > 1 && self.t > 1))
    }

    /// Number of scattering events of its paths.
    #[inline]
    #[must_use]
    pub const fn bounces(self) -> u16 {
        self.s.saturating_add(self.t).saturating_sub(if self.merged { 3 } else { 2 })
    }
}

impl fmt::Display for Technique {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { s, t, merged } = self;
        write!(f, "{}({s}, {t})", if *merged { "merge " } else { "" })
    }
}

/// The value that one path adds to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Position on the film, in pixels of the full film.
    pub raster: DVec2,
    /// Unweighted estimate `f(x) / (n p(x))`, in radiance averaged over the window.
    pub value: Rgb,
    /// Multiple importance sampling weight.
    pub weight: f64,
    /// The technique that drew the path.
    pub technique: Technique,
}

/// Receives contributions: a film, a pyramid of techniques, statistics, an audit. A closure is one.
pub trait Sink {
    /// Takes a contribution of the sample with this number in its batch. Those of one sample come
    /// in their order, those of different samples in any.
    fn add(&mut self, sample: usize, contribution: &Contribution);
}

impl<F: FnMut(usize, &Contribution)> Sink for F {
    fn add(&mut self, sample: usize, contribution: &Contribution) {
        self(sample, contribution);
    }
}

/// Collects contributions as they come.
impl Sink for Vec<Contribution> {
    fn add(&mut self, _sample: usize, contribution: &Contribution) {
        self.push(*contribution);
    }
}
