//! `texray selftest`: the hard cases, on the user's own device.
//!
//! Comes in: a device and how much to sample. Goes out: a table on stdout as the cases end, or one JSON document.

use std::time::Instant;

use clap::Args;
use serde::Serialize;
use texray::Result;
use texray::selftest::{CaseOutcome, CaseReport, GROUPS, Group, Tier};
use texray::statistics::Finding;

use super::engine::Engine;
use super::signals::Signals;
use super::{Outcome, streams};

/// Run the hard cases of path tracing on a device and say whether its pictures can be trusted
#[derive(Args)]
pub struct SelftestArgs {
    /// Device by number or name, as `texray devices` lists them [default: the best one]
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
    /// Sample ten times as much: up to 10 minutes on two cores instead of one
    #[arg(long)]
    full: bool,
    /// Run these cases alone, by number (1 to 80)
    #[arg(long = "case", value_name = "N", value_parser = clap::value_parser!(u8).range(1..=80))]
    cases: Vec<u8>,
    /// Use the validation layers; their messages are failures
    #[arg(long)]
    validation: bool,
    /// Print one JSON document on stdout instead of the table
    #[arg(long)]
    json: bool,
    /// Print everything that was looked at, not only the first of each case
    #[arg(short, long)]
    verbose: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    device: &'a str,
    driver: &'a str,
    tier: &'static str,
    seconds: f64,
    passes: bool,
    /// The signal that ended the run before its last case.
    stopped_by: Option<u8>,
    validation: &'a [String],
    /// What it says of the device, in one sentence.
    verdict: String,
    cases: Vec<CaseLine>,
}

#[derive(Serialize)]
struct CaseLine {
    case: u8,
    title: &'static str,
    verdict: Verdict,
    failure_means: &'static str,
    awaits_in_part: Option<&'static str>,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
    findings: Vec<Finding>,
}

/// What became of a case.
#[derive(Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Pass,
    Fail,
    ShownByTests,
    AwaitsEffect,
    Error,
}

impl Verdict {
    fn of(outcome: &CaseOutcome) -> Verdict {
        match outcome {
            CaseOutcome::Ran(_) if outcome.passes() => Verdict::Pass,
            CaseOutcome::Ran(_) => Verdict::Fail,
            CaseOutcome::ShownBy(_) => Verdict::ShownByTests,
            CaseOutcome::Awaits(_) => Verdict::AwaitsEffect,
            CaseOutcome::Failed(_) => Verdict::Error,
        }
    }

    /// The word of the table.
    fn word(self) -> &'static str {
        match self {
            Verdict::Pass => "ok",
            Verdict::Fail => "FAIL",
            Verdict::ShownByTests => "tests",
            Verdict::AwaitsEffect => "later",
            Verdict::Error => "ERROR",
        }
    }
}

impl SelftestArgs {
    /// Runs the cases; a failed one is the exit code 1. A signal ends the run after the case that it meets; what there is is
    /// printed.
    pub fn run(&self) -> Result<Outcome> {
        let started = Instant::now();
        let signals = Signals::watch()?;
        let engine = Engine::open(self.device.as_deref(), self.validation)?;
        if !self.json {
            streams::answer(&streams::folded(&format!("device {}", engine.device().summary), 2))?;
        }
        let report = self.run_cases(&engine, &signals)?;
        let seconds = started.elapsed().as_secs_f64();
        let validation = engine.validation();
        let failed = report.iter().filter(|found| !found.outcome.passes()).count();
        let asked = self.cases.is_empty() && signals.received().is_none();
        if self.json {
            streams::answer_json(&Document {
                schema: 1,
                device: &engine.device().name,
                driver: &engine.device().driver,
                tier: if self.full { "full" } else { "fast" },
                seconds,
                passes: failed == 0 && validation.is_empty() && signals.received().is_none(),
                stopped_by: signals.received(),
                validation: &validation,
                verdict: verdict(&report, validation.len(), asked),
                cases: report.iter().map(case_line).collect(),
            })?;
        } else {
            validation.iter().for_each(|message| streams::say(&format!("validation: {message}")));
            streams::answer(&summary(&report, seconds))?;
            streams::answer(&streams::folded(&format!("verdict: {}", verdict(&report, validation.len(), asked)), 0))?;
        }
        Ok(match (signals.received(), failed + validation.len()) {
            (Some(signal), _) => Outcome::Signal(signal),
            (None, 0) => Outcome::Done,
            (None, _) => Outcome::HardCasesFailed,
        })
    }

