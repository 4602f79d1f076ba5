//! The techniques that an integrator runs, and the reasons against the others.

use super::{Family, LeftOut, LightSubpaths, Reason};
use crate::film::Technique;
use crate::sampler::{Sampler, Stream};
use crate::scene::Needs;
use std::fmt;

/// The set of techniques that an integrator runs on a scene, and the number of samples of each per
/// sample of the image.
///
/// A path with k edges can be drawn by the techniques (s, t) with s + t = k + 1 and t ≥ 1: the lens
/// is never hit by chance; or by merges, with s + t = k + 2. A set is a union of the families that
/// need different code, less what the scene rules out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueSet {
    /// s = 0: a camera walk hits a light (BSDF sampling).
    pub bsdf_sampling: bool,
    /// s = 1, t ≥ 2: a vertex of a camera subpath connects to a point sampled on a light (next
    /// event estimation).
    pub next_event: bool,
    /// s ≥ 2, t ≥ 2: a vertex of a camera subpath connects to one of a light subpath.
    pub connections: bool,
    /// t = 1, s ≥ 1: a vertex of a light subpath connects to the lens.
    pub lens_sampling: bool,
    /// Every vertex after the first surface uniform by area, the last one on a light: the integral
    /// over paths, sampled as it stands; no (s, t) technique.
    pub uniform_area: bool,
    /// s ≥ 2, t ≥ 2, merged: a vertex of a camera subpath meets one of a light subpath. The number
    /// of light subpaths, shared by all camera subpaths of a pass, that each merges with; 0 for
    /// none.
    pub merges: u32,
    /// The number of samples of connections and of lens sampling; the others have one, but for
    /// merges.
    pub light_subpaths: LightSubpaths,
    /// Single techniques that are left out although their families are in the set.
    pub excluded: Excluded,
}

/// Single techniques (s, t) and single merges, of paths with up to [`Excluded::MOST_BOUNCES`]
/// scattering events. Weights within a set that leaves some out are computed by a sweep over each
/// path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Excluded(u128);

impl Excluded {
    /// No technique.
    pub const NONE: Self = Self(0);
    /// Techniques of longer paths cannot be told apart.
    pub const MOST_BOUNCES: u16 = 8;

    /// The set with one technique more; `None` if its paths are too long, or if it does not
    /// [exist](Technique::exists).
    #[must_use]
    pub fn with(self, technique: Technique) -> Option<Self> {
        Some(Self(self.0 | Self::bit(technique)?))
    }

    /// True if there are none.
    #[inline]
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// True if a technique is among them.
    #[inline]
    #[must_use]
    pub fn contains(self, technique: Technique) -> bool {
        !self.is_empty() && Self::bit(technique).is_some_and(|bit| self.0 & bit != 0)
    }

    /// All of them, by path length and then s; merges last.
    pub fn techniques(self) -> impl Iterator<Item = Technique> {
        let connections = Technique::up_to(Self::MOST_BOUNCES);
        connections
            .chain(Technique::merges_up_to(Self::MOST_BOUNCES))
            .filter(move |technique| self.contains(*technique))
    }

    /// True if one of them is no merge.
    #[inline]
    fn has_connections(self) -> bool {
        self.0 & ((1 << Self::FIRST_MERGE) - 1) != 0
    }

    /// Bits of connections come before this one.
    const FIRST_MERGE: u16 = 64;

    #[inline]
    fn bit(technique: Technique) -> Option<u128> {
        let (bounces, s) = (technique.bounces(), technique.s);
        (technique.exists() && bounces <= Self::MOST_BOUNCES).then(|| {
            1 << match technique.merged {
                false => bounces * (bounces + 3) / 2 + s,
                true => Self::FIRST_MERGE + bounces * (bounces - 1) / 2 + s - 2,
            }
        })
    }
}

impl TechniqueSet {
    /// No technique.
    pub const NONE: Self = Self {
        bsdf_sampling: false,
        next_event: false,
        connections: false,
        lens_sampling: false,
        uniform_area: false,
        merges: 0,
        light_subpaths: LightSubpaths::ONE,
        excluded: Excluded::NONE,
    };
    /// Every technique (s, t) with t ≥ 1, and no merges.
    pub const BIDIRECTIONAL: Self = Self {
        bsdf_sampling: true,
        next_event: true,
        connections: true,
        lens_sampling: true,
        ..Self::NONE
    };

