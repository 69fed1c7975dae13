//! Names of the design that do not do anything yet: refused by name rather than as unknown.
//!
//! Comes in: a name that clap does not know. Goes out: the refusal, if it is one of these.

const SUBCOMMANDS: [&str; 3] = ["view", "merge", "film"];
const OPTIONS: [&str; 4] = ["--adaptive", "--checkpoint", "--checkpoint-every", "--resume"];

/// The refusal of a subcommand that is not built yet.
pub fn command(name: &str) -> Option<String> {
    SUBCOMMANDS.contains(&name).then(|| refusal(name))
}

/// The refusal of an option that is not built yet.
pub fn option(name: &str) -> Option<String> {
    OPTIONS.contains(&name).then(|| refusal(name))
}

/// The refusal of anything.
pub fn refusal(name: &str) -> String {
    format!("{name} is not built yet")
}
