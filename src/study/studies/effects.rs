//! The study of effects: the price list. What each effect of a scene costs in time, instructions and bytes, and what its picture is
//! without it; and what the code of an effect costs a scene that does not call for it.
//!
//! Comes in: scenes and a device. Goes out: a row a set of effects and repeat, each repeat two seeds. `own` is the least set that the
//! scene calls for; `without NAME` leaves one of those out, `with NAME` puts another in; `all` has every effect. Pictures have
//! the scene's filter, which is an effect too.

mod instructions;

use crate::Result;
use crate::gpu::{Context, Direction, Ledger};
use crate::interface::{EFFECTS, EffectKind};
use crate::render::effects::EFFECT_NAMES;
use crate::render::kernel::{self, ReadAs};
use crate::render::{Effects, Tuning, build_accel};
use crate::report::{Bars, Block};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::study::engine::schedule::interleaved;
use crate::study::engine::seed_pair::{SeedPair, bias_percent};
use crate::study::engine::spread::digits;
use crate::study::engine::subject::{Subject, Subjects};
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Spread, Step, Study, Values, Watch};

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "effects",
    help: "What each effect costs in time, instructions and bytes, and the error without it",
    title: "The price of an effect",
    scenes: Scenes::Chosen {
        full: &["cornell-box", "cornell-mirror", "cornell-glass", "teapot", "bunny"],
        quick: &["cornell-glass", "teapot"],
    },
    summary: |rows, _| summary(rows),
    opens: |context, plan, _| Ok(Box::new(EffectPrices::new(context, plan)?)),
};

/// How much is measured.
struct EffectsWorkload {
    size: [u32; 2],
    /// Samples of each of a repeat's two seeds.
    spp: u32,
    repeats: u32,
}

const FULL: EffectsWorkload = EffectsWorkload { size: [240, 180], spp: 32, repeats: 5 };
const QUICK: EffectsWorkload = EffectsWorkload { size: [160, 120], spp: 16, repeats: 3 };
const LEAST: EffectsWorkload = EffectsWorkload { size: [8, 6], spp: 16, repeats: 1 };

/// A set of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    /// What the scene calls for.
    Own,
    /// Every effect.
    All,
    /// Its own but this one.
    Without(u32),
    /// Its own and this one.
    With(u32),
}

impl Case {
    fn name(self) -> String {
        match self {
            Case::Own => "own".into(),
            Case::All => "all".into(),
            Case::Without(effect) => format!("without {}", EFFECT_NAMES[effect as usize]),
            Case::With(effect) => format!("with {}", EFFECT_NAMES[effect as usize]),
        }
    }
}

fn cases() -> Vec<Case> {
    let toggled = (0..EFFECTS).flat_map(|effect| [Case::Without(effect), Case::With(effect)]);
    [Case::Own, Case::All].into_iter().chain(toggled).collect()
}

/// The cases that say something of a scene with these effects on.
fn cases_of(on: &[bool]) -> Vec<usize> {
    let says = |case: &Case| match *case {
        Case::Own | Case::All => true,
        Case::Without(effect) => on[effect as usize],
        Case::With(effect) => !on[effect as usize],
    };
    cases().iter().enumerate().filter(|(_, case)| says(case)).map(|(place, _)| place).collect()
}

/// The study.
pub struct EffectPrices {
    subjects: Subjects,
    workload: EffectsWorkload,
    cases: Vec<Case>,
    /// By scene: which effects it calls for.
    on: Vec<Vec<bool>>,
    /// Pictures with the scene's own effects, by scene and repeat.
    own: Option<((usize, u32), SeedPair)>,
}

impl EffectPrices {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<EffectPrices> {
        let mut on = Vec::new();
        for path in &plan.scenes {
            let scene = Scene::load(path)?;
            let effects = Effects::of(&scene, &Settings::for_scene(&scene));
            on.push(effects.iter().map(|effect| effect.on).collect());
        }
        Ok(EffectPrices {
            subjects: Subjects::new(context, &plan.scenes)?,
            workload: plan.amount.of(FULL, QUICK, LEAST),
            cases: cases(),
            on,
            own: None,
        })
    }
}

fn settings(subject: &Subject, workload: &EffectsWorkload) -> Settings {
    let [width, height] = workload.size;
    Settings { width, height, spp: workload.spp, ..Settings::for_scene(&subject.scene) }
}

/// Bytes of a buffer on the device.
fn buffer_bytes(ledger: &Ledger, buffer: &str) -> u64 {
    let entries = ledger.entries();
    entries.iter().filter(|entry| entry.buffer == buffer && entry.direction == Direction::Up).map(|e| e.bytes).sum()
}

