//! The study of precision: what each numerical guard costs in time, and what leaving it out costs in error.
//!
//! Comes in: scenes and a device. Goes out: rows of three kinds. Pictures with one guard out, or with the triangle test that leaks, beside
//! pictures with all: time, bias, samples left out. Rays that are hard (`rays`, file `faults`): how many go wrong with and without. Sums
//! (`sums`, file `sums`): how far plain ones drift, and what exact ones take. The kernels with a guard out are reachable from here and
//! from tests alone: no option of `render` selects one.

mod faults;
mod sums;

use crate::gpu::Context;
use crate::render::{Guard, Tuning};
use crate::report::{Bars, Block};
use crate::selftest::{TestBench, Tier};
use crate::settings::{Intersector, Settings};
use crate::study::engine::schedule::interleaved;
use crate::study::engine::seed_pair::{SeedPair, bias_percent};
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subjects;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Spread, Step, Study, Values, Watch};
use crate::{Error, Result};
use faults::Fault;
use sums::Sum;

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "precision",
    help: "What each numerical guard costs in time, and the error without it",
    title: "The price of a guard",
    scenes: Scenes::Chosen {
        full: &["cornell-box", "cornell-coplanar", "cornell-glass", "room"],
        quick: &["cornell-coplanar", "cornell-glass"],
    },
    summary: |rows, _| summary(rows),
    opens: |context, plan, _| Ok(Box::new(Precision::new(context, plan)?)),
};

/// Guards that a render meets all the time.
const GUARDS: [Guard; 14] = [
    Guard::NodePad,
    Guard::TriangleBox,
    Guard::CullSlack,
    Guard::DirectionFloor,
    Guard::SpawnOffset,
    Guard::SkipSource,
    Guard::EdgeMargin,
    Guard::SkipLight,
    Guard::ShadowLimit,
    Guard::EmitterNearer,
    Guard::InvalidSamples,
    Guard::UnitFloat,
    Guard::DiscRenormalise,
    Guard::FresnelProduct,
];

/// A bias in per cent below which nothing of a guard is seen.
const VISIBLE_PERCENT: f64 = 0.05;
/// Names of what is measured without a scene of the user's.
const RAYS: &str = "rays";
const SUMS: &str = "sums";

/// How much is measured.
struct PrecisionWorkload {
    size: [u32; 2],
    /// Samples of each of a repeat's two seeds.
    spp: u32,
    repeats: u32,
    /// Rays of a fault.
    rays: usize,
}

const FULL: PrecisionWorkload = PrecisionWorkload { size: [240, 180], spp: 32, repeats: 4, rays: 1_000_000 };
const QUICK: PrecisionWorkload = PrecisionWorkload { size: [128, 96], spp: 16, repeats: 3, rays: 100_000 };
const LEAST: PrecisionWorkload = PrecisionWorkload { size: [8, 6], spp: 16, repeats: 1, rays: 1_000 };

/// One thing to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    /// A picture with every guard.
    Guarded,
    /// The same once more: what differs is noise of the clock.
    Again,
    /// A picture without one.
    Without(Guard),
    /// A picture by the triangle test that leaks.
    MollerTrumbore,
    /// Rays that may go wrong.
    Fault(Fault),
    /// A long sum.
    Sum(Sum),
}

impl Case {
    fn name(self) -> String {
        match self {
            Case::Guarded => "all guards".into(),
            Case::Again => "without nothing".into(),
            Case::Without(guard) => format!("without {}", plain(guard)),
            Case::MollerTrumbore => "Moller-Trumbore".into(),
            Case::Fault(fault) => fault.name(),
            Case::Sum(sum) => sum.name().into(),
        }
    }

    fn is_picture(self) -> bool {
        !matches!(self, Case::Fault(_) | Case::Sum(_))
    }
}

/// A guard's name in words.
fn plain(guard: Guard) -> String {
    guard.name().trim_start_matches("GUARD_").to_lowercase().replace('_', " ")
}

fn cases() -> Vec<Case> {
    let pictures = [Case::Guarded, Case::Again, Case::MollerTrumbore].into_iter().chain(GUARDS.map(Case::Without));
    let faults = Fault::all().into_iter().map(Case::Fault);
    pictures.chain(faults).chain(Sum::ALL.map(Case::Sum)).collect()
}

/// Pictures scene by scene in repeats; rays and sums once, in the two places after the scenes.
fn schedule(scenes: usize, cases: &[Case], repeats: u32) -> Vec<Step> {
    let places = |wanted: &dyn Fn(Case) -> bool| -> Vec<usize> {
        (0..cases.len()).filter(|&place| wanted(cases[place])).collect()
    };
    let once = |scene, cases: Vec<usize>| cases.into_iter().map(move |case| Step { scene, case, repeat: 0 });
    let mut steps = interleaved(scenes, &places(&Case::is_picture), repeats);
    steps.extend(once(scenes, places(&|case| matches!(case, Case::Fault(_)))));
    steps.extend(once(scenes + 1, places(&|case| matches!(case, Case::Sum(_)))));
    steps
}

