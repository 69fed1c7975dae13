//! Guards of group H: whole scenes.

use texray::render::Guard;

/// Each guard with the case that fails without it.
pub const MUTANTS: &[(Guard, u8)] = &[(Guard::Recentre, 70), (Guard::Rescale, 70)];
