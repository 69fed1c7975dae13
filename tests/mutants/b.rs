//! Guards of group B: triangles.

use texray::render::Guard;

/// Each guard with the case that fails without it.
pub const MUTANTS: &[(Guard, u8)] = &[
    (Guard::UnfusedEdges, 12),
    (Guard::UnfusedEdges, 13),
    (Guard::ExactDeterminant, 14),
    (Guard::Rescale, 15),
    (Guard::TriangleBox, 16),
    (Guard::DropDegenerate, 18),
    (Guard::EmitterNearer, 20),
];