impl EffectPrices {
    /// What does not differ from repeat to repeat: instructions, and bytes of an effect's own buffer.
    fn still(&mut self, step: Step, settings: &Settings, tuning: &Tuning, watch: &dyn Watch) -> Result<Option<Values>> {
        let case = self.cases[step.case];
        let subject = self.subjects.at(step.scene)?;
        let scene = &subject.scene;
        let mut effects = Effects::of(scene, settings);
        effects = match case {
            Case::Without(effect) => effects.without(effect),
            Case::With(effect) => effects.with(effect),
            Case::Own | Case::All => effects,
        };
        let accel = build_accel(scene, settings);
        let tree = accel.stats(scene.triangles.len());
        let read_as = ReadAs { records: settings.buffers, paths: settings.buffers };
        let kernel = kernel::specialized(subject.context(), settings, &accel, &tree, &effects, read_as, tuning);
        let mut values = Values::new();
        values.extend(instructions::count(&kernel)?.map(|count| ("instructions", count as f64)));
        if let Case::Without(effect) = case
            && let Some(record) = EffectKind::ALL[effect as usize].record()
        {
            let one = Settings { crop: Some([0, 0, 1, 1]), spp: 1, ..settings.clone() };
            let Some(rendered) = subject.render(&one, &Tuning::default(), watch)? else { return Ok(None) };
            values.push(("bytes_own_buffer", buffer_bytes(&rendered.ledger, record.name()) as f64));
        }
        Ok(Some(values))
    }
}

impl Study for EffectPrices {
    fn scenes(&self) -> &[String] {
        self.subjects.names()
    }

    fn case(&self, case: usize) -> String {
        self.cases[case].name()
    }

    fn schedule(&self) -> Vec<Step> {
        let of = |(scene, on): (usize, &Vec<bool>)| {
            let steps = interleaved(1, &cases_of(on), self.workload.repeats);
            steps.into_iter().map(move |step| Step { scene, ..step })
        };
        self.on.iter().enumerate().flat_map(of).collect()
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let case = self.cases[step.case];
        let subject = self.subjects.at(step.scene)?;
        let own_settings = settings(subject, &self.workload);
        let key = (step.scene, step.repeat);
        if self.own.as_ref().is_none_or(|(made_for, _)| *made_for != key) {
            let Some(pair) = SeedPair::render(subject, &own_settings, &Tuning::default(), step.repeat, watch)? else {
                return Ok(None);
            };
            self.own = Some((key, pair));
        }
        let mut tuning = Tuning::default();
        match case {
            Case::Without(effect) => tuning.without_effect = Some(effect),
            Case::With(effect) => tuning.with_effect = Some(effect),
            Case::Own | Case::All => (),
        }
        let settings = Settings { all_effects: case == Case::All, ..own_settings };
        let Some(pair) = SeedPair::render(subject, &settings, &tuning, step.repeat, watch)? else { return Ok(None) };
        let Some((_, own)) = &self.own else { return Ok(None) };
        let mut values = vec![
            ("seconds", pair.seconds),
            ("us_per_path", pair.us_per_path()),
            ("relative_bias_squared", own.bias_squared(&pair)?),
            ("brightness_ratio", pair.brightness() / own.brightness()),
            ("pixels_changed", own.changed(&pair)),
        ];
        if step.repeat == 0 {
            let Some(still) = self.still(step, &settings, &tuning, watch)? else { return Ok(None) };
            values.extend(still);
        }
        Ok(Some(values))
    }

    fn headline(&self, row: &Row) -> String {
        row.values.get("us_per_path").map(|us| format!("{} us a path", digits(*us))).unwrap_or_default()
    }
}

/// How much longer `more` takes than `less`, in per cent, repeat against repeat.
fn price(rows: &Rows, scene: &str, more: Case, less: Case) -> Option<Spread> {
    let of = |case: Case| rows.values(scene, &case.name(), "seconds").collect::<Vec<_>>();
    Spread::of(of(more).into_iter().zip(of(less)).map(|(more, less)| 100.0 * (more / less - 1.0)))
}

