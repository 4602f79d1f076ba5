//! Shards: the parts of a rendering that different machines draw.

use super::RenderError;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// One of several parts of a rendering, whose passes one process draws. Prints and parses as `I/N`
/// with I from 1 to N.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    /// All of a rendering.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// The part of number `index` of `count`, from 1 on; `None` if there is none.
    #[must_use]
    pub fn new(index: u32, count: u32) -> Option<Self> {
        (1..=count).contains(&index).then_some(Self { index, count })
    }

    /// Its number, from 1 to [`count`](Self::count).
    #[must_use]
    pub const fn index(self) -> u32 {
        self.index
    }

    /// The number of shards.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.count
    }

    /// The part of so many things that fall to it, consecutive and as many as to every other one, up
    /// to one.
    #[must_use]
    pub fn part_of(self, things: u32) -> Range<u32> {
        let end = |shards: u32| {
            // At most `things`.
            (u64::from(things) * u64::from(shards) / u64::from(self.count)) as u32
        };
        end(self.index - 1)..end(self.index)
    }

    /// The passes of a rendering of so many that it draws.
    pub(super) fn passes(self, passes: Option<u32>) -> Result<Range<u32>, RenderError> {
        match passes {
            None if self == Self::WHOLE => Ok(0..u32::MAX),
            None => Err(RenderError::ShardOfTime(self)),
            Some(passes) if passes < self.count => {
                Err(RenderError::EmptyShard { shard: self, passes })
            }
            Some(passes) => Ok(self.part_of(passes)),
        }
    }
}

impl Default for Shard {
    fn default() -> Self {
        Self::WHOLE
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// The text is no shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no shard; one looks like 3/7, with the first number from 1 to the second")]
pub struct ShardError(String);

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let numbers = text.split_once('/').and_then(|(index, count)| {
            Self::new(index.trim().parse().ok()?, count.trim().parse().ok()?)
        });
        numbers.ok_or_else(|| ShardError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_everything_once() {
        for (count, things) in [(1, 5), (7, 7), (7, 64), (3, u32::MAX), (1000, 1001)] {
            let mut next = 0;
            for index in 1..=count {
                let part = Shard::new(index, count).unwrap().part_of(things);
                assert_eq!(part.start, next);
                let length = part.len() as u32;
                assert!((things / count..=things.div_ceil(count)).contains(&length));
                next = part.end;
            }
            assert_eq!(next, things);
        }
    }

    #[test]
    fn shards_print_as_they_parse() {
        assert_eq!("3/7".parse(), Ok(Shard { index: 3, count: 7 }));
        assert_eq!(Shard::new(3, 7).unwrap().to_string(), "3/7");
        for text in ["", "3", "0/7", "8/7", "-1/7", "1/0", "1/2/3", "a/b", "1.5/2"] {
            assert!(text.parse::<Shard>().unwrap_err().to_string().contains(text), "{text}");
        }
    }

    #[test]
    fn a_shard_without_passes_is_refused() {
        let shard = Shard::new(2, 3).unwrap();
        assert!(matches!(shard.passes(Some(2)), Err(RenderError::EmptyShard { passes: 2, .. })));
        assert!(matches!(shard.passes(None), Err(RenderError::ShardOfTime(_))));
        assert_eq!(shard.passes(Some(7)), Ok(2..4));
        assert_eq!(Shard::WHOLE.passes(None), Ok(0..u32::MAX));
    }
}
