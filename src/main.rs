//! The `texray` program: run one command, print the error, set the exit code.
//!
//! Exit codes: 0 done, 1 internal, a failed self-test or a limit of `compare` not kept, 2 usage, 3 bad scene or input, 4 no usable device or device lost,
//! 5 output, 6 `--target-error` or `--max-bias` not met (pictures saved), 7 invalid samples under `--strict`, 128 + n after signal n (129, 130, 143), with the picture saved.

#![deny(unsafe_code)]

mod cli;

use std::error::Error;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::time::Instant;

use cli::streams::say;
use cli::{Failure, Outcome};
use texray::quote::is_hidden;

const INTERNAL: u8 = 1;
const LIMIT_EXCEEDED: u8 = 1;
const NOT_WRITTEN: u8 = 5;
const TARGET_MISSED: u8 = 6;
const INVALID_SAMPLES: u8 = 7;
const SIGNAL: u8 = 128;

fn main() -> ExitCode {
    let started = Instant::now();
    // A panic is a bug of texray; its message is printed by the panic hook.
    let code = match catch_unwind(AssertUnwindSafe(|| cli::run(started))) {
        Ok(Ok(Outcome::Done)) => 0,
        Ok(Ok(Outcome::TargetMissed(what))) => {
            say(&format!("error: {what}"));
            TARGET_MISSED
        }
        Ok(Ok(Outcome::InvalidSamples(count))) => {
            say(&format!("error: {count} invalid samples were left out (--strict)"));
            INVALID_SAMPLES
        }
        Ok(Ok(Outcome::HardCasesFailed)) => INTERNAL,
        Ok(Ok(Outcome::LimitsExceeded(limits))) => {
            limits.iter().for_each(|limit| say(&format!("error: {limit}")));
            LIMIT_EXCEEDED
        }
        Ok(Ok(Outcome::NotWritten)) => NOT_WRITTEN,
        Ok(Ok(Outcome::Signal(signal))) => SIGNAL.saturating_add(signal),
        Ok(Err(Failure::Arguments(error))) => {
            // Help and version come this way too, with the code 0 and on stdout. Nothing can be told to a closed
            // stream. An argument that steers a terminal is shown without the colours that clap would print.
            let steers = |argument: OsString| argument.to_string_lossy().contains(is_hidden);
            match error.use_stderr() && std::env::args_os().any(steers) {
                true => say(error.to_string().trim_end()),
                false => drop(error.print()),
            }
            u8::try_from(error.exit_code()).unwrap_or(INTERNAL)
        }
        Ok(Err(Failure::Command(error))) => {
            // Several refusals of a scene are a line each.
            let text = error.to_string();
            let several = matches!(error, texray::Error::Scenes { .. } | texray::Error::Warnings { .. });
            let parts = if several { text.lines().collect() } else { vec![text.as_str()] };
            parts.iter().for_each(|part| say(&format!("error: {part}")));
            let mut cause = error.source();
            while let Some(error) = cause {
                say(&format!("  caused by: {error}"));
                cause = error.source();
            }
            error.exit_code()
        }
        Err(_) => INTERNAL,
    };
    ExitCode::from(code)
}
