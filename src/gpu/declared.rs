//! What a module asks of its pipeline: bindings, push constants, workgroup.
//!
//! Comes in: SPIR-V without specialisation constants. Goes out: a [`Declared`], from which the pipeline's layout is
//! made, so that layout and module cannot differ; or an error where the module has what no pipeline here can give it.

use std::collections::{HashMap, HashSet};

use super::instructions::{Instruction, instructions};
use super::pipeline::{BindingKind, BindingSlot};
use crate::{Error, Result};

// Opcodes, and of their operands storage classes, decorations and the like.
const OP_EXT_INST: u32 = 12;
const OP_ENTRY_POINT: u32 = 15;
const OP_EXECUTION_MODE: u32 = 16;
const MODE_LOCAL_SIZE: u32 = 17;
const OP_TYPE_INT: u32 = 21;
const OP_TYPE_FLOAT: u32 = 22;
const OP_TYPE_VECTOR: u32 = 23;
const OP_TYPE_IMAGE: u32 = 25;
const DIM_BUFFER: u32 = 5;
const SAMPLED: u32 = 1;
const OP_TYPE_ARRAY: u32 = 28;
const OP_TYPE_STRUCT: u32 = 30;
const OP_TYPE_POINTER: u32 = 32;
const OP_CONSTANT: u32 = 43;
const OP_CONSTANT_COMPOSITE: u32 = 44;
const OP_FUNCTION: u32 = 54;
const OP_FUNCTION_END: u32 = 56;
const OP_FUNCTION_CALL: u32 = 57;
const OP_VARIABLE: u32 = 59;
const CLASS_UNIFORM_CONSTANT: u32 = 0;
const CLASS_UNIFORM: u32 = 2;
const CLASS_PUSH_CONSTANT: u32 = 9;
const CLASS_STORAGE_BUFFER: u32 = 12;
const OP_LOAD: u32 = 61;
const OP_STORE: u32 = 62;
const OP_DECORATE: u32 = 71;
const OP_MEMBER_DECORATE: u32 = 72;
const DECORATION_BUFFER_BLOCK: u32 = 3;
const DECORATION_BUILT_IN: u32 = 11;
const BUILT_IN_WORKGROUP_SIZE: u32 = 25;
const DECORATION_BINDING: u32 = 33;
const DECORATION_DESCRIPTOR_SET: u32 = 34;
const DECORATION_OFFSET: u32 = 35;
const OP_VECTOR_SHUFFLE: u32 = 79;
const OP_COMPOSITE_EXTRACT: u32 = 81;
const OP_COMPOSITE_INSERT: u32 = 82;
const OP_LOOP_MERGE: u32 = 246;
const OP_SELECTION_MERGE: u32 = 247;
const OP_BRANCH_CONDITIONAL: u32 = 250;
const OP_SWITCH: u32 = 251;

/// Most elements of an array in a shader's own memory. Compilers place such arrays on the stack of a thread, once for
/// each lane of a vector; the longest here, a traversal stack, has a few dozen.
const MOST_ELEMENTS: u32 = 4096;

/// What a module asks for.
#[derive(Debug, PartialEq)]
pub(super) struct Declared {
    /// Bindings that the entry point uses, in rising order of number. All are in set 0.
    pub(super) bindings: Vec<BindingSlot>,
    /// Bytes of the push-constant block.
    pub(super) push_constant_bytes: u32,
    /// Invocations of a workgroup, by dimension.
    pub(super) workgroup: [u32; 3],
}

impl Declared {
    /// Reads it off the words of a module.
    pub(super) fn of(spirv: &[u32]) -> Result<Declared> {
        let module = Module::read(spirv)?;
        Ok(Declared {
            bindings: module.bindings()?,
            push_constant_bytes: module.push_constant_bytes()?,
            workgroup: module.workgroup()?,
        })
    }
}

/// A module's instructions, by what is looked up in them.
struct Module<'a> {
    entry: u32,
    local_size: Option<[u32; 3]>,
    /// Global types, constants and variables by their result.
    globals: HashMap<u32, (u32, &'a [u32])>,
    /// Bodies by the function's result.
    functions: HashMap<u32, Vec<Instruction<'a>>>,
    /// Words of decorations by target and decoration.
    decorations: HashMap<(u32, u32), u32>,
    /// Offsets of members by struct and member.
    offsets: HashMap<(u32, u32), u32>,
}

