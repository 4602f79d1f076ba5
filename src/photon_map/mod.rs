//! Photons on surfaces, and the map that finds those near a point.
//!
//! A light walk leaves a [`Photon`] where it arrives at a surface. Its throughput there is flux, so
//! the radiance that leaves a point y towards the camera is, from the photons z of N light walks,
//!
//! ```text
//! L(y) ≈ 1/N Σ_z f(z.to_previous, y.to_previous) K(z - y) Φ_z,    K = 1/(π r²) for |z - y| < r
//! ```
//!
//! without a cosine or a geometry term: the density of photons has them (Jensen 1996, "Global
//! Illumination using Photon Maps"; Pharr, Jakob and Humphreys 2016, section 16.2). On a smooth
//! surface the estimate is biased by `r²/8 ∇²L`; its variance is proportional to 1/(N r²).
//!
//! At the distance d = u r from a straight edge the kernel loses the share
//! `(acos u - u √(1 - u²))/π`, since photons of other surfaces are left out by their normals.

mod grid;

use crate::geometry::SurfacePoint;
use crate::math::Rgb;
use glam::DVec3;
use grid::HashGrid;
use std::f64::consts::PI;

/// The cosine between two normals below which they are not of one surface.
const MIN_COSINE: f64 = 0.5;

/// True if photons can be found within a radius: it is positive, and its square a normal number.
#[must_use]
pub fn has_area(radius: f64) -> bool {
    radius > 0.0 && (radius * radius).is_normal()
}

/// The arrival of a light walk at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// World position.
    pub position: DVec3,
    /// Unit geometric normal of the surface.
    pub normal: DVec3,
    /// Unit direction to the previous vertex of the walk.
    pub to_previous: DVec3,
    /// Throughput of the walk up to here: flux per walk, W.
    pub flux: Rgb,
    /// Number of vertices of the light subpath that ends here, at least 2.
    pub s: u16,
}

impl AsRef<Self> for Photon {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// Photons, and the search for those within one radius of a point on the same surface.
///
/// `P` is a photon or what has one, such as a photon with densities of its walk. Plain data,
/// without the lifetime of a scene.
#[derive(Clone, Debug)]
pub struct PhotonMap<P = Photon> {
    grid: HashGrid<P>,
}

impl<P: AsRef<Photon>> PhotonMap<P> {
    /// The map of some photons for one radius of search, in the scene's unit of length. Takes time
    /// proportional to the number of photons, and while it runs 4 bytes more for each than
    /// [`PhotonMap::bytes`] tells.
    ///
    /// A radius whose square is zero, subnormal, infinite or not a number makes an empty map.
    /// Photons at positions that are not finite are kept and never found.
    ///
    /// # Errors
    /// If there is not enough memory, or there are more than 2³² - 1 photons.
    pub fn build(photons: Vec<P>, radius: f64) -> Result<Self, PhotonMapError> {
        let error = PhotonMapError { photons: photons.len() };
        let grid = HashGrid::build(photons, radius, |photon| photon.as_ref().position);
        grid.map(|grid| Self { grid }).ok_or(error)
    }

    /// Visits each photon z for which `|z - y| < r` and `n(z) · n(y) > 1/2` once, with y the point
    /// and n the geometric normals. Takes time proportional to the number of photons in a few balls
    /// around the point. The order depends on nothing but the order of the photons that the map was
    /// built of.
    #[inline]
    pub fn within(&self, point: &SurfacePoint, mut visit: impl FnMut(&P)) {
        self.grid.within(point.position, |photon| {
            if photon.as_ref().normal.dot(point.geometric_normal) > MIN_COSINE {
                visit(photon);
            }
        });
    }

    /// All photons, neighbours near to each other.
    #[must_use]
    pub fn photons(&self) -> &[P] {
        self.grid.points()
    }

    /// True if there are no photons to be found.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.photons().is_empty()
    }

    /// The radius r of the search.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.grid.radius()
    }

    /// The area π r² of the disc in which photons are found on a plane; its inverse is the kernel.
    #[must_use]
    pub fn area(&self) -> f64 {
        PI * self.radius() * self.radius()
    }

    /// The memory that the map holds, in bytes: 28 to 32 for each photon, and the photon.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.grid.bytes()
    }
}

/// Photons that take too much memory to be a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a map of {photons} photons takes too much memory")]
pub struct PhotonMapError {
    /// The number of photons.
    pub photons: usize,
}
