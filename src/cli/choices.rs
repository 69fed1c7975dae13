//! Values of options that are a choice of a few, with their help, made from the names that the library states.
//!
//! Comes in: a [`Named`] choice, or the list of studies. Goes out: clap's parser of it.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use texray::named::Named;
use texray::study::{Kind, named, studies};

/// The word for all studies.
const ALL: &str = "all";

/// What to study.
#[derive(Clone, Copy)]
pub enum What {
    /// One study.
    One(&'static Kind),
    /// All of them.
    All,
}

/// The parser of a choice.
pub fn of<T: Named>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|value| possible(value.name(), value.help()));
    PossibleValuesParser::new(values).try_map(|name| T::of_name(&name).ok_or(format!("no value is named {name}")))
}

/// The name of a choice's default.
pub fn default<T: Named + Default>() -> &'static str {
    T::default().name()
}

/// The parser of a study's name.
pub fn study() -> impl TypedValueParser<Value = What> {
    let values = studies::ALL.iter().map(|kind| possible(kind.name, kind.help));
    let all = possible(ALL, "All of them, one after the other");
    PossibleValuesParser::new(values.chain([all])).try_map(|name| match name.as_str() {
        ALL => Ok(What::All),
        name => named(name).map(What::One).ok_or(format!("no study is named {name}")),
    })
}

/// A value with its help, which ends without a full stop like all help.
fn possible(name: &'static str, help: &'static str) -> PossibleValue {
    PossibleValue::new(name).help(help.strip_suffix('.').unwrap_or(help))
}
