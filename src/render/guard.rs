//! The numerical guards by name, and what takes one out.
//!
//! A guard is a line of the shaders or of the host without which some hard case goes wrong. To show that, tests and the
//! studies render with one of them out; a user's render never does: [`Tuning`](crate::render::Tuning) is not reachable from
//! the command line. A guard of a shader goes by the constant `SPEC_WITHOUT_GUARD`, `UnfusedEdges` by a module of its own. Those
//! of the host, and the compensated sum, are taken out by the cases themselves, which leave out what the host does.

use crate::interface::GUARDS;
pub use crate::interface::Guard;

impl Guard {
    /// The value of the constant `SPEC_WITHOUT_GUARD` that takes it out.
    pub fn number(self) -> u32 {
        self as u32
    }

    /// Its name in the shaders.
    pub fn name(self) -> &'static str {
        self.entry().0
    }

    /// The hard case that it cures first of all.
    pub fn case(self) -> u8 {
        self.entry().2
    }

    /// What it does, a sentence without its end.
    pub fn purpose(self) -> &'static str {
        self.entry().3
    }

    fn entry(self) -> &'static (&'static str, u32, u8, &'static str) {
        // The numbers count from 1, in the order of the list (a test says so).
        &GUARDS[self as usize - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guards_are_numbered_from_one_in_order() {
        assert_eq!(Guard::ALL.len(), GUARDS.len());
        for ((index, guard), (_, number, case, _)) in Guard::ALL.iter().enumerate().zip(GUARDS) {
            assert!(guard.number() == *number && *number as usize == index + 1 && (1..=80).contains(case));
        }
    }
}
