//! A case of the catalogue.

use super::kit::TestBench;
use crate::Result;
use crate::statistics::Finding;

/// One hard case.
#[derive(Debug)]
pub struct Case {
    /// Its number in the catalogue, 1 to 80.
    pub number: u8,
    /// What is hard, in a few words.
    pub title: &'static str,
    /// What a picture looks like where this fails.
    pub meaning: &'static str,
    /// How it is tested.
    pub check: Check,
}

/// How a case is tested.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// By this function, on the device.
    Run(fn(&TestBench) -> Result<Vec<Finding>>),
    /// By a test program of the repository alone, since it needs what no user has: files, other drivers, proptest.
    Tests(&'static str),
    /// Not yet: the effect that it waits for.
    Awaits(&'static str),
}

/// Cases of one subject.
#[derive(Debug)]
pub struct Group {
    /// Letter, A to H.
    pub letter: char,
    /// Subject.
    pub name: &'static str,
    /// Its cases, in order of number.
    pub cases: &'static [Case],
}

/// Cases of which a part waits for something that is not built, and what that part is.
pub const IN_PART: &[(u8, &str)] = &[
    (47, "the picture at the smallest roughness awaits rough materials"),
    (57, "mixtures of lobes in a furnace await materials that mix"),
    (60, "two films made apart await the command `merge`"),
    (67, "the clamped half awaits a clamp"),
    (77, "rough glass awaits rough materials"),
];

impl Case {
    /// What of it waits for something that is not built.
    pub fn awaits_in_part(&self) -> Option<&'static str> {
        IN_PART.iter().find(|(number, _)| *number == self.number).map(|&(_, part)| part)
    }
}
