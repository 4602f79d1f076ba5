//! Streams of the reference encoder (meshoptimizer 1.0) with contents that formulas give.

use super::*;

fn bytes(hex: &str) -> Vec<u8> {
    let digit = |c: u8| char::from(c).to_digit(16).expect("a digit") as u8;
    hex.as_bytes().as_chunks::<2>().0.iter().map(|&[a, b]| digit(a) << 4 | digit(b)).collect()
}

fn packed(mode: Mode, filter: Filter, count: usize, stride: usize) -> Packed {
    let (count, stride) = (count as u64, stride as u64);
    Packed { buffer: 0, offset: 0, length: 0, stride, count, mode, filter }
}

const SMALL_0: &str = "a000150208208208208208208200001f0002060a0e12161a1e22262a2e32363a3e42464a4e52565a5e62\
         666a6e72767affff00007e82868a8e92969a1f00c2c2c2c2ffc2c2c2c2ffc2c2c2c2ffc2c2c2c2ffc2c2\
         c2c2ffc2c2c2c2ffc2ffff0000c2c2c2ffc2c2c2c2151555555555555555555500001a00022224444666\
         68888aaaacccceeeef10ffff000010101012121212142a0caaaaafaaa8cafa3b3baaaaaf8caaaafaaa3b\
         3ba8cfaaaa000000003b0000000000000000000000000000000000000000000000000007000000c800ff\
         15";
const SMALL_1: &str = "a1f695150208208208208208208200000002060a0e12161a1e22262a2e32363a3e42464a4e52565a5e62\
         666a6e72767a7e82868a8e92969a00c2c2c2c2ffc2c2c2c2ffc2c2c2c2ffc2c2c2c2ffc2c2c2c2ffc2c2\
         c2c2ffc2c2c2c2ffc2c2c2c2151555555555555555555500000a0002222444466668888aaaacccceeeef\
         10ff0010101012121212142a0caaaaafaaa8cafa3b3baaaaaf8caaaafaaa3b3ba8cfaaaa000000003b00\
         0000000000000000000000000007000000c800ff150000";
const WIDE_0: &str = "a00010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c000060010000100c00000060000c000\
         060010000100c00000060000c000060010000100c00000060000c0000600000000000000000000000000\
         00000000000000000000000000000000000000000102030405060708090a0b0c0d0e0f10111213141516\
         1718191a1b1c1d1e1f";
const WIDE_1: &str = "a10000000000000000001000011000060001060010000110000600010600100001100006000106001000\
         011000060001060010000110000600010600100001100006000106001000011000060001060010000110\
         000600010600100001100006000106001000011000060001060010000110000600010600100001100006\
         000106001000011000060001060010000110000600010600100001100006000106001000011000060001\
         060010000110000600010600100001100006000106001000011000060001060010000110000600010600\
         100001100006000106001000011000060001060010000110000600010600100001100006000106001000\
         011000060001060010000110000600010600100001100006000106001000011000060001060010000110\
         0006000106001000011000060001060010000110000600010600100001100006000106aaaaaaaaaaaaaa\
         aa000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f0000000000000000";
const MIXED_1: &str = "a177683d69005a5a545a5a545a5a545a5a545a5a545a5a545a5a545a5a545a5a545a5a545a5a545a5a54\
         5a5a54152aaaaaaaaaaaaaaaaaaa0000000d2945617d99b5d1ed0925415d7995b1cde905213d597591ad\
         c9e5011d3955718da9c5e1fd1935250000055556aaaaff0303030333333344000000000110001f1a08f8\
         f4c4f4c4f26218f81c3ce262f262e262f1311e7edddd000007030f0300faf6a9aaa9aba9a9aaaaa9aaac\
         aa7ddba9aaa9aba9aaa9aaa9a9aaa9b600aaa9aaa9aa00ab00acaba9a9ab00acaa00a9aaaaacab00acab\
         a9a9aa00a9aa00a9abff5354ff5354ff5354ff5300ab00d3d4b67684505c5a383e424228282c30302a1c\
         1c1e202022241e141414141616181818181a063a2008007c100002151999999999999999999900001526\
         6666666666666666660000000000000000ffff0000803f000000000005000001620000";
const TRIANGLES: &str = "e1fe1e100e100e100e100efe1e190e180e170e160eff1e160e160e160e160eff1e160e160e160e160eff\
         1e160e160e160e160eff10ffff1f0f0c9f025f090c5f090c5f090cff8a0fd00fd00f43a11fff92b608dd\
         c5080104007687566778a9866589689801690000";
const SEQUENCE: &str = "d1a11f040c2530246d60f71fd81e375534076d4a9f01e61ee91f6e2a458801123b0e040d201c7376349d\
         01464c1d166463aec1cdb20400000000";

/// Differences of no, few and many bits.
fn small(i: usize) -> [u8; 8] {
    let seventh = i % 7 * 5 + if i.is_multiple_of(11) { 255 } else { 0 };
    [7, i / 3, i * i, i * 97 + i / 5 * 31, 200 - i, i * i / 8, seventh, 21].map(|x| x as u8)
}