/// What the rows say.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let figure = |case: Case, value: &str| rows.median(scene, &case.name(), value);
        let own = figure(Case::Own, "instructions");
        let title = format!(
            "{scene}: what an effect costs (time with it over without, range of the repeats; instructions; bytes of its own \
             buffer), and the relative RMS error of the picture without it"
        );
        let mut table = Table::new(title, &["effect", "called for", "time %", "range", "instr.", "bytes", "error %"]);
        let title = format!("{scene}: time of a path with an effect over without it");
        let mut bars = Bars { title, unit: "%".into(), bars: Vec::new() };
        for effect in 0..EFFECTS {
            let (without, with) = (Case::Without(effect), Case::With(effect));
            let called = figure(without, "seconds").is_some();
            let (more, less) = if called { (Case::Own, without) } else { (with, Case::Own) };
            let Some(time) = price(rows, scene, more, less) else { continue };
            let instructions = match called {
                true => own.zip(figure(without, "instructions")).map(|(own, without)| own - without),
                false => own.zip(figure(with, "instructions")).map(|(own, with)| with - own),
            };
            let what = if called { "called for" } else { "left in" };
            bars.bars.push(time.bar(&format!("{} ({what})", EFFECT_NAMES[effect as usize])));
            let error = figure(if called { without } else { with }, "relative_bias_squared").map(bias_percent);
            table.rows.push(vec![
                EFFECT_NAMES[effect as usize].into(),
                if called { "yes" } else { "no" }.into(),
                format!("{:+.1}", time.median),
                format!("{:+.1} to {:+.1}", time.least, time.most),
                instructions.map_or("?".into(), |count| format!("{count:+.0}")),
                figure(without, "bytes_own_buffer").map_or("-".into(), |bytes| format!("{bytes:.0}")),
                error.map_or("?".into(), digits),
            ]);
        }
        summary.figure(Block::Bars(bars));
        summary.table(table);
        summary.findings.extend(finding(rows, scene));
        summary.plain.extend(plain(rows, scene));
    }
    summary
}

fn plain(rows: &Rows, scene: &str) -> Option<String> {
    let Spread { median, least, most, .. } = price(rows, scene, Case::All, Case::Own)?;
    let text = format!("{scene}: with the effects that it has no use for, a path takes {median:+.0} % time");
    let doubt = if least <= 0.0 && most >= 0.0 { ", which is within what repeats differ by" } else { "" };
    Some(format!("{text} ({least:+.0} to {most:+.0} %){doubt}."))
}

fn finding(rows: &Rows, scene: &str) -> Option<String> {
    let median = |case: Case, value: &str| rows.median(scene, &case.name(), value);
    let saved = price(rows, scene, Case::All, Case::Own)?;
    let called = (0..EFFECTS).filter(|&effect| median(Case::Without(effect), "seconds").is_some()).count();
    let changed = median(Case::All, "pixels_changed")?;
    let mut text = format!(
        "{scene}: it calls for {called} of {EFFECTS} effects; with all of them a path takes {:+.1} % time ({:+.1} to {:+.1})",
        saved.median, saved.least, saved.most
    );
    if let (Some(own), Some(all)) = (median(Case::Own, "instructions"), median(Case::All, "instructions")) {
        text += &format!(", the kernel has {all:.0} instructions instead of {own:.0}");
    }
    text += &match changed {
        0.0 => ", and not a bit of the picture changes".to_owned(),
        share => format!(", and {:.2} % of the pixels change", 100.0 * share),
    };
    Some(text + ".")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::{EFFECT_EMITTERS, EFFECT_GLASS, Record};

    #[test]
    fn a_scene_leaves_out_what_it_has_and_puts_in_what_it_lacks() {
        let mut on = [false; EFFECTS as usize];
        on[EFFECT_GLASS as usize] = true;
        let names: Vec<String> = cases_of(&on).into_iter().map(|place| cases()[place].name()).collect();
        assert_eq!(names.len(), 2 + EFFECTS as usize);
        assert!(names.contains(&"without glass".into()) && names.contains(&"with sky".into()));
        assert!(!names.contains(&"with glass".into()));
        let buffer = |effect: u32| EffectKind::ALL[effect as usize].record().map(Record::name);
        assert_eq!([buffer(EFFECT_EMITTERS), buffer(EFFECT_GLASS)], [Some("lights"), None]);
    }

    #[test]
    fn the_price_list_has_both_directions() {
        let values = |seconds, instructions, bias| {
            [
                ("seconds", seconds),
                ("instructions", instructions),
                ("relative_bias_squared", bias),
                ("pixels_changed", 0.0),
            ]
        };
        let figures = [
            ("own", values(1.2, 1000.0, 0.0)),
            ("all", values(1.26, 1500.0, 0.0)),
            ("without glass", values(1.0, 900.0, 0.09)),
            ("with sky", values(1.212, 1010.0, 0.0)),
        ];
        let rows: Vec<_> = figures.iter().map(|(case, values)| ("ball", *case, 0, &values[..])).collect();
        let summary = summary(&Rows::synthetic(&rows));
        assert_eq!(summary.tables()[0].rows[0], ["sky", "no", "+1.0", "+1.0 to +1.0", "+10", "-", "0"]);
        assert_eq!(summary.tables()[0].rows[1], ["glass", "yes", "+20.0", "+20.0 to +20.0", "+100", "-", "30.0"]);
        let finding = &summary.findings[0];
        assert!(finding.contains("1 of 6 effects") && finding.contains("+5.0 % time"), "{finding}");
        assert!(finding.contains("1500 instructions instead of 1000, and not a bit"), "{finding}");
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
    }
}