    /// All techniques but the others of the same path length: at that length `technique` is alone,
    /// whether or not the set is given merges. One that merges does so with one light walk. `None`
    /// if its paths are too long, or if it does not exist.
    #[must_use]
    pub fn only(technique: Technique) -> Option<Self> {
        Excluded::NONE.with(technique)?;
        let bounces = technique.bounces();
        let excluded = Technique::up_to(bounces)
            .chain(Technique::merges_up_to(bounces))
            .filter(|other| other.bounces() == bounces && *other != technique)
            .try_fold(Excluded::NONE, Excluded::with)?;
        Some(Self { excluded, merges: technique.merged.into(), ..Self::BIDIRECTIONAL })
    }

    /// Leaves out what a scene cannot use; exactly, since what is left out would contribute nothing
    /// or, if it is redundant, is drawn by another technique of the set.
    #[inline]
    #[must_use]
    pub fn pruned(mut self, needs: &Needs) -> Self {
        let full = self;
        let keep = |family| full.reason(family, needs).is_none();
        self.bsdf_sampling &= keep(Family::BsdfSampling);
        self.uniform_area &= keep(Family::UniformArea);
        self.next_event &= keep(Family::NextEventEstimation);
        self.connections &= keep(Family::Connections);
        self.lens_sampling &= keep(Family::LensSampling);
        if !keep(Family::Merges) {
            self.merges = 0;
        }
        self
    }

    /// The families that [`pruned`](Self::pruned) leaves out, and the reasons.
    #[must_use]
    pub fn left_out(&self, needs: &Needs) -> LeftOut {
        let reason =
            |family: Family| if self.has(family) { self.reason(family, needs) } else { None };
        let runs = Family::ALL.into_iter().any(|family| self.pruned(needs).has(family));
        LeftOut {
            reasons: Family::ALL.map(reason),
            most_bounces: needs.most_bounces().filter(|_| runs),
        }
    }

    // ANCHOR: reason
    /// The one place that decides what a scene rules out.
    #[inline]
    fn reason(&self, family: Family, needs: &Needs) -> Option<Reason> {
        let hittable = needs.contains(Needs::HITTABLE_LIGHTS);
        let no_scattering = if !needs.contains(Needs::FINITE_LOBES) {
            Some(Reason::NoFiniteLobe)
        } else if !needs.contains(Needs::ILLUMINATION) {
            Some(Reason::NoIllumination)
        } else {
            None
        };
        match family {
            Family::BsdfSampling | Family::UniformArea => {
                (!hittable).then_some(Reason::NoHittableLight)
            }
            Family::NextEventEstimation if !needs.contains(Needs::CONNECTIBLE_LIGHTS) => {
                Some(Reason::NoConnectibleLight)
            }
            Family::NextEventEstimation | Family::Connections => no_scattering,
            Family::Merges => {
                let narrow =
                    needs.contains(Needs::DIRAC_LOBES) || needs.contains(Needs::GLOSSY_LOBES);
                let connects = self.bsdf_sampling
                    && self.next_event
                    && self.connections
                    && !self.excluded.has_connections();
                no_scattering.or((connects && !narrow).then_some(Reason::Connectible))
            }
            Family::LensSampling if !hittable && !needs.contains(Needs::DIRAC_LIGHTS) => {
                Some(Reason::NoLight)
            }
            Family::LensSampling => {
                let direct = self.bsdf_sampling && !needs.contains(Needs::DIRAC_LIGHTS);
                (no_scattering.is_some() && direct && !self.excluded.has_connections())
                    .then_some(Reason::Redundant)
            }
        }
    }
    // ANCHOR_END: reason

    /// True if a family is in the set.
    #[inline]
    #[must_use]
    pub fn has(&self, family: Family) -> bool {
        match family {
            Family::BsdfSampling => self.bsdf_sampling,
            Family::NextEventEstimation => self.next_event,
            Family::Connections => self.connections,
            Family::LensSampling => self.lens_sampling,
            Family::UniformArea => self.uniform_area,
            Family::Merges => self.merges > 0,
        }
    }

    /// True if a technique is in the set.
    #[inline]
    #[must_use]
    pub fn contains(&self, technique: Technique) -> bool {
        technique.t > 0 && self.has(Family::of(technique)) && !self.excluded.contains(technique)
    }

