//! Classes of paths, and those that a set of techniques cannot draw.
//!
//! A path is written from the light to the lens in the notation of Heckbert (1990): L is the light,
//! S a vertex that scatters by a Dirac lobe, D one that scatters by a finite lobe, diffuse or
//! glossy, and E the lens. A technique draws a path if the ends of its connecting edge, or the
//! vertex that it merges, can be connected to:
//!
//! | technique | draws |
//! |---|---|
//! | s = 0 | all of a light that can be hit |
//! | s = 1, t ≥ 2 | L D …, of a light that can be connected to |
//! | s ≥ 2, t ≥ 2 | … D D … |
//! | t = 1, s ≥ 2 | … D E |
//! | (1, 1) | L E, but not of a Dirac light to a Dirac lens, nor from infinity to infinity |
//! | merges | … D … |
//! | vertices uniform by area | L D … D E, of a light with area |

use super::connect::are_joinable;
use super::{Depth, Excluded, Plan, Stage, TechniqueSet};
use crate::endpoint::LightKind;
use crate::film::Technique;
use crate::geometry::Place;
use crate::scene::{Needs, Scene};
use std::fmt;

/// A class of paths, by what scatters next to the light, next to the lens and in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathClass {
    /// L E: light that is seen directly.
    Direct,
    /// L S … S E: light that is seen by way of Dirac lobes alone.
    SpecularlySeen,
    /// L D … D E: light that finite lobes alone scatter.
    Scattered,
    /// L S … D E: caustics.
    Caustic,
    /// L D … S E: what light falls on, seen by way of a Dirac lobe.
    SpecularView,
    /// L S … D … S E: caustics, seen by way of a Dirac lobe.
    SpecularViewOfCaustic,
    /// L D … S … D E: light that Dirac lobes hand on between finite ones.
    Between,
}

/// The integrators of this crate that draw a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DrawnBy {
    /// Bidirectional path tracing, by connections of all kinds.
    Connections,
    /// Only those that merge.
    Merges,
    /// None.
    Nothing,
}

/// Paths that a set of techniques cannot draw, as far as a scene has such: of one class, from
/// lights of one kind. Its [`Display`](fmt::Display) names them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct MissingPaths {
    /// The class.
    pub class: PathClass,
    /// The kind of the lights.
    pub kind: LightKind,
    /// The names of the lights; none if the scene does not name its lights.
    pub lights: Vec<String>,
    /// The shortest of the paths, such as `L S D E`.
    pub shortest: String,
    /// The integrators that draw them.
    pub drawn_by: DrawnBy,
}

/// All that decides which techniques draw a path.
#[derive(Clone, Copy)]
struct Signature {
    light: LightKind,
    /// True if the light can be connected to the lens.
    is_joinable: bool,
    bounces: u16,
    /// Bit i is set if the vertex with i more between it and the light takes a Dirac lobe.
    dirac: u32,
}

/// Every pattern that decides is found among paths with up to so many scattering events, such as
/// both D D and S next to both ends in L S D D S E.
const LONGEST_PATTERN: u32 = 4;

impl Signature {
    /// The signatures of paths from a light that a scene with these needs may have, the shortest
    /// first.
    fn all(
        light: LightKind,
        (needs, lens): (Needs, Place),
        depth: Depth,
        longest: u32,
    ) -> impl Iterator<Item = Self> {
        let is_hidden = light.place == Place::Infinite && !needs.contains(Needs::ILLUMINATION);
        let is_joinable = are_joinable(lens, light.place, light.hittable)
            // The walks from infinity start at the extent of what they illuminate.
            && if light.hittable { !is_hidden } else { light.connectible };
        let (dirac, finite) =
            (needs.contains(Needs::DIRAC_LOBES), needs.contains(Needs::FINITE_LOBES));
        let lengths = if depth.contains(depth.limit()) {
            depth.min_bounces.min(longest)..depth.limit().min(longest) + 1
        } else {
            0..0
        };
        lengths.flat_map(move |bounces| {
            let all = (1 << bounces) - 1;
            let lobes =
                (0..=all).filter(move |set| (dirac || *set == 0) && (finite || *set == all));
            lobes.map(move |dirac| Self { light, is_joinable, bounces: bounces as u16, dirac })
        })
    }

