//! The dimension of the sample space that the next number belongs to: the stream and the count
//! within it.

use super::Stream;

/// Dimensions that a sampler may stratify together. In many sequences the first two are the best
/// ones, so they are for points.
pub(super) const SET: u32 = 4;

/// Names the dimensions of one sample by (stream, count within the stream), so that a number keeps
/// its dimension whatever other streams consumed before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Dimension {
    /// Identifies the stream, and the repetition if a stream was announced more than once.
    stream: u64,
    numbers: u32,
    points: u32,
    announced: u128,
    repeats: u32,
}

impl Dimension {
    /// Starts a stream. A stream that was announced before starts as a new one, so its numbers
    /// never repeat.
    #[inline]
    pub fn announce(&mut self, stream: Stream) {
        // Exactly one number per stream, the first vertex of a walk being 1; 0 is left for numbers
        // drawn before any announcement.
        let id = match stream {
            Stream::Film => 1,
            Stream::Lens => 2,
            Stream::Emission => 3,
            Stream::PathLength => 4,
            Stream::Technique => 5,
            Stream::CameraVertex(n) => 4 + 4 * u64::from(n),
            Stream::LightVertex(n) => 5 + 4 * u64::from(n),
            Stream::NextEvent(n) => 6 + 4 * u64::from(n),
            Stream::LensSampling(n) => 7 + 4 * u64::from(n),
        };
        // Deep in a path (beyond vertex 30) no track is kept of what was announced and each
        // announcement counts as a repetition.
        let repeated = id >= 128 || self.announced >> id & 1 == 1;
        if repeated {
            self.repeats = self.repeats.wrapping_add(1);
            self.stream = id | u64::from(self.repeats) << 36;
        } else {
            self.announced |= 1 << id;
            self.stream = id;
        }
        (self.numbers, self.points) = (0, 0);
    }

    /// A number for dimension or set `n` of the current stream, by which it is hashed.
    #[inline]
    pub fn id(&self, n: u32) -> u64 {
        // Odd and irregular, so that no two streams meet.
        self.stream.wrapping_add(u64::from(n).wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// The dimension of the next number of the stream: of each set of four, the last two.
    #[inline]
    pub fn number(&mut self) -> u32 {
        let n = self.numbers;
        self.numbers = n.wrapping_add(1);
        (n / 2).wrapping_mul(SET) + 2 + n % 2
    }

    /// The first of two dimensions, the first of a set of four, for the next point of the stream.
    #[inline]
    pub fn point(&mut self) -> u32 {
        let n = self.points;
        self.points = n.wrapping_add(1);
        n.wrapping_mul(SET)
    }
}
