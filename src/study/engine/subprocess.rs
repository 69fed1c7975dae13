//! texray in a process of its own: what a user waits for from the start of the program, and runs under another environment.
//!
//! Comes in: the program's file, a scene, arguments, variables. Goes out: the figures of its `--json` document.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::{Error, Result};

/// How a subprocess is started.
#[derive(Clone, Debug)]
pub struct Subprocess {
    /// The texray program.
    pub program: PathBuf,
    /// `--device`, if not the default.
    pub device: Option<String>,
}

impl Subprocess {
    /// Renders `scene` with these arguments beside `--json`; the picture is thrown away. `seconds.total` is from the start of
    /// the process to the picture on disk.
    pub fn render(&self, scene: &Path, arguments: &[String], variables: &[(&str, &str)]) -> Result<Value> {
        let folder = tempfile::tempdir().map_err(|error| Error::output(std::env::temp_dir(), error.to_string()))?;
        let mut command = Command::new(&self.program);
        command.arg("render").arg(scene).arg("--output").arg(folder.path().join("picture.exr"));
        command.args(["--json", "--quiet"]).args(arguments).envs(variables.iter().copied());
        if let Some(device) = &self.device {
            command.args(["--device", device]);
        }
        let output = command
            .output()
            .map_err(|error| Error::Internal(format!("{} cannot be started: {error}", self.program.display())))?;
        let complaint = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() {
            return Err(Error::Internal(format!(
                "a render in its own process ended with {}: {complaint}",
                output.status
            )));
        }
        serde_json::from_slice(&output.stdout)
            .map_err(|error| Error::Internal(format!("a render in its own process printed no JSON: {error}")))
    }
}

/// The number at a path of keys.
///
/// Fails with [`Error::Internal`] where there is none.
pub fn number(document: &Value, keys: &[&str]) -> Result<f64> {
    let found = keys.iter().try_fold(document, |value, key| value.get(key));
    found
        .and_then(Value::as_f64)
        .ok_or_else(|| Error::Internal(format!("a document without a number at {}", keys.join("."))))
}