    fn is_finite(&self, vertex: u16) -> bool {
        self.dirac >> vertex & 1 == 0
    }

    fn is_all_finite(&self) -> bool {
        self.dirac == 0
    }

    /// True if a technique for paths of this length draws it.
    fn is_drawn_by(&self, Technique { s, t, merged }: Technique) -> bool {
        match (s, t) {
            _ if merged => self.is_finite(s - 2),
            (0, _) => self.light.hittable,
            (1, 1) => self.is_joinable,
            (1, _) => self.light.connectible && self.is_finite(0),
            (_, 1) => self.is_finite(s - 2),
            _ => self.is_finite(s - 2) && self.is_finite(s - 1),
        }
    }

    fn is_drawn_uniformly_by_area(&self) -> bool {
        self.light.hittable
            && self.is_all_finite()
            && (self.bounces == 0 || self.light.place != Place::Infinite)
    }

    fn class(&self) -> PathClass {
        if self.bounces == 0 {
            return PathClass::Direct;
        }
        match (self.is_finite(0), self.is_finite(self.bounces - 1)) {
            (false, false) if self.dirac.count_ones() == u32::from(self.bounces) => {
                PathClass::SpecularlySeen
            }
            (false, false) => PathClass::SpecularViewOfCaustic,
            (false, true) => PathClass::Caustic,
            (true, false) => PathClass::SpecularView,
            (true, true) if self.is_all_finite() => PathClass::Scattered,
            (true, true) => PathClass::Between,
        }
    }

    fn drawn_by(&self) -> DrawnBy {
        let merges = TechniqueSet { merges: 1, ..TechniqueSet::NONE };
        if TechniqueSet::BIDIRECTIONAL.draws(self) {
            DrawnBy::Connections
        } else if merges.draws(self) {
            DrawnBy::Merges
        } else {
            DrawnBy::Nothing
        }
    }
}

impl fmt::Display for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("L ")?;
        (0..self.bounces)
            .try_for_each(|vertex| f.write_str(if self.is_finite(vertex) { "D " } else { "S " }))?;
        f.write_str("E")
    }
}

impl TechniqueSet {
    /// True if the set draws every path that the set of all connections draws, on any scene with
    /// these needs and through a lens at such a place. Decided from the needs alone, so false may
    /// mean "not on every such scene".
    #[must_use]
    pub fn is_complete(&self, needs: &Needs, lens: Place) -> bool {
        let missing = self.missing(needs, lens, Depth::default());
        missing.iter().all(|paths| paths.drawn_by != DrawnBy::Connections)
    }

    /// The paths that the set cannot draw, of a scene with these needs, through a lens at such a
    /// place and of lengths that count. Decided from the needs alone: a scene may have none of
    /// them.
    #[must_use]
    pub fn missing(&self, needs: &Needs, lens: Place, depth: Depth) -> Vec<MissingPaths> {
        let (subject, depth) = ((*needs, lens), depth.within(needs));
        let longest = match self.excluded.is_empty() {
            true => LONGEST_PATTERN,
            false => u32::from(Excluded::MOST_BOUNCES) + 1,
        };
        let mut missing: Vec<MissingPaths> = Vec::new();
        let signatures =
            light_kinds(needs).flat_map(|light| Signature::all(light, subject, depth, longest));
        for path in signatures.filter(|path| !self.draws(path)) {
            let (class, kind, drawn_by) = (path.class(), path.light, path.drawn_by());
            if !missing.iter().any(|m| (m.class, m.kind, m.drawn_by) == (class, kind, drawn_by)) {
                let (lights, shortest) = (Vec::new(), path.to_string());
                missing.push(MissingPaths { class, kind, lights, shortest, drawn_by });
            }
        }
        missing
    }

    fn draws(&self, path: &Signature) -> bool {
        let n = path.bounces;
        let connected = (0..n + 2).map(|s| Technique::new(s, n + 2 - s));
        let merged = (2..n + 2).map(|s| Technique::merge(s, n + 3 - s));
        connected.chain(merged).any(|by| self.contains(by) && path.is_drawn_by(by))
            || (self.uniform_area && path.is_drawn_uniformly_by_area())
    }
}

