//! Wide node ↔ 5 texels, the 80-byte layout of Ylitie, Karras and Laine (HPG 2017).
//!
//! Comes in: a [`WideNode`]. Goes out, with byte `i` of a group of eight in bits `8 (i % 4) ..` of word `i / 4`:
//!
//! ```text
//! texel 0   origin.x           origin.y             origin.z           exponent x | y << 8 | z << 16 | inner_mask << 24
//! texel 1   first_child        first_triangle       meta 0..4          meta 4..8
//! texel 2   low x 0..4         low x 4..8           low y 0..4         low y 4..8
//! texel 3   low z 0..4         low z 4..8           high x 0..4        high x 4..8
//! texel 4   high y 0..4        high y 4..8          high z 0..4        high z 4..8
//! ```
//!
//! May be assumed: no bit is lost either way.

use super::Texel;
use crate::bvh::WideNode;
use crate::interface::WIDE_NODE_TEXELS;

/// The node's record.
pub fn pack(node: &WideNode) -> [Texel; WIDE_NODE_TEXELS as usize] {
    let [x, y, z] = node.exponent;
    let shape = u32::from_le_bytes([x, y, z, node.inner_mask]);
    let [[lx0, lx1], [ly0, ly1], [lz0, lz1]] = node.low.map(words);
    let [[hx0, hx1], [hy0, hy1], [hz0, hz1]] = node.high.map(words);
    let [meta0, meta1] = words(node.meta);
    [
        [node.origin[0], node.origin[1], node.origin[2], shape],
        [node.first_child, node.first_triangle, meta0, meta1],
        [lx0, lx1, ly0, ly1],
        [lz0, lz1, hx0, hx1],
        [hy0, hy1, hz0, hz1],
    ]
}

/// The node of a record.
pub fn unpack(record: &[Texel; WIDE_NODE_TEXELS as usize]) -> WideNode {
    let [[ox, oy, oz, shape], [first_child, first_triangle, meta0, meta1], a, b, c] = *record;
    let [x, y, z, inner_mask] = shape.to_le_bytes();
    WideNode {
        origin: [ox, oy, oz],
        exponent: [x, y, z],
        inner_mask,
        first_child,
        first_triangle,
        meta: bytes([meta0, meta1]),
        low: [bytes([a[0], a[1]]), bytes([a[2], a[3]]), bytes([b[0], b[1]])],
        high: [bytes([b[2], b[3]]), bytes([c[0], c[1]]), bytes([c[2], c[3]])],
    }
}

fn words(bytes: [u8; 8]) -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = bytes;
    [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
}

fn bytes(words: [u32; 2]) -> [u8; 8] {
    let ([a, b, c, d], [e, f, g, h]) = (words[0].to_le_bytes(), words[1].to_le_bytes());
    [a, b, c, d, e, f, g, h]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_survive_the_round_trip() {
        let run = |first: u8| std::array::from_fn(|i| first + i as u8);
        let node = WideNode {
            origin: [0x8000_0000, 1, 0x3f80_0000],
            exponent: [67, 119, 254],
            inner_mask: 0b1010_0101,
            first_child: 16_777_217,
            first_triangle: 0xffff_fffe,
            meta: run(1),
            low: [run(10), run(20), run(30)],
            high: [run(110), run(120), run(130)],
        };
        let record = pack(&node);
        assert_eq!(record[0][3], 0xa5fe_7743);
        assert_eq!(record[1], [16_777_217, 0xffff_fffe, 0x0403_0201, 0x0807_0605]);
        assert_eq!(record[3][0..2], [0x2120_1f1e, 0x2524_2322]);
        assert_eq!(unpack(&record), node);
    }
}