impl<'a> Module<'a> {
    fn read(spirv: &'a [u32]) -> Result<Module<'a>> {
        let mut module = Module {
            entry: 0,
            local_size: None,
            globals: HashMap::new(),
            functions: HashMap::new(),
            decorations: HashMap::new(),
            offsets: HashMap::new(),
        };
        let mut function = None;
        for instruction in instructions(spirv)? {
            match (instruction.opcode(), instruction.operands()) {
                (OP_ENTRY_POINT, &[_, entry, ..]) => module.entry = entry,
                (OP_EXECUTION_MODE, &[_, MODE_LOCAL_SIZE, x, y, z]) => module.local_size = Some([x, y, z]),
                (OP_DECORATE, &[target, decoration, ref rest @ ..]) => {
                    module.decorations.insert((target, decoration), rest.first().copied().unwrap_or_default());
                }
                (OP_MEMBER_DECORATE, &[target, member, DECORATION_OFFSET, offset]) => {
                    module.offsets.insert((target, member), offset);
                }
                (OP_FUNCTION, &[_, result, ..]) => function = Some((result, Vec::new())),
                (OP_FUNCTION_END, _) => module.functions.extend(function.take()),
                // Types have their result first, constants and variables their type before it.
                (opcode @ 19..=39, &[result, ref rest @ ..]) => {
                    module.globals.insert(result, (opcode, rest));
                }
                (opcode @ (41..=52 | OP_VARIABLE), operands @ &[_, result, ..]) if function.is_none() => {
                    module.globals.insert(result, (opcode, operands));
                }
                _ => {
                    if let Some((_, body)) = &mut function {
                        body.push(instruction);
                    }
                }
            }
        }
        module.check_arrays()?;
        Ok(module)
    }

    /// Bindings that the entry point, or what it calls, uses.
    fn bindings(&self) -> Result<Vec<BindingSlot>> {
        let used = self.used()?;
        let mut bindings = Vec::new();
        for (&variable, &(opcode, operands)) in &self.globals {
            let (OP_VARIABLE, &[pointer, _, class, ..]) = (opcode, operands) else { continue };
            let is_bound = [CLASS_UNIFORM_CONSTANT, CLASS_UNIFORM, CLASS_STORAGE_BUFFER].contains(&class);
            if !is_bound || !used.contains(&variable) {
                continue;
            }
            let bad = |what: String| Error::Internal(format!("shader variable {variable}: {what}"));
            let pointed = self.pointed(pointer).ok_or_else(|| bad("no pointer".into()))?;
            let kind = match (class, self.global(pointed)) {
                (CLASS_UNIFORM_CONSTANT, Some((OP_TYPE_IMAGE, &[_, DIM_BUFFER, _, _, _, SAMPLED, ..]))) => {
                    BindingKind::Texel
                }
                // SPIR-V 1.3 has both ways of saying it.
                (CLASS_STORAGE_BUFFER, Some((OP_TYPE_STRUCT, _))) => BindingKind::Storage,
                (CLASS_UNIFORM, Some((OP_TYPE_STRUCT, _)))
                    if self.decorations.contains_key(&(pointed, DECORATION_BUFFER_BLOCK)) =>
                {
                    BindingKind::Storage
                }
                _ => return Err(bad("neither a uniform texel buffer nor a storage buffer".into())),
            };
            let decoration = |decoration| self.decorations.get(&(variable, decoration)).copied();
            let (Some(0), Some(number)) = (decoration(DECORATION_DESCRIPTOR_SET), decoration(DECORATION_BINDING))
            else {
                return Err(bad("no binding in set 0".into()));
            };
            bindings.push(BindingSlot { number, kind });
        }
        bindings.sort_unstable();
        match bindings.windows(2).find(|pair| pair[0].number == pair[1].number) {
            Some(pair) => Err(Error::Internal(format!("a shader has binding {} twice", pair[0].number))),
            None => Ok(bindings),
        }
    }

    /// Ids that stand in the functions which the entry point reaches.
    fn used(&self) -> Result<HashSet<u32>> {
        let (mut used, mut reached, mut left) = (HashSet::new(), HashSet::from([self.entry]), vec![self.entry]);
        while let Some(function) = left.pop() {
            let body = self.functions.get(&function);
            let body = body.ok_or_else(|| Error::Internal(format!("a shader lacks its function {function}")))?;
            for instruction in body {
                used.extend(ids(instruction));
                if let (OP_FUNCTION_CALL, &[_, _, called, ..]) = (instruction.opcode(), instruction.operands())
                    && reached.insert(called)
                {
                    left.push(called);
                }
            }
        }
        Ok(used)
    }

    /// Bytes up to the end of the last member of the push-constant block.
    fn push_constant_bytes(&self) -> Result<u32> {
        let mut bytes = 0;
        for &(opcode, operands) in self.globals.values() {
            let (OP_VARIABLE, &[pointer, _, CLASS_PUSH_CONSTANT, ..]) = (opcode, operands) else { continue };
            let block = self.pointed(pointer);
            let Some((block, (OP_TYPE_STRUCT, members))) = block.and_then(|id| Some((id, self.global(id)?))) else {
                return Err(Error::Internal("a push-constant block that is no struct".into()));
            };
            for (index, &member) in (0..).zip(members) {
                let end =
                    self.offsets.get(&(block, index)).zip(self.bytes(member)).map(|(offset, bytes)| offset + bytes);
                bytes = bytes.max(end.ok_or_else(|| Error::Internal("a push constant of unknown size".into()))?);
            }
        }
        Ok(bytes.next_multiple_of(4))
    }

    /// The constant `gl_WorkGroupSize` where there is one, which then rules, else the execution mode.
    fn workgroup(&self) -> Result<[u32; 3]> {
        let is_size = |&(&(_, decoration), &built_in): &(&(u32, u32), &u32)| {
            decoration == DECORATION_BUILT_IN && built_in == BUILT_IN_WORKGROUP_SIZE
        };
        let size = self.decorations.iter().find(is_size).and_then(|(&(target, _), _)| self.global(target));
        let size = match size {
            Some((OP_CONSTANT_COMPOSITE, &[_, _, x, y, z])) => {
                let [x, y, z] = [x, y, z].map(|id| self.constant(id));
                x.zip(y).zip(z).map(|((x, y), z)| [x, y, z])
            }
            _ => self.local_size,
        };
        size.ok_or_else(|| Error::Internal("a shader without a workgroup size".into()))
    }

    /// Refuses arrays that no compiler should be asked for: empty ones are not valid, and long ones overflow stacks.
    fn check_arrays(&self) -> Result<()> {
        for &(opcode, operands) in self.globals.values() {
            let (OP_TYPE_ARRAY, &[_, length]) = (opcode, operands) else { continue };
            match self.constant(length) {
                Some(1..=MOST_ELEMENTS) => {}
                length => {
                    let need =
                        length.map_or("an unknown number of elements".into(), |length| format!("{length} elements"));
                    let have = format!("1 to {MOST_ELEMENTS}");
                    return Err(Error::Limit { what: "an array of a shader".into(), need, have });
                }
            }
        }
        Ok(())
    }

    fn global(&self, id: u32) -> Option<(u32, &'a [u32])> {
        self.globals.get(&id).copied()
    }

    fn pointed(&self, pointer: u32) -> Option<u32> {
        match self.global(pointer)? {
            (OP_TYPE_POINTER, &[_, pointed]) => Some(pointed),
            _ => None,
        }
    }

    fn constant(&self, id: u32) -> Option<u32> {
        match self.global(id)? {
            (OP_CONSTANT, &[_, _, value]) => Some(value),
            _ => None,
        }
    }

    /// Bytes of a number or a vector of them, which is all that push-constant blocks have here.
    fn bytes(&self, kind: u32) -> Option<u32> {
        match self.global(kind)? {
            (OP_TYPE_INT | OP_TYPE_FLOAT, &[bits, ..]) => Some(bits / 8),
            (OP_TYPE_VECTOR, &[component, count]) => Some(self.bytes(component)? * count),
            _ => None,
        }
    }
}

/// The ids among an instruction's operands. Where literals stand they are left out, since they may be equal to the
/// number of an id; a type or result that is taken along is no variable's.
fn ids<'a>(instruction: &Instruction<'a>) -> impl Iterator<Item = u32> + use<'a> {
    let operands = instruction.operands();
    let (first, last) = match instruction.opcode() {
        OP_LOAD | OP_COMPOSITE_EXTRACT => (operands.get(2..3), None),
        OP_STORE => (operands.get(..2), None),
        OP_VECTOR_SHUFFLE | OP_COMPOSITE_INSERT => (operands.get(2..4), None),
        // The set, the number of the instruction in it, its operands.
        OP_EXT_INST => (operands.get(2..3), operands.get(4..)),
        OP_BRANCH_CONDITIONAL | OP_SWITCH => (operands.get(..1), None),
        OP_LOOP_MERGE | OP_SELECTION_MERGE => (None, None),
        _ => (Some(operands), None),
    };
    first.unwrap_or_default().iter().chain(last.unwrap_or_default()).copied()
}

