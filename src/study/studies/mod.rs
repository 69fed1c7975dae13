//! The studies: one file each, and the list of them.
//!
//! Comes in: a name. Goes out: the [`Kind`] of that name. A new study is a file with its `KIND` and an entry here.

pub mod bounces;
pub mod convergence;
pub mod cornell;
pub mod effects;
pub mod precision;
pub mod published;
pub mod speed;
pub mod spp;
pub mod thesis;
pub mod transfer;
pub mod triangles;

use super::engine::Kind;

/// Every study, in the order in which `all` runs them.
pub static ALL: [Kind; 10] = [
    spp::KIND,
    bounces::KIND,
    convergence::KIND,
    triangles::KIND,
    thesis::KIND,
    effects::KIND,
    precision::KIND,
    transfer::KIND,
    speed::KIND,
    published::KIND,
];

/// The study of this name.
pub fn named(name: &str) -> Option<&'static Kind> {
    ALL.iter().find(|kind| kind.name == name)
}
