//! Guards of group C: the tree.

use texray::render::Guard;

/// Each guard with the case that fails without it.
pub const MUTANTS: &[(Guard, u8)] = &[
    (Guard::NodePad, 22),
    (Guard::DirectionFloor, 22),
    (Guard::TriangleBox, 22),
    (Guard::CullSlack, 23),
    (Guard::StackDepth, 26),
    (Guard::RefuseInvalidRays, 29),
];
