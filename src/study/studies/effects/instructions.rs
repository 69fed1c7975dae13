//! How many instructions a kernel has once its constants are frozen.
//!
//! Comes in: a specialised module, and `spirv-opt` on `PATH` (SPIRV-Tools). Goes out: its number of instructions after freezing,
//! folding and the optimiser's usual passes; or nothing where the tool is not there. What the driver makes of them is its own affair.

use std::fs;
use std::io::ErrorKind;
use std::process::Command;

use crate::render::kernel::Specialized;
use crate::{Error, Result};

const OP_FUNCTION: u32 = 54;
const OP_FUNCTION_END: u32 = 56;
const OP_LABEL: u32 = 248;
/// Words before the first instruction of a module.
const HEADER_WORDS: usize = 5;

/// Instructions in the functions of the optimised module; `None` where `spirv-opt` is not installed.
pub fn count(kernel: &Specialized) -> Result<Option<usize>> {
    let failed = |error: std::io::Error| Error::Internal(format!("spirv-opt cannot be given a module: {error}"));
    let folder = tempfile::tempdir().map_err(failed)?;
    let (plain, frozen) = (folder.path().join("plain.spv"), folder.path().join("frozen.spv"));
    fs::write(&plain, bytemuck::cast_slice(kernel.module.words())).map_err(failed)?;
    let values: Vec<String> = kernel.constants.iter().map(|(id, value)| format!("{id}:{value}")).collect();
    let mut command = Command::new("spirv-opt");
    command.arg(format!("--set-spec-const-default-value={}", values.join(" ")));
    command.args(["--freeze-spec-const", "--fold-spec-const-op-composite", "-O"]).arg(&plain).arg("-o").arg(&frozen);
    let output = match command.output() {
        Ok(output) => output,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Error::Internal(format!("spirv-opt cannot be started: {error}"))),
    };
    if !output.status.success() {
        let complaint = String::from_utf8_lossy(&output.stderr);
        return Err(Error::Internal(format!("spirv-opt ended with {}: {complaint}", output.status)));
    }
    let bytes = fs::read(&frozen).map_err(failed)?;
    Ok(Some(in_functions(&bytemuck::pod_collect_to_vec::<u8, u32>(&bytes))))
}

/// Instructions between the functions' braces; labels are none.
fn in_functions(words: &[u32]) -> usize {
    let mut rest = words.get(HEADER_WORDS..).unwrap_or_default();
    let (mut inside, mut count) = (false, 0);
    while let Some(&first) = rest.first() {
        let (length, opcode) = ((first >> 16).max(1) as usize, first & 0xffff);
        inside |= opcode == OP_FUNCTION;
        count += usize::from(inside && ![OP_FUNCTION, OP_FUNCTION_END, OP_LABEL].contains(&opcode));
        rest = rest.get(length..).unwrap_or_default();
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_function_does_is_counted() {
        let op = |opcode: u32, words: u32| [words << 16 | opcode].into_iter().chain((1..words).map(|_| 7));
        let mut words = vec![0; HEADER_WORDS];
        // A capability and a constant; a function with a label, an addition, a return; its end.
        for (opcode, length) in
            [(17, 2), (43, 4), (OP_FUNCTION, 5), (OP_LABEL, 2), (128, 5), (253, 1), (OP_FUNCTION_END, 1)]
        {
            words.extend(op(opcode, length));
        }
        assert_eq!(in_functions(&words), 2);
        assert_eq!(in_functions(&[]), 0);
    }
}
