//! Absorbing media of a world: the bodies behind surfaces of materials that absorb.
//!
//! Light that goes a distance d through a medium keeps `exp(-σ d)` of itself, σ its absorption
//! coefficient (Bouguer 1729, Lambert 1760, Beer 1852). A medium lies behind its boundary's
//! surfaces; a walk that goes through one notes it in its points, so that what is inside of a body
//! and no boundary itself knows where it is.

use super::World;
use crate::geometry::{Place, SurfacePoint};
use crate::math::Rgb;
use crate::scene::Scene;
use glam::DVec3;

/// The direction of the rays that find out which medium a point is in.
const PROBE: DVec3 = DVec3::new(0.36, 0.48, 0.8);

/// The most surfaces that such a ray crosses.
const MOST_CROSSED: usize = 256;

/// The media of a world. Number 0 is what absorbs nothing.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Media {
    /// Absorption coefficients of the others.
    absorption: Vec<Rgb>,
    /// The medium behind surfaces of each material.
    behind: Vec<u16>,
}

impl Media {
    /// Adds a material with what lies behind it. Returns false if there are too many media.
    pub fn push(&mut self, absorption: Rgb) -> bool {
        let mut medium = 0;
        if !absorption.is_black() {
            self.absorption.push(absorption);
            let Ok(number) = u16::try_from(self.absorption.len()) else { return false };
            medium = number;
        }
        self.behind.push(medium);
        true
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.absorption.is_empty()
    }

    /// The absorption coefficient of a medium, per unit of length.
    fn absorption(&self, medium: u16) -> Rgb {
        match usize::from(medium).checked_sub(1) {
            Some(index) => self.absorption[index],
            None => Rgb::BLACK,
        }
    }
}

impl World {
    /// The medium behind the surface that a point lies on.
    fn medium_behind(&self, x: &SurfacePoint) -> u16 {
        let material = self.surfaces.get(x.surface as usize).map(|surface| surface.material);
        material.and_then(|id| self.media.behind.get(id.0 as usize).copied()).unwrap_or(0)
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
        } else if self.media.absorption.len() == 1 {
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
        let passing = |sigma: f64| if sigma > 0.0 { (-sigma * distance).exp() } else { 1.0 };
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
