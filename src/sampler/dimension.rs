//! The dimension of the sample space that the next number belongs to: the stream and the count
//! within it.

use super::Stream;

/// Names the dimensions of one sample by (stream, count within the stream), so that a number keeps
/// its dimension whatever other streams consumed before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Dimension {
    /// Identifies the stream, and the repetition if a stream was announced more than once.
    pub stream: u64,
    /// The number of dimensions of the stream that were used.
    pub count: u32,
    announced: u128,
    repeats: u32,
}

impl Dimension {
    /// Starts a stream. A stream that was announced before starts as a new one, so its numbers
    /// never repeat.
    #[inline]
    pub fn announce(&mut self, stream: Stream) {
        // Exactly one number per stream; 0 is left for numbers drawn before any announcement.
        let id = match stream {
            Stream::Film => 1,
            Stream::Lens => 2,
            Stream::Emission => 3,
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
        self.count = 0;
    }

    /// Reserves `n` dimensions and returns the first.
    #[inline]
    pub fn take(&mut self, n: u32) -> u32 {
        let first = self.count;
        self.count = first.wrapping_add(n);
        first
    }
}
