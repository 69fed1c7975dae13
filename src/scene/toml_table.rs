//! Tables of a scene file, read key by key.
//!
//! Comes in: the text of a `.toml` file. Goes out: checked values, each refusal with the line of its key, the value as
//! the file has it and what is allowed. Every table tells which of its keys are not known.

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::nearest::known_names;
use super::number::MAX_MAGNITUDE;
use super::toml_source::Source;
use crate::quote::{self, quoted};
use crate::{Error, Result};

/// One table.
#[derive(Clone, Copy)]
pub(super) struct Table<'a> {
    source: &'a Source<'a>,
    /// As messages name it: `[camera]`.
    name: &'a str,
    /// Its line, from 1.
    pub line: usize,
    entries: &'a DeTable<'a>,
}

/// A value with its key.
#[derive(Clone, Copy)]
pub(super) struct Entry<'a> {
    source: &'a Source<'a>,
    key: &'a str,
    /// Line of the value, from 1.
    pub line: usize,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Table<'a> {
    /// The whole file as a table.
    pub(super) fn root(source: &'a Source<'a>, root: &'a Spanned<DeTable<'a>>) -> Table<'a> {
        Table { source, name: "the file", line: 1, entries: root.get_ref() }
    }

    /// A refusal of each key that is neither `known` nor `unbuilt`; it offers the `known` ones.
    pub(super) fn unknown_keys(&self, known: &[&str], unbuilt: &[&str]) -> Vec<Error> {
        let is_in = |keys: &[&str], key: &Spanned<_>| keys.contains(&AsRef::<str>::as_ref(Spanned::get_ref(key)));
        let unknown = |key: &&Spanned<_>| !is_in(known, key) && !is_in(unbuilt, key);
        let refusal = |key: &Spanned<_>| {
            let name: &str = AsRef::<str>::as_ref(Spanned::<std::borrow::Cow<'a, str>>::get_ref(key));
            let allowed = known_names(name, known.iter().copied(), "the nearest known key is", "allowed are");
            let allowed = allowed.unwrap_or_default();
            let message = format!("unknown key {} in {}; {allowed}", quoted(name), self.name);
            Error::scene(self.source.path, self.source.line(key.span().start), message)
        };
        self.entries.keys().filter(unknown).map(refusal).collect()
    }

    /// The value of `key`, if the table has it.
    pub(super) fn get(&self, key: &str) -> Option<Entry<'a>> {
        let (key, value) = self.entries.iter().find(|(known, _)| known.get_ref() == key)?;
        let line = self.source.line(value.span().start);
        Some(Entry { source: self.source, key: key.get_ref(), line, value })
    }

    /// The value of `key`; a table without it is refused.
    pub(super) fn need(&self, key: &str) -> Result<Entry<'a>> {
        self.get(key).ok_or_else(|| self.refuse(format!("{} lacks the key \"{key}\"", self.name)))
    }

    /// A refusal of each of `keys` that is there: they are known, and a later version will read them.
    pub(super) fn unbuilt_keys(&self, keys: &[&str]) -> Vec<Error> {
        let refusal =
            |entry: Entry| entry.error(format!("\"{}\" is not built yet; allowed is to leave it out", entry.key));
        keys.iter().filter_map(|key| self.get(key)).map(refusal).collect()
    }

    /// Keys and values in the order of the file.
    pub(super) fn entries(&self) -> Vec<Entry<'a>> {
        let source = self.source;
        let entry = |(key, value): (&'a Spanned<_>, &'a Spanned<DeValue<'a>>)| Entry {
            source,
            key: AsRef::<str>::as_ref(Spanned::<std::borrow::Cow<'a, str>>::get_ref(key)),
            line: source.line(value.span().start),
            value,
        };
        let mut entries = self.entries.iter().map(entry).collect::<Vec<_>>();
        entries.sort_by_key(|entry| entry.value.span().start);
        entries
    }

    /// A refusal of the table as a whole.
    pub(super) fn refuse(&self, message: String) -> Error {
        Error::scene(self.source.path, self.line, message)
    }
}

