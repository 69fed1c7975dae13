//! Which nodes of a binary tree become the children of a wide one.
//!
//! Comes in: a binary tree. Goes out: for each of its nodes, the cheapest way to stand for it by at most `i` children of
//! a wide node, found by the dynamic programme of Ylitie, Karras and Laine (HPG 2017, section 3.1): with area `A` and
//! `n` triangles below,
//!
//! ```text
//! C(node, 1) = min(A n TRIANGLE_COST if n <= 3, C_distribute(node, 8) + A NODE_COST)
//! C(node, i) = min(C_distribute(node, i), C(node, i - 1))
//! C_distribute(node, j) = min over 0 < k < j of C(left, k) + C(right, j - k)
//! ```
//!
//! May be assumed: a wide node's children lie below its own binary node, so the wide tree is no deeper than the binary.

use super::BinaryNode;
use crate::interface::{WIDE_CHILDREN, WIDE_LEAF_TRIANGLES};

/// Cost of visiting a wide node.
pub(super) const NODE_COST: f32 = 1.0;
/// Cost of testing a triangle, in wide nodes.
pub(super) const TRIANGLE_COST: f32 = 0.3;
/// Subtrees with fewer nodes are not worth a task of their own.
const TASK: usize = 1 << 13;
const WIDTH: usize = WIDE_CHILDREN as usize;

/// What stands for a binary node. Entry 0, for one child: the triangles of a leaf, or 0 for an inner node. Entry `j - 1`,
/// for `j` children: the left child's share of them, or 0 where `j - 1` children are no worse.
type Choice = [u8; WIDTH];

/// The answer for one binary node: its choice, kept, and what its parent asks for.
struct Answer {
    choice: Choice,
    /// `costs[i - 1]` is `C(node, i)`.
    costs: [f32; WIDTH - 1],
    /// Triangles below, where they fit a leaf; otherwise one more than fit.
    triangles: u8,
}

/// The choices for all nodes.
pub(super) struct Collapse<'a> {
    nodes: &'a [BinaryNode],
    choices: Vec<Choice>,
}

impl<'a> Collapse<'a> {
    /// Solves for every node of a tree laid out as [`super::subdivide`] does, with at most [`WIDE_LEAF_TRIANGLES`]
    /// triangles a leaf.
    pub fn solve(nodes: &'a [BinaryNode]) -> Collapse<'a> {
        let mut choices = vec![[0; WIDTH]; nodes.len()];
        if let Some((root, below)) = choices.split_first_mut() {
            *root = solve_below(nodes, 0, below).choice;
        }
        Collapse { nodes, choices }
    }

    /// The binary nodes that become the children of the wide node that stands for `node`; returns how many.
    pub fn children(&self, node: u32, children: &mut [u32; WIDTH]) -> usize {
        let mut count = 0;
        self.collect(node, WIDTH, children, &mut count);
        count
    }

    /// Whether a binary node, as one child of a wide node, is a leaf.
    pub fn is_leaf(&self, node: u32) -> bool {
        self.choices[node as usize][0] > 0
    }

    /// First leaf-order position and number of the triangles below a node that is a leaf.
    pub fn triangles(&self, node: u32) -> (u32, u32) {
        let mut first = node as usize;
        while self.nodes[first].count == 0 {
            first = self.nodes[first].first as usize;
        }
        (self.nodes[first].first, u32::from(self.choices[node as usize][0]))
    }

    fn collect(&self, node: u32, slots: usize, children: &mut [u32; WIDTH], count: &mut usize) {
        let BinaryNode { first, count: triangles, .. } = self.nodes[node as usize];
        let mut slots = slots;
        while slots > 1 && triangles == 0 {
            let share = usize::from(self.choices[node as usize][slots - 1]);
            if share > 0 {
                self.collect(first, share, children, count);
                self.collect(first + 1, slots - share, children, count);
                return;
            }
            slots -= 1;
        }
        children[*count] = node;
        *count += 1;
    }
}

/// Solves for a node; `below` are the choices of the nodes below it, which start with its children's.
fn solve_below(nodes: &[BinaryNode], node: u32, below: &mut [Choice]) -> Answer {
    let BinaryNode { bounds, first, count } = nodes[node as usize];
    let area = bounds.half_area();
    if count > 0 {
        let mut choice = [0; WIDTH];
        choice[0] = count as u8;
        return Answer { choice, costs: [area * count as f32 * TRIANGLE_COST; WIDTH - 1], triangles: count as u8 };
    }
    let (pair, rest) = below.split_at_mut(2);
    // Below the left child first, below the right child after it; a leaf has nothing below.
    let right = nodes[first as usize + 1];
    let left_length = if right.count > 0 { rest.len() } else { (right.first - first - 2) as usize };
    let is_task = rest.len() >= TASK;
    let (left_rest, right_rest) = rest.split_at_mut(left_length);
    let mut solve_left = || solve_below(nodes, first, left_rest);
    let mut solve_right = || solve_below(nodes, first + 1, right_rest);
    let (left, right) = if is_task { rayon::join(solve_left, solve_right) } else { (solve_left(), solve_right()) };
    (pair[0], pair[1]) = (left.choice, right.choice);
    combine(&left, &right, area)
}

fn combine(left: &Answer, right: &Answer, area: f32) -> Answer {
    let triangles = (left.triangles + right.triangles).min(WIDE_LEAF_TRIANGLES as u8 + 1);
    let (mut choice, mut costs) = ([0; WIDTH], [0.0; WIDTH - 1]);
    let mut distributed = [f32::INFINITY; WIDTH + 1];
    for (slots, least) in distributed.iter_mut().enumerate().skip(2) {
        for share in 1..slots {
            let cost = left.costs[share - 1] + right.costs[slots - share - 1];
            if cost < *least || share == 1 {
                *least = cost;
                choice[slots - 1] = share as u8;
            }
        }
    }
    let inner = distributed[WIDTH] + area * NODE_COST;
    let leaf = if u32::from(triangles) <= WIDE_LEAF_TRIANGLES {
        area * f32::from(triangles) * TRIANGLE_COST
    } else {
        f32::INFINITY
    };
    if leaf <= inner && u32::from(triangles) <= WIDE_LEAF_TRIANGLES {
        choice[0] = triangles;
    }
    costs[0] = leaf.min(inner);
    // The full width always distributes: a wide node has at least two children.
    for (slots, &cost) in distributed.iter().enumerate().take(WIDTH).skip(2) {
        let fewer = costs[slots - 2];
        costs[slots - 1] = cost.min(fewer);
        if cost >= fewer {
            choice[slots - 1] = 0;
        }
    }
    Answer { choice, costs, triangles }
}