#[cfg(test)]
mod tests {
    use super::super::shader_module::ShaderModule;
    use super::super::{shaders, specialise};
    use super::*;
    use crate::interface::*;

    fn declared(module: ShaderModule, values: &[(u32, u32)]) -> Result<Declared> {
        Declared::of(&specialise(module, values)?)
    }

    #[test]
    fn the_echo_kernel_asks_for_what_its_source_says() {
        let slots = [(BINDING_PROBE_INPUT, BindingKind::Texel), (BINDING_PROBE_OUTPUT, BindingKind::Storage)];
        let bindings = slots.map(|(number, kind)| BindingSlot { number, kind }).to_vec();
        let expected = Declared { bindings, push_constant_bytes: 4, workgroup: [64, 1, 1] };
        assert_eq!(declared(shaders::PROBE_ECHO, &[]).unwrap(), expected);
    }

    #[test]
    fn the_path_tracer_uses_all_but_the_probes_bindings() {
        let texel = (0..RECORD_BINDINGS).chain([BINDING_PATHS]).map(|number| (number, BindingKind::Texel));
        let written = [BINDING_PATHS_WRITTEN, BINDING_LISTS, BINDING_SUMS, BINDING_COUNTERS];
        let storage = (STORAGE_TWIN..STORAGE_TWIN + RECORD_BINDINGS).chain(written);
        let all = texel.chain(storage.map(|number| (number, BindingKind::Storage)));
        let mut bindings: Vec<_> = all.map(|(number, kind)| BindingSlot { number, kind }).collect();
        bindings.sort_unstable();
        for module in [
            shaders::PATH_TRACE,
            shaders::PATH_TRACE_KEEP_NAN,
            shaders::PATH_TRACE_PLAIN,
            shaders::PATH_TRACE_PLAIN_KEEP_NAN,
        ] {
            let found = declared(module, &[(SPEC_WORKGROUP_X, 16), (SPEC_WORKGROUP_Y, 4)]).unwrap();
            assert_eq!(found.bindings, bindings);
            assert_eq!((found.push_constant_bytes, found.workgroup), (PUSH_CONSTANT_BYTES, [16, 4, 1]));
        }
    }