    /// Runs what is asked for, group by group, until a signal comes. The table grows on stdout as the cases end; with `--json`
    /// a line a case goes to stderr.
    fn run_cases(&self, engine: &Engine, signals: &Signals) -> Result<Vec<CaseReport>> {
        let tier = if self.full { Tier::Full } else { Tier::Fast };
        let wanted = |number: u8| self.cases.is_empty() || self.cases.contains(&number);
        let mut report = Vec::new();
        for group in &GROUPS {
            let mut heading = (!self.json).then(|| heading(group));
            for case in group.cases.iter().filter(|case| wanted(case.number)) {
                if signals.received().is_some() {
                    return Ok(report);
                }
                if let Some(heading) = heading.take() {
                    streams::answer(&heading)?;
                }
                let found = engine.run_case(tier, case);
                match self.json {
                    false => streams::answer(&lines(&found, self.verbose).join("\n"))?,
                    true => streams::say(&format!("case {}: {}", case.number, Verdict::of(&found.outcome).word())),
                }
                report.push(found);
            }
        }
        Ok(report)
    }
}

fn heading(group: &Group) -> String {
    format!("\n{}  {}", group.letter, group.name)
}

/// Columns before what belongs to a case.
const MARGIN: usize = 12;

/// A case: its line, what was looked at, and what a failure means.
fn lines(found: &CaseReport, verbose: bool) -> Vec<String> {
    let case = found.case;
    let mut lines = vec![format!("{:3}  {:5}  {}", case.number, Verdict::of(&found.outcome).word(), case.title)];
    let note = |text: &str| streams::folded(&format!("{:MARGIN$}{text}", ""), MARGIN);
    match &found.outcome {
        CaseOutcome::Ran(findings) => {
            lines[0] += &format!(" ({}, {:.1} s)", count(findings.len(), "check"), found.seconds);
            let failing = findings.iter().filter(|finding| !finding.passes);
            let shown: Vec<&Finding> = match (verbose, found.outcome.passes()) {
                (true, _) => findings.iter().collect(),
                (false, true) => findings.iter().take(1).collect(),
                (false, false) => failing.collect(),
            };
            for Finding { what, expected, got, tolerance, passes } in shown {
                let mark = if *passes { " " } else { "!" };
                lines.push(streams::folded(&format!("          {mark} {what}"), MARGIN));
                lines.push(note(&format!("expected {expected}, got {got}")));
                lines.push(note(&format!("tolerance: {tolerance}")));
            }
            lines.extend(case.awaits_in_part().map(|part| note(&format!("later: {part}"))));
            if !found.outcome.passes() {
                lines.push(note(&format!("pictures: {}", case.meaning)));
            }
        }
        CaseOutcome::ShownBy(program) => lines.push(note(program)),
        CaseOutcome::Awaits(effect) => lines.push(note(&format!("awaits {effect}"))),
        // It says nothing about pictures.
        CaseOutcome::Failed(error) => lines.push(note(error)),
    }
    lines[0] = streams::folded(&lines[0], MARGIN);
    lines
}