impl<'a> Entry<'a> {
    /// The key.
    pub(super) fn key(&self) -> &'a str {
        self.key
    }

    /// A refusal at this entry's line.
    pub(super) fn error(&self, message: String) -> Error {
        Error::scene(self.source.path, self.line, message)
    }

    /// A refusal that quotes the value and states what is allowed.
    pub(super) fn refuse(&self, allowed: &str) -> Error {
        self.error(format!("{} = {}; allowed is {allowed}", self.key, self.written()))
    }

    /// The value as the file has it, on one line and cut after 40 characters.
    fn written(&self) -> String {
        let text = self.source.text.get(self.value.span()).unwrap_or_default();
        // More words than characters that are shown need not be joined.
        let words = text.split_ascii_whitespace().take(quote::MOST_SHOWN).collect::<Vec<_>>();
        quote::shown(&words.join(" "))
    }

    /// A table; who reads it refuses its unknown keys ([`Table::unknown_keys`]).
    pub(super) fn table(&self, name: &'a str) -> Result<Table<'a>> {
        match self.value.get_ref() {
            DeValue::Table(entries) => Ok(Table { source: self.source, name, line: self.line, entries }),
            _ => Err(self.refuse(&format!("a table {name}"))),
        }
    }

    /// The items of an array.
    pub(super) fn items(&self, allowed: &str) -> Result<Vec<Entry<'a>>> {
        let DeValue::Array(items) = self.value.get_ref() else { return Err(self.refuse(allowed)) };
        let item =
            |value: &'a Spanned<DeValue<'a>>| Entry { line: self.source.line(value.span().start), value, ..*self };
        Ok(items.iter().map(item).collect())
    }

    /// A text.
    pub(super) fn text(&self, allowed: &str) -> Result<&'a str> {
        self.value.get_ref().as_str().ok_or_else(|| self.refuse(allowed))
    }

    /// A finite number, integer or not.
    fn finite(&self) -> Option<f64> {
        let number = match self.value.get_ref() {
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64),
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            _ => None,
        };
        number.filter(|number| number.abs() <= MAX_MAGNITUDE)
    }

    /// Whether the value is a number, in range or not.
    pub(super) fn is_number(&self) -> bool {
        self.value.get_ref().is_integer() || self.value.get_ref().is_float()
    }

    /// A number that `fits`.
    pub(super) fn number(&self, allowed: &str, fits: impl Fn(f64) -> bool) -> Result<f64> {
        self.finite().filter(|&number| fits(number)).ok_or_else(|| self.refuse(allowed))
    }

    /// An integer from `least` to `most`.
    pub(super) fn integer(&self, least: u32, most: u32) -> Result<u32> {
        let refusal = || self.refuse(&format!("an integer from {least} to {most}"));
        let DeValue::Integer(integer) = self.value.get_ref() else { return Err(refusal()) };
        let value =
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().and_then(|value| u32::try_from(value).ok());
        value.filter(|value| (least..=most).contains(value)).ok_or_else(refusal)
    }

    /// `N` numbers that all `fit`.
    pub(super) fn numbers<const N: usize>(&self, allowed: &str, fits: impl Fn(f64) -> bool) -> Result<[f64; N]> {
        let items = self.items(allowed)?;
        if items.len() != N {
            return Err(self.refuse(allowed));
        }
        let mut values = [0.0; N];
        for (value, item) in values.iter_mut().zip(&items) {
            *value = item.finite().filter(|&number| fits(number)).ok_or_else(|| self.refuse(allowed))?;
        }
        Ok(values)
    }

    /// A point or direction.
    pub(super) fn vector(&self) -> Result<DVec3> {
        self.numbers("[x, y, z] of finite numbers up to 1e100", |_| true).map(DVec3::from_array)
    }

    /// A direction of some length.
    pub(super) fn direction(&self) -> Result<DVec3> {
        let allowed = "[x, y, z] of finite numbers up to 1e100, not all zero";
        let direction = DVec3::from_array(self.numbers(allowed, |_| true)?);
        if direction == DVec3::ZERO {
            return Err(self.refuse(allowed));
        }
        Ok(direction)
    }

    /// The words that a statement of an MTL file would have for this value: numbers as written, without brackets.
    pub(super) fn words(&self, count: usize) -> Result<Vec<String>> {
        if count == 1 {
            return match self.is_number() {
                true => Ok(vec![self.word()]),
                false => Err(self.refuse("a number")),
            };
        }
        let allowed = format!("an array of {count} numbers");
        let items = self.items(&allowed)?;
        match items.len() == count && items.iter().all(Entry::is_number) {
            true => Ok(items.iter().map(Entry::word).collect()),
            false => Err(self.refuse(&allowed)),
        }
    }

    /// One number as a word: decimal, as TOML's underscores and hexadecimals are not known elsewhere.
    fn word(&self) -> String {
        self.finite().map_or_else(|| self.written(), |number| format!("{number}"))
    }
}
