//! The study of the thesis: its configuration and ours on the same scene, and what each change between them buys.
//!
//! Comes in: scenes and a device. Goes out: a row a configuration and repeat, each repeat another seed. The changes are made one after
//! the other, from the thesis's methods to ours (`to …`: that one and all before it), and each alone on the thesis's (`only …`). The
//! time is of the same samples in all, the error against a reference of our own configuration.

use crate::Result;
use crate::compare::relative_error::mean;
use crate::gpu::Context;
use crate::render::Tuning;
use crate::report::{Bars, Block};
use crate::settings::{AccelKind, Builder, Hemisphere, Intersector, LightPick, Lights, Roulette, Sampler, Settings};
use crate::study::engine::schedule::interleaved;
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subjects;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Spread, Step, Study, Values, Watch};

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "thesis",
    help: "What each change from the methods of the 2022 thesis to the defaults buys",
    title: "From the thesis's methods to ours",
    scenes: Scenes::Chosen { full: &["cornell-box", "room", "fetched/dragon-res3"], quick: &["cornell-box"] },
    summary: |rows, _| summary(rows),
    opens: |context, plan, _| Ok(Box::new(Thesis::new(context, plan)?)),
};

/// Probability of survival in the thesis's roulette.
const THESIS_SURVIVAL: f32 = 0.7;

/// A change by its name: takes a setting from ours.
type Change = (&'static str, fn(&mut Settings, &Settings));

/// From the thesis's methods to ours: the tree, the test, then what a sample is worth.
const CHANGES: [Change; 8] = [
    ("builder sah", |settings, ours| settings.builder = ours.builder),
    // The median builder's tree collapses as well as the other's.
    ("accel wide", |settings, ours| settings.accel = ours.accel),
    ("intersector watertight", |settings, ours| settings.intersector = ours.intersector),
    ("lights mis", |settings, ours| settings.lights = ours.lights),
    ("light-pick default", |settings, ours| settings.light_pick = ours.light_pick),
    ("hemisphere cosine", |settings, ours| settings.hemisphere = ours.hemisphere),
    ("roulette throughput", |settings, ours| settings.roulette = ours.roulette),
    ("sampler sobol", |settings, ours| settings.sampler = ours.sampler),
];

/// How much is measured.
struct ThesisWorkload {
    size: [u32; 2],
    spp: u32,
    repeats: u32,
    reference_spp: u32,
}

const FULL: ThesisWorkload = ThesisWorkload { size: [240, 180], spp: 32, repeats: 3, reference_spp: 1024 };
const QUICK: ThesisWorkload = ThesisWorkload { size: [128, 96], spp: 32, repeats: 3, reference_spp: 1024 };
const LEAST: ThesisWorkload = ThesisWorkload { size: [8, 6], spp: 16, repeats: 1, reference_spp: 64 };

/// A configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    /// The thesis's with so many of the changes made; all of them: ours.
    To(usize),
    /// The thesis's with this change alone.
    Only(usize),
}

impl Case {
    fn name(self) -> String {
        match self {
            Case::To(0) => "thesis".into(),
            Case::To(made) => format!("to {}", CHANGES[made - 1].0),
            Case::Only(change) => format!("only {}", CHANGES[change].0),
        }
    }

    fn settings(self, ours: Settings) -> Settings {
        let mut settings = Settings {
            builder: Builder::Median,
            accel: AccelKind::Binary,
            intersector: Intersector::MollerTrumbore,
            lights: Lights::Area,
            light_pick: LightPick::Area,
            hemisphere: Hemisphere::Uniform,
            roulette: Roulette::Fixed(THESIS_SURVIVAL),
            sampler: Sampler::Table,
            ..ours.clone()
        };
        let made = match self {
            Case::To(made) => &CHANGES[..made],
            Case::Only(change) => &CHANGES[change..=change],
        };
        made.iter().for_each(|(_, change)| change(&mut settings, &ours));
        settings
    }
}

/// The way from the thesis to us, then each change alone but the first, which is the way's first step.
fn cases() -> Vec<Case> {
    let way = (0..=CHANGES.len()).map(Case::To);
    way.chain((1..CHANGES.len()).map(Case::Only)).collect()
}