/// More elements than a block has.
fn wide(i: usize) -> [u8; 32] {
    std::array::from_fn(|k| (i / 100 * 3 + k) as u8)
}

/// 16-bit numbers, floating-point numbers and bytes.
fn mixed(i: usize) -> [u8; 16] {
    let [a, b] = [300 * i + i % 3, 65535 - 7 * i * i].map(|x| (x as u16).to_le_bytes());
    let x = i as f32;
    let [c, d] = [1.0 + x * 0.25, x * x / 3.0].map(f32::to_le_bytes);
    let e = [if i % 2 == 1 { 255 } else { 0 }, 5, 0, (i % 2) as u8];
    [a[0], a[1], b[0], b[1], c[0], c[1], c[2], c[3], d[0], d[1], d[2], d[3], e[0], e[1], e[2], e[3]]
}

fn elements<const N: usize>(count: usize, element: fn(usize) -> [u8; N]) -> Vec<u8> {
    (0..count).flat_map(element).collect()
}

#[test]
fn attributes_are_those_that_were_encoded() {
    let cases = [
        ("small, version 0", SMALL_0, 8, elements(40, small)),
        ("small, version 1", SMALL_1, 8, elements(40, small)),
        ("wide, version 0", WIDE_0, 32, elements(260, wide)),
        ("wide, version 1", WIDE_1, 32, elements(260, wide)),
        ("mixed, version 1", MIXED_1, 16, elements(40, mixed)),
    ];
    for (name, stream, stride, expected) in cases {
        let packed = packed(Mode::Attributes, Filter::None, expected.len() / stride, stride);
        assert!(packed.unpack(&bytes(stream)).expect(name) == expected, "{name}");
    }
}

/// A grid, then triangles that share little with what was before.
#[test]
fn triangles_are_those_that_were_encoded() {
    let mut expected = Vec::new();
    for p in (0..5).flat_map(|y| (0..5).map(move |x| 6 * y + x)) {
        expected.extend([[p, p + 1, p + 6], [p + 1, p + 7, p + 6]]);
    }
    expected.extend([[1000, 2000, 3000], [3000, 2000, 7], [999, 1000, 2000], [70000, 1, 0]]);
    expected.push([0, 1, 2]);
    let found = triangles(&bytes(TRIANGLES), 3 * expected.len()).expect("valid");
    for (found, [a, b, c]) in found.as_chunks::<3>().0.iter().zip(expected) {
        assert!([[a, b, c], [b, c, a], [c, a, b]].contains(found), "{found:?} {:?}", [a, b, c]);
    }
    let unpack =
        |stride| packed(Mode::Triangles, Filter::None, 165, stride).unpack(&bytes(TRIANGLES));
    let narrow: Vec<u8> = found.iter().flat_map(|index| (*index as u16).to_le_bytes()).collect();
    assert_eq!(unpack(2), Ok(narrow));
    assert_eq!(unpack(4).map(|bytes| bytes.len()), Ok(4 * 165));
    assert_eq!(unpack(3), Err(STRIDE));
}

#[test]
fn sequences_are_those_that_were_encoded() {
    let far = |k: u32| if k.is_multiple_of(3) { 1000 } else { 0 };
    let mut expected: Vec<u32> = (0..40).map(|k| k * k % 50 + far(k)).collect();
    expected.push(4_000_000_000);
    assert_eq!(sequence(&bytes(SEQUENCE), 41), Ok(expected));
}

