//! Guards of group D: ray origins.

use texray::render::Guard;

/// Each guard with the case that fails without it.
pub const MUTANTS: &[(Guard, u8)] = &[
    (Guard::SkipSource, 30),
    (Guard::SpawnOffset, 32),
    (Guard::EdgeMargin, 32),
    (Guard::ShadowLimit, 33),
    (Guard::SkipLight, 33),
    (Guard::GeometricSide, 34),
    (Guard::NormalSide, 35),
];
