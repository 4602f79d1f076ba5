//! Integer hashing: what turns the index of a sample into numbers without any state.

/// A bijection of 64-bit integers in which every bit of the input flips about half of the output:
/// the finaliser "variant 13" of Stafford (2011), as used by SplitMix64 (Steele, Lea and Flood
/// 2014).
#[inline]
#[must_use]
pub(super) const fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// 2⁶⁴ divided by the golden ratio, odd and with irregular bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes one more value into a hash. For a given hash this is a bijection of the value.
#[inline]
#[must_use]
pub(super) const fn combine(hash: u64, value: u64) -> u64 {
    // The constant keeps 0 from being a fixed point.
    mix(hash.wrapping_add(GOLDEN) ^ mix(value.wrapping_add(GOLDEN)))
}

/// Number `n` of the sequence that a hash starts (SplitMix64), at half the cost of [`combine`].
#[inline]
#[must_use]
pub(super) const fn nth(hash: u64, n: u64) -> u64 {
    mix(hash.wrapping_add(GOLDEN.wrapping_mul(n.wrapping_add(1))))
}

/// The hash of one sample. Within one seed different samples have different hashes.
#[inline]
#[must_use]
pub(super) const fn hash_sample(seed: u64, pixel: u32, pass: u32) -> u64 {
    combine(mix(seed), (pixel as u64) << 32 | pass as u64)
}

/// The upper 53 bits as a number in `[0, 1)`: a multiple of 2⁻⁵³, at most 1 - 2⁻⁵³.
#[inline]
#[must_use]
pub(super) const fn unit_interval(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Keeps `(stratum + jitter) / strata`, rounded, below 1.
pub(super) const ONE_MINUS_ULP: f64 = 1.0 - f64::EPSILON / 2.0;

/// Element number `index` of a permutation of `0..length` that `key`, a hash, selects; 0 if
/// `length` is 0 and `index` is taken modulo `length`.
///
/// A bijection of the next power of two is iterated until it lands in the range ("cycle walking",
/// Black and Rogaway 2002; for sampling patterns Kensler 2013). The final rotation makes each
/// single element uniform.
#[inline]
#[must_use]
pub(super) fn permute(index: u32, length: u32, key: u64) -> u32 {
    if length <= 1 {
        return 0;
    }
    let bits = 32 - (length - 1).leading_zeros();
    let mask = u32::MAX >> (32 - bits);
    let shift = bits.div_ceil(2);
    let mut x = index % length;
    loop {
        let mut round_key = key;
        for _ in 0..4 {
            // Each step is invertible modulo 2^bits: addition, odd multiplication, exclusive or
            // with its own upper half. The keys of the rounds are a linear congruential sequence
            // from the (hashed) key; its upper bits are good.
            round_key =
                round_key.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(0x9e37_79b9_7f4a_7c15);
            x = x.wrapping_add((round_key >> 40) as u32) & mask;
            x = x.wrapping_mul((round_key >> 24) as u32 | 1) & mask;
            x ^= x >> shift;
        }
        if x < length {
            break;
        }
    }
    // A number below `length` from 32 hashed bits (Lemire 2019, without its rejection: the bias is
    // below 2⁻³² · length).
    let rotation = (((mix(key) >> 32) * u64::from(length)) >> 32) as u32;
    let room = length - rotation;
    if x < room { x + rotation } else { x - room }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permutations_are_bijections_and_uniform() {
        for length in [1u32, 2, 3, 5, 16, 17, 100, 1000] {
            for key in 0..50 {
                let mut seen: Vec<u32> = (0..length).map(|i| permute(i, length, key)).collect();
                seen.sort_unstable();
                assert!(seen.iter().copied().eq(0..length));
            }
        }
        // Pairs of places: all 5·4 ordered pairs equally likely. 200 000 keys, 19 degrees of
        // freedom: mean 19, sd 6.2.
        for length in [4u32, 5, 7] {
            let (n, cells) = (200_000u64, length * (length - 1));
            for (i, j) in [(0, 1), (0, length - 1), (1, 2)] {
                let mut counts = vec![0u32; (length * length) as usize];
                for key in 0..n {
                    let key = mix(key);
                    counts
                        [(permute(i, length, key) * length + permute(j, length, key)) as usize] +=
                        1;
                }
                let expected = n as f64 / f64::from(cells);
                let chi2: f64 = counts
                    .iter()
                    .filter(|&&c| c > 0)
                    .map(|&c| (f64::from(c) - expected).powi(2) / expected)
                    .sum();
                let freedom = f64::from(cells - 1);
                println!(
                    "length {length}, places {i} {j}: chi-square {chi2:.1} for {freedom} degrees of freedom"
                );
                // A hash is no ideal shuffle, so only gross dependence is excluded: each pair
                // within 10 % of its share.
                assert!(
                    chi2 < freedom + 5.0 * (2.0 * freedom).sqrt() + 0.01 * n as f64,
                    "{length} {i} {j}: {chi2}"
                );
            }
        }
    }

    #[inline]
    #[test]
    fn unit_interval_is_half_open() {
        assert_eq!(unit_interval(0), 0.0);
        assert_eq!(unit_interval(u64::MAX), 1.0 - f64::EPSILON / 2.0);
        assert_eq!(ONE_MINUS_ULP, 1.0f64.next_down());
    }
}
