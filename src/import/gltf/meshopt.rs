//! Buffer views compressed by `EXT_meshopt_compression`, or by `KHR_meshopt_compression`, which
//! adds version 1 of attributes and the filter of colours; after the text of the extensions.
//!
//! Streams are not trusted: each byte is asked for, and memory grows only as they are read.

use gltf::json::buffer::{Buffer, View};

/// The names of the extension.
pub(super) const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

const CUT_OFF: &str = "the stream ends too early";
const TOO_LONG: &str = "the stream goes on after its end";
const EMPTY: &str = "the stream refers to what it has not had";
const STRIDE: &str = "the stride does not fit its mode or filter";

/// A compressed buffer view.
pub(super) struct Packed {
    /// Index of the buffer.
    pub buffer: usize,
    pub offset: u64,
    pub length: u64,
    stride: u64,
    count: u64,
    mode: Mode,
    filter: Filter,
}

#[derive(Clone, Copy)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Colour,
}

impl Packed {
    /// The extension of a buffer view; `None` if it has none.
    pub fn of(view: &View) -> Option<Result<Self, String>> {
        let others = &view.extensions.as_ref()?.others;
        let extension = EXTENSIONS.iter().find_map(|name| others.get(*name))?;
        let number = |name: &str| extension.get(name).and_then(|value| value.as_u64());
        let needed = |name: &str| number(name).ok_or_else(|| format!("{name} is missing"));
        let word = |name: &str| extension.get(name).and_then(|value| value.as_str());
        let read = || {
            Ok(Self {
                buffer: needed("buffer")? as usize,
                offset: number("byteOffset").unwrap_or(0),
                length: needed("byteLength")?,
                stride: needed("byteStride")?,
                count: needed("count")?,
                mode: match word("mode") {
                    Some("ATTRIBUTES") => Mode::Attributes,
                    Some("TRIANGLES") => Mode::Triangles,
                    Some("INDICES") => Mode::Indices,
                    other => return Err(format!("unknown mode {other:?}")),
                },
                filter: match word("filter").unwrap_or("NONE") {
                    "NONE" => Filter::None,
                    "OCTAHEDRAL" => Filter::Octahedral,
                    "QUATERNION" => Filter::Quaternion,
                    "EXPONENTIAL" => Filter::Exponential,
                    "COLOR" => Filter::Colour,
                    other => return Err(format!("unknown filter {other}")),
                },
            })
        };
        Some(read())
    }

    /// The number of bytes after decompression.
    pub fn size(&self) -> u64 {
        self.count.saturating_mul(self.stride)
    }

    /// The bytes that a stream stands for.
    pub fn unpack(&self, stream: &[u8]) -> Result<Vec<u8>, &'static str> {
        let (count, stride) = (self.count as usize, self.stride as usize);
        let mut bytes = match self.mode {
            Mode::Attributes => attributes(stream, count, stride)?,
            Mode::Triangles => packed_indices(&triangles(stream, count)?, stride)?,
            Mode::Indices => packed_indices(&sequence(stream, count)?, stride)?,
        };
        self.filter.undo(&mut bytes, stride)?;
        Ok(bytes)
    }
}

/// True for a buffer that only those need who cannot decompress.
pub(super) fn is_fallback(buffer: &Buffer) -> bool {
    let others = buffer.extensions.as_ref().map(|extensions| &extensions.others);
    let extension = others.and_then(|others| EXTENSIONS.iter().find_map(|name| others.get(*name)));
    extension.and_then(|extension| extension.get("fallback")?.as_bool()).unwrap_or(false)
}

/// The rest of a stream.
struct Stream<'a>(&'a [u8]);

impl<'a> Stream<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], &'static str> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CUT_OFF)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, &'static str> {
        self.take(1).map(|byte| byte[0])
    }

    /// A number in groups of seven bits, the lowest first.
    fn number(&mut self) -> Result<u32, &'static str> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(TOO_LONG)
    }

    fn end(&self) -> Result<(), &'static str> {
        if self.0.is_empty() { Ok(()) } else { Err(TOO_LONG) }
    }
}

/// The signed number, as its two's complement, whose sign has become the lowest bit.
fn signed(number: u32) -> u32 {
    (number >> 1) ^ (number & 1).wrapping_neg()
}

