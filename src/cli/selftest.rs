//! `texray selftest`: the hard cases, on the user's own device.
//!
//! Comes in: a device and how much to sample. Goes out: a table on stdout as the cases end, or one JSON document.

use std::time::Instant;

use clap::Args;
use serde::Serialize;
use texray::Result;
use texray::selftest::{CaseReport, Finding, GROUPS, Group, Outcome as Found, Tier};

use super::engine::{DeviceLine, Engine};
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
struct Document {
    schema: u32,
    device: DeviceLine,
    tier: &'static str,
    seconds: f64,
    passes: bool,
    validation: Vec<String>,
    cases: Vec<CaseLine>,
}

#[derive(Serialize)]
struct CaseLine {
    case: u8,
    title: &'static str,
    verdict: &'static str,
    failure_means: &'static str,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
    findings: Vec<Finding>,
}

impl SelftestArgs {
    /// Runs the cases; a failed one is the exit code 1.
    pub fn run(&self) -> Result<Outcome> {
        let started = Instant::now();
        let signals = Signals::watch()?;
        let engine = Engine::open(self.device.as_deref(), self.validation)?;
        if !self.json {
            streams::answer(&format!("device {}", engine.device().summary))?;
        }
        let tier = if self.full { Tier::Full } else { Tier::Fast };
        let wanted = |number: u8| self.cases.is_empty() || self.cases.contains(&number);
        let mut report = Vec::new();
        for group in &GROUPS {
            let mut heading = (!self.json).then(|| heading(group));
            for case in group.cases.iter().filter(|case| wanted(case.number)) {
                if let Some(signal) = signals.received() {
                    return Ok(Outcome::Signal(signal));
                }
                if let Some(heading) = heading.take() {
                    streams::answer(&heading)?;
                }
                let found = engine.run_case(tier, case);
                if !self.json {
                    streams::answer(&lines(&found, self.verbose).join("\n"))?;
                }
                report.push(found);
            }
        }
        let seconds = started.elapsed().as_secs_f64();
        let validation = engine.validation();
        let failed = report.iter().filter(|found| !found.outcome.passes()).count();
        if self.json {
            streams::answer_json(&Document {
                schema: 1,
                device: engine.device().clone(),
                tier: if self.full { "full" } else { "fast" },
                seconds,
                passes: failed == 0 && validation.is_empty(),
                validation: validation.clone(),
                cases: report.iter().map(case_line).collect(),
            })?;
        } else {
            validation.iter().for_each(|message| streams::say(&format!("validation: {message}")));
            streams::answer(&summary(&report, seconds))?;
        }
        Ok(match failed + validation.len() {
            0 => Outcome::Done,
            _ => Outcome::HardCasesFailed,
        })
    }
}

fn heading(group: &Group) -> String {
    format!("\n{}  {}", group.letter, group.name)
}

fn verdict(outcome: &Found) -> &'static str {
    match outcome {
        Found::Ran(_) if outcome.passes() => "ok",
        Found::Ran(_) => "FAIL",
        Found::ShownBy(_) => "tests",
        Found::Awaits(_) => "later",
        Found::Failed(_) => "ERROR",
    }
}

/// A case: its line, what was looked at, and what a failure means.
fn lines(found: &CaseReport, verbose: bool) -> Vec<String> {
    let case = found.case;
    let mut lines = vec![format!("{:3}  {:5}  {}", case.number, verdict(&found.outcome), case.title)];
    match &found.outcome {
        Found::Ran(findings) => {
            lines[0] += &format!(" ({}, {:.1} s)", count(findings.len(), "check"), found.seconds);
            let failing = findings.iter().filter(|finding| !finding.passes);
            let shown: Vec<&Finding> = match (verbose, found.outcome.passes()) {
                (true, _) => findings.iter().collect(),
                (false, true) => findings.iter().take(1).collect(),
                (false, false) => failing.collect(),
            };
            lines.extend(shown.into_iter().flat_map(finding_lines));
        }
        Found::ShownBy(program) => lines.push(format!("            {program}")),
        Found::Awaits(effect) => lines.push(format!("            awaits {effect}")),
        Found::Failed(error) => lines.push(format!("            {error}")),
    }
    if !found.outcome.passes() {
        lines.push(format!("            pictures: {}", case.meaning));
    }
    lines
}

fn finding_lines(finding: &Finding) -> [String; 2] {
    let mark = if finding.passes { " " } else { "!" };
    [
        format!("          {mark} {}", finding.what),
        format!("            expected {}, got {}; tolerance: {}", finding.expected, finding.got, finding.tolerance),
    ]
}

fn count(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

fn summary(report: &[CaseReport], seconds: f64) -> String {
    let of = |wanted: &[&str]| report.iter().filter(|found| wanted.contains(&verdict(&found.outcome))).count();
    let mut text = format!(
        "\n{} passed, {} failed, {} shown by the repository's tests, {} for effects to come, in {seconds:.0} s",
        count(of(&["ok"]), "case"),
        of(&["FAIL", "ERROR"]),
        of(&["tests"]),
        of(&["later"]),
    );
    let broken: Vec<String> = report
        .iter()
        .filter(|found| !found.outcome.passes())
        .map(|found| format!("\n  case {}: {}", found.case.number, found.case.meaning))
        .collect();
    if !broken.is_empty() {
        text += "\nwhat to expect of pictures from this device:";
        text += &broken.concat();
    }
    text
}

fn case_line(found: &CaseReport) -> CaseLine {
    let (findings, note) = match &found.outcome {
        Found::Ran(findings) => (findings.clone(), None),
        Found::ShownBy(text) | Found::Awaits(text) => (Vec::new(), Some((*text).to_owned())),
        Found::Failed(error) => (Vec::new(), Some(error.clone())),
    };
    CaseLine {
        case: found.case.number,
        title: found.case.title,
        verdict: match verdict(&found.outcome) {
            "ok" => "pass",
            "FAIL" => "fail",
            "tests" => "shown_by_tests",
            "later" => "awaits_effect",
            _ => "error",
        },
        failure_means: found.case.meaning,
        seconds: found.seconds,
        note,
        findings,
    }
}
