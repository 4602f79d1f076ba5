//! Random damage to files.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// What numbers become.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "255",
    "65536",
    "4294967295",
    "-4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "1e-320",
    "1e38",
    "-1e39",
    "1e300",
    "1e999",
    "nan",
    "-inf",
    "infinity",
    "0x10",
    "",
];

/// What words become, beside other words of the file.
const WORDS: [&str; 10] =
    ["", "true", "null", "\"", "..", "/dev/null", "$a", "\u{0}", "\u{FFFD}", "'"];

/// What four bytes become.
const CODES: [[u8; 4]; 8] = [
    [0; 4],
    [0xFF; 4],
    [0xFF, 0xFF, 0xFF, 0x7F],
    [0x7F, 0xFF, 0xFF, 0xFF],
    [1, 0, 0, 0],
    [0, 0, 0, 1],
    // Infinity and a NaN.
    [0, 0, 0x80, 0x7F],
    [0, 0, 0xC0, 0x7F],
];

/// A file with some of its numbers, words, bytes or elements changed, left out or repeated.
pub fn damaged(original: &[u8], is_text: bool, random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = original.to_vec();
    let most = if random.random_range(0..4) == 0 { 12 } else { 3 };
    for _ in 0..random.random_range(1..=most) {
        if bytes.is_empty() {
            break;
        }
        if is_text && random.random_range(0..8) != 0 {
            damage_text(&mut bytes, random);
        } else {
            damage_bytes(&mut bytes, random);
        }
    }
    bytes
}

fn damage_bytes(bytes: &mut Vec<u8>, random: &mut Pcg64Mcg) {
    let at = random.random_range(0..bytes.len());
    let longest = if random.random_range(0..4) == 0 { bytes.len() } else { 16 };
    let end = (at + random.random_range(1..=longest)).min(bytes.len());
    match random.random_range(0..8) {
        0 => bytes[at] ^= 1 << random.random_range(0..8),
        1 => bytes[at] = random.random(),
        2 => bytes[at] = bytes[at].wrapping_add(if random.random() { 1 } else { 255 }),
        3 | 4 => {
            let code = CODES[random.random_range(0..CODES.len())];
            bytes.iter_mut().skip(at).zip(code).for_each(|(byte, code)| *byte = code);
        }
        5 => drop(bytes.drain(at..end)),
        6 => repeat(bytes, at, end, random),
        _ => bytes.truncate(at),
    }
}

fn repeat(bytes: &mut Vec<u8>, at: usize, end: usize, random: &mut Pcg64Mcg) {
    let part = bytes[at..end].repeat(random.random_range(1..3));
    bytes.splice(at..at, part);
}

fn damage_text(bytes: &mut Vec<u8>, random: &mut Pcg64Mcg) {
    let kind = random.random_range(0..8);
    let Some((at, end)) = (match kind {
        0..=2 => choice(&words(bytes, |word| word.iter().any(u8::is_ascii_digit)), random),
        3 | 4 => choice(&words(bytes, |_| true), random),
        _ => choice(&elements(bytes), random),
    }) else {
        return damage_bytes(bytes, random);
    };
    match kind {
        0..=2 => {
            let number = NUMBERS[random.random_range(0..NUMBERS.len())];
            bytes.splice(at..end, number.bytes());
        }
        3 | 4 => {
            let others = words(bytes, |_| true);
            let word = if random.random() {
                let (at, end) = others[random.random_range(0..others.len())];
                bytes[at..end].to_vec()
            } else {
                WORDS[random.random_range(0..WORDS.len())].as_bytes().to_vec()
            };
            bytes.splice(at..end, word);
        }
        5 => drop(bytes.drain(at..end)),
        6 => repeat(bytes, at, end, random),
        _ => {
            // Another element in its place.
            if let Some((from, to)) = choice(&elements(bytes), random) {
                let part = bytes[from..to].to_vec();
                bytes.splice(at..end, part);
            }
        }
    }
}

fn choice(parts: &[(usize, usize)], random: &mut Pcg64Mcg) -> Option<(usize, usize)> {
    (!parts.is_empty()).then(|| parts[random.random_range(0..parts.len())])
}

/// The words and numbers of a text that are of some kind.
fn words(bytes: &[u8], kind: impl Fn(&[u8]) -> bool) -> Vec<(usize, usize)> {
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || b"_-+.".contains(byte);
    let mut words = Vec::new();
    let mut at = 0;
    for word in bytes.chunk_by(|a, b| is_part(a) == is_part(b)) {
        if is_part(&word[0]) && kind(word) {
            words.push((at, at + word.len()));
        }
        at += word.len();
    }
    words
}

/// Lines, tags, and what is between brackets of each kind.
fn elements(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut elements = Vec::new();
    let mut open = Vec::new();
    let mut line = 0;
    for (at, byte) in bytes.iter().enumerate() {
        match byte {
            b'<' | b'{' | b'[' => open.push(at),
            b'>' | b'}' | b']' => elements.extend(open.pop().map(|start| (start, at + 1))),
            b'\n' => {
                elements.push((line, at + 1));
                line = at + 1;
            }
            _ => {}
        }
    }
    elements
}