/// Elements of `stride` bytes. In blocks of up to 256 elements the differences of each byte from
/// that of the element before lie together, in groups of 16 of as many bits as they need.
fn attributes(stream: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    if stride == 0 || !stride.is_multiple_of(4) || stride > 256 {
        return Err(STRIDE);
    }
    // The element before the first one, and in version 1 the kind of each four bytes.
    let (is_first_version, tail, least) = match stream.first() {
        Some(0xa0) => (true, stride, 32),
        Some(0xa1) => (false, stride + stride / 4, 24),
        _ => return Err("it is no stream of attributes"),
    };
    let end = stream.len().checked_sub(tail.max(least)).filter(|end| *end > 0).ok_or(CUT_OFF)?;
    let (before, kinds) = stream[stream.len() - tail..].split_at(stride);
    let mut before = before.as_chunks::<4>().0.to_vec();
    let mut stream = Stream(&stream[1..end]);
    let block = ((8192 / stride) & !15).min(256);
    let mut bytes = Vec::new();
    let mut left = count;
    while left > 0 {
        let elements = left.min(block);
        left -= elements;
        let start = bytes.len();
        bytes.resize(start + elements * stride, 0);
        let controls = if is_first_version { &[] } else { stream.take(stride / 4)? };
        for (k, before) in before.iter_mut().enumerate() {
            let mut differences = [[0; 256]; 4];
            for (j, differences) in differences.iter_mut().enumerate() {
                let padded = &mut differences[..elements.next_multiple_of(16)];
                match controls.get(k).map(|control| control >> (2 * j) & 3) {
                    None => stream.groups([0, 2, 4, 8], padded)?,
                    Some(0) => stream.groups([0, 1, 2, 4], padded)?,
                    Some(1) => stream.groups([1, 2, 4, 8], padded)?,
                    Some(2) => {}
                    Some(_) => padded[..elements].copy_from_slice(stream.take(elements)?),
                }
            }
            let kind = kinds.get(k).copied().unwrap_or(0);
            for i in 0..elements {
                let difference = differences.map(|differences| differences[i]);
                *before = after(*before, difference, kind)?;
                bytes[start + i * stride + 4 * k..][..4].copy_from_slice(before);
            }
        }
    }
    stream.end()?;
    Ok(bytes)
}

impl Stream<'_> {
    /// Bytes in groups of 16, each of which has one of four numbers of bits.
    fn groups(&mut self, bits: [usize; 4], bytes: &mut [u8]) -> Result<(), &'static str> {
        let groups = bytes.as_chunks_mut::<16>().0;
        let headers = self.take(groups.len().div_ceil(4))?;
        for (g, group) in groups.iter_mut().enumerate() {
            let bits = bits[usize::from(headers[g / 4] >> (2 * (g % 4)) & 3)];
            let packed = self.take(2 * bits)?;
            if bits == 8 {
                group.copy_from_slice(packed);
            } else if bits > 0 {
                let most = (1 << bits) - 1;
                for (i, byte) in group.iter_mut().enumerate() {
                    let place = i * bits % 8;
                    // Single bits begin with the lowest one, others with the highest.
                    let shift = if bits == 1 { place } else { 8 - bits - place };
                    let code = packed[i * bits / 8] >> shift & most;
                    *byte = if code == most { self.byte()? } else { code };
                }
            }
        }
        Ok(())
    }
}

/// Four bytes after those `before`: apart by differences of bytes or of 16-bit numbers, or by
/// turned bits.
fn after(before: [u8; 4], difference: [u8; 4], kind: u8) -> Result<[u8; 4], &'static str> {
    let byte = |j: usize| before[j].wrapping_add(signed(u32::from(difference[j])) as u8);
    let short = |bytes: [u8; 4], j: usize| u16::from_le_bytes([bytes[j], bytes[j + 1]]);
    let shorts = |j: usize| {
        let change = signed(u32::from(short(difference, j))) as u16;
        short(before, j).wrapping_add(change).to_le_bytes()
    };
    match kind & 3 {
        0 => Ok(std::array::from_fn(byte)),
        1 => {
            let ([a, b], [c, d]) = (shorts(0), shorts(2));
            Ok([a, b, c, d])
        }
        2 => {
            let turned = u32::from_le_bytes(difference).rotate_right(u32::from(kind >> 4));
            Ok((turned ^ u32::from_le_bytes(before)).to_le_bytes())
        }
        _ => Err("unknown kind of attributes"),
    }
}

