//! Capital letters and figures of 5 by 7 pixels, for labels in images.

/// Width and height of a glyph without the gap to the next one.
const SIZE: [u32; 2] = [5, 7];

/// Rows from top to bottom; the highest of five bits is at the left.
#[rustfmt::skip]
const GLYPHS: [(char, [u8; 7]); 42] = [
    ('A', [14, 17, 17, 31, 17, 17, 17]), ('B', [30, 17, 17, 30, 17, 17, 30]), ('C', [14, 17, 16, 16, 16, 17, 14]),
    ('D', [30, 17, 17, 17, 17, 17, 30]), ('E', [31, 16, 16, 30, 16, 16, 31]), ('F', [31, 16, 16, 30, 16, 16, 16]),
    ('G', [14, 17, 16, 23, 17, 17, 14]), ('H', [17, 17, 17, 31, 17, 17, 17]), ('I', [14, 4, 4, 4, 4, 4, 14]),
    ('J', [1, 1, 1, 1, 1, 17, 14]), ('K', [17, 18, 20, 24, 20, 18, 17]), ('L', [16, 16, 16, 16, 16, 16, 31]),
    ('M', [17, 27, 21, 21, 17, 17, 17]), ('N', [17, 25, 21, 19, 17, 17, 17]), ('O', [14, 17, 17, 17, 17, 17, 14]),
    ('P', [30, 17, 17, 30, 16, 16, 16]), ('Q', [14, 17, 17, 17, 21, 18, 13]), ('R', [30, 17, 17, 30, 20, 18, 17]),
    ('S', [15, 16, 16, 14, 1, 1, 30]), ('T', [31, 4, 4, 4, 4, 4, 4]), ('U', [17, 17, 17, 17, 17, 17, 14]),
    ('V', [17, 17, 17, 17, 17, 10, 4]), ('W', [17, 17, 17, 21, 21, 27, 17]), ('X', [17, 17, 10, 4, 10, 17, 17]),
    ('Y', [17, 17, 10, 4, 4, 4, 4]), ('Z', [31, 1, 2, 4, 8, 16, 31]), ('0', [14, 17, 19, 21, 25, 17, 14]),
    ('1', [4, 12, 4, 4, 4, 4, 14]), ('2', [14, 17, 1, 6, 8, 16, 31]), ('3', [31, 1, 2, 6, 1, 17, 14]),
    ('4', [2, 6, 10, 18, 31, 2, 2]), ('5', [31, 16, 30, 1, 1, 17, 14]), ('6', [14, 16, 16, 30, 17, 17, 14]),
    ('7', [31, 1, 2, 4, 8, 8, 8]), ('8', [14, 17, 17, 14, 17, 17, 14]), ('9', [14, 17, 17, 15, 1, 1, 14]),
    ('-', [0, 0, 0, 14, 0, 0, 0]), ('+', [0, 4, 4, 31, 4, 4, 0]), ('.', [0, 0, 0, 0, 0, 0, 4]),
    ('%', [25, 25, 2, 4, 8, 19, 19]), ('/', [1, 1, 2, 4, 8, 16, 16]), ('=', [0, 0, 31, 0, 31, 0, 0]),
];

/// Width of a text in pixels.
pub fn width(text: &str, scale: u32) -> u32 {
    text.chars().count() as u32 * (SIZE[0] + 1) * scale
}

/// Height of a line in pixels, the gap to the next one included.
pub fn height(scale: u32) -> u32 {
    (SIZE[1] + 3) * scale
}

/// Calls `paint` for every pixel of a text whose upper left corner is at the origin. What has no
/// glyph is left blank.
pub fn draw(text: &str, scale: u32, mut paint: impl FnMut(u32, u32)) {
    for (i, character) in text.chars().enumerate() {
        let Some((_, rows)) = GLYPHS.iter().find(|(c, _)| *c == character.to_ascii_uppercase())
        else {
            continue;
        };
        let left = i as u32 * (SIZE[0] + 1) * scale;
        for (y, row) in (0..).zip(rows) {
            for x in (0..SIZE[0]).filter(|x| row >> (SIZE[0] - 1 - x) & 1 == 1) {
                for dy in 0..scale {
                    (0..scale).for_each(|dx| paint(left + x * scale + dx, y * scale + dy));
                }
            }
        }
    }
}
