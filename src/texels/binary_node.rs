//! Binary node ↔ 2 texels.
//!
//! Comes in: a [`BinaryNode`]. Goes out: `[lo.x, lo.y, lo.z, first]`, `[hi.x, hi.y, hi.z, count]`, as
//! [`crate::interface::BINARY_NODE_TEXELS`] states. May be assumed: no bit is lost either way.

use glam::Vec3;

use super::Texel;
use crate::bvh::{Aabb, BinaryNode};
use crate::interface::BINARY_NODE_TEXELS;

/// The node's record.
pub fn pack(node: &BinaryNode) -> [Texel; BINARY_NODE_TEXELS as usize] {
    let [low, high] = [node.bounds.low, node.bounds.high].map(|corner| corner.to_array().map(f32::to_bits));
    [[low[0], low[1], low[2], node.first], [high[0], high[1], high[2], node.count]]
}

/// The node of a record.
pub fn unpack(record: &[Texel; BINARY_NODE_TEXELS as usize]) -> BinaryNode {
    let [[lx, ly, lz, first], [hx, hy, hz, count]] = *record;
    let corner = |lanes: [u32; 3]| Vec3::from_array(lanes.map(f32::from_bits));
    BinaryNode { bounds: Aabb { low: corner([lx, ly, lz]), high: corner([hx, hy, hz]) }, first, count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_survive_the_round_trip() {
        let bounds = Aabb { low: Vec3::new(-0.0, 1e-40, -1.5), high: Vec3::new(0.25, 1.0, 1e30) };
        let node = BinaryNode { bounds, first: 16_777_217, count: 3 };
        let record = pack(&node);
        assert_eq!(record[0], [0x8000_0000, 1e-40f32.to_bits(), (-1.5f32).to_bits(), 16_777_217]);
        assert_eq!(record[1][3], 3);
        assert_eq!(pack(&unpack(&record)), record);
    }
}
