//! The report of a folder: every study whose rows are in it.
//!
//! Comes in: a folder of rows and pictures, what made the newest of them. Goes out: `report.html` in that folder. Rows of another
//! program or device are left out.

use std::path::Path;

use super::engine::{Kind, Origin, Rows};
use super::studies;
use crate::Result;
use crate::output::write_whole;
use crate::report::Report;

/// Name of the report's file.
pub const FILE: &str = "report.html";

/// Sentences that the report opens with.
const OPENING: usize = 5;

/// Writes the report.
pub fn write(folder: &Path, origin: &Origin) -> Result<()> {
    write_whole(&folder.join(FILE), false, report(folder, origin).to_html().as_bytes())
}

fn report(folder: &Path, origin: &Origin) -> Report {
    let facts = [
        ("device", origin.device.clone()),
        ("driver", origin.driver.clone()),
        ("processor cores", origin.cores.to_string()),
        ("texray", origin.version.clone()),
        ("kernel", origin.kernel.clone()),
    ];
    let studied: Vec<(&Kind, Rows)> = studies::ALL
        .iter()
        .filter_map(|kind| Some((kind, Rows::read(folder, kind.name)?)))
        .filter(|(_, rows)| rows.origin().agrees(origin) && !rows.all().is_empty())
        .collect();
    let measurements: usize = studied.iter().map(|(_, rows)| rows.all().len()).sum();
    let lead = format!(
        "From {measurements} measurements on {}; the raw rows are beside this file. Errors are relative: of a pixel's \
         difference to \
         its reference over the reference, where 0.1 counts as dark. \"The default\" is what `texray render` does \
         unless it is told \
         otherwise.",
        origin.device
    );
    let summaries: Vec<_> = studied.iter().map(|(kind, rows)| (*kind, rows, (kind.summary)(rows, folder))).collect();
    let findings = opening(&summaries.iter().map(|(_, _, summary)| summary.plain.as_slice()).collect::<Vec<_>>());
    Report {
        title: "What accuracy costs in time".into(),
        findings,
        lead: vec![lead],
        facts: facts.into_iter().map(|(name, value)| (name.into(), value)).collect(),
        sections: summaries
            .into_iter()
            .map(|(kind, rows, summary)| summary.section(kind.name, kind.title, rows.remade_by()))
            .collect(),
    }
}

/// The first sentence of each study, then the second of each, and so on, as far as [`OPENING`] goes; in the order of
/// the studies.
fn opening(plain: &[&[String]]) -> Vec<String> {
    let longest = plain.iter().map(|sentences| sentences.len()).max().unwrap_or(0);
    let turns = (0..longest).flat_map(|turn| (0..plain.len()).map(move |study| (study, turn)));
    let mut chosen: Vec<(usize, usize)> =
        turns.filter(|&(study, turn)| turn < plain[study].len()).take(OPENING).collect();
    chosen.sort_unstable();
    chosen.into_iter().map(|(study, turn)| plain[study][turn].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::opening;

    #[test]
    fn the_page_opens_with_five_sentences_of_as_many_studies_as_there_are() {
        let study = |name: &str, count: usize| (0..count).map(|i| format!("{name}{i}")).collect::<Vec<_>>();
        let (a, b, c) = (study("a", 3), study("b", 1), study("c", 9));
        assert_eq!(opening(&[&a, &b, &c]), ["a0", "a1", "b0", "c0", "c1"]);
        assert_eq!(opening(&[&c]), ["c0", "c1", "c2", "c3", "c4"]);
        assert!(opening(&[&[], &b]).len() == 1 && opening(&[]).is_empty());
    }
}
