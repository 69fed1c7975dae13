//! Pictures side by side, under a slider, and as differences from one of them.
//!
//! Comes in: [`Pictures`] of linear radiance. Goes out: a figure: a stage on which any two are compared and magnified
//! (page.js), then all of them in a row. A picture is in the page once, as PNG: the stage borrows from the row.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use crate::compare::difference::{Difference, LEGEND};
use crate::output::{Display, Metadata, Picture, encode_png};

/// Pictures to hold against each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pictures {
    /// What is shown.
    pub title: String,
    /// In order.
    pub pictures: Vec<NamedPicture>,
    /// Index of the one that the others are held against: each other of its size gets a difference image.
    pub reference: Option<usize>,
}

/// A picture and what it is of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedPicture {
    /// What it is of.
    pub name: String,
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Linear radiance, in rows from the top.
    pub rgb: Vec<[f32; 3]>,
}

/// A picture as it stands in the page, or why it cannot.
struct Shown {
    name: String,
    size: [u32; 2],
    png: Result<Vec<u8>, String>,
    note: String,
}

impl Pictures {
    /// The figure; `id` is unique on the page.
    pub(super) fn markup(&self, id: &str) -> Markup {
        let plain: Vec<Shown> = self.pictures.iter().map(|picture| self.shown(picture)).collect();
        let differences = self.differences();
        let drawn = |shown: &&Shown| shown.png.is_ok();
        let stage = plain.iter().chain(&differences).filter(drawn).count() > 1;
        html! {
            figure.pictures id=(id) {
                figcaption { (self.title) }
                @if plain.is_empty() { p.gap { "No pictures." } }
                @if stage { div.compare data-compare="" hidden {} }
                div.row { @for shown in &plain { (tile(shown)) } }
                @if !differences.is_empty() {
                    p.note { "Below: " (LEGEND) "." }
                    div.row { @for shown in &differences { (tile(shown)) } }
                }
            }
        }
    }

    fn shown(&self, picture: &NamedPicture) -> Shown {
        let bad = picture.rgb.iter().filter(|rgb| rgb.iter().any(|channel| !channel.is_finite())).count();
        let note = if bad > 0 { format!("{} (not-a-numbers show black)", not_finite(bad)) } else { String::new() };
        Shown { name: picture.name.clone(), size: [picture.width, picture.height], png: encode(picture), note }
    }

    fn differences(&self) -> Vec<Shown> {
        let Some((at, reference)) = self.reference.and_then(|at| Some((at, self.pictures.get(at)?))) else {
            return Vec::new();
        };
        let others = self.pictures.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, other)| other);
        others.map(|picture| difference(picture, reference)).collect()
    }
}

fn encode(picture: &NamedPicture) -> Result<Vec<u8>, String> {
    let whole = Picture::new(picture.width, picture.height, None, picture.rgb.clone());
    encode_png(&whole.map_err(|error| error.to_string())?, &Display::default(), &Metadata::new())
}

fn difference(picture: &NamedPicture, reference: &NamedPicture) -> Shown {
    let size = [picture.width, picture.height];
    let same = size == [reference.width, reference.height];
    let found = Difference::of(&picture.rgb, &reference.rgb).filter(|_| same);
    let (png, note) = match found {
        Some(found) if found.not_finite > 0 => (found.png(size[0], size[1]), not_finite(found.not_finite)),
        Some(found) => (found.png(size[0], size[1]), String::new()),
        None => (Err("no difference image: the sizes differ".into()), String::new()),
    };
    Shown { name: format!("{} against {}", picture.name, reference.name), size, png, note }
}

fn not_finite(pixels: usize) -> String {
    if pixels == 1 { "1 pixel is not finite".into() } else { format!("{pixels} pixels are not finite") }
}

fn tile(shown: &Shown) -> Markup {
    html! {
        div.tile style=(format!("width: {}px", shown.size[0])) {
            @match &shown.png {
                Ok(png) => img src=(format!("data:image/png;base64,{}", STANDARD.encode(png))) alt=(shown.name)
                    width=(shown.size[0]) height=(shown.size[1]);,
                Err(why) => p.gap { (why) },
            }
            span { (shown.name) @if !shown.note.is_empty() { em.gap { " " (shown.note) } } }
        }
    }
}
