//! Which studies there are.

use std::path::{Path, PathBuf};

use super::bounces::Bounces;
use super::convergence::Convergence;
use super::effects::EffectPrices;
use super::precision::Precision;
use super::published::Published;
use super::speed::Speed;
use super::spp::Spp;
use super::thesis::Thesis;
use super::transfer::Transfer;
use super::triangles::Triangles;
use super::{
    Account, Amount, Plan, Rows, Study, Watch, bounces, convergence, effects, precision, published, speed, spp, thesis,
    transfer, triangles,
};
use crate::Result;
use crate::gpu::Context;

/// A study by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Pictures and error by samples.
    Spp,
    /// Brightness, bias and time by the most bounces of a path.
    Bounces,
    /// Error against time for samplers, light strategies, hemisphere sampling, roulette.
    Convergence,
    /// Time by the number of triangles, with two trees and with none.
    Triangles,
    /// What each change from the thesis's methods to ours buys.
    Thesis,
    /// What each effect costs, and what the picture is without it.
    Effects,
    /// What each numerical guard costs, and what leaving it out does.
    Precision,
    /// Bytes between host and device.
    Transfer,
    /// Paths a second, the error of a sample, start-up.
    Speed,
    /// The Cornell box beside another renderer's picture of the published data.
    Cornell,
}

impl Kind {
    /// Every study, in the order in which `all` runs them.
    pub const ALL: [Kind; 10] = [
        Kind::Spp,
        Kind::Bounces,
        Kind::Convergence,
        Kind::Triangles,
        Kind::Thesis,
        Kind::Effects,
        Kind::Precision,
        Kind::Transfer,
        Kind::Speed,
        Kind::Cornell,
    ];

    /// Its name on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Spp => "spp",
            Kind::Bounces => "bounces",
            Kind::Convergence => "convergence",
            Kind::Triangles => "triangles",
            Kind::Thesis => "thesis",
            Kind::Effects => "effects",
            Kind::Precision => "precision",
            Kind::Transfer => "transfer",
            Kind::Speed => "speed",
            Kind::Cornell => "cornell",
        }
    }

    /// Whether it is about scenes of the user's choice; otherwise it has its own.
    pub fn takes_scenes(self) -> bool {
        !matches!(self, Kind::Triangles | Kind::Cornell)
    }

    /// The repository's scenes that show what the study is about, as far as they are there; the first is always kept: its absence
    /// is to be told.
    pub fn default_scenes(self, amount: Amount) -> Vec<PathBuf> {
        let names: &[&str] = match (self, amount == Amount::Full) {
            (Kind::Triangles, _) => &[],
            (Kind::Cornell, _) => &["cornell-box"],
            (Kind::Spp | Kind::Bounces | Kind::Convergence | Kind::Thesis, false) => &["cornell-box"],
            (Kind::Spp, true) => &["cornell-box", "cornell-glass"],
            (Kind::Bounces, true) => &["cornell-box", "room"],
            (Kind::Convergence, true) => &["cornell-box", "cornell-glass", "bunny"],
            (Kind::Thesis, true) => &["cornell-box", "room", "fetched/dragon-res3"],
            (Kind::Effects, false) => &["cornell-glass", "teapot"],
            (Kind::Effects, true) => &["cornell-box", "cornell-mirror", "cornell-glass", "teapot", "bunny"],
            (Kind::Precision, false) => &["cornell-coplanar", "cornell-glass"],
            (Kind::Precision, true) => &["cornell-box", "cornell-coplanar", "cornell-glass", "room"],
            (Kind::Transfer, false) => &["cornell-box"],
            (Kind::Transfer, true) => &["cornell-box", "fetched/dragon-res2"],
            (Kind::Speed, _) => &["cornell-box", "fetched/dragon-res2", "fetched/dragon"],
        };
        let paths = names.iter().map(|name| PathBuf::from(format!("scenes/{name}.toml"))).enumerate();
        paths.filter(|(index, path)| *index == 0 || Path::exists(path)).map(|(_, path)| path).collect()
    }

    /// What its section of a report is headed.
    pub fn title(self) -> &'static str {
        match self {
            Kind::Spp => "Samples a pixel",
            Kind::Bounces => "Bounces",
            Kind::Convergence => "Error against time",
            Kind::Triangles => "Numbers of triangles",
            Kind::Thesis => "From the thesis's methods to ours",
            Kind::Effects => "The price of an effect",
            Kind::Precision => "The price of a guard",
            Kind::Transfer => "Between host and device",
            Kind::Speed => "Speed",
            Kind::Cornell => "The Cornell box",
        }
    }

    /// What rows say; pictures are looked for in `folder`.
    pub fn account(self, rows: &Rows, folder: &Path) -> Account {
        match self {
            Kind::Spp => spp::account(rows, folder),
            Kind::Bounces => bounces::account(rows, folder),
            Kind::Convergence => convergence::account(rows),
            Kind::Triangles => triangles::account(rows),
            Kind::Thesis => thesis::account(rows),
            Kind::Effects => effects::account(rows),
            Kind::Precision => precision::account(rows),
            Kind::Transfer => transfer::account(rows),
            Kind::Speed => speed::account(rows),
            Kind::Cornell => published::account(rows, folder),
        }
    }

    /// The study, with the plan's scenes or its own.
    pub fn open(self, context: &Context, plan: &Plan, watch: &mut dyn Watch) -> Result<Box<dyn Study>> {
        let mut plan = plan.clone();
        if plan.scenes.is_empty() {
            plan.scenes = self.default_scenes(plan.amount);
        }
        Ok(match self {
            Kind::Spp => Box::new(Spp::new(context, &plan)?),
            Kind::Bounces => Box::new(Bounces::new(context, &plan)?),
            Kind::Convergence => Box::new(Convergence::new(context, &plan)?),
            Kind::Triangles => Box::new(Triangles::new(context, &plan)?),
            Kind::Thesis => Box::new(Thesis::new(context, &plan)?),
            Kind::Effects => Box::new(EffectPrices::new(context, &plan)?),
            Kind::Precision => Box::new(Precision::new(context, &plan)?),
            Kind::Transfer => Box::new(Transfer::new(context, &plan)?),
            Kind::Speed => Box::new(Speed::new(context, &plan, watch)?),
            Kind::Cornell => Box::new(Published::new(context, &plan)?),
        })
    }
}
