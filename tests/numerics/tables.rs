//! The tables of docs/numerics.md, in Markdown.

use std::fmt::Write;

use texray::render::Guard;
use texray::render::startup;
use texray::selftest::{CaseOutcome, CaseReport, GROUPS, TestBench, Tier, case, run_case};
use texray::statistics::Finding;

use crate::harness::device::{assert_valid, context};

/// Every case at the full tier: how much was looked at, and the first thing of it with its figure.
pub fn cases() -> String {
    let bench = TestBench::new(context(), Tier::Full);
    let mut text = String::new();
    for group in &GROUPS {
        let _ = writeln!(
            text,
            "\n**{} {}**\n\n| case | what fails | checks | of these | expected | got |",
            group.letter, group.name
        );
        text += "|---|---|---|---|---|---|\n";
        for case in group.cases {
            let report = run_case(&bench, case);
            assert!(report.outcome.passes(), "case {}: {:?}", case.number, report.outcome);
            text += &case_row(&report);
        }
    }
    assert_valid(context());
    let _ = writeln!(text, "\nOn {}.", context().device_info().summary());
    text
}

fn case_row(report: &CaseReport) -> String {
    let CaseReport { case, outcome, .. } = report;
    let start = format!("| {} {} | {} |", case.number, cell(case.title), cell(case.meaning));
    let later = case.awaits_in_part().map_or(String::new(), |part| format!("; later: {part}"));
    match outcome {
        CaseOutcome::Ran(findings) => {
            let Finding { what, expected, got, .. } = telling(findings);
            format!("{start} {} | {} | {} | {}{later} |\n", findings.len(), cell(what), cell(expected), cell(got))
        }
        CaseOutcome::ShownBy(test) => format!("{start} | shown by {} | | |\n", cell(test)),
        CaseOutcome::Awaits(effect) => format!("{start} | awaits {} | | |\n", cell(effect)),
        CaseOutcome::Failed(error) => format!("{start} | {} | | |\n", cell(error)),
    }
}

/// The finding to show: the first, or the first after figures of the start-up probe, which `texray devices -v` shows.
fn telling(findings: &[Finding]) -> &Finding {
    findings.iter().find(|finding| finding.what != startup::LOOPS).unwrap_or(&findings[0])
}

/// Every guard, and what its case finds first without it, at the fast tier.
pub fn guards() -> String {
    let bench = TestBench::new(context(), Tier::Fast);
    let mut text =
        "\n| guard | what it does | case | without it | expected | got |\n|---|---|---|---|---|---|\n".to_owned();
    for &guard in Guard::ALL {
        let report = run_case(&bench.without(guard), case(guard.case()).expect("the catalogue has this case"));
        let CaseOutcome::Ran(findings) = &report.outcome else { panic!("{guard:?}: {:?}", report.outcome) };
        let bitten = findings.iter().find(|finding| !finding.passes).expect("the case fails without its guard");
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} |",
            guard.name(),
            cell(guard.purpose()),
            guard.case(),
            cell(&bitten.what),
            cell(&bitten.expected),
            cell(&bitten.got)
        );
    }
    text
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// The document with the table of that name replaced: what stands between its two marks.
pub fn put(document: &str, name: &str, table: &str) -> String {
    let [start, end] = ["table", "end of table"].map(|mark| format!("<!-- {mark}: {name} -->\n"));
    let (before, rest) = document.split_once(&start).expect("the document has the table's mark");
    let (_, after) = rest.split_once(&end).expect("the document has the mark of the table's end");
    format!("{before}{start}{table}\n{end}{after}")
}
