//! Rows of text under headings.

use maud::{Markup, html};

/// Rows of text; a cell that is missing or empty is shown as a dash.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Headings, one a column.
    pub columns: Vec<String>,
    /// Cells, a row each.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The table; `label` says what it is of.
    pub(super) fn markup(&self, label: &str) -> Markup {
        let columns = self.rows.iter().map(Vec::len).fold(self.columns.len(), usize::max);
        let cell = |row: &[String], i: usize| row.get(i).filter(|cell| !cell.trim().is_empty()).cloned();
        html! {
            @if self.rows.is_empty() { p.gap { "No rows." } }
            @else {
                div.scroll tabindex="0" role="region" aria-label=(label) {
                    table {
                        thead { tr { @for i in 0..columns {
                            th scope="col" .num[self.is_numeric(i)] { (cell(&self.columns, i).unwrap_or_default()) }
                        } } }
                        tbody { @for row in &self.rows { tr { @for i in 0..columns {
                            td .num[self.is_numeric(i)] { (cell(row, i).unwrap_or_else(|| "–".into())) }
                        } } } }
                    }
                }
            }
        }
    }

    /// Whether every cell of a column that says something begins as a number does.
    fn is_numeric(&self, column: usize) -> bool {
        let starts =
            |cell: &str| cell.trim_start_matches(['-', '−', '+', '±', '~']).starts_with(|c: char| c.is_ascii_digit());
        let mut cells =
            self.rows.iter().filter_map(|row| row.get(column)).filter(|cell| !cell.trim().is_empty()).peekable();
        cells.peek().is_some() && cells.all(|cell| starts(cell))
    }
}

/// The numbers of a figure, folded away.
pub(super) fn numbers(title: &str, table: &Table) -> Markup {
    html! { details { summary { "The numbers" } (table.markup(&format!("Numbers: {title}"))) } }
}
