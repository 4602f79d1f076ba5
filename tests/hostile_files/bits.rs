//! Small files that stand for large ones.

/// A zlib stream of some bytes and very many zeros behind them: one after the other literally, and
/// then copies of 258 bytes, which take 13 bits each (RFC 1951, section 3.2.6).
pub fn zlib_with_zeros(first: &[u8], zeros: u64) -> Vec<u8> {
    let mut bytes = vec![0x78, 0x01];
    // A stored block.
    let length = u16::try_from(first.len()).expect("short");
    bytes.push(0);
    bytes.extend([length.to_le_bytes(), (!length).to_le_bytes()].concat());
    bytes.extend(first);
    let mut bits = Bits { bytes, pending: 0, count: 0 };
    // The last block, with fixed codes; codes begin with their highest bit.
    bits.push(0b011, 3);
    bits.push(0b0000_1100, 8);
    for _ in 0..zeros / 258 {
        bits.push(0b1010_0011, 8);
        bits.push(0, 5);
    }
    bits.push(0, 7);
    bits.push(0, 7);
    bits.bytes
}

struct Bits {
    bytes: Vec<u8>,
    pending: u64,
    count: u32,
}

impl Bits {
    /// Adds bits, the lowest one first.
    fn push(&mut self, bits: u64, count: u32) {
        self.pending |= bits << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }
}

/// A chunk of a PNG file.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let length = u32::try_from(data.len()).expect("short").to_be_bytes();
    let checked = [kind, data].concat();
    let crc = !checked.iter().fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    });
    [&length[..], &checked, &crc.to_be_bytes()].concat()
}

/// A PNG file of a size, with other chunks before its pixels.
pub fn png(width: u32, height: u32, others: &[(&[u8; 4], Vec<u8>)], pixels: &[u8]) -> Vec<u8> {
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    // 8 bits, RGB.
    header.extend([8, 2, 0, 0, 0]);
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    bytes.extend(chunk(b"IHDR", &header));
    others.iter().for_each(|(kind, data)| bytes.extend(chunk(kind, data)));
    bytes.extend(chunk(b"IDAT", pixels));
    bytes.extend(chunk(b"IEND", &[]));
    bytes
}

/// A JPEG file that ends after its header.
pub fn jpeg(width: u16, height: u16) -> Vec<u8> {
    let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xC0, 0, 17, 8];
    bytes.extend([height.to_be_bytes(), width.to_be_bytes()].concat());
    bytes.extend([3, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0]);
    bytes.extend([0xFF, 0xDA, 0, 12, 3, 1, 0, 2, 0, 3, 0, 0, 63, 0, 0, 0xFF, 0xD9]);
    bytes
}

/// An OpenEXR file of 16-bit red, green, blue and other channels, with one block if it is
/// compressed.
pub fn exr(
    data_window: [i32; 4],
    display_window: [i32; 4],
    others: u32,
    extra: &[u8],
    block: Option<ExrBlock>,
) -> Vec<u8> {
    let attribute = |name: &str, kind: &str, value: &[u8]| {
        let length = (value.len() as u32).to_le_bytes();
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length[..], value].concat()
    };
    let window = |window: [i32; 4]| window.map(i32::to_le_bytes).concat();
    let channel = |name: &str| {
        [name.as_bytes(), &[0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]].concat()
    };
    let mut names = ["B".to_owned(), "G".to_owned(), "R".to_owned()].to_vec();
    names.extend((0..others).map(|index| format!("X{index:06}")));
    let mut channels: Vec<u8> = names.iter().flat_map(|name| channel(name)).collect();
    channels.push(0);
    let mut bytes = vec![0x76, 0x2F, 0x31, 0x01, 2, 0, 0, 0];
    bytes.extend(extra);
    bytes.extend(attribute("channels", "chlist", &channels));
    let compression = block.as_ref().map_or(0, |block| block.compression);
    bytes.extend(attribute("compression", "compression", &[compression]));
    bytes.extend(attribute("dataWindow", "box2i", &window(data_window)));
    bytes.extend(attribute("displayWindow", "box2i", &window(display_window)));
    bytes.extend(attribute("lineOrder", "lineOrder", &[0]));
    bytes.extend(attribute("pixelAspectRatio", "float", &1f32.to_le_bytes()));
    bytes.extend(attribute("screenWindowCenter", "v2f", &[0; 8]));
    bytes.extend(attribute("screenWindowWidth", "float", &1f32.to_le_bytes()));
    bytes.push(0);
    match block {
        Some(ExrBlock { data, .. }) => {
            bytes.extend((bytes.len() as u64 + 8).to_le_bytes());
            bytes.extend([data_window[1], data.len() as i32].map(i32::to_le_bytes).concat());
            bytes.extend(data);
        }
        None => bytes.extend([0; 64]),
    }
    bytes
}

/// The only block of an OpenEXR file.
pub struct ExrBlock {
    pub compression: u8,
    pub data: Vec<u8>,
}

/// A block of zeros, as wavelets and Huffman's codes hold them.
pub fn piz() -> ExrBlock {
    let lengths = [1u16, 0].map(u16::to_le_bytes).concat();
    let codes = [0u32, 0, 1, 8, 0].map(u32::to_le_bytes).concat();
    let data = [lengths, 22i32.to_le_bytes().into(), codes, vec![0x04, 0]].concat();
    ExrBlock { compression: 4, data }
}
