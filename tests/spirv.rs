//! What the compiled kernels declare: bindings and push constants as `src/interface.rs` states them, and NoContraction on the
//! arithmetic that watertightness and equal bytes rest on.
//!
//! Comes in: the SPIR-V modules of the library, parsed. `precise` in GLSL becomes the decoration NoContraction on results; it
//! does not reach into called functions, so it is counted function by function.

use std::collections::{BTreeMap, HashMap, HashSet};

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op};
use texray::gpu::{ShaderModule, shaders, specialise};
use texray::interface::*;

fn parse(module: ShaderModule) -> Module {
    parse_words(module.words())
}

fn parse_words(words: &[u32]) -> Module {
    rspirv::dr::load_words(words).expect("the library's SPIR-V is valid")
}

fn names(module: &Module) -> HashMap<u32, String> {
    let named = module.debug_names.iter().filter(|instruction| instruction.class.opcode == Op::Name);
    named.map(|name| (name.operands[0].unwrap_id_ref(), name.operands[1].unwrap_literal_string().to_owned())).collect()
}

/// Arithmetic on floats that a driver may contract or reorder unless told not to.
fn contractible(instruction: &Instruction) -> bool {
    use Op::*;
    matches!(
        instruction.class.opcode,
        FAdd | FSub | FMul | FDiv | FNegate | VectorTimesScalar | Dot | MatrixTimesVector | VectorTimesMatrix
    )
}

/// Arithmetic of each function by its GLSL name: instructions that are decorated, and all.
fn arithmetic(module: &Module) -> BTreeMap<String, (usize, usize)> {
    let names = names(module);
    let decorated: HashSet<u32> = module
        .annotations
        .iter()
        .filter(|a| a.class.opcode == Op::Decorate && a.operands[1] == Operand::Decoration(Decoration::NoContraction))
        .map(|a| a.operands[0].unwrap_id_ref())
        .collect();
    let mut functions = BTreeMap::new();
    for function in &module.functions {
        let id = function.def.as_ref().and_then(|def| def.result_id).expect("a function has an id");
        // glslang's names: hit_watertight(struct-Ray-...;...
        let name = names.get(&id).map_or("", |name| name.split('(').next().unwrap_or(name));
        let all: Vec<_> = function.all_inst_iter().filter(|instruction| contractible(instruction)).collect();
        let kept = all.iter().filter(|i| i.result_id.is_some_and(|id| decorated.contains(&id))).count();
        let entry: &mut (usize, usize) = functions.entry(name.to_owned()).or_default();
        *entry = (entry.0 + kept, entry.1 + all.len());
    }
    functions
}

/// Functions all of whose arithmetic must round as written, each with a number of instructions that it has at least: hits and boxes
/// (equal in every tree, on CPU and GPU), the start of the next ray, and what the estimator multiplies and adds.
const PRECISE: [(&str, usize); 28] = [
    ("edge_function", 3),
    ("hit_watertight", 26),
    ("hit_moller_trumbore", 30),
    ("meets_own_box", 4),
    ("test_triangle", 1),
    ("make_ray", 2),
    ("enters_box", 4),
    ("enter_children", 4),
    ("enter_four", 6),
    ("inner_point", 15),
    ("spawn_origin", 5),
    ("shadow_limit", 2),
    ("camera_direction", 5),
    ("advance", 1),
    ("make_basis", 10),
    ("cosine_hemisphere", 2),
    ("reflect_about", 5),
    ("refract_through", 4),
    ("fresnel_dielectric", 15),
    ("light_pdf", 2),
    ("power_heuristic", 3),
    ("emission_weight", 5),
    ("cluster_importance", 20),
    ("share_words", 8),
    ("angle_less", 4),
    ("decode_octahedral", 5),
    ("survives", 1),
    ("add_sample", 1),
];

#[test]
fn hits_boxes_and_origins_are_never_contracted() {
    for (module, words) in [
        ("path_trace", shaders::PATH_TRACE),
        ("path_trace_plain", shaders::PATH_TRACE_PLAIN),
        ("path_trace_keep_nan", shaders::PATH_TRACE_KEEP_NAN),
        ("path_trace_plain_keep_nan", shaders::PATH_TRACE_PLAIN_KEEP_NAN),
        ("probe_trace", shaders::PROBE_TRACE),
    ] {
        let functions = arithmetic(&parse(words));
        for (name, least) in PRECISE {
            match functions.get(name) {
                Some(&(kept, all)) => {
                    assert!(
                        kept == all && kept >= least,
                        "{module}: {name} keeps {kept} of {all}, at least {least} expected"
                    );
                }
                None => assert!(module == "probe_trace", "{module} has no function {name}"),
            }
        }
        assert!(functions.contains_key("hit_watertight") && functions.contains_key("enter_four"), "{module}");
    }
    // Control: the parser tells a decorated instruction from another.
    let functions = arithmetic(&parse(shaders::PATH_TRACE));
    assert_eq!(functions["unit_float"], (0, 2), "products that may be contracted");
}

/// Bits of floats whose NaN, infinities and signed zeros a module asks to keep.
fn kept_nan(module: ShaderModule) -> Vec<u32> {
    let module = parse(module);
    let preserve = Operand::ExecutionMode(rspirv::spirv::ExecutionMode::SignedZeroInfNanPreserve);
    let modes = module.execution_modes.iter().filter(|mode| mode.operands[1] == preserve);
    modes.map(|mode| mode.operands[2].unwrap_literal_bit32()).collect()
}

