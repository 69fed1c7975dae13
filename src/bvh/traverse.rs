//! Finding hits on the CPU: the oracle that the shader is held against.
//!
//! Comes in: a tree or none, the triangles, rays. Goes out: closest hits, occlusion, and the work done. May be assumed:
//! the answer does not depend on the tree (see [`super::intersect`]); the stack has [`Accel::stack_entries`] entries,
//! and an entry too many is counted in [`Work::overflows`], never written.

use super::intersect::{NO_HIT_KEY, Prepared, TracedTriangle};
use super::{Accel, BinaryBvh, Hit, Intersector, Ray};
use crate::interface::{CULL_BEYOND, MAX_TREE_DEPTH, NO_INDEX};
use crate::scene::Triangle;

/// Work done by one ray or many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Inner nodes opened.
    pub nodes: u64,
    /// Triangles tested.
    pub triangles: u64,
    /// Most stack entries in use at once.
    pub stack: u32,
    /// Entries that found the stack full; each may have lost hits.
    pub overflows: u64,
}

impl Work {
    /// Sum of both; the larger of the stacks.
    pub fn plus(self, other: Work) -> Work {
        Work {
            nodes: self.nodes + other.nodes,
            triangles: self.triangles + other.triangles,
            stack: self.stack.max(other.stack),
            overflows: self.overflows + other.overflows,
        }
    }
}

/// Traces rays through one tree.
pub struct Tracer<'a> {
    accel: &'a Accel,
    triangles: Vec<TracedTriangle>,
    intersector: Intersector,
}

impl<'a> Tracer<'a> {
    /// Lays the triangles out in leaf order; `emits` says by id which ones emit. Ids beyond the triangles are left out.
    pub fn new(
        accel: &'a Accel,
        triangles: &[Triangle],
        emits: impl Fn(u32) -> bool,
        intersector: Intersector,
    ) -> Tracer<'a> {
        let order = accel.order(triangles.len());
        let traced = order.iter().filter_map(|&id| {
            let positions = triangles.get(id as usize)?.positions;
            Some(TracedTriangle { positions, id, emits: emits(id) })
        });
        Tracer { accel, triangles: traced.collect(), intersector }
    }

    /// The closest hit.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest_with_work(ray).0
    }

    /// The closest hit and the work of finding it.
    pub fn closest_with_work(&self, ray: &Ray) -> (Option<Hit>, Work) {
        let mut query = Query::new(ray, NO_HIT_KEY, [ray.skip, NO_INDEX], false);
        self.run(ray, &mut query);
        ((query.best.id != NO_INDEX).then_some(query.best), query.work)
    }

    /// Whether any triangle but the ray's own and `skip` is hit with a key below `t_max`.
    pub fn any_hit(&self, ray: &Ray, t_max: f32, skip: u32) -> bool {
        self.any_hit_with_work(ray, t_max, skip).0
    }

    /// The same, and the work of finding it.
    pub fn any_hit_with_work(&self, ray: &Ray, t_max: f32, skip: u32) -> (bool, Work) {
        let mut query = Query::new(ray, t_max, [ray.skip, skip], true);
        self.run(ray, &mut query);
        (query.found, query.work)
    }

    fn run(&self, ray: &Ray, query: &mut Query) {
        if !ray.is_valid() {
            return;
        }
        match self.accel {
            Accel::Brute => self.test(0..self.triangles.len() as u32, query),
            Accel::Binary(tree) => self.run_binary(tree, query),
            Accel::Wide(tree) => self.run_wide(tree, query),
        }
    }

    /// Tests the triangles at some leaf-order positions.
    pub(super) fn test(&self, positions: std::ops::Range<u32>, query: &mut Query) {
        for position in positions {
            let triangle = &self.triangles[position as usize];
            query.work.triangles += 1;
            if query.skip.contains(&triangle.id) {
                continue;
            }
            let Some(hit) = query.ray.hit(triangle, self.intersector) else { continue };
            if query.any {
                if hit.key < query.best.key {
                    query.found = true;
                    return;
                }
            } else if hit.precedes(&query.best) {
                query.best = hit;
            }
        }
    }

    fn run_binary(&self, tree: &BinaryBvh, query: &mut Query) {
        let Some(root) = tree.nodes.first() else { return };
        let mut stack = Stack::new(self.accel.stack_entries());
        if !query.ray.enters(root.bounds.low, root.bounds.high, query.cull()).0 {
            return;
        }
        let mut node = *root;
        loop {
            let mut next = None;
            if node.is_leaf() {
                self.test(node.first..node.first + node.count, query);
                if query.found {
                    return;
                }
            } else {
                query.work.nodes += 1;
                let cull = query.cull();
                let enters = |child: u32| {
                    let bounds = tree.nodes[child as usize].bounds;
                    query.ray.enters(bounds.low, bounds.high, cull)
                };
                let (left, right) = (node.first, node.first + 1);
                let ((enters_left, left_entry), (enters_right, right_entry)) = (enters(left), enters(right));
                if enters_left && enters_right {
                    // The nearer child first; the left one of equals.
                    let (near, far, far_entry) =
                        if left_entry <= right_entry { (left, right, right_entry) } else { (right, left, left_entry) };
                    stack.push([far, far_entry.to_bits()], &mut query.work);
                    next = Some(near);
                } else if enters_left || enters_right {
                    next = Some(if enters_left { left } else { right });
                }
            }
            while next.is_none() {
                let Some([child, entry]) = stack.pop() else { return };
                if f32::from_bits(entry) <= query.cull() {
                    next = Some(child);
                }
            }
            if let Some(index) = next {
                node = tree.nodes[index as usize];
            }
        }
    }
}

/// A ray on its way, and what it has found.
pub(super) struct Query {
    pub ray: Prepared,
    /// Ids to leave out.
    skip: [u32; 2],
    /// The best hit; of an any-hit query, only its key counts, and stays.
    best: Hit,
    any: bool,
    pub found: bool,
    pub work: Work,
}

impl Query {
    fn new(ray: &Ray, key: f32, skip: [u32; 2], any: bool) -> Query {
        let best = Hit { key, ..Hit::NONE };
        Query { ray: Prepared::new(ray), skip, best, any, found: false, work: Work::default() }
    }

    /// Boxes entered beyond this hold nothing that could still win.
    pub fn cull(&self) -> f32 {
        self.best.key * CULL_BEYOND
    }
}

/// A stack of two-word entries, of a size fixed beforehand, as the shader has it.
pub(super) struct Stack {
    entries: [[u32; 2]; MAX_TREE_DEPTH as usize],
    length: usize,
    capacity: usize,
}

impl Stack {
    pub fn new(capacity: u32) -> Stack {
        Stack { entries: [[0; 2]; MAX_TREE_DEPTH as usize], length: 0, capacity: capacity.min(MAX_TREE_DEPTH) as usize }
    }

    pub fn push(&mut self, entry: [u32; 2], work: &mut Work) {
        if self.length == self.capacity {
            work.overflows += 1;
            return;
        }
        self.entries[self.length] = entry;
        self.length += 1;
        work.stack = work.stack.max(self.length as u32);
    }

    pub fn pop(&mut self) -> Option<[u32; 2]> {
        self.length = self.length.checked_sub(1)?;
        Some(self.entries[self.length])
    }
}
