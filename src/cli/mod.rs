//! The command line: arguments to a checked request, the library's answer to text, JSON and files.
//!
//! Comes in: the process's arguments. Goes out: an [`Outcome`] or a [`Failure`], which `main` turns into an exit code.
//! One file a subcommand.

mod bias;
mod choices;
mod compare;
mod devices;
mod document;
mod dry_run;
mod engine;
mod explain;
mod limits;
mod meant;
mod not_built;
mod outputs;
mod parse;
pub mod process;
mod progress;
mod render;
mod save;
mod selftest;
mod settings;
mod shell;
mod signals;
mod stop;
pub mod streams;
mod study;
mod summary;
mod threads;

use std::time::Instant;

use clap::{Parser, Subcommand};

/// How a command that did not fail ended.
pub enum Outcome {
    /// Everything asked for is done.
    Done,
    /// `--target-error` is not met: in words; pictures are saved.
    TargetMissed(String),
    /// `--strict`, and this many samples were left out; pictures are saved.
    InvalidSamples(u64),
    /// A self-test found that the device, or texray on it, does not compute what it should.
    HardCasesFailed,
    /// A picture is further from its reference than the limits given allow: the limits that are not kept, in words.
    LimitsExceeded(Vec<String>),
    /// The render is done, and some of its files could not be written, which it has said; all others are.
    NotWritten,
    /// Stopped by this signal; what there was is saved.
    Signal(u8),
}

/// Why a command failed.
pub enum Failure {
    /// The arguments cannot be parsed, or ask for help or the version.
    Arguments(clap::Error),
    /// Anything else.
    Command(texray::Error),
}

impl From<texray::Error> for Failure {
    fn from(error: texray::Error) -> Failure {
        Failure::Command(error)
    }
}

/// A Monte Carlo path tracer that drives Vulkan compute shaders directly.
#[derive(Parser)]
#[command(name = "texray", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Explain(explain::ExplainArgs),
    Devices(devices::DevicesArgs),
    Selftest(selftest::SelftestArgs),
    Study(study::StudyArgs),
    Compare(compare::CompareArgs),
}

/// Runs the command that the process was started with, at `started`.
pub fn run(started: Instant) -> Result<Outcome, Failure> {
    // Before anything can begin a thread.
    threads::share_out()?;
    signals::survive_large_files();
    let arguments = Arguments::try_parse().map_err(|error| {
        let typed: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
        match meant::of(&error, &typed) {
            Some(sentence) => Failure::Command(texray::Error::Usage(sentence)),
            None => Failure::Arguments(error),
        }
    })?;
    let outcome = match arguments.command {
        Command::Render(arguments) => arguments.run(started)?,
        Command::Explain(arguments) => arguments.run()?,
        Command::Devices(arguments) => arguments.run()?,
        Command::Selftest(arguments) => arguments.run()?,
        Command::Study(arguments) => arguments.run()?,
        Command::Compare(arguments) => arguments.run()?,
    };
    Ok(outcome)
}