#[test]
fn nan_is_kept_where_a_module_says_so() {
    for words in [
        shaders::PATH_TRACE_KEEP_NAN,
        shaders::PATH_TRACE_PLAIN_KEEP_NAN,
        shaders::PROBE_FLOATS_KEEP_NAN,
        shaders::PROBE_STARTUP_KEEP_NAN,
    ] {
        assert_eq!(kept_nan(words), [32]);
    }
    for words in [shaders::PATH_TRACE, shaders::PATH_TRACE_PLAIN, shaders::PROBE_FLOATS, shaders::PROBE_STARTUP] {
        assert!(kept_nan(words).is_empty());
    }
}

/// Name and number of each binding; a block goes by the name of its type.
fn bindings(module: &Module) -> BTreeMap<u32, String> {
    let names = names(module);
    let globals: HashMap<u32, &Instruction> =
        module.types_global_values.iter().filter_map(|i| i.result_id.map(|id| (id, i))).collect();
    let name_of = |variable: u32| {
        let own = names.get(&variable).filter(|name| !name.is_empty()).cloned();
        own.unwrap_or_else(|| {
            let pointer = globals[&globals[&variable].result_type.expect("a variable has a type")];
            names[&pointer.operands[1].unwrap_id_ref()].clone()
        })
    };
    let bound =
        module.annotations.iter().filter(|a| a.operands.get(1) == Some(&Operand::Decoration(Decoration::Binding)));
    bound.map(|a| (a.operands[2].unwrap_literal_bit32(), name_of(a.operands[0].unwrap_id_ref()))).collect()
}

#[test]
fn bindings_are_the_contracts() {
    let records = [
        "nodes",
        "triangles",
        "surfaces",
        "corners",
        "materials",
        "lights",
        "camera",
        "filter",
        "random",
        "light_nodes",
    ]
    .into_iter();
    let numbers = [
        BINDING_NODES,
        BINDING_TRIANGLES,
        BINDING_SURFACES,
        BINDING_CORNERS,
        BINDING_MATERIALS,
        BINDING_LIGHTS,
        BINDING_CAMERA,
        BINDING_FILTER,
        BINDING_RANDOM,
        BINDING_LIGHT_NODES,
    ];
    let mut expected = BTreeMap::new();
    for (name, number) in records.zip(numbers) {
        expected.insert(number, format!("{name}_view"));
        expected.insert(number + STORAGE_TWIN, format!("{name}_block"));
    }
    for (number, name) in [
        (BINDING_PATHS, "paths_view"),
        (BINDING_PATHS_WRITTEN, "PathStates"),
        (BINDING_LISTS, "Lists"),
        (BINDING_SUMS, "OpenSums"),
        (BINDING_COUNTERS, "Counters"),
        (BINDING_PROBE_INPUT, "ProbeInput"),
        (BINDING_PROBE_OUTPUT, "ProbeOutput"),
    ] {
        expected.insert(number, name.to_owned());
    }
    assert_eq!(expected.len(), 27);
    for words in [shaders::PATH_TRACE, shaders::PATH_TRACE_PLAIN, shaders::PROBE_TRACE, shaders::PROBE_SAMPLING] {
        assert_eq!(bindings(&parse(words)), expected);
    }
}

#[test]
fn push_constants_stand_at_the_contracts_offsets() {
    let module = parse(shaders::PATH_TRACE);
    let names = names(&module);
    let push = *names.iter().find(|(_, name)| *name == "Push").expect("the block is named").0;
    let members = |list: &[Instruction], op: Op| -> Vec<Instruction> {
        list.iter().filter(|i| i.class.opcode == op && i.operands[0] == Operand::IdRef(push)).cloned().collect()
    };
    let offsets: BTreeMap<u32, u32> = members(&module.annotations, Op::MemberDecorate)
        .iter()
        .filter(|a| a.operands[2] == Operand::Decoration(Decoration::Offset))
        .map(|a| (a.operands[1].unwrap_literal_bit32(), a.operands[3].unwrap_literal_bit32()))
        .collect();
    let mut found: Vec<(String, u32)> = members(&module.debug_names, Op::MemberName)
        .iter()
        .map(|name| {
            let text = name.operands[2].unwrap_literal_string().to_owned();
            (text, offsets[&name.operands[1].unwrap_literal_bit32()])
        })
        .collect();
    found.sort_by_key(|(_, offset)| *offset);
    let expected: Vec<(String, u32)> = PUSH_FIELDS.iter().map(|&(name, _, offset)| (name.to_owned(), offset)).collect();
    assert_eq!(found, expected);
}

#[test]
fn specialised_modules_have_no_constants_left_to_specialise() {
    let ids: Vec<(u32, u32)> = (0..64).map(|id| (id, 1)).collect();
    let modules = [
        ("path_trace", shaders::PATH_TRACE),
        ("path_trace_keep_nan", shaders::PATH_TRACE_KEEP_NAN),
        ("path_trace_plain", shaders::PATH_TRACE_PLAIN),
        ("path_trace_plain_keep_nan", shaders::PATH_TRACE_PLAIN_KEEP_NAN),
        ("probe_trace", shaders::PROBE_TRACE),
        ("probe_origins", shaders::PROBE_ORIGINS),
        ("probe_scattering", shaders::PROBE_SCATTERING),
        ("probe_sampling", shaders::PROBE_SAMPLING),
    ];
    for (name, words) in modules {
        let before = parse(words);
        for values in [&[][..], &ids] {
            let after = parse_words(&specialise(words, values).unwrap_or_else(|error| panic!("{name}: {error}")));
            let spec = |module: &Module| {
                let constants = module.types_global_values.iter().map(|instruction| instruction.class.opcode);
                constants.filter(|op| format!("{op:?}").starts_with("SpecConstant")).count()
            };
            assert!(spec(&before) > 0 && spec(&after) == 0, "{name}");
            assert_eq!(after.types_global_values.len(), before.types_global_values.len(), "{name}");
        }
    }
}
