//! What is to be studied, how much of it, and with what.

use std::path::PathBuf;

use super::peers::Peers;
use super::subprocess::Subprocess;

/// What is to be studied, and with what.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Scene files; empty: those of [`Kind::default_scenes`](super::Kind::default_scenes).
    pub scenes: Vec<PathBuf>,
    /// How much is measured.
    pub amount: Amount,
    /// Folder for rows and pictures.
    pub folder: PathBuf,
    /// The program itself, for processes of their own.
    pub subprocess: Subprocess,
    /// Where the peers are, if they are asked for.
    pub peers: Option<Peers>,
}

/// How much is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Amount {
    /// Figures to keep.
    #[default]
    Full,
    /// Smaller pictures, fewer repeats: less than two minutes on two cores.
    Quick,
    /// Every measurement once, of next to nothing: shows that a study runs, and no more.
    Least,
}

impl Amount {
    /// What is meant for this amount.
    pub fn of<T>(self, full: T, quick: T, least: T) -> T {
        match self {
            Amount::Full => full,
            Amount::Quick => quick,
            Amount::Least => least,
        }
    }
}
