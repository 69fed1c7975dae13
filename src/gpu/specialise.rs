//! Specialisation on the host: constants get their values before the driver sees the module.
//!
//! Comes in: a SPIR-V module and values for its specialisation constants. Goes out: the same module without any: each is
//! an ordinary constant, and what was computed from them alone is folded.
//!
//! Vulkan lets the driver do this, and most do it well. SwiftShader does not fold what depends on a specialisation
//! constant, so it compiles the code of every absent effect as well (docs/performance.md, 'Pipelines'). Done here, "an
//! absent effect leaves no code behind" holds whatever the driver.

use std::collections::HashMap;

use super::instructions::{HEADER_WORDS, instructions};
use super::shader_module::ShaderModule;
use crate::{Error, Result};

// Numbers of the SPIR-V specification, version 1.3, sections 3.20 and 3.32.
const DECORATION_SPEC_ID: u32 = 1;
const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
const OP_CONSTANT: u32 = 43;
const OP_CONSTANT_COMPOSITE: u32 = 44;
const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_SPEC_CONSTANT_COMPOSITE: u32 = 51;
const OP_SPEC_CONSTANT_OP: u32 = 52;
const OP_DECORATE: u32 = 71;

/// The module's words with `values`, `(constant id, value)`, in the place of its specialisation constants; those
/// without a value keep their default. A value is the 32 bits of a number, or 0 and 1 for a bool; ids that the module
/// lacks are ignored. Fails where the module computes something from constants that this does not know, such as a
/// quotient by 0.
pub fn specialise(module: ShaderModule, values: &[(u32, u32)]) -> Result<Vec<u32>> {
    fold(module.words(), values)
}

fn fold(spirv: &[u32], values: &[(u32, u32)]) -> Result<Vec<u32>> {
    let bad = |what: String| Error::Internal(format!("specialising a shader: {what}"));
    let given: HashMap<u32, u32> = values.iter().copied().collect();
    // Values of results: of what stands for a specialisation constant, and of every 32-bit constant.
    let mut given_to: HashMap<u32, u32> = HashMap::new();
    let mut known: HashMap<u32, u32> = HashMap::new();
    let all = instructions(spirv)?;
    let mut out = spirv[..HEADER_WORDS].to_vec();
    for instruction in all {
        let opcode = instruction.opcode();
        match (opcode, instruction.operands()) {
            (OP_DECORATE, &[target, DECORATION_SPEC_ID, id]) => {
                given_to.extend(given.get(&id).map(|&value| (target, value)));
            }
            (OP_SPEC_CONSTANT_TRUE | OP_SPEC_CONSTANT_FALSE, &[kind, result]) => {
                let default = u32::from(opcode == OP_SPEC_CONSTANT_TRUE);
                let value = u32::from(given_to.get(&result).copied().unwrap_or(default) != 0);
                known.insert(result, value);
                out.extend(bool_constant(kind, result, value));
            }
            (OP_SPEC_CONSTANT, &[kind, result, default]) => {
                let value = given_to.get(&result).copied().unwrap_or(default);
                known.insert(result, value);
                out.extend([head(OP_CONSTANT, 4), kind, result, value]);
            }
            (OP_SPEC_CONSTANT_COMPOSITE, operands) => {
                out.push(head(OP_CONSTANT_COMPOSITE, instruction.words.len()));
                out.extend(operands);
            }
            (OP_SPEC_CONSTANT_OP, &[kind, result, operation, ref operands @ ..]) => {
                let operands: Option<Vec<u32>> = operands.iter().map(|id| known.get(id).copied()).collect();
                let Some((value, is_bool)) = operands.as_deref().and_then(|operands| evaluate(operation, operands))
                else {
                    return Err(bad(format!("operation {operation} of constants is not known")));
                };
                known.insert(result, value);
                match is_bool {
                    true => out.extend(bool_constant(kind, result, value)),
                    false => out.extend([head(OP_CONSTANT, 4), kind, result, value]),
                }
            }
            (OP_SPEC_CONSTANT..=OP_SPEC_CONSTANT_OP, _) => return Err(bad("a constant wider than 32 bits".into())),
            (OP_CONSTANT, &[_, result, value]) => {
                known.insert(result, value);
                out.extend(instruction.words);
            }
            (OP_CONSTANT_TRUE | OP_CONSTANT_FALSE, &[_, result]) => {
                known.insert(result, u32::from(opcode == OP_CONSTANT_TRUE));
                out.extend(instruction.words);
            }
            _ => out.extend(instruction.words),
        }
    }
    Ok(out)
}

/// First word of an instruction of `length` words.
fn head(opcode: u32, length: usize) -> u32 {
    (length as u32) << 16 | opcode
}

fn bool_constant(kind: u32, result: u32, value: u32) -> [u32; 3] {
    [head(if value != 0 { OP_CONSTANT_TRUE } else { OP_CONSTANT_FALSE }, 3), kind, result]
}