/// Filtered elements and what the reference decoder makes of them; rounding may differ by one.
#[test]
fn filters_give_what_the_reference_gives() {
    let cases = [
        (
            Filter::Octahedral,
            4,
            "7f007f7f29e57f81ada07f7f90137f818a487f7f163f7f815bea7f7f40087f81d88e7f7f98317f8193c5\
         7f7f017d7f81",
            "7f00007f44d36281cbb5a87f8211fb81ad0ea17f236544817ae2137f600c5281ee88db7f8c22d98196e4\
         c07f017f0181",
        ),
        (
            Filter::Octahedral,
            8,
            "ff070000ff07ff7f9c024ffeff070180cdfaf6f9ff07ff7feff83301ff07018096f88a04ff07ff7f6901\
         ff03ff070180b40599feff07ff7f09047b00ff07018081fdd9f8ff07ff7f76f91e03ff07018025f950fc\
         ff07ff7f0900e407ff070180",
            "ff7f00000000ff7f28452cd3ef610180cbcaf6b3daa7ff7f48815511fafa01804dac180e32a0ff7f5824\
         fd66bf420180e47ac8e13113ff7f88607e0b4353018065edb88690dbff7f668bd22253d8018092948fe3\
         7fc0ff7f9200fd7f24010180",
        ),
        (
            Filter::Quaternion,
            8,
            "000000000000ff1fa0fa6debcaf2fc1f81f4400e4f0cfc1f2ffaa2028aedff1fa0ed7cf7ade3fc1fc9e3\
         4dfeb90cfc1f8f05590881f6fe1fbff5481021e7fe1f0f06940203edfd1f73052aee08e6ff1fcc03aee7\
         c6ecff1fcdff020066fffd1f",
            "000000000000ff7f9f6accf0cdc5a1dac06f7bdf4f28d1228cef7307c8cb7573be5106cce9e7e1af3f5d\
         30b032fbfd239d1723e5e379b90f0e2ea6b90a5cffe24acaae7223114b076a0f8ccd8bb6935abd0a35bb\
         9dc99d5c4cfefc7f70ff0600",
        ),
        (
            Filter::Exponential,
            16,
            "00d0fff4000000f4000000f4000000f400c8fff3000000f3f8fffff3000000f300e0fff2020000f2dfff\
         fff2000000f2003000f2100000f2cffffff2000000f2002000f4290000f4f0fffff4000000f4003400f4\
         9a0100f4ecfffff4000000f4002400f5000800f5f4fffff5000000f5001700f6002800f6f9fffff60000\
         00f6800300f9003200f9fffffff9000000f9840000fc803e00fc000000fc000000fc0a00000010270000\
         000000000000000001000003d43000030000000300000003",
            "000040c00000000000000000000000000000e0bf00000000000080ba00000000000000bf000000390000\
         04bb000000000000403f0000803a000044bb00000000000000400000243c000080bb0000000000005040\
         0000cd3d0000a0bb00000000000090400000803f0000c0bb000000000000b840000020410000e0bb0000\
         00000000e0400000c842000000bc000000000000044100007a4400000000000000000000204100401c46\
         0000000000000000000000410050c3470000000000000000",
        ),
        (
            Filter::Colour,
            4,
            "7f007fff7f0068f98be945f4a2bb16ee7f0022e8682e23e25c4517dc5c4500d7692eded18000afcb5d45\
         bbc54674bbc0",
            "00fe00ff17e717f32fd05de847b8d1dc5da15dd0738b17c48a7300b8a15c17afb9475da3d12fd197e718\
         5d8bff011780",
        ),
        (
            Filter::Colour,
            8,
            "ff070000ff07ff0fff0700008b06a20fb9088cfe5c04450f2e0aa4fb7401e80eff0700002e028b0e8b06\
         e8022f022e0ed1055d047401d10dd1055d040000740d8b06e802d2fd170d00080000eafaba0cd1055d04\
         a3fb5d0c5d044507a4fb000c",
            "0000efff0000ffff4117aee841174ef4932e5cd1155dbee8e4452bba6cd10ddd155ddaa2155d7cd14774\
         a88b4117ccc5a88b577400003bbaeaa2155d41178aae1bbad445155dfaa26cd1a32e6cd14997bee84117\
         155db88befff100041170880",
        ),
    ];
    for (filter, stride, filtered, expected) in cases {
        let (mut found, expected) = (bytes(filtered), bytes(expected));
        filter.undo(&mut found, stride).expect("a stride for it");
        let width = if stride == 4 { 1 } else { 2 };
        for (found, expected) in found.chunks(width).zip(expected.chunks(width)) {
            let value =
                |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, b| sum << 8 | i32::from(*b));
            let apart = (value(found) - value(expected)).rem_euclid(1 << (8 * width));
            let most = if matches!(filter, Filter::Exponential) { 0 } else { 1 };
            assert!(apart.min((1 << (8 * width)) - apart) <= most, "{found:?} {expected:?}");
        }
    }
}

/// Streams that are cut off or damaged, and elements that do not fit, are errors or other contents.
#[test]
fn damaged_streams_do_not_panic() {
    let streams = [SMALL_0, SMALL_1, WIDE_1, MIXED_1, TRIANGLES, SEQUENCE].map(bytes);
    for (k, stream) in streams.iter().enumerate() {
        for end in 0..stream.len() {
            let cut = &stream[..end];
            match k {
                0..4 => assert!(
                    attributes(cut, [40, 40, 260, 40][k], [8, 8, 32, 16][k]).is_err(),
                    "{k} {end}"
                ),
                4 => assert!(triangles(cut, 165).is_err(), "{end}"),
                _ => assert!(sequence(cut, 41).is_err(), "{end}"),
            }
            for value in [0, 1, 0x7f, 0x80, 0xf0, 0xfe, 0xff] {
                let mut damaged = stream.clone();
                damaged[end] = value;
                for count in [0, 3, 39, 165, 1 << 40] {
                    let _ = attributes(&damaged, count, 8);
                    let _ = attributes(&damaged, count, 256);
                    let _ = sequence(&damaged, count);
                    let _ = triangles(&damaged, count);
                }
            }
        }
    }
    for stride in [0, 2, 260, usize::MAX] {
        assert_eq!(attributes(&streams[0], 1, stride), Err(STRIDE));
    }
}