    /// The number of samples of a technique of the set per sample of the image.
    #[inline]
    #[must_use]
    pub fn count(&self, technique: Technique) -> f64 {
        self.family_count(Family::of(technique))
    }

    /// The same of all techniques of a family.
    #[inline]
    #[must_use]
    pub fn family_count(&self, family: Family) -> f64 {
        match family {
            Family::Connections | Family::LensSampling => self.light_subpaths.count(),
            Family::Merges => self.merges.into(),
            _ => 1.0,
        }
    }

    /// The cost of the kernel that runs the set over that of the general one with the same
    /// [`Counters::cost`](super::Counters::cost): the dedicated ones have few weights or none.
    /// Fitted like the constants there.
    #[must_use]
    pub fn kernel_cost(&self) -> f64 {
        let dedicated = !(self.has_camera_subpath() && self.has_light_subpath());
        if dedicated { 0.9 } else { 1.0 }
    }

    /// The number of light subpaths of a sample; takes a number only if that is random.
    #[inline]
    pub fn draw_light_subpaths<P: Sampler>(&self, sampler: &mut P) -> u32 {
        if !self.has_light_subpath() {
            return 0;
        }
        self.light_subpaths.draw(|| {
            sampler.stream(Stream::Emission);
            sampler.next_1d()
        })
    }

    /// True if samples need light subpaths of their own.
    #[inline]
    #[must_use]
    pub fn has_light_subpath(&self) -> bool {
        self.connections || self.lens_sampling
    }

    /// True if camera subpaths are needed.
    #[inline]
    #[must_use]
    pub fn has_camera_subpath(&self) -> bool {
        self.bsdf_sampling
            || self.next_event
            || self.connections
            || self.uniform_area
            || self.merges > 0
    }
}

/// Every technique (s, t).
impl Default for TechniqueSet {
    fn default() -> Self {
        Self::BIDIRECTIONAL
    }
}

