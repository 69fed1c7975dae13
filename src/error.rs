//! The one error of the library: what was being done, to which file or device, and what would be allowed.
//!
//! `main` alone turns a kind of error into an exit code ([`Error::exit_code`] states the table of the design).

use std::path::{Path, PathBuf};

use crate::quote;

/// Result of every fallible function of the library.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong, by kind of cause.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command line asks for something that does not exist or contradicts itself.
    #[error("{0}")]
    Usage(String),
    /// A scene, OBJ, MTL or image file is refused. `line` is counted from 1; 0 where the file as a whole is meant.
    #[error("{}: {message}", place(path, *line))]
    Scene {
        /// The refused file.
        path: PathBuf,
        /// Line, from 1; 0 for the whole file.
        line: usize,
        /// What is wrong, with the value found and what is allowed.
        message: String,
    },
    /// Several things of the files of a scene are refused, each by an [`Error::Scene`].
    #[error("{}", lines(refusals, *more))]
    Scenes {
        /// The refusals, in the order in which they are to be told.
        refusals: Vec<Error>,
        /// How many more there are.
        more: usize,
    },
    /// Loading warned, and warnings are refused.
    #[error("{}", warnings.join("\n"))]
    Warnings {
        /// The warnings, each with its file.
        warnings: Vec<String>,
    },
    /// Something needs more than there is.
    #[error("{what}: {need} needed, {have} available")]
    Limit {
        /// The limited thing, by name (a buffer, a device limit).
        what: String,
        /// What is needed, with its unit.
        need: String,
        /// What there is, with its unit.
        have: String,
    },
    /// No Vulkan device can be used.
    #[error("no usable Vulkan device: {0}")]
    NoDevice(String),
    /// A Vulkan call failed.
    #[error("{call} failed: {code}")]
    Vulkan {
        /// The call, and on what.
        call: String,
        /// The result code by name.
        code: String,
    },
    /// The device was lost and the picture could not be finished.
    #[error("the Vulkan device was lost: {0}")]
    DeviceLost(String),
    /// A picture or report cannot be written.
    #[error("{}: {message}", quote::path(path))]
    Output {
        /// The file that was to be written.
        path: PathBuf,
        /// Why it was not.
        message: String,
    },
    /// An invariant of texray itself does not hold: a bug.
    #[error("internal error: {0}")]
    Internal(String),
}

impl Error {
    /// A refusal of `path` at `line` (from 1, or 0 for the whole file).
    pub fn scene(path: impl Into<PathBuf>, line: usize, message: impl Into<String>) -> Error {
        Error::Scene { path: path.into(), line, message: message.into() }
    }

    /// A failure to write `path`.
    pub fn output(path: impl Into<PathBuf>, message: impl Into<String>) -> Error {
        Error::Output { path: path.into(), message: message.into() }
    }

    /// Exit code of the design: 1 internal, 2 usage, 3 bad scene, 4 no device or device lost, 5 output.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Internal(_) => 1,
            Error::Usage(_) => 2,
            Error::Scene { .. } | Error::Scenes { .. } | Error::Warnings { .. } => 3,
            Error::NoDevice(_) | Error::DeviceLost(_) | Error::Vulkan { .. } | Error::Limit { .. } => 4,
            Error::Output { .. } => 5,
        }
    }
}

/// A line a refusal.
fn lines(refusals: &[Error], more: usize) -> String {
    let mut lines: Vec<String> = refusals.iter().map(Error::to_string).collect();
    if more > 0 {
        lines.push(format!("and {more} more like these"));
    }
    lines.join("\n")
}

fn place(path: &Path, line: usize) -> String {
    match line {
        0 => quote::path(path),
        line => format!("{}:{line}", quote::path(path)),
    }
}