    #[test]
    fn a_stack_of_no_entries_or_too_many_is_refused() {
        for (entries, fits) in
            [(0, false), (1, true), (MOST_ELEMENTS, true), (MOST_ELEMENTS + 1, false), (u32::MAX, false)]
        {
            let found = declared(shaders::PATH_TRACE, &[(SPEC_STACK_ENTRIES, entries)]);
            assert_eq!(found.is_ok(), fits, "{entries}: {found:?}");
            if let Err(error) = found {
                assert!(matches!(&error, Error::Limit { need, .. } if need.contains(&entries.to_string())), "{error}");
            }
        }
    }

    #[test]
    fn literals_are_no_ids() {
        let of = |words: &[u32]| ids(&Instruction { words }).collect::<Vec<_>>();
        assert_eq!(of(&[4 << 16 | OP_LOAD, 1, 2, 3]), [3]);
        assert_eq!(of(&[6 << 16 | OP_LOAD, 1, 2, 3, 2, 4]), [3]);
        assert_eq!(of(&[7 << 16 | OP_EXT_INST, 1, 2, 3, 81, 5, 6]), [3, 5, 6]);
        assert_eq!(of(&[5 << 16 | OP_COMPOSITE_EXTRACT, 1, 2, 3, 0]), [3]);
        assert_eq!(of(&[3 << 16 | OP_LOOP_MERGE, 8, 9]), [0; 0]);
    }
}