/// The last 16 of what has been put in.
#[derive(Default)]
struct Recent<T> {
    items: [Option<T>; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, item: T) {
        self.items[self.next % 16] = Some(item);
        self.next += 1;
    }

    /// The last one is 0 back.
    fn get(&self, back: u8) -> Result<T, &'static str> {
        let place = self.next.wrapping_sub(1 + usize::from(back)) % 16;
        self.items[place].ok_or(EMPTY)
    }
}

/// The vertices of triangles, each with a code of one byte: at one of the last 16 edges with a
/// vertex that is new, recent or far off, or apart from the others.
fn triangles(stream: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    if stream.first() != Some(&0xe1) {
        return Err("it is no stream of triangles");
    }
    if !count.is_multiple_of(3) {
        return Err("its indices do not make whole triangles");
    }
    let mut stream = Stream(&stream[1..]);
    let codes = stream.take(count / 3)?;
    let table = stream.0.len().checked_sub(16).ok_or(CUT_OFF)?;
    let (data, table) = stream.0.split_at(table);
    stream = Stream(data);
    let (mut edges, mut vertices) = (Recent::<[u32; 2]>::default(), Recent::<u32>::default());
    let (mut next, mut last) = (0u32, 0u32);
    let mut indices = Vec::with_capacity(count);
    for &code in codes {
        if code < 0xf0 {
            let [a, b] = edges.get(code >> 4)?;
            let c = match code & 15 {
                0 => new(&mut next),
                recent @ 1..13 => vertices.get(recent)?,
                13 => far(&mut last, 1u32.wrapping_neg()),
                14 => far(&mut last, 1),
                _ => far(&mut last, signed(stream.number()?)),
            };
            if !matches!(code & 15, 1..13) {
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
            indices.extend([a, b, c]);
            continue;
        }
        let pair = if code < 0xfe { table[usize::from(code & 15)] } else { stream.byte()? };
        if code >= 0xfe && pair == 0 {
            next = 0;
        }
        let mut corner = |kind: u8| match kind {
            0 => Ok(new(&mut next)),
            15 => stream.number().map(|number| far(&mut last, signed(number))),
            recent => vertices.get(recent - 1),
        };
        let kinds = [if code == 0xff { 15 } else { 0 }, pair >> 4, pair & 15];
        let [a, b, c] = [corner(kinds[0])?, corner(kinds[1])?, corner(kinds[2])?];
        for (kind, vertex) in kinds.into_iter().zip([a, b, c]) {
            if matches!(kind, 0 | 15) {
                vertices.push(vertex);
            }
        }
        edges.push([b, a]);
        edges.push([c, b]);
        edges.push([a, c]);
        indices.extend([a, b, c]);
    }
    stream.end()?;
    Ok(indices)
}

/// The first vertex that has not been used.
fn new(next: &mut u32) -> u32 {
    let vertex = *next;
    *next = next.wrapping_add(1);
    vertex
}

/// The vertex at a distance from the last one that was given so.
fn far(last: &mut u32, difference: u32) -> u32 {
    *last = last.wrapping_add(difference);
    *last
}

/// Indices, each by its distance from one of two earlier ones.
fn sequence(stream: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    if stream.first() != Some(&0xd1) {
        return Err("it is no stream of indices");
    }
    let end = stream.len().checked_sub(4).filter(|end| *end > 0).ok_or(CUT_OFF)?;
    let mut stream = Stream(&stream[1..end]);
    let mut last = [0; 2];
    let mut indices = Vec::new();
    for _ in 0..count {
        let number = stream.number()?;
        indices.push(far(&mut last[(number & 1) as usize], signed(number >> 1)));
    }
    stream.end()?;
    Ok(indices)
}

/// The bytes of indices of 2 or 4 bytes.
fn packed_indices(indices: &[u32], stride: usize) -> Result<Vec<u8>, &'static str> {
    match stride {
        2 => Ok(indices.iter().flat_map(|index| (*index as u16).to_le_bytes()).collect()),
        4 => Ok(indices.iter().flat_map(|index| index.to_le_bytes()).collect()),
        _ => Err(STRIDE),
    }
}

