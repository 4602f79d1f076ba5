//! Checkpoints: renderings between two passes, which can go on later, elsewhere, and in parts.
//!
//! Film and ledger are [exact sums](crate::math::ExactSums), and a pass depends on its number alone.
//! So whoever draws the passes, with whatever breaks in between, in however many parts, has the same
//! image to the bit.

use super::RenderError;
use super::identity::Identity;
use super::shard::Shard;
use super::state::{State, Times};
use crate::film::{Film, Image};
use crate::path::Counters;
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

/// A rendering between two passes: the sums of those that were drawn, and what they are of. With it
/// [`resume`](super::resume()) goes on; and [`Merger`] adds those of all shards of a rendering.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    pub(crate) identity: Identity,
    pub(crate) shard: Shard,
    pub(crate) state: State,
    /// The caller's own entries, which go into its files and into those of images.
    pub metadata: BTreeMap<String, String>,
}

/// The reason why a checkpoint is not one of a rendering.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// Something differs.
    #[error("the checkpoint is of another rendering: its {name} is {there}, here it is {here}")]
    Different {
        /// The name of what differs.
        name: String,
        /// The value in the checkpoint.
        there: String,
        /// The value here.
        here: String,
    },
    /// The counts of the preparation differ, which are the same in all processes.
    #[error(
        "the checkpoint was prepared in another way, so its machine computes other numbers than \
         this one"
    )]
    Prepared,
}

impl Checkpoint {
    pub(super) fn new(identity: &Identity, shard: Shard, state: &State) -> Self {
        let (identity, state) = (identity.clone(), state.clone());
        Self { identity, shard, state, metadata: BTreeMap::new() }
    }

    /// The part of the rendering that it belongs to.
    #[must_use]
    pub fn shard(&self) -> Shard {
        self.shard
    }

    /// The passes that it holds.
    #[must_use]
    pub fn passes(&self) -> Range<u32> {
        self.state.passes.clone()
    }

    /// True if it holds all passes of its shard.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        let samples = self.samples();
        samples.is_some_and(|samples| self.shard.part_of(samples) == self.state.passes)
    }

    /// The passes of the whole rendering, if it is not limited by time.
    fn samples(&self) -> Option<u32> {
        self.identity.0.get("samples per pixel").and_then(|samples| samples.parse().ok())
    }

    /// The sums so far.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.state.film
    }

    /// Counts of what was done so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.state.counters()
    }

    /// The image so far.
    #[must_use]
    pub fn image(&self) -> Image {
        self.state.image()
    }

    /// Wall-clock time spent so far; that of several shards one after the other.
    #[must_use]
    pub fn wall(&self) -> Duration {
        self.state.times.wall
    }

    /// The same without times, in which alone the checkpoints of the same passes differ.
    #[must_use]
    pub fn without_clocks(mut self) -> Self {
        self.state.times = Times::default();
        self
    }

    /// The state to go on from, in a rendering of this identity.
    pub(super) fn into_state(
        self,
        identity: &Identity,
        shard: Shard,
    ) -> Result<State, RenderError> {
        self.check(identity, shard)?;
        Ok(self.state)
    }

    fn check(&self, identity: &Identity, shard: Shard) -> Result<(), CheckpointError> {
        let mut differences = identity.difference(&self.identity).into_iter();
        let shards = || {
            (self.shard != shard)
                .then(|| ["shard".to_owned(), self.shard.to_string(), shard.to_string()])
        };
        match differences.next().or_else(shards) {
            Some([name, there, here]) => Err(CheckpointError::Different { name, there, here }),
            None => Ok(()),
        }
    }
}

/// The sum of all shards of a rendering, added in any order: to the bit what one process would have
/// drawn.
#[derive(Clone, Debug, Default)]
pub struct Merger {
    sum: Option<Checkpoint>,
    /// The names of the shards that are in it.
    names: BTreeMap<u32, String>,
}

/// The reason why shards make no rendering.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// There is nothing to merge.
    #[error("there are no shards to merge")]
    Nothing,
    /// Two are not of the same rendering.
    #[error("{name}: {reason}")]
    Different {
        /// The name of the shard that is not of the rendering of those before it.
        name: String,
        /// The difference.
        reason: CheckpointError,
    },
    /// The rendering of a shard has not ended.
    #[error(
        "{name}: shard {shard} is unfinished, with {drawn} of {all} passes: resume it", 
        drawn = .passes.len(), all = .all.len()
    )]
    Unfinished {
        /// The name of the shard.
        name: String,
        /// The shard.
        shard: Shard,
        /// The passes that it holds.
        passes: Range<u32>,
        /// The passes that it should hold.
        all: Range<u32>,
    },
    /// A shard is there twice.
    #[error("{name}: shard {shard} is there already, as {first}")]
    Twice {
        /// The name of the second one.
        name: String,
        /// The shard.
        shard: Shard,
        /// The name of the first one.
        first: String,
    },
    /// Shards are missing.
    #[error("missing {}", list(.0))]
    Missing(Vec<Shard>),
}

fn list(shards: &[Shard]) -> String {
    let names: Vec<String> = shards.iter().map(Shard::to_string).collect();
    format!("shard{} {}", if shards.len() == 1 { "" } else { "s" }, names.join(", "))
}

impl Merger {
    /// Adds a shard; errors call it by its name, such as that of its file.
    ///
    /// # Errors
    /// If it is unfinished, of another rendering than those before, or there already.
    pub fn add(&mut self, name: &str, shard: Checkpoint) -> Result<(), MergeError> {
        let name = name.to_owned();
        if !shard.is_complete() {
            let all = shard.shard.part_of(shard.samples().unwrap_or(u32::MAX));
            let (passes, shard) = (shard.state.passes, shard.shard);
            return Err(MergeError::Unfinished { name, shard, passes, all });
        }
        let index = shard.shard.index();
        if let Some(sum) = &mut self.sum {
            let different = |reason| MergeError::Different { name: name.clone(), reason };
            let expected = Shard::new(index, sum.shard.count()).unwrap_or(sum.shard);
            shard.check(&sum.identity, expected).map_err(different)?;
            if shard.metadata != sum.metadata {
                let [of, own] = [&shard, &*sum].map(|part| Identity(part.metadata.clone()));
                let difference = own.difference(&of).unwrap_or_default();
                let [name, there, here] = difference;
                return Err(different(CheckpointError::Different { name, there, here }));
            }
            if shard.state.prepared != sum.state.prepared {
                return Err(different(CheckpointError::Prepared));
            }
            if let Some(first) = self.names.get(&index) {
                let (shard, first) = (shard.shard, first.clone());
                return Err(MergeError::Twice { name, shard, first });
            }
            sum.state.merge(&shard.state);
        } else {
            self.sum = Some(shard);
        }
        self.names.insert(index, name);
        Ok(())
    }

    /// The rendering, whole.
    ///
    /// # Errors
    /// If shards are missing.
    pub fn finish(self) -> Result<Checkpoint, MergeError> {
        let mut sum = self.sum.ok_or(MergeError::Nothing)?;
        let all = (1..=sum.shard.count()).filter_map(|index| Shard::new(index, sum.shard.count()));
        let missing: Vec<Shard> = all.filter(|s| !self.names.contains_key(&s.index())).collect();
        if !missing.is_empty() {
            return Err(MergeError::Missing(missing));
        }
        sum.state.passes = 0..sum.samples().unwrap_or_default();
        sum.shard = Shard::WHOLE;
        Ok(sum)
    }
}
