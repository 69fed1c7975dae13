//! Names of the design that do not do anything yet: refused by name rather than as unknown.
//!
//! Comes in: what clap could not parse. Goes out: the name, if it is one of these.

use clap::error::{ContextKind, ContextValue, Error};

const SUBCOMMANDS: [&str; 3] = ["view", "merge", "film"];
const OPTIONS: [&str; 5] = ["--samples", "--adaptive", "--checkpoint", "--checkpoint-every", "--resume"];

/// The subcommand or option that `error` is about, where it is a name not built yet.
pub fn named_by(error: &Error) -> Option<String> {
    let named = |kind, names: &[&str]| match error.get(kind) {
        Some(ContextValue::String(name)) => names.contains(&name.as_str()).then(|| name.clone()),
        _ => None,
    };
    named(ContextKind::InvalidSubcommand, &SUBCOMMANDS).or_else(|| named(ContextKind::InvalidArg, &OPTIONS))
}
