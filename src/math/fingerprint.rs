//! A number that tells things apart by how they print.

use std::fmt::{self, Write};

/// FNV-1a in 64 bits (Fowler, Noll and Vo) over what is written: the same in every run and on every
/// machine.
#[derive(Clone, Copy, Debug)]
pub struct Fingerprint(u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    /// The fingerprint of the debug output of something. Numbers print with all their digits, so
    /// that it tells apart what differs in one bit.
    #[must_use]
    pub fn of(thing: impl fmt::Debug) -> u64 {
        Self::default().with(thing).get()
    }

    /// The fingerprint of all before and of the debug output of one more thing.
    #[must_use]
    pub fn with(mut self, thing: impl fmt::Debug) -> Self {
        // A separator, or neighbours could exchange digits. Writing to it cannot fail.
        let _ = write!(self, "{thing:?};");
        self
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u64 {
        self.0
    }
}

impl Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_in_one_bit_has_another_fingerprint() {
        assert_eq!(Fingerprint::of(1.0), Fingerprint::of(1.0));
        assert_ne!(Fingerprint::of(1.0), Fingerprint::of(1.0f64.next_up()));
        assert_ne!(Fingerprint::of(0.0), Fingerprint::of(-0.0));
        let of = |a: u32, b: u32| Fingerprint::default().with(a).with(b).get();
        assert_ne!(of(12, 3), of(1, 23));
        let mut print = Fingerprint::default();
        // A published value of FNV-1a.
        print.write_str("foobar").unwrap();
        assert_eq!(print.get(), 0x8594_4171_f739_67e8);
    }
}
