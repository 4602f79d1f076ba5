//! Pixel values inside a page: half floats, which keep three digits of the film's 64 bits.
//!
//! A value is stored times a power of two that puts the page's white near 1, so that the range of
//! half floats, 24 stops below and 16 above, lies where the eye looks. Bytes of one kind stand
//! together, by which they compress by a fifth: the lower bytes of all red values, the upper ones,
//! those of green and of blue; then zlib's format and Base64. That is some 5 bytes a pixel.

use crate::film::Image;
use base64::prelude::{BASE64_STANDARD, Engine};
use exr::prelude::f16;
use flate2::{Compression, write::ZlibEncoder};
use std::io::Write;

/// The largest half float, which stands for all that is larger.
const LARGEST: f64 = 65504.0;

/// The values of an image times `2^stops`.
pub(super) fn encoded(image: &Image, stops: i32) -> String {
    let gain = f64::from(stops).exp2();
    let halves = |channel: usize| {
        let half = move |x: f64| f16::from_f64((x * gain).clamp(-LARGEST, LARGEST));
        image.pixels().iter().map(move |p| half(p[channel]).to_le_bytes())
    };
    let planes = (0..3).flat_map(|channel| {
        [0, 1].into_iter().flat_map(move |byte| halves(channel).map(move |half| half[byte]))
    });
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to memory cannot fail.
    let _ = packed.write_all(&planes.collect::<Vec<u8>>());
    packed.finish().map_or_else(|_| String::new(), |bytes| BASE64_STANDARD.encode(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use std::io::Read;

    #[test]
    fn values_keep_three_digits() {
        let value = |x: u32, c: u32| 1.7e-4 * 1.37f64.powi((x + c) as i32);
        let image = Image::from_fn(40, 1, |x, _| Rgb([0, 1, 2].map(|c| value(x, c))));
        let packed = BASE64_STANDARD.decode(encoded(&image, 3)).unwrap();
        let mut planes = Vec::new();
        flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut planes).unwrap();
        assert_eq!(planes.len(), 6 * 40);
        for (x, c) in (0..40).flat_map(|x| (0..3).map(move |c| (x, c))) {
            let [low, high] = [0, 40].map(|plane| planes[80 * c as usize + plane + x as usize]);
            let found = f16::from_le_bytes([low, high]).to_f64() / 8.0;
            assert!((found / value(x, c) - 1.0).abs() < 5e-4, "{x} {c} {found}");
        }
    }
}
