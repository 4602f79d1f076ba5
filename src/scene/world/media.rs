//! Absorbing media of a world: the bodies behind surfaces.
//!
//! Light that goes a distance d through a medium keeps `exp(-σ d)` of itself, σ its absorption
//! coefficient (Bouguer 1729, Lambert 1760, Beer 1852). A medium lies behind its boundary's
//! surfaces; a walk that goes through one notes it in its points, so that what is inside of a body
//! and no boundary itself knows where it is.

use super::World;
use crate::geometry::{Place, SurfacePoint};
use crate::math::Rgb;
use crate::scene::surface::Surface;
use crate::scene::{Scene, SceneError};
use glam::DVec3;
use std::collections::HashMap;

/// The direction of the rays that find out which medium a point is in.
const PROBE: DVec3 = DVec3::new(0.36, 0.48, 0.8);

/// The most surfaces that such a ray crosses.
const MOST_CROSSED: usize = 256;

/// The absorption coefficients of a world's media. Number 0 is what absorbs nothing and not in the
/// list.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Media(Vec<Rgb>);

impl Media {
    /// The media behind some surfaces, which get their numbers.
    pub fn of(surfaces: &mut [Surface]) -> Result<Self, SceneError> {
        let (mut media, mut numbers) = (Vec::new(), HashMap::new());
        for surface in surfaces.iter_mut().filter(|surface| !surface.absorption.is_black()) {
            let number =
                numbers.entry(surface.absorption.0.map(f64::to_bits)).or_insert_with(|| {
                    media.push(surface.absorption);
                    media.len()
                });
            let too_many = |_| SceneError::TooManyMedia { object: surface.name.clone() };
            surface.medium = u16::try_from(*number).map_err(too_many)?;
        }
        Ok(Self(media))
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The absorption coefficient of a medium, per unit of length.
    fn absorption(&self, medium: u16) -> Rgb {
        usize::from(medium).checked_sub(1).map_or(Rgb::BLACK, |index| self.0[index])
    }
}

impl World {
    /// The medium behind the surface that a point lies on.
    fn medium_behind(&self, x: &SurfacePoint) -> u16 {
        self.surfaces.get(x.surface as usize).map_or(0, |surface| surface.medium)
    }

    /// [`Scene::medium_towards`] of a world with media. In front of a boundary that was reached
    /// through what it bounds is what a ray finds there.
    #[inline(never)]
    pub(super) fn medium_beyond(&self, x: &SurfacePoint, direction: DVec3) -> u16 {
        let behind = self.medium_behind(x);
        if behind == 0 {
            x.medium
        } else if x.geometric_normal.dot(direction) < 0.0 {
            behind
        } else if x.medium != behind {
            x.medium
        } else if self.media.0.len() == 1 {
            0
        } else {
            self.medium_around(x)
        }
    }

    /// [`Scene::transmittance`] of a world with media: through what is densest of the two media
    /// that the ends know of, for an end that no walk has reached knows of none.
    #[inline(never)]
    pub(super) fn passing(&self, a: &SurfacePoint, b: &SurfacePoint) -> Rgb {
        let (direction, distance) = match (a.place, b.place) {
            (Place::Infinite, _) => (a.geometric_normal, f64::INFINITY),
            (_, Place::Infinite) => (-b.geometric_normal, f64::INFINITY),
            _ => (b.position - a.position, a.position.distance(b.position)),
        };
        let media = [self.medium_beyond(a, direction), self.medium_beyond(b, -direction)];
        if media == [0, 0] || distance == 0.0 {
            return Rgb::WHITE;
        }
        let [near, far] = media.map(|medium| self.media.absorption(medium).0);
        // Without `0 · ∞`.
        let passing = |sigma: f64| if sigma > 0.0 { libm::exp(-sigma * distance) } else { 1.0 };
        Rgb(std::array::from_fn(|i| passing(near[i].max(far[i]))))
    }

    /// [`Scene::medium_at`] of a world with media, by the boundaries that a ray crosses from there.
    /// In front of the surface, if the point lies on one.
    #[inline(never)]
    pub(super) fn medium_around(&self, x: &SurfacePoint) -> u16 {
        if x.place == Place::Infinite {
            return 0;
        }
        let mut from = *x;
        // The media that it has entered and not left yet.
        let mut entered = Vec::new();
        if x.geometric_normal.dot(PROBE) < 0.0 {
            entered.extend(Some(self.medium_behind(x)).filter(|medium| *medium != 0));
        }
        for _ in 0..MOST_CROSSED {
            let Some(next) = self.intersect(&from, PROBE) else { break };
            let medium = self.medium_behind(&next);
            if medium != 0 && next.geometric_normal.dot(PROBE) < 0.0 {
                entered.push(medium);
            } else if medium != 0 {
                match entered.iter().rposition(|other| *other == medium) {
                    Some(index) => drop(entered.remove(index)),
                    None => return medium,
                }
            }
            from = next;
        }
        0
    }
}