/// The study.
pub struct Thesis {
    subjects: Subjects,
    workload: ThesisWorkload,
    cases: Vec<Case>,
}

impl Thesis {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<Thesis> {
        let workload = plan.amount.of(FULL, QUICK, LEAST);
        Ok(Thesis { subjects: Subjects::new(context, &plan.scenes)?, workload, cases: cases() })
    }
}

impl Study for Thesis {
    fn scenes(&self) -> &[String] {
        self.subjects.names()
    }

    fn case(&self, case: usize) -> String {
        self.cases[case].name()
    }

    fn schedule(&self) -> Vec<Step> {
        let cases: Vec<usize> = (0..self.cases.len()).collect();
        interleaved(self.subjects.names().len(), &cases, self.workload.repeats)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let subject = self.subjects.at(step.scene)?;
        let ours = subject.settings(self.workload.size, self.workload.spp);
        let reference = Settings { spp: self.workload.reference_spp, ..ours.clone() };
        let settings = Settings { seed: u64::from(step.repeat), ..self.cases[step.case].settings(ours) };
        let Some(rendered) = subject.render_warm(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let Some(reference) = subject.reference(&reference, watch)? else { return Ok(None) };
        let picture = rendered.film.mean();
        let error = reference.relative_mse(&picture)?;
        let report = rendered.report;
        let (seconds, rays, paths) = (report.seconds.render, report.rays as f64, report.paths as f64);
        Ok(Some(vec![
            ("spp", f64::from(settings.spp)),
            ("seconds", seconds),
            ("us_per_path", 1e6 * seconds / paths),
            ("ns_per_ray", 1e9 * seconds / rays),
            ("rays_per_path", rays / paths),
            ("relative_mse_spp", error * f64::from(settings.spp)),
            ("mean_to_reference", mean(&picture) / mean(&reference.mean)),
            ("seconds_bvh", report.seconds.bvh),
        ]))
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied().unwrap_or(f64::NAN);
        format!("{} us a sample, relMSE * spp {}", digits(figure("us_per_path")), digits(figure("relative_mse_spp")))
    }
}

/// What a configuration costs: microseconds of a path, relative MSE times samples, and their product, which is the time that an
/// error takes.
#[derive(Clone, Copy)]
struct Cost {
    us: f64,
    error: f64,
}

impl Cost {
    fn of(rows: &Rows, scene: &str, case: Case) -> Option<Cost> {
        let median = |value| rows.median(scene, &case.name(), value);
        Some(Cost { us: median("us_per_path")?, error: median("relative_mse_spp")? })
    }

    fn product(self) -> f64 {
        self.us * self.error
    }
}

/// What the rows say.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let cost = |case| Cost::of(rows, scene, case);
        let Some(thesis) = cost(Case::To(0)) else { continue };
        let title = format!(
            "{scene}: from the thesis's methods to ours, one after the other; gain: how many times less time an error takes \
             than before, and than in the thesis, and with that change alone"
        );
        let mut table = Table::new(title, &["methods", "us a path", "relMSE * spp", "gain", "so far", "alone"]);
        let mut before = thesis;
        for made in 0..=CHANGES.len() {
            let Some(this) = cost(Case::To(made)) else { continue };
            let alone = match made {
                0 => None,
                1 => Some(this),
                made => cost(Case::Only(made - 1)),
            };
            let gain = |from: Cost, to: Cost| digits(from.product() / to.product());
            table.rows.push(vec![
                if made == 0 { "thesis".into() } else { format!("+ {}", CHANGES[made - 1].0) },
                digits(this.us),
                digits(this.error),
                if made == 0 { "-".into() } else { gain(before, this) },
                gain(thesis, this),
                alone.map_or("-".into(), |alone| gain(thesis, alone)),
            ]);
            before = this;
        }
        summary.figure(bars(rows, scene));
        summary.table(table);
        summary.findings.extend(finding(scene, thesis, cost));
        summary.plain.extend(cost(Case::To(CHANGES.len())).map(|ours| {
            let times = digits(thesis.product() / ours.product());
            format!(
                "{scene}: the defaults reach the same error {times} times as fast as the methods of the 2022 thesis."
            )
        }));
    }
    summary
}

