//! The study of bounces: brightness, bias and time by the number of scatterings that a path may have (thesis, figures 4.4 to 4.6).
//!
//! Comes in: scenes and a device. Goes out: a row a cap and repeat, with roulette and without, and pictures of each cap: the whole,
//! and a detail with shadows, three times as large. Every repeat is of two seeds; a path's random numbers do not depend on the
//! cap, so the pictures of two caps differ in what the further bounces bring, and their noise is mostly the same.

mod shadow;

use std::path::Path;

use crate::Result;
use crate::compare::relative_error::mean;
use crate::gpu::Context;
use crate::render::Tuning;
use crate::report::{Axis, Block, Chart, Series, axis};
use crate::settings::{Roulette, Settings};
use crate::study::engine::gallery::Gallery;
use crate::study::engine::schedule::interleaved;
use crate::study::engine::seed_pair::{SeedPair, bias_percent};
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subjects;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Spread, Step, Study, Values, Watch};

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "bounces",
    help: "Brightness, bias and time for 1 to 30 bounces a path",
    title: "Bounces",
    scenes: Scenes::Chosen { full: &["cornell-box", "room"], quick: &["cornell-box"] },
    summary,
    opens: |context, plan, _| Ok(Box::new(Bounces::new(context, plan)?)),
};

/// Caps, the last of which stands for all bounces.
const CAPS: [u32; 7] = [1, 2, 3, 5, 8, 15, 30];
/// The last of them.
const LONGEST: u32 = CAPS[CAPS.len() - 1];
/// How much larger the detail is drawn.
const DETAIL_SCALE: u32 = 3;

/// How much is measured.
struct BouncesWorkload {
    size: [u32; 2],
    /// Samples of each of a repeat's two seeds.
    spp: u32,
    repeats: u32,
}

const FULL: BouncesWorkload = BouncesWorkload { size: [200, 150], spp: 64, repeats: 3 };
const QUICK: BouncesWorkload = BouncesWorkload { size: [160, 120], spp: 16, repeats: 3 };
const LEAST: BouncesWorkload = BouncesWorkload { size: [16, 12], spp: 16, repeats: 1 };

/// What is measured of a cap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    /// Everything, with the default roulette.
    Whole(u32),
    /// Time without roulette.
    NoRoulette(u32),
    /// Only the picture of a detail.
    Detail(u32),
}

impl Case {
    fn name(self) -> String {
        match self {
            Case::Whole(cap) => cap.to_string(),
            Case::NoRoulette(cap) => format!("{cap} without roulette"),
            Case::Detail(cap) => format!("{cap} detail"),
        }
    }
}

fn cases() -> Vec<Case> {
    [Case::Whole as fn(u32) -> Case, Case::NoRoulette, Case::Detail]
        .into_iter()
        .flat_map(|kind| CAPS.map(kind))
        .collect()
}

/// Timed cases repeat by repeat, then the details, which have no noise in their time to average.
fn schedule(scenes: usize, repeats: u32) -> Vec<Step> {
    let timed: Vec<usize> = (0..2 * CAPS.len()).collect();
    let details: Vec<usize> = (2 * CAPS.len()..3 * CAPS.len()).collect();
    let of = |scene, cases: &[usize], repeats| {
        interleaved(1, cases, repeats).into_iter().map(move |step| Step { scene, ..step }).collect::<Vec<_>>()
    };
    (0..scenes).flat_map(|scene| [of(scene, &timed, repeats), of(scene, &details, 1)].concat()).collect()
}

/// The study.
pub struct Bounces {
    subjects: Subjects,
    gallery: Gallery,
    workload: BouncesWorkload,
    cases: Vec<Case>,
    /// Pictures of the longest paths, by scene and repeat.
    longest: Option<((usize, u32), SeedPair)>,
    /// The window of the detail, by scene.
    window: Option<(usize, [u32; 4])>,
}

impl Bounces {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<Bounces> {
        Ok(Bounces {
            subjects: Subjects::new(context, &plan.scenes)?,
            gallery: Gallery::new(&plan.folder, "bounces"),
            workload: plan.amount.of(FULL, QUICK, LEAST),
            cases: cases(),
            longest: None,
            window: None,
        })
    }

    /// What all paths of this repeat see, rendered once.
    fn longest(&mut self, step: Step, watch: &dyn Watch) -> Result<Option<&SeedPair>> {
        let key = (step.scene, step.repeat);
        if self.longest.as_ref().is_none_or(|(made_for, _)| *made_for != key) {
            let subject = self.subjects.at(step.scene)?;
            let settings = Settings { max_bounces: LONGEST, ..subject.settings(self.workload.size, self.workload.spp) };
            let Some(pair) = SeedPair::render(subject, &settings, &Tuning::default(), step.repeat, watch)? else {
                return Ok(None);
            };
            self.longest = Some((key, pair));
        }
        Ok(self.longest.as_ref().map(|(_, pair)| pair))
    }

