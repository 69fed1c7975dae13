//! The instructions of a SPIR-V module, one after the other.
//!
//! Comes in: the words of a module. Goes out: each instruction as its opcode and its operands. Numbers of opcodes and
//! decorations are those of the SPIR-V specification, version 1.3.

use crate::{Error, Result};

/// Words before the first instruction.
pub(super) const HEADER_WORDS: usize = 5;

/// One instruction: all its words, the first of which holds length and opcode.
pub(super) struct Instruction<'a> {
    pub(super) words: &'a [u32],
}

impl<'a> Instruction<'a> {
    pub(super) fn opcode(&self) -> u32 {
        self.words[0] & 0xffff
    }

    /// The words after the first.
    pub(super) fn operands(&self) -> &'a [u32] {
        &self.words[1..]
    }
}

/// Every instruction of a module; fails where one is longer than what is left, or has no length.
pub(super) fn instructions(module: &[u32]) -> Result<Vec<Instruction<'_>>> {
    let mut rest =
        module.get(HEADER_WORDS..).ok_or_else(|| Error::Internal("a shader module without a header".into()))?;
    let mut all = Vec::new();
    while let Some(&first) = rest.first() {
        let length = (first >> 16) as usize;
        let Some((words, after)) = rest.split_at_checked(length).filter(|_| length > 0) else {
            let left = rest.len();
            return Err(Error::Internal(format!(
                "a shader module has an instruction of {length} words with {left} left"
            )));
        };
        all.push(Instruction { words });
        rest = after;
    }
    Ok(all)
}
