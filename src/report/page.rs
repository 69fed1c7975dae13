//! The page: heading, facts, contents, sections, with style and script inside.

use std::collections::BTreeSet;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Block, Report, Section};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Nothing is fetched: pictures are in the page, as are style and script.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The whole page.
pub(super) fn html(report: &Report) -> Markup {
    let ids = ids(&report.sections);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (report.title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    button #theme type="button" hidden { "Light or dark" }
                    h1 { (report.title) }
                    @if !report.findings.is_empty() {
                        ul.opening { @for sentence in &report.findings { li { (sentence) } } }
                    }
                    @for paragraph in &report.lead { p.lead { (paragraph) } }
                    @if !report.facts.is_empty() {
                        dl { @for (name, value) in &report.facts { div { dt { (name) } dd { (value) } } } }
                    }
                }
                @if report.sections.len() > 1 {
                    nav aria-label="Contents" {
                        ol { @for (section, id) in report.sections.iter().zip(&ids) {
                            li { a href=(format!("#{id}")) { (section.title) } }
                        } }
                    }
                }
                main {
                    @if report.sections.is_empty() { p.gap { "Nothing was measured." } }
                    @for (section, id) in report.sections.iter().zip(&ids) { (section_markup(section, id)) }
                }
                div #tip role="status" hidden {}
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn section_markup(section: &Section, id: &str) -> Markup {
    html! {
        section id=(id) aria-labelledby=(format!("{id}-title")) {
            h2 id=(format!("{id}-title")) { (section.title) }
            @for sentence in &section.finding { p.finding { (sentence) } }
            @for (i, block) in section.blocks.iter().enumerate() {
                (block_markup(block, &section.title, &format!("{id}-{}", i + 1)))
            }
            @if !section.command.is_empty() {
                p.note { "Remade by" }
                pre.command { code { (section.command) } }
            }
        }
    }
}

fn block_markup(block: &Block, title: &str, id: &str) -> Markup {
    match block {
        Block::Chart(chart) => chart.markup(id),
        Block::Bars(bars) => bars.markup(id),
        Block::Table(table) => table.markup(title),
        Block::Pictures(pictures) => pictures.markup(id),
        Block::Text(text) => html! { p { (text) } },
    }
}

/// An anchor a section: its id of letters, digits, `-` and `_`, made unique.
fn ids(sections: &[Section]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut ids = Vec::new();
    for section in sections {
        let plain: String = section.id.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '-' }).collect();
        let plain = if plain.is_empty() { "section".into() } else { plain };
        let mut id = plain.clone();
        let mut next = 2;
        while !taken.insert(id.clone()) {
            id = format!("{plain}--{next}");
            next += 1;
        }
        ids.push(id);
    }
    ids
}