fn count(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

fn summary(report: &[CaseReport], seconds: f64) -> String {
    let of = |wanted: Verdict| report.iter().filter(|found| Verdict::of(&found.outcome) == wanted).count();
    let in_part = report.iter().filter(|found| found.case.awaits_in_part().is_some()).count();
    let text = format!(
        "{} passed ({in_part} of them in part), {} failed, {} could not be run, {} shown by the repository's tests, {} for \
         effects to come, in {seconds:.0} s",
        count(of(Verdict::Pass), "case"),
        of(Verdict::Fail),
        of(Verdict::Error),
        of(Verdict::ShownByTests),
        of(Verdict::AwaitsEffect),
    );
    let mut text = format!("\n{}", streams::folded(&text, 0));
    let broken: Vec<String> = report
        .iter()
        .filter(|found| Verdict::of(&found.outcome) == Verdict::Fail)
        .map(|found| format!("\n  case {}: {}", found.case.number, found.case.meaning))
        .collect();
    if !broken.is_empty() {
        text += "\nwhat to expect of pictures from this device:";
        text += &broken.concat();
    }
    text
}

/// What the run says of the device, in one sentence. `whole` is whether all cases were asked for and come to.
fn verdict(report: &[CaseReport], validation: usize, whole: bool) -> String {
    let of = |wanted: Verdict| report.iter().filter(|found| Verdict::of(&found.outcome) == wanted).count();
    let (failed, not_run) = (of(Verdict::Fail), of(Verdict::Error));
    if failed > 0 {
        let means = "its pictures can be wrong in the ways told above";
        return format!("do not trust this device yet: {} failed, and {means}", count(failed, "case"));
    }
    if not_run > 0 {
        return format!("unknown, as {} could not be run; nothing that ran failed", count(not_run, "case"));
    }
    if validation > 0 {
        let messages = count(validation, "message");
        return format!("every case passed, but Vulkan was not used as it should be: {messages} of validation");
    }
    match (whole, of(Verdict::Pass)) {
        (_, 0) => "none, as no case ran on the device".into(),
        (true, _) => "this device can be trusted with pictures: every case that ran passed".into(),
        (false, passed) => {
            format!("{} passed; the device can be trusted as far as that goes", count(passed, "case"))
        }
    }
}

fn case_line(found: &CaseReport) -> CaseLine {
    let (findings, note) = match &found.outcome {
        CaseOutcome::Ran(findings) => (findings.clone(), None),
        CaseOutcome::ShownBy(text) | CaseOutcome::Awaits(text) => (Vec::new(), Some((*text).to_owned())),
        CaseOutcome::Failed(error) => (Vec::new(), Some(error.clone())),
    };
    CaseLine {
        case: found.case.number,
        title: found.case.title,
        verdict: Verdict::of(&found.outcome),
        failure_means: found.case.meaning,
        awaits_in_part: found.case.awaits_in_part(),
        seconds: found.seconds,
        note,
        findings,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ran(outcomes: Vec<CaseOutcome>) -> Vec<CaseReport> {
        let cases = GROUPS.iter().flat_map(|group| group.cases);
        cases.zip(outcomes).map(|(case, outcome)| CaseReport { case, outcome, seconds: 0.1 }).collect()
    }

    #[test]
    fn one_sentence_says_whether_the_device_can_be_trusted() {
        let pass = || CaseOutcome::Ran(vec![Finding::exact("a number", 1, 1)]);
        let fail = || CaseOutcome::Ran(vec![Finding::exact("a number", 1, 2)]);
        let error = || CaseOutcome::Failed("no memory".into());
        let tests = || CaseOutcome::ShownBy("tests/output.rs");
        for (outcomes, validation, whole, words) in [
            (vec![pass(), tests(), pass()], 0, true, "can be trusted with pictures"),
            (vec![pass(), fail(), error()], 1, true, "do not trust this device yet: 1 case failed"),
            (vec![pass(), error()], 0, true, "unknown, as 1 case could not be run"),
            (vec![pass(), pass()], 2, true, "every case passed, but Vulkan was not used as it should be: 2 messages"),
            (vec![pass()], 0, false, "1 case passed; the device can be trusted as far as that goes"),
            (vec![tests()], 0, false, "none, as no case ran"),
        ] {
            let verdict = verdict(&ran(outcomes), validation, whole);
            assert!(verdict.contains(words), "{verdict}");
            assert!(!verdict.contains('\n') && verdict.chars().count() < 160, "{verdict}");
        }
    }
}