    fn timed(&mut self, step: Step, settings: &Settings, watch: &dyn Watch) -> Result<Option<Values>> {
        let subject = self.subjects.at(step.scene)?;
        let Some(pair) = SeedPair::render(subject, settings, &Tuning::default(), step.repeat, watch)? else {
            return Ok(None);
        };
        let mut values = vec![
            ("seconds", pair.seconds),
            ("mpaths_per_second", pair.paths / pair.seconds / 1e6),
            ("rays_per_path", pair.rays / pair.paths),
            ("brightness", pair.brightness()),
        ];
        if settings.roulette == Roulette::default() {
            if step.repeat == 0 {
                let cap = format!("{:02}", settings.max_bounces);
                self.gallery.keep(&subject.scene.name, &cap, self.workload.size, &pair.picture())?;
            }
            let Some(longest) = self.longest(step, watch)? else { return Ok(None) };
            values.push(("brightness_to_longest", pair.brightness() / longest.brightness()));
            values.push(("relative_bias_squared", longest.bias_squared(&pair)?));
        }
        Ok(Some(values))
    }

    fn detail(&mut self, step: Step, cap: u32, watch: &dyn Watch) -> Result<Option<Values>> {
        let subject = self.subjects.at(step.scene)?;
        let window = match self.window {
            Some((scene, window)) if scene == step.scene => window,
            _ => {
                let Some(window) = shadow::window(subject, self.workload.size, LONGEST, watch)? else {
                    return Ok(None);
                };
                self.window = Some((step.scene, window));
                window
            }
        };
        let size = self.workload.size.map(|pixels| pixels * DETAIL_SCALE);
        let crop = window.map(|pixels| pixels * DETAIL_SCALE);
        let settings = subject.settings(size, 2 * self.workload.spp);
        let settings = Settings { max_bounces: cap, crop: Some(crop), ..settings };
        let Some(rendered) = subject.render(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let picture = rendered.film.mean();
        let (scene, brightness) = (subject.scene.name.clone(), mean(&picture));
        self.gallery.keep(&scene, &format!("detail {cap:02}"), [crop[2], crop[3]], &picture)?;
        Ok(Some(vec![("brightness", brightness), ("x", f64::from(crop[0])), ("y", f64::from(crop[1]))]))
    }
}

impl Study for Bounces {
    fn scenes(&self) -> &[String] {
        self.subjects.names()
    }

    fn case(&self, case: usize) -> String {
        self.cases[case].name()
    }

    fn schedule(&self) -> Vec<Step> {
        schedule(self.subjects.names().len(), self.workload.repeats)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let (cap, roulette) = match self.cases[step.case] {
            Case::Whole(cap) => (cap, Roulette::default()),
            Case::NoRoulette(cap) => (cap, Roulette::Off),
            Case::Detail(cap) => return self.detail(step, cap, watch),
        };
        let settings = self.subjects.at(step.scene)?.settings(self.workload.size, self.workload.spp);
        self.timed(step, &Settings { max_bounces: cap, roulette, ..settings }, watch)
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied();
        match (figure("seconds"), figure("brightness_to_longest")) {
            (Some(seconds), Some(share)) => {
                format!("bounces: {} s, {} % of the light", digits(seconds), digits(100.0 * share))
            }
            (Some(seconds), None) => format!("{} s", digits(seconds)),
            _ => "kept".into(),
        }
    }
}

/// What the rows say.
pub fn summary(rows: &Rows, folder: &Path) -> Summary {
    let gallery = Gallery::new(folder, "bounces");
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let figure = |case: Case, value: &str| rows.median(scene, &case.name(), value);
        let text = |value: Option<f64>| value.map_or("?".into(), digits);
        let title =
            format!("{scene}: brightness, bias and time by the most bounces of a path (bias against {LONGEST})");
        let mut table = Table::new(title, &["cap", "s", "s, no roulette", "rays a path", "light %", "bias %"]);
        for cap in CAPS {
            let whole = Case::Whole(cap);
            if figure(whole, "seconds").is_none() {
                continue;
            }
            table.rows.push(vec![
                cap.to_string(),
                text(figure(whole, "seconds")),
                text(figure(Case::NoRoulette(cap), "seconds")),
                text(figure(whole, "rays_per_path")),
                figure(whole, "brightness_to_longest").map_or("?".into(), |share| format!("{:.2}", 100.0 * share)),
                text(figure(whole, "relative_bias_squared").map(bias_percent)),
            ]);
        }
        charts(rows, scene).into_iter().for_each(|block| summary.figure(block));
        for (prefix, what) in
            [("", "by the most bounces of a path"), ("detail ", "a detail with shadows, three times as large")]
        {
            let pictures = CAPS.map(|cap| (format!("{prefix}{cap:02}"), label(cap)));
            let figure = gallery.figure(scene, &format!("{scene}: {what}"), &pictures, CAPS.len() - 1);
            figure.into_iter().for_each(|block| summary.figure(block));
        }
        summary.table(table);
        summary.findings.extend(findings(scene, figure));
        summary.plain.extend(plain(scene, figure));
    }
    summary
}

