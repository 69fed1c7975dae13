//! What rows say: sentences with their numbers, tables, and figures for the report.
//!
//! Comes in: findings, tables and figures of a study. Goes out: lines of at most 80 columns for a terminal, and a section of the
//! report.

use crate::report::{self, Block, Section};

/// Columns of a terminal.
const COLUMNS: usize = 80;

/// What a study found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Lines of at most 80 columns that need no more setting; on a terminal alone.
    pub text: Vec<String>,
    /// Sentences that state a finding with its number.
    pub findings: Vec<String>,
    /// The same in plain words, for who reads nothing else; what matters most comes first. For the report alone.
    pub plain: Vec<String>,
    parts: Vec<Part>,
}

/// What the findings rest on.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    /// For terminal and report.
    Table(Table),
    /// For the report alone.
    Figure(Block),
}

/// A table of short cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What it shows, with the conditions.
    pub title: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Rows, as many cells each as the head has.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(title: impl Into<String>, head: &[&str]) -> Table {
        Table { title: title.into(), head: head.iter().map(|&name| name.into()).collect(), rows: Vec::new() }
    }

    /// Title and rows, columns as wide as their widest cell; the first is flush left, the others right.
    pub fn lines(&self) -> Vec<String> {
        let all = || std::iter::once(&self.head).chain(&self.rows);
        let columns = self.head.len();
        let width =
            |column: usize| all().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let line = |row: &Vec<String>| {
            let mut text = String::from("  ");
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let padding = " ".repeat(width - cell.chars().count());
                text += &if column == 0 { format!("{cell}{padding}") } else { format!("  {padding}{cell}") };
            }
            text.trim_end().to_owned()
        };
        let mut lines = wrapped(&self.title, "", "");
        lines.extend(all().map(line));
        lines
    }
}

impl Summary {
    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.parts.push(Part::Table(table));
    }

    /// Adds a chart, bars or pictures.
    pub fn figure(&mut self, block: Block) {
        self.parts.push(Part::Figure(block));
    }

    /// Adds what another summary says.
    pub fn extend(&mut self, other: Summary) {
        self.text.extend(other.text);
        self.findings.extend(other.findings);
        self.plain.extend(other.plain);
        self.parts.extend(other.parts);
    }

    /// The tables, in order.
    pub fn tables(&self) -> Vec<&Table> {
        self.parts.iter().filter_map(|part| if let Part::Table(table) = part { Some(table) } else { None }).collect()
    }

    /// Text, tables, then findings, in lines of a terminal. A table is as wide as its cells.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = self.text.clone();
        for table in self.tables() {
            lines.extend(table.lines());
            lines.push(String::new());
        }
        lines.extend(self.findings.iter().flat_map(|finding| wrapped(finding, "- ", "  ")));
        lines
    }

    /// The section of a report that says the same.
    pub fn section(self, id: &str, title: &str, command: &str) -> Section {
        let mut blocks = Vec::new();
        for part in self.parts {
            match part {
                Part::Figure(block) => blocks.push(block),
                Part::Table(table) => {
                    // The report has a mark of its own for what is missing.
                    let cell = |cell: String| if cell == "-" { String::new() } else { cell };
                    let rows = table.rows.into_iter().map(|row| row.into_iter().map(cell).collect()).collect();
                    blocks.push(Block::Text(table.title));
                    blocks.push(Block::Table(report::Table { columns: table.head, rows }));
                }
            }
        }
        Section { id: id.into(), title: title.into(), finding: self.findings, command: command.into(), blocks }
    }
}

/// `text` broken between words.
fn wrapped(text: &str, first: &str, rest: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for word in text.split_whitespace() {
        if !empty && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            lines.push(std::mem::replace(&mut line, rest.to_owned()));
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line += word;
        empty = false;
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_line_up_and_sentences_wrap() {
        let mut table = Table::new("Time by cap", &["cap", "seconds"]);
        table.rows = vec![vec!["1".into(), "0.25".into()], vec!["15".into(), "4".into()]];
        let finding = "Each bounce more costs a little less than the one before, as fewer paths live to see it at all.";
        let mut summary = Summary { findings: vec![finding.into()], ..Summary::default() };
        summary.table(table);
        let lines = summary.lines();
        assert_eq!(lines[..5], ["Time by cap", "  cap  seconds", "  1       0.25", "  15         4", ""]);
        assert!(lines[5].starts_with("- Each") && lines[6].starts_with("  ") && lines.len() == 7);
        assert!(lines.iter().all(|line| line.chars().count() <= COLUMNS));
        let section = summary.section("caps", "Caps", "texray study bounces");
        assert_eq!((section.blocks.len(), section.finding.len()), (2, 1));
    }
}