/// The study.
pub struct Precision {
    subjects: Subjects,
    names: Vec<String>,
    bench: TestBench,
    workload: PrecisionWorkload,
    cases: Vec<Case>,
    /// Pictures with all guards, by scene and repeat.
    guarded: Option<((usize, u32), SeedPair)>,
}

impl Precision {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<Precision> {
        let subjects = Subjects::new(context, &plan.scenes)?;
        if let Some(name) = subjects.names().iter().find(|name| [RAYS, SUMS].contains(&name.as_str())) {
            return Err(Error::Usage(format!("a scene named {name}, which study precision has for its own rows")));
        }
        let names = subjects.names().iter().cloned().chain([RAYS.into(), SUMS.into()]).collect();
        Ok(Precision {
            subjects,
            names,
            bench: TestBench::new(context, Tier::Fast),
            workload: plan.amount.of(FULL, QUICK, LEAST),
            cases: cases(),
            guarded: None,
        })
    }

    fn picture(&mut self, step: Step, case: Case, watch: &dyn Watch) -> Result<Option<Values>> {
        let key = (step.scene, step.repeat);
        let (size, spp) = (self.workload.size, self.workload.spp);
        let subject = self.subjects.at(step.scene)?;
        let settings = subject.settings(size, spp);
        if self.guarded.as_ref().is_none_or(|(made_for, _)| *made_for != key) {
            let Some(pair) = SeedPair::render(subject, &settings, &Tuning::default(), step.repeat, watch)? else {
                return Ok(None);
            };
            self.guarded = Some((key, pair));
        }
        let Some((_, guarded)) = &self.guarded else { return Ok(None) };
        let intersector = match case {
            Case::MollerTrumbore => Intersector::MollerTrumbore,
            _ => Intersector::default(),
        };
        let without_guard = if let Case::Without(guard) = case { Some(guard) } else { None };
        let tuning = Tuning { without_guard, ..Tuning::default() };
        let settings = Settings { intersector, ..settings };
        let Some(pair) = SeedPair::render(subject, &settings, &tuning, step.repeat, watch)? else { return Ok(None) };
        Ok(Some(vec![
            ("seconds", pair.seconds),
            ("us_per_path", pair.us_per_path()),
            ("relative_bias_squared", guarded.bias_squared(&pair)?),
            ("brightness_ratio", pair.brightness() / guarded.brightness()),
            ("pixels_changed", guarded.changed(&pair)),
            ("invalid_samples_per_million", 1e6 * pair.invalid_samples / pair.paths),
        ]))
    }
}

impl Study for Precision {
    fn scenes(&self) -> &[String] {
        &self.names
    }

    fn case(&self, case: usize) -> String {
        self.cases[case].name()
    }

    fn schedule(&self) -> Vec<Step> {
        schedule(self.subjects.names().len(), &self.cases, self.workload.repeats)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        match self.cases[step.case] {
            Case::Fault(fault) => fault.measure(&self.bench, self.workload.rays).map(Some),
            Case::Sum(sum) => sum.measure(&self.bench).map(Some),
            case => self.picture(step, case, watch),
        }
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied();
        if let Some(us) = figure("us_per_path") {
            return format!("{} us a path", digits(us));
        }
        if let Some(faults) = figure("faults_per_million") {
            return format!("{} faults in a million", digits(faults));
        }
        figure("relative_error").map(|error| format!("off by {error:.1e}")).unwrap_or_default()
    }
}

/// What is left out, in a word or two.
fn left_out(case: Case) -> String {
    match case {
        Case::Again => "nothing (noise)".into(),
        Case::MollerTrumbore => "watertight test".into(),
        case => case.name().trim_start_matches("without ").to_owned(),
    }
}

/// How much longer the guarded picture takes than the one of `case`, in per cent, repeat against repeat.
fn price(rows: &Rows, scene: &str, case: Case) -> Option<Spread> {
    let of = |case: Case| rows.values(scene, &case.name(), "seconds").collect::<Vec<_>>();
    let pairs = of(Case::Guarded).into_iter().zip(of(case));
    Spread::of(pairs.map(|(guarded, without)| 100.0 * (guarded / without - 1.0)))
}

/// What the rows say.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = Summary::default();
    for scene in rows.scenes().into_iter().filter(|scene| ![RAYS, SUMS].contains(scene)) {
        summary.extend(pictures(rows, scene));
    }
    summary.extend(faults::summary(rows, RAYS));
    summary.extend(sums::summary(rows, SUMS));
    summary.findings.push(
        "Kernels with a guard out are weakened on purpose, for this study: no option of `render` selects one.".into(),
    );
    summary
}