/// Value of an operation of 32-bit unsigned numbers or bools, and whether it is a bool; `None` for one that no module here has.
fn evaluate(operation: u32, operands: &[u32]) -> Option<(u32, bool)> {
    let truth = |value: bool| Some((u32::from(value), true));
    let number = |value: u32| Some((value, false));
    match (operation, operands) {
        (128, &[a, b]) => number(a.wrapping_add(b)), // OpIAdd
        (130, &[a, b]) => number(a.wrapping_sub(b)), // OpISub
        (132, &[a, b]) => number(a.wrapping_mul(b)), // OpIMul
        (134, &[a, b]) => number(a.checked_div(b)?), // OpUDiv; by 0 it has no value
        (137, &[a, b]) => number(a.checked_rem(b)?), // OpUMod
        (166, &[a, b]) => truth(a | b != 0),         // OpLogicalOr
        (167, &[a, b]) => truth(a & b != 0),         // OpLogicalAnd
        (168, &[a]) => truth(a == 0),                // OpLogicalNot
        (170, &[a, b]) => truth(a == b),             // OpIEqual
        (171, &[a, b]) => truth(a != b),             // OpINotEqual
        (172, &[a, b]) => truth(a > b),              // OpUGreaterThan
        (174, &[a, b]) => truth(a >= b),             // OpUGreaterThanEqual
        (176, &[a, b]) => truth(a < b),              // OpULessThan
        (178, &[a, b]) => truth(a <= b),             // OpULessThanEqual
        (197, &[a, b]) => number(a | b),             // OpBitwiseOr
        (199, &[a, b]) => number(a & b),             // OpBitwiseAnd
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: [u32; HEADER_WORDS] = [0x0723_0203, 0x0001_0300, 0, 20, 0];

    fn module(instructions: &[&[u32]]) -> Vec<u32> {
        let mut words = HEADER.to_vec();
        for instruction in instructions {
            words.push(head(instruction[0], instruction.len()));
            words.extend(&instruction[1..]);
        }
        words
    }

    #[test]
    fn values_defaults_and_what_follows_from_them() {
        // Constants 5 (id 7, default 3) and 6 (id 8, a bool, default true); 9 = (5 == 4), 10 = 5 + 4, 11 = a pair of them.
        let before = module(&[
            &[OP_DECORATE, 5, DECORATION_SPEC_ID, 7],
            &[OP_DECORATE, 6, DECORATION_SPEC_ID, 8],
            &[OP_DECORATE, 12, 0],
            &[OP_CONSTANT, 1, 4, 3],
            &[OP_SPEC_CONSTANT, 1, 5, 3],
            &[OP_SPEC_CONSTANT_TRUE, 2, 6],
            &[OP_SPEC_CONSTANT_OP, 2, 9, 170, 5, 4],
            &[OP_SPEC_CONSTANT_OP, 1, 10, 128, 5, 4],
            &[OP_SPEC_CONSTANT_COMPOSITE, 3, 11, 5, 10],
            &[OP_SPEC_CONSTANT_OP, 2, 13, 167, 9, 6],
        ]);
        let after = |five: u32, six: u32, equal: u32, sum: u32, both: u32| {
            module(&[
                &[OP_DECORATE, 12, 0],
                &[OP_CONSTANT, 1, 4, 3],
                &[OP_CONSTANT, 1, 5, five],
                &[six, 2, 6],
                &[equal, 2, 9],
                &[OP_CONSTANT, 1, 10, sum],
                &[OP_CONSTANT_COMPOSITE, 3, 11, 5, 10],
                &[both, 2, 13],
            ])
        };
        let (yes, no) = (OP_CONSTANT_TRUE, OP_CONSTANT_FALSE);
        assert_eq!(fold(&before, &[]).unwrap(), after(3, yes, yes, 6, yes));
        assert_eq!(fold(&before, &[(8, 0), (7, u32::MAX), (99, 1)]).unwrap(), after(u32::MAX, no, no, 2, no));
    }

    #[test]
    fn what_cannot_be_folded_is_refused() {
        for (bad, text) in [
            (HEADER[..3].to_vec(), "without a header"),
            (module(&[&[OP_SPEC_CONSTANT_OP, 1, 9, 170, 5, 4]]), "operation 170"),
            (module(&[&[OP_CONSTANT, 1, 4, 0], &[OP_SPEC_CONSTANT_OP, 1, 9, 134, 4, 4]]), "operation 134"),
            (module(&[&[OP_SPEC_CONSTANT, 1, 5, 3, 0]]), "wider than 32 bits"),
            ([&HEADER[..], &[3 << 16 | OP_CONSTANT, 1]].concat(), "of 3 words with 2 left"),
            ([&HEADER[..], &[OP_CONSTANT]].concat(), "of 0 words"),
        ] {
            let error = fold(&bad, &[]).unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
    }
}
