//! What integrators produce and where it goes: contributions, sinks and the film.

mod filter;
mod image;
#[cfg(feature = "image")]
mod output;
mod sums;

pub use filter::{Filter, FilterError, Kernel};
pub use image::{Image, linear_from_srgb, srgb_from_linear};
#[cfg(feature = "image")]
pub use output::{ImageFile, OutputError};
pub use sums::{ChunkFilm, Film, FilmError, NonFinite, NonFiniteContribution};

use crate::math::Rgb;
use crate::sampler::{Sampler, Stream};
use glam::{DVec2, UVec2};

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

    /// From pixels of the full film to window coordinates, (0, 0) to (1, 1).
    #[inline]
    #[must_use]
    pub fn to_window(&self, raster: DVec2) -> DVec2 {
        (raster - self.window_min.as_dvec2()) / self.window_size().as_dvec2()
    }

    /// From window coordinates to pixels of the full film.
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

/// Where one sample looks.
///
/// The pixel filter is the pixel's box convolved with a kernel. A sample draws an offset from that
/// kernel and everything it does is as if the film were displaced by it: camera walks start at
/// `raster + offset`, and what a light walk projects to a point `p` of the film is recorded at `p -
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
        // Rounding must not carry the point into the next pixel.
        let last = corner + 1.0;
        let raster =
            (corner + sampler.next_2d()).min(DVec2::new(last.x.next_down(), last.y.next_down()));
        Self { raster, offset: kernel.sample(sampler) }
    }
}

/// One sample of a batch.
#[derive(Clone, Debug)]
pub struct BatchSample<P> {
    /// Where it looks.
    pub film: FilmSample,
    /// Its numbers.
    pub sampler: P,
}

/// One way to draw a path: `s` vertices from the light, `t` from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Technique {
    /// Number of vertices drawn from the light.
    pub s: u16,
    /// Number of vertices drawn from the camera.
    pub t: u16,
}

/// What one path adds to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Position on the film, in pixels of the full film.
    pub raster: DVec2,
    /// Unweighted estimate `f(x) / (n p(x))`, in radiance averaged over the window.
    pub value: Rgb,
    /// Multiple importance sampling weight.
    pub weight: f64,
    /// How the path was drawn.
    pub technique: Technique,
}

/// Receives contributions: a film, a pyramid of techniques, statistics, an audit.
pub trait Sink {
    /// Takes one contribution.
    fn add(&mut self, contribution: &Contribution);
}

impl<K: Sink + ?Sized> Sink for &mut K {
    fn add(&mut self, contribution: &Contribution) {
        (**self).add(contribution);
    }
}

/// Receives the contributions of several samples, in any order.
pub trait BatchSink {
    /// Takes a contribution of the sample with this number in its batch.
    fn add(&mut self, sample: usize, contribution: &Contribution);
}

/// Both sinks receive every contribution.
impl<A: Sink, B: Sink> Sink for (A, B) {
    fn add(&mut self, contribution: &Contribution) {
        self.0.add(contribution);
        self.1.add(contribution);
    }
}

/// Collects contributions as they come.
impl Sink for Vec<Contribution> {
    fn add(&mut self, contribution: &Contribution) {
        self.push(*contribution);
    }
}