fn pictures(rows: &Rows, scene: &str) -> Summary {
    let title = format!(
        "{scene}: what a guard costs in time (with it over without, range of the repeats), and what the picture loses without it: \
         relative RMS bias, change of brightness, pixels that differ, samples left out in a million"
    );
    let mut table = Table::new(title, &["left out", "costs %", "range", "bias %", "light %", "pixels %", "invalid"]);
    let title = format!("{scene}: time of a path with a guard over without it");
    let mut bars = Bars { title, unit: "%".into(), bars: Vec::new() };
    let mut worst: Option<(f64, Case)> = None;
    let mut prices = Vec::new();
    for case in cases().into_iter().filter(|case| case.is_picture() && *case != Case::Guarded) {
        let median = |value| rows.median(scene, &case.name(), value);
        let Some(price) = price(rows, scene, case) else { continue };
        let bias = median("relative_bias_squared").map(bias_percent);
        if bias.is_some_and(|bias| worst.is_none_or(|(most, _)| bias > most)) {
            worst = bias.map(|bias| (bias, case));
        }
        if case != Case::Again {
            prices.push(price);
        }
        bars.bars.push(price.bar(&left_out(case)));
        table.rows.push(vec![
            left_out(case),
            format!("{:+.1}", price.median),
            format!("{:+.0} to {:+.0}", price.least, price.most),
            bias.map_or("?".into(), |bias| format!("{bias:.3}")),
            median("brightness_ratio").map_or("?".into(), |ratio| format!("{:+.3}", 100.0 * (ratio - 1.0))),
            median("pixels_changed").map_or("?".into(), |share| format!("{:.1}", 100.0 * share)),
            median("invalid_samples_per_million").map_or("?".into(), digits),
        ]);
    }
    let noise = price(rows, scene, Case::Again).map(|noise| noise.least.abs().max(noise.most.abs()));
    let dear = noise.map(|noise| prices.iter().filter(|price| price.least > noise).count());
    let findings = worst.map(|(bias, case)| {
        let times = match (noise, dear) {
            (Some(noise), Some(dear)) => format!(
                "{dear} of {} guards cost more time than two runs of the same kernel differ by ({noise:.1} %)",
                prices.len()
            ),
            _ => format!("{} guards were taken out", prices.len()),
        };
        let loss = match (bias < VISIBLE_PERCENT, case) {
            (true, _) => format!("without any one of them the picture's bias stays below {VISIBLE_PERCENT} %"),
            (false, Case::MollerTrumbore) => format!("the watertight test is missed most: {bias:.2} % bias without it"),
            (false, case) => format!("the one missed most is {}: {bias:.2} % bias without it", left_out(case)),
        };
        format!("{scene}: {times}; {loss} (relative RMS).")
    });
    let mut summary = Summary::default();
    summary.findings.extend(findings);
    summary.plain.extend(worst.map(|(bias, case)| {
        format!(
            "{scene}: the numerical guard that is missed most ({}) keeps a bias of {bias:.2} % out.",
            left_out(case)
        )
    }));
    summary.figure(Block::Bars(bars));
    summary.table(table);
    summary
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_and_sums_come_once_after_the_scenes() {
        let cases = cases();
        let steps = schedule(2, &cases, 3);
        let pictures = cases.iter().filter(|case| case.is_picture()).count();
        assert_eq!(pictures, 3 + GUARDS.len());
        assert_eq!(steps.len(), 2 * 3 * pictures + cases.len() - pictures);
        assert!(steps[2 * 3 * pictures..].iter().all(|step| step.scene >= 2 && step.repeat == 0));
        let sums = steps.iter().filter(|step| step.scene == 3).count();
        assert_eq!(sums, Sum::ALL.len());
    }

    #[test]
    fn a_price_is_read_repeat_against_repeat() {
        let values = |seconds, bias| {
            [("seconds", seconds), ("relative_bias_squared", bias), ("brightness_ratio", 0.98), ("pixels_changed", 0.5)]
        };
        // The machine was half as fast during the second repeat.
        let figures = [
            ("all guards", 0, values(1.1, 0.0)),
            ("without node pad", 0, values(1.0, 4e-4)),
            ("all guards", 1, values(2.2, 0.0)),
            ("without node pad", 1, values(2.0, 4e-4)),
        ];
        let rows: Vec<_> = figures.iter().map(|(case, repeat, values)| ("box", *case, *repeat, &values[..])).collect();
        let summary = summary(&Rows::synthetic(&rows));
        assert_eq!(summary.tables()[0].rows[0], ["node pad", "+10.0", "+10 to +10", "2.000", "-2.000", "50.0", "?"]);
        assert!(summary.findings[0].contains("missed most is node pad: 2.00 %"), "{:?}", summary.findings);
        assert!(summary.findings.last().unwrap().contains("no option of `render`"));
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
    }
}