fn label(cap: u32) -> String {
    match cap {
        1 => "1 bounce".into(),
        DEFAULT_CAP => format!("{cap} bounces (the default)"),
        cap => format!("{cap} bounces"),
    }
}

/// The cap of a scene that does not say.
const DEFAULT_CAP: u32 = 8;

/// Light and time by the cap.
fn charts(rows: &Rows, scene: &str) -> [Block; 2] {
    let series = |name: &str, case: fn(u32) -> Case, value: &str, scale: f64| {
        let point = |cap: u32| {
            let spread = rows.spread(scene, &case(cap).name(), value)?;
            Some(
                Spread {
                    median: scale * spread.median,
                    least: scale * spread.least,
                    most: scale * spread.most,
                    ..spread
                }
                .point(f64::from(cap)),
            )
        };
        Series::new(name, CAPS.into_iter().filter_map(point).collect())
    };
    let chart = |title: &str, y: Axis, series| {
        let x = Axis::new("most bounces of a path", "", axis::Scale::Log);
        Block::Chart(Chart { title: format!("{scene}: {title}"), x, y, series })
    };
    let share = series("light", Case::Whole, "brightness_to_longest", 100.0);
    let times = vec![
        series("with roulette", Case::Whole, "seconds", 1.0).default_if(true),
        series("without roulette", Case::NoRoulette, "seconds", 1.0),
    ];
    [
        chart(
            "light that arrives",
            Axis::new(&format!("of what {LONGEST} bounces bring"), "%", axis::Scale::Linear),
            vec![share],
        ),
        chart("time", Axis::new("time", "s", axis::Scale::Log), times),
    ]
}

fn plain(scene: &str, figure: impl Fn(Case, &str) -> Option<f64>) -> Option<String> {
    let share = |cap| Some(100.0 * figure(Case::Whole(cap), "brightness_to_longest")?);
    let times = figure(Case::Whole(DEFAULT_CAP), "seconds")? / figure(Case::Whole(1), "seconds")?;
    Some(format!(
        "{scene}: one bounce shows {:.0} % of the light; {DEFAULT_CAP}, the default, show {:.1} % and take {} times \
         as long.",
        share(1)?,
        share(DEFAULT_CAP)?,
        digits(times)
    ))
}

fn findings(scene: &str, figure: impl Fn(Case, &str) -> Option<f64>) -> Option<String> {
    let share = |cap| Some(100.0 * figure(Case::Whole(cap), "brightness_to_longest")?);
    let bias = |cap| Some(bias_percent(figure(Case::Whole(cap), "relative_bias_squared")?));
    let growth = |case: fn(u32) -> Case| Some(figure(case(LONGEST), "seconds")? / figure(case(8), "seconds")?);
    Some(format!(
        "{scene}: one bounce shows {:.1} % of the light that {LONGEST} bounces bring, three {:.1} %, eight {:.2} % (bias {} %). \
         Going from 8 to {LONGEST} takes {} times as long with roulette and {} times without.",
        share(1)?,
        share(3)?,
        share(8)?,
        digits(bias(8)?),
        digits(growth(Case::Whole)?),
        digits(growth(Case::NoRoulette)?),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_are_drawn_once_after_what_is_timed() {
        let steps = schedule(2, 3);
        assert_eq!(steps.len(), 2 * (3 * 14 + 7));
        assert!(steps[..42].iter().all(|step| step.case < 14 && step.scene == 0));
        assert!(steps[42..49].iter().all(|step| step.case >= 14 && step.repeat == 0));
    }

    #[test]
    fn the_account_tells_light_bias_and_time() {
        let whole = |seconds, share, bias| {
            [("seconds", seconds), ("brightness_to_longest", share), ("relative_bias_squared", bias)]
        };
        let figures = [
            (1, whole(1.0, 0.5, 0.25)),
            (3, whole(2.0, 0.8, 0.04)),
            (8, whole(3.0, 0.99, 1e-4)),
            (30, whole(4.5, 1.0, 0.0)),
        ];
        let names: Vec<String> = figures.iter().map(|(cap, _)| cap.to_string()).collect();
        let slow: [(&str, [(&str, f64); 1]); 2] =
            [("8 without roulette", [("seconds", 5.0)]), ("30 without roulette", [("seconds", 15.0)])];
        let mut rows: Vec<_> =
            figures.iter().zip(&names).map(|((_, values), name)| ("box", name.as_str(), 0, &values[..])).collect();
        rows.extend(slow.iter().map(|(name, values)| ("box", *name, 0, &values[..])));
        let summary = summary(&Rows::synthetic(&rows), Path::new("nowhere"));
        assert_eq!(summary.tables()[0].rows[2], ["8", "3.00", "5.00", "?", "99.00", "1.00"]);
        let finding = &summary.findings[0];
        assert!(finding.contains("one bounce shows 50.0 %") && finding.contains("(bias 1.00 %)"), "{finding}");
        assert!(finding.contains("takes 1.50 times as long with roulette and 3.00 times without"), "{finding}");
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80));
    }
}
