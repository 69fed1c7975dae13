//! The report: findings, charts and pictures as one HTML page that needs nothing else.
//!
//! Comes in: a [`Report`] of plain values; this module knows nothing of studies or renders. Goes out: the text of one
//! file ([`Report::to_html`]), which opens without a network, in light and dark, with and without scripts. The page is
//! a function of the report alone. What is missing or is not a number leaves a gap that is stated in words beside the
//! chart; it never breaks the page.
//!
//! ```text
//! chart, bars, table, pictures   what a section shows, and the markup of each
//! fit                            a power law through a chart's points
//! axis, number                   where a value lies in a chart, and how it is written
//! page                           all of it as one page; page.css and page.js go into it
//! ```

pub mod axis;
pub mod bars;
pub mod chart;
mod chart_marks;
pub mod fit;
mod number;
mod page;
pub mod pictures;
pub mod table;

pub use axis::{Axis, Scale};
pub use bars::{Bar, Bars};
pub use chart::{Chart, Point, Series};
pub use fit::Fit;
pub use pictures::{NamedPicture, Pictures};
pub use table::Table;

/// A whole page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What the page is about; its heading and title.
    pub title: String,
    /// Sentences that say what was found, in plain words.
    pub findings: Vec<String>,
    /// Paragraphs that say what the page is about.
    pub lead: Vec<String>,
    /// Names and values of the circumstances: device, driver, version, command. A date is among them only if given.
    pub facts: Vec<(String, String)>,
    /// What was found, in order.
    pub sections: Vec<Section>,
}

/// One finding with its figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Anchor of the section, unique in the report; characters that are no letters, digits, `-` or `_` become `-`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Sentences that state the finding with its number.
    pub finding: Vec<String>,
    /// The command that remakes the section's figures; empty where there is none.
    pub command: String,
    /// Figures, in order.
    pub blocks: Vec<Block>,
}

/// One figure of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Series of points in a plane.
    Chart(Chart),
    /// Values by name.
    Bars(Bars),
    /// Rows of text.
    Table(Table),
    /// Pictures to hold against each other.
    Pictures(Pictures),
    /// A paragraph.
    Text(String),
}

impl Report {
    /// The page, UTF-8, self-contained.
    pub fn to_html(&self) -> String {
        page::html(self).into_string()
    }
}