impl Filter {
    /// Turns filtered elements into those that accessors describe.
    fn undo(self, bytes: &mut [u8], stride: usize) -> Result<(), &'static str> {
        match (self, stride) {
            (Self::None, _) => {}
            (Self::Octahedral, 4) => bytes.as_chunks_mut().0.iter_mut().for_each(|element| {
                let [x, y, one, w] = *element;
                let signed = |byte| f64::from(byte as i8);
                let [x, y, z] = unit([x, y, one].map(signed), 127.0).map(|c| c as i8 as u8);
                *element = [x, y, z, w];
            }),
            (Self::Octahedral, 8) => shorts(bytes, |[x, y, one, w]| {
                let [x, y, z] = unit([x, y, one].map(f64::from), 32767.0);
                [x as i16, y as i16, z as i16, w]
            }),
            (Self::Quaternion, 8) => shorts(bytes, quaternion),
            (Self::Exponential, _) if stride.is_multiple_of(4) => {
                for number in bytes.as_chunks_mut::<4>().0 {
                    let bits = i32::from_le_bytes(*number);
                    let power = f64::from_bits(((1023 + (bits >> 24)) as u64) << 52);
                    *number = ((f64::from(bits << 8 >> 8) * power) as f32).to_le_bytes();
                }
            }
            (Self::Colour, 4) => bytes.as_chunks_mut().0.iter_mut().for_each(|element| {
                let [y, orange, green, alpha] = *element;
                let signed = |byte| f64::from(byte as i8);
                let rgba = colour([f64::from(y), signed(orange), signed(green)], alpha.into(), 8);
                *element = rgba.map(|c| c as u8);
            }),
            (Self::Colour, 8) => shorts(bytes, |[y, orange, green, alpha]| {
                let luma = f64::from(y as u16);
                let rgba = colour([luma, orange.into(), green.into()], (alpha as u16).into(), 16);
                rgba.map(|c| c as u16 as i16)
            }),
            _ => return Err(STRIDE),
        }
        Ok(())
    }
}

/// Changes elements of four 16-bit numbers.
fn shorts(bytes: &mut [u8], change: impl Fn([i16; 4]) -> [i16; 4]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let numbers =
            std::array::from_fn(|k| i16::from_le_bytes([element[2 * k], element[2 * k + 1]]));
        let changed = change(numbers).map(i16::to_le_bytes);
        element.copy_from_slice(changed.as_flattened());
    }
}

/// The unit vector, times `greatest`, of a point of the octahedron |x| + |y| + |z| = 1, whose lower
/// half is folded out.
fn unit([x, y, one]: [f64; 3], greatest: f64) -> [f64; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let unfolded = |c: f64| if c >= 0.0 { c + fold } else { c - fold };
    let vector = glam::DVec3::new(unfolded(x), unfolded(y), z);
    (vector * (greatest / vector.length())).to_array().map(f64::round)
}

/// A unit quaternion of its three smaller components; two bits of the fourth number say which one
/// is left out, the others how large 1/√2 is.
fn quaternion([x, y, z, rest]: [i16; 4]) -> [i16; 4] {
    let scale = std::f64::consts::FRAC_1_SQRT_2 / f64::from(rest | 3);
    let [x, y, z] = [x, y, z].map(|c| f64::from(c) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut turned = [w, x, y, z].map(|c| (c * 32767.0).round() as i16);
    turned.rotate_right((rest & 3) as usize);
    turned
}

/// Red, green, blue and alpha of luma and the chroma of orange and green. The highest bit of
/// `alpha` tells how many bits all of them have.
fn colour([y, orange, green]: [f64; 3], alpha: u32, bits: u32) -> [f64; 4] {
    let scale = alpha.checked_ilog2().map_or(0, |highest| (2u32 << highest) - 1);
    let alpha = alpha << 1 & scale | alpha & 1;
    let greatest = f64::from((1u32 << bits) - 1);
    let rgba = [y + orange - green, y + green, y - orange - green, f64::from(alpha)];
    rgba.map(|c| (c * (greatest / f64::from(scale))).round())
}

#[cfg(test)]
mod tests;