impl fmt::Display for TechniqueSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = Family::ALL
            .into_iter()
            .filter(|family| self.has(*family))
            .map(|family| family.to_string())
            .collect();
        if names.is_empty() {
            return f.write_str("none");
        }
        f.write_str(&names.join(", "))?;
        if self.has_light_subpath() && self.light_subpaths != LightSubpaths::ONE {
            write!(f, ", {} light walks per camera walk", self.light_subpaths.count())?;
        }
        if self.merges > 0 {
            write!(f, " with {} light walks", self.merges)?;
        }
        let of_set = |technique: &Technique| self.has(Family::of(*technique));
        self.excluded
            .techniques()
            .filter(of_set)
            .try_for_each(|technique| write!(f, ", without {technique}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Place;

    const PLAIN: Needs = Needs::ALL
        .without(Needs::DIRAC_LOBES)
        .without(Needs::GLOSSY_LOBES)
        .without(Needs::DIRAC_LIGHTS)
        .without(Needs::UNCONNECTIBLE_LIGHTS)
        .without(Needs::ENVIRONMENT);
    const PATH: TechniqueSet =
        TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    const LIGHT: TechniqueSet = TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE };

    #[test]
    fn what_is_left_out_has_a_reason() {
        let all = TechniqueSet { uniform_area: true, ..TechniqueSet::BIDIRECTIONAL };
        for bits in 0..1u32 << Needs::SINGLE.len() {
            let chosen = (0..).zip(Needs::SINGLE).filter(|(n, _)| bits >> n & 1 == 1);
            let needs = chosen.fold(Needs::NONE, |needs, (_, need)| needs | need);
            for set in [all, PATH, LIGHT] {
                let (pruned, left_out) = (set.pruned(&needs), set.left_out(&needs));
                for family in Family::ALL {
                    let reason = left_out.families().find(|(f, _)| *f == family);
                    assert_eq!(
                        reason.is_some(),
                        set.has(family) && !pruned.has(family),
                        "{needs} {left_out}"
                    );
                }
                assert_eq!(pruned.pruned(&needs), pruned);
            }
        }
        assert!(all.left_out(&Needs::ALL).is_empty());
        assert_eq!(all.left_out(&Needs::ALL).to_string(), "nothing");
    }

    #[test]
    fn every_technique_and_every_merge_can_be_left_out() {
        let most = Excluded::MOST_BOUNCES;
        let all = || Technique::up_to(most).chain(Technique::merges_up_to(most));
        let mut excluded = Excluded::NONE;
        for technique in all() {
            assert!(!excluded.contains(technique), "{technique}");
            excluded = excluded.with(technique).expect("a short path");
            assert!(excluded.contains(technique), "{technique}");
        }
        assert_eq!(excluded.techniques().count(), all().count());
        let longer = [Technique::new(0, most + 3), Technique::merge(2, most + 2)];
        let none = [Technique::new(2, 0), Technique::merge(1, 3), Technique::merge(3, 1)];
        let huge = [Technique::new(u16::MAX, u16::MAX), Technique::merge(u16::MAX, 2)];
        for technique in [&longer[..], &none, &huge].concat() {
            assert_eq!(Excluded::NONE.with(technique), None, "{technique}");
            assert!(!excluded.contains(technique), "{technique}");
            assert_eq!(TechniqueSet::only(technique), None, "{technique}");
        }
        for technique in all() {
            let only = TechniqueSet::only(technique).expect("a short path");
            let alike = all().filter(|other| other.bounces() == technique.bounces());
            let merging = TechniqueSet { merges: 7, ..only };
            assert!(alike.filter(|other| merging.contains(*other)).eq([technique]), "{merging}");
        }
    }

    #[test]
    fn excluded_merges_are_named_and_need_merges_no_more() {
        let merges = [Technique::merge(2, 2), Technique::merge(2, 3)];
        let excluded = merges.into_iter().try_fold(Excluded::NONE, Excluded::with);
        let excluded = excluded.expect("short paths");
        let merging = TechniqueSet { merges: 100, excluded, ..TechniqueSet::BIDIRECTIONAL };
        let text = merging.to_string();
        assert!(text.ends_with(", without merge (2, 2), without merge (2, 3)"), "{text}");
        let text = TechniqueSet { merges: 0, ..merging }.to_string();
        assert!(!text.contains("without"), "{text}");
        assert!(!merging.contains(merges[0]) && merging.contains(Technique::merge(3, 2)));
        // What replaces the merges is still there; but not without one of the connections.
        assert_eq!(merging.pruned(&PLAIN).merges, 0);
        let fewer = excluded.with(Technique::new(1, 3)).expect("a short path");
        assert_eq!(TechniqueSet { excluded: fewer, ..merging }.pruned(&PLAIN).merges, 100);
    }

    #[test]
    fn a_purely_specular_room_takes_emission_alone() {
        let mirrors = Needs::HITTABLE_LIGHTS
            | Needs::CONNECTIBLE_LIGHTS
            | Needs::DIRAC_LOBES
            | Needs::ILLUMINATION
            | Needs::INTERREFLECTION;
        let set = TechniqueSet::BIDIRECTIONAL;
        assert_eq!(
            set.pruned(&mirrors),
            TechniqueSet { bsdf_sampling: true, ..TechniqueSet::NONE }
        );
        let text = set.left_out(&mirrors).to_string();
        assert!(
            text.contains("s = 1 (next event estimation): no surface has a lobe")
                && text.contains("t = 1 (lens sampling): only"),
            "{text}"
        );
        // A point light that a lens of finite area sees is drawn by (1, 1) alone.
        assert!(set.pruned(&(mirrors | Needs::DIRAC_LIGHTS)).lens_sampling);
        assert!(LIGHT.pruned(&mirrors).lens_sampling);
    }

    #[test]
    fn completeness_is_decided_by_lights_lobes_and_lens() {
        use Place::{Area, Dirac, Infinite};
        for lens in [Area, Dirac, Infinite] {
            assert!(TechniqueSet::BIDIRECTIONAL.is_complete(&Needs::ALL, lens));
            assert!(PATH.is_complete(&PLAIN, lens) && LIGHT.is_complete(&PLAIN, lens));
            assert!(!LIGHT.is_complete(&(PLAIN | Needs::DIRAC_LOBES), lens));
            assert!(PATH.is_complete(&(PLAIN | Needs::DIRAC_LOBES), lens));
            assert!(!PATH.is_complete(&(PLAIN | Needs::DIRAC_LOBES | Needs::DIRAC_LIGHTS), lens));
            assert_eq!(PATH.is_complete(&(PLAIN | Needs::DIRAC_LIGHTS), lens), lens != Area);
            assert_eq!(LIGHT.is_complete(&(PLAIN | Needs::ENVIRONMENT), lens), lens != Infinite);
        }
    }
}
