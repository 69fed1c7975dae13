//! The report of a folder: every study whose rows are in it.
//!
//! Comes in: a folder of rows and pictures, what made the newest of them. Goes out: `report.html` in that folder. Rows of another
//! program or device are left out.

use std::path::Path;

use super::{Kind, Origin, Rows};
use crate::Result;
use crate::output::write_whole;
use crate::report::Report;

/// Name of the report's file.
pub const FILE: &str = "report.html";

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
    let studied: Vec<(Kind, Rows)> = Kind::ALL
        .into_iter()
        .filter_map(|kind| Some((kind, Rows::read(folder, kind.name())?)))
        .filter(|(_, rows)| rows.origin().agrees(origin) && !rows.all().is_empty())
        .collect();
    let measurements: usize = studied.iter().map(|(_, rows)| rows.all().len()).sum();
    let lead = format!(
        "What accuracy costs in time on {}, from {measurements} measurements; the raw rows are beside this file. Errors are relative: \
         of a pixel's difference to its reference over the reference, where 0.1 counts as dark.",
        origin.device
    );
    Report {
        title: "What accuracy costs in time".into(),
        lead: vec![lead],
        facts: facts.into_iter().map(|(name, value)| (name.into(), value)).collect(),
        sections: studied
            .into_iter()
            .map(|(kind, rows)| kind.account(&rows, folder).section(kind.name(), kind.title(), &rows.origin().command))
            .collect(),
    }
}