/// The kinds of lights that a scene with these needs may have.
fn light_kinds(needs: &Needs) -> impl Iterator<Item = LightKind> {
    use Place::{Area, Dirac, Infinite};
    let kinds = [(Area, true), (Infinite, true), (Dirac, false), (Infinite, false)];
    let kinds = kinds.into_iter().flat_map(|(place, hittable)| {
        [true, false].map(|connectible| LightKind { place, hittable, connectible })
    });
    let needs = *needs;
    kinds.filter(move |kind| {
        let hit = if kind.hittable { Needs::HITTABLE_LIGHTS } else { Needs::DIRAC_LIGHTS };
        let connection = match kind.connectible {
            true => Needs::CONNECTIBLE_LIGHTS,
            false => Needs::UNCONNECTIBLE_LIGHTS,
        };
        let is_environment = kind.hittable && kind.place == Infinite;
        needs.contains(hit | connection) && (!is_environment || needs.contains(Needs::ENVIRONMENT))
    })
}

impl<S: Scene + ?Sized> Plan<'_, S> {
    /// The paths that the techniques cannot draw, of the lengths that count, with the names of the
    /// lights if the scene tells them.
    #[must_use]
    pub fn missing(&self) -> Vec<MissingPaths> {
        let Stage { scene, camera, needs, .. } = self.stage;
        let (lens, depth) = (camera.place(), self.depth);
        let mut missing = self.techniques.missing(&needs, lens, depth);
        if !camera.can_be_connected() {
            let all = TechniqueSet { lens_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
            let lost = all.missing(&needs, lens, depth);
            let is_lost = |paths: &MissingPaths| {
                lost.iter().any(|other| (other.class, other.kind) == (paths.class, paths.kind))
            };
            for paths in missing.iter_mut().filter(|paths| is_lost(paths)) {
                let has_finite_vertex =
                    !matches!(paths.class, PathClass::Direct | PathClass::SpecularlySeen);
                let by = if has_finite_vertex { DrawnBy::Merges } else { DrawnBy::Nothing };
                paths.drawn_by = by;
            }
        }
        missing.retain_mut(|paths| match scene.light_names(paths.kind) {
            Some(names) => {
                paths.lights = names.into_iter().map(str::to_owned).collect();
                !paths.lights.is_empty()
            }
            // Without names one entry for Dirac lights is enough.
            None => paths.kind.hittable || paths.kind.place != Place::Infinite,
        });
        missing
    }
}

/// Names that are written out; the others are counted.
const MOST_NAMES: usize = 4;

impl MissingPaths {
    /// The lights, by their names as far as these are known.
    fn lights_in_words(&self) -> String {
        let quoted = |name: &String| format!("{name:?}");
        match self.lights.as_slice() {
            [] if !self.kind.hittable && self.kind.connectible => "Dirac lights".to_owned(),
            [] if self.kind.hittable && self.kind.place == Place::Infinite => {
                format!("the {}", self.kind)
            }
            [] => format!("{}s", self.kind),
            [name] => format!("the {} {}", self.kind, quoted(name)),
            names => {
                let written = names.len().min(MOST_NAMES);
                let list = names[..written].iter().map(quoted).collect::<Vec<_>>().join(", ");
                match names.len() - written {
                    0 => format!("the {}s {list}", self.kind),
                    more => format!("the {}s {list} and {more} more", self.kind),
                }
            }
        }
    }
}

impl fmt::Display for MissingPaths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lights = self.lights_in_words();
        match self.class {
            PathClass::Direct => write!(f, "{lights} seen directly through the lens"),
            PathClass::SpecularlySeen => write!(f, "specular images of {lights}"),
            PathClass::Scattered => write!(f, "light of {lights} on diffuse and glossy surfaces"),
            PathClass::Caustic => write!(f, "caustics of {lights}"),
            PathClass::SpecularView => {
                write!(f, "specular images of surfaces in the light of {lights}")
            }
            PathClass::SpecularViewOfCaustic => {
                write!(f, "specular images of caustics of {lights}")
            }
            PathClass::Between => {
                write!(f, "light of {lights} that specular surfaces hand on between others")
            }
        }?;
        match self.drawn_by {
            DrawnBy::Connections => write!(f, " ({})", self.shortest),
            DrawnBy::Merges => write!(f, " ({}, drawn by merging alone)", self.shortest),
            DrawnBy::Nothing => write!(f, " ({}, drawn by no integrator here)", self.shortest),
        }
    }
}
