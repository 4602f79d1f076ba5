//! Files of a line of JSON and then 64-bit floats.

use serde::{Serialize, de::DeserializeOwned};

/// The bytes of such a file.
pub(super) fn encode(header: &impl Serialize, numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    let mut bytes = serde_json::to_vec(header).unwrap_or_default();
    bytes.push(b'\n');
    numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes
}

/// Header and numbers of such a file; `None` if it is none.
pub(super) fn decode<H: DeserializeOwned>(
    bytes: &[u8],
) -> Option<(H, impl ExactSizeIterator<Item = f64>)> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let header = serde_json::from_slice(&bytes[..end]).ok()?;
    let (numbers, rest) = bytes[end + 1..].as_chunks::<8>();
    let numbers = numbers.iter().map(|number| f64::from_le_bytes(*number));
    rest.is_empty().then_some((header, numbers))
}
