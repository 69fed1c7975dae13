//! Finding hits in the compressed wide tree, as the shader does it.
//!
//! Comes in: a wide tree and a ray. Goes out: its hits, through [`Query`]. May be assumed: as in [`super::traverse`].
//!
//! A *node group* is two words: the index of the first inner child of some node, and its hits (bits 24 to 31: children
//! still to be visited, at `24 + (slot ^ order)`) with its inner mask (bits 0 to 7). A *triangle group* is a first
//! position and a mask of positions relative to it. The highest bit of a node group goes first; `order` has the bit of
//! an axis (4 for x, 2 for y, 1 for z) set for rays that go up along it, so children come roughly front to back
//! (Ylitie, Karras and Laine, HPG 2017, section 4).

use super::traverse::{Query, Stack, Tracer};
use super::{WideBvh, WideNode};
use crate::interface::WIDE_CHILDREN;

/// Hit bits of a node group.
const GROUP_HITS: u32 = 0xff00_0000;

impl Tracer<'_> {
    pub(super) fn run_wide(&self, tree: &WideBvh, query: &mut Query) {
        if tree.nodes.is_empty() {
            return;
        }
        let order = slot_order(&query.ray.inverse);
        let mut stack = Stack::new(tree.depth.max(1));
        // The root as the only child of nothing: an empty inner mask makes its index 0 whatever the slot.
        let mut group = [0, 0x8000_0000];
        loop {
            if group[1] & GROUP_HITS == 0 {
                let Some(popped) = stack.pop() else { return };
                group = popped;
            }
            let bit = 31 - group[1].leading_zeros();
            group[1] &= !(1 << bit);
            if group[1] & GROUP_HITS != 0 {
                stack.push(group, &mut query.work);
            }
            let slot = (bit - 24) ^ order;
            let before = group[1] & ((1 << slot) - 1) & 0xff;
            let node = &tree.nodes[(group[0] + before.count_ones()) as usize];
            query.work.nodes += 1;
            let hits = hits(node, query, order);
            group = [node.first_child, hits & GROUP_HITS | u32::from(node.inner_mask)];
            let mut triangles = hits & !GROUP_HITS;
            while triangles != 0 {
                let position = node.first_triangle + triangles.trailing_zeros();
                triangles &= triangles - 1;
                self.test(position..position + 1, query);
                if query.found {
                    return;
                }
            }
        }
    }
}

/// The slots' visiting order: bit of an axis set where the ray goes up along it.
fn slot_order(inverse: &[f32; 3]) -> u32 {
    u32::from(inverse[0] >= 0.0) << 2 | u32::from(inverse[1] >= 0.0) << 1 | u32::from(inverse[2] >= 0.0)
}

/// Tests all children; inner ones answer in bits 24 to 31, triangles of leaves in bits 0 to 23.
fn hits(node: &WideNode, query: &Query, order: u32) -> u32 {
    let ray = &query.ray;
    let cull = query.cull();
    let (mut step, mut near_base, mut far_base) = ([0.0f32; 3], [0.0f32; 3], [0.0f32; 3]);
    for axis in 0..3 {
        let inverse = ray.inverse[axis];
        let origin = f32::from_bits(node.origin[axis]);
        step[axis] = f32::from_bits(u32::from(node.exponent[axis]) << 23) * inverse;
        let base = (origin - ray.origin[axis]) * inverse;
        (near_base[axis], far_base[axis]) = (base - ray.node_pad[axis], base + ray.node_pad[axis]);
    }
    let mut mask = 0;
    for slot in 0..WIDE_CHILDREN as usize {
        let meta = u32::from(node.meta[slot]);
        let (mut near, mut far) = ([0.0f32; 3], [0.0f32; 3]);
        for axis in 0..3 {
            let planes = (f32::from(node.low[axis][slot]), f32::from(node.high[axis][slot]));
            let (q_near, q_far) = if ray.inverse[axis] >= 0.0 { planes } else { (planes.1, planes.0) };
            near[axis] = q_near * step[axis] + near_base[axis];
            far[axis] = q_far * step[axis] + far_base[axis];
        }
        let entry = near[0].max(near[1]).max(near[2]);
        let exit = far[0].min(far[1]).min(far[2]);
        if entry <= exit && exit >= 0.0 && entry <= cull {
            // An inner child's position is turned by the order; an empty slot has no bits to set.
            let turn = if node.inner_mask >> slot & 1 == 1 { order } else { 0 };
            mask |= (meta >> 5) << ((meta & 31) ^ turn);
        }
    }
    mask
}
