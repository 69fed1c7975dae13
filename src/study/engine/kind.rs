//! What is stated of a study, once: its names, its scenes, how it is begun and what its rows say.
//!
//! Comes in: a plan. Goes out: the [`Study`], or the [`Summary`] of its rows. The list of all kinds is
//! [`studies::ALL`](crate::study::studies::ALL).

use std::path::{Path, PathBuf};

use super::{Amount, Plan, Rows, Study, Summary, Watch};
use crate::Result;
use crate::gpu::Context;

/// How a study is begun, with scenes in the plan.
pub type Open = fn(&Context, &Plan, &mut dyn Watch) -> Result<Box<dyn Study>>;

/// A kind of study.
#[derive(Debug)]
pub struct Kind {
    /// Its name on the command line and in file names.
    pub name: &'static str,
    /// What it measures, a sentence without its end.
    pub help: &'static str,
    /// What its section of a report is headed.
    pub title: &'static str,
    /// Which scenes it is about.
    pub scenes: Scenes,
    /// What rows say; pictures are looked for in the folder.
    pub summary: fn(&Rows, &Path) -> Summary,
    /// See [`Kind::open`].
    pub opens: Open,
}

/// The scenes of a study, files of `scenes/` without folder and ending.
#[derive(Debug)]
pub enum Scenes {
    /// Those of the user's choice. By default these of the repository's that show what the study is about.
    Chosen {
        /// For figures to keep.
        full: &'static [&'static str],
        /// For less.
        quick: &'static [&'static str],
    },
    /// Its own: these of the repository's, or scenes that it makes.
    Own(&'static [&'static str]),
}

impl Kind {
    /// Whether it is about scenes of the user's choice; otherwise it has its own.
    pub fn takes_scenes(&self) -> bool {
        matches!(self.scenes, Scenes::Chosen { .. })
    }

    /// The repository's scenes that show what the study is about, as far as they are there; the first is always kept:
    /// its absence is to be told.
    pub fn default_scenes(&self, amount: Amount) -> Vec<PathBuf> {
        let names = match self.scenes {
            Scenes::Own(names) => names,
            Scenes::Chosen { full, .. } if amount == Amount::Full => full,
            Scenes::Chosen { quick, .. } => quick,
        };
        let paths = names.iter().map(|name| PathBuf::from(format!("scenes/{name}.toml"))).enumerate();
        paths.filter(|(index, path)| *index == 0 || Path::exists(path)).map(|(_, path)| path).collect()
    }

    /// The study, with the plan's scenes or its own.
    pub fn open(&self, context: &Context, plan: &Plan, watch: &mut dyn Watch) -> Result<Box<dyn Study>> {
        let mut plan = plan.clone();
        if plan.scenes.is_empty() {
            plan.scenes = self.default_scenes(plan.amount);
        }
        (self.opens)(context, &plan, watch)
    }
}