/// What an error takes on the way from the thesis to us: repeat by repeat, as part of the thesis's.
fn bars(rows: &Rows, scene: &str) -> Block {
    let products = |case: Case| {
        let name = case.name();
        let values = |value| rows.values(scene, &name, value).collect::<Vec<_>>();
        values("us_per_path")
            .into_iter()
            .zip(values("relative_mse_spp"))
            .map(|(us, error)| us * error)
            .collect::<Vec<_>>()
    };
    let thesis = products(Case::To(0));
    let bar = |made: usize| {
        let parts = products(Case::To(made)).into_iter().zip(&thesis).map(|(this, thesis)| 100.0 * this / thesis);
        let name = if made == 0 { "thesis".to_owned() } else { format!("+ {}", CHANGES[made - 1].0) };
        Some(Spread::of(parts)?.bar(&name).default_if(made == CHANGES.len()))
    };
    Block::Bars(Bars {
        title: format!("{scene}: time to an error, as part of the thesis's"),
        unit: "%".into(),
        bars: (0..=CHANGES.len()).filter_map(bar).collect(),
    })
}

fn finding(scene: &str, thesis: Cost, cost: impl Fn(Case) -> Option<Cost>) -> Option<String> {
    let ours = cost(Case::To(CHANGES.len()))?;
    let gains = (1..=CHANGES.len())
        .filter_map(|made| Some((made, cost(Case::To(made - 1))?.product() / cost(Case::To(made))?.product())));
    let (largest, gain) = gains.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "{scene}: an error takes our methods {} times less time than the thesis's: a path costs {} us instead of {}, and one path's \
         squared error is {} times smaller. Of the steps, {} buys most, {} times.",
        digits(thesis.product() / ours.product()),
        digits(ours.us),
        digits(thesis.us),
        digits(thesis.error / ours.error),
        CHANGES[largest - 1].0,
        digits(gain),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_changes_together_are_the_defaults() {
        let ours = Settings {
            width: 4,
            height: 3,
            crop: None,
            filter: Default::default(),
            spp: 1,
            max_bounces: 8,
            seed: 0,
            sampler: Sampler::default(),
            accel: AccelKind::default(),
            builder: Builder::default(),
            intersector: Intersector::default(),
            lights: Lights::default(),
            light_pick: LightPick::Power,
            hemisphere: Hemisphere::default(),
            roulette: Roulette::default(),
            buffers: Default::default(),
            all_effects: false,
            allow_black: false,
            replicates: None,
        };
        assert_eq!(Case::To(CHANGES.len()).settings(ours.clone()), ours);
        // Every step changes something.
        for made in 1..=CHANGES.len() {
            let [before, after] = [made - 1, made].map(|made| Case::To(made).settings(ours.clone()));
            assert_ne!(before, after, "{}", CHANGES[made - 1].0);
        }
        assert_eq!(cases().len(), 9 + 7);
    }

    #[test]
    fn gains_multiply_up() {
        // Each step halves the error; time goes down from 10 to 2 microseconds at the last.
        let mut figures = Vec::new();
        for case in cases() {
            let (made, us) = match case {
                Case::To(made) => (made, if made == CHANGES.len() { 2.0 } else { 10.0 }),
                Case::Only(_) => (1, 10.0),
            };
            figures.push((case.name(), [("us_per_path", us), ("relative_mse_spp", 0.5f64.powi(made as i32))]));
        }
        let rows: Vec<_> = figures.iter().map(|(case, values)| ("box", case.as_str(), 0, &values[..])).collect();
        let summary = summary(&Rows::synthetic(&rows));
        assert_eq!(summary.tables()[0].rows[3][3..], ["2.00", "8.00", "2.00"]);
        let finding = &summary.findings[0];
        assert!(
            finding.contains("1280 times less time") && finding.contains("sampler sobol buys most, 10.0"),
            "{finding}"
        );
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
    }
}
