//! The paths of a sample with their contributions.

use crate::film::{Contribution, Sample};
use crate::integrator::bidirectional::Pairs;
use crate::integrator::{Bidirectional, MergingPairs, Stage};
use crate::path::{MergedPath, Out, Path, Scratch, Site, Weighting};
use crate::sampler::Sampler;
use crate::scene::Scene;

impl Bidirectional {
    /// Draws one sample and shows every path with a nonzero contribution, with its weight, to
    /// `visit`, as an audit or an experiment looks at them.
    pub fn for_each_path<'s, S: Scene + ?Sized, P: Sampler>(
        &self,
        stage: Stage<'s, S>,
        sample: Sample<P>,
        scratch: &mut Scratch<'s, S>,
        visit: impl FnMut(&Path<'_, 's, S>, &Contribution),
    ) {
        self.run(stage).for_each_path(sample, scratch, visit, |_| {});
    }
}

impl<'a, S: Scene + ?Sized> Pairs<'a, S> {
    /// Draws one sample, shows `visit` every path with a nonzero contribution, and `merge` the
    /// complete camera subpath.
    fn for_each_path<P: Sampler>(
        &self,
        sample: Sample<P>,
        scratch: &mut Scratch<'a, S>,
        mut visit: impl FnMut(&Path<'_, 'a, S>, &Contribution),
        merge: impl FnMut(&mut Site<'_, 'a, S, P>),
    ) {
        let mut look = |_: &mut Out<'_>, path: &Path<'_, 'a, S>, contribution, counters: &mut _| {
            if path.is_visible(counters) {
                visit(path, &contribution);
            }
        };
        let nowhere = &mut |_, _: &Contribution| {};
        self.trace(&mut [sample], nowhere, scratch, &mut look, merge);
    }
}

impl<'a, S: Scene + ?Sized + 'a> MergingPairs<'a, S> {
    /// Draws one sample and shows every path with a nonzero contribution, connected or merged, as an
    /// audit looks at them; merged ones of a pass that [keeps](Self::keep_subpaths) light subpaths.
    pub fn for_each_path<P: Sampler>(
        &self,
        sample: Sample<P>,
        scratch: &mut Scratch<'a, S>,
        connected: impl FnMut(&Path<'_, 'a, S>, &Contribution),
        mut merged: impl FnMut(&MergedPath<'_, 'a, S>, &Contribution),
    ) {
        let Self { pairs, merges } = self;
        pairs.for_each_path(sample, scratch, connected, |site| {
            merges.for_each(&pairs.weighting, site, |path, contribution, _| {
                path.into_iter().for_each(|path| merged(path, &contribution));
            });
        });
    }

    /// Keeps whole light subpaths in the passes to come.
    pub fn keep_subpaths(&mut self) {
        self.merges.keeps_subpaths = true;
    }

    /// The weights of the pass under way.
    pub fn weighting(&self) -> &Weighting {
        &self.pairs.weighting
    }
}
