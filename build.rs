//! Writes `interface.glsl` from `src/interface.rs`, then compiles each `glsl/*.comp` to SPIR-V with the glslang binary.
//!
//! Comes in: the contract, the shader sources, and a glslang found in `GLSLANG` or on `PATH`. Goes out, all in
//! `OUT_DIR`: the contract's headers (`interface.glsl` and its fellows), one `.spv` a module, and `shaders.rs`, one
//! `pub static NAME: ShaderModule` a module. A shader that does not compile stops the build and shows the compiler's
//! own message.

use std::collections::BTreeSet;
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

#[allow(dead_code)]
#[path = "src/interface.rs"]
mod interface;

/// Modules that do not follow the rule 'one source, one module of its name, no defines': module, source, defines. A
/// source named here is built only as listed. A specialisation constant is preferred wherever it can do the job; a
/// define is needed for what no constant can take away: declared capabilities (`SUBGROUP_BALLOT`), execution modes
/// (`KEEP_NAN`), decorations (`PRECISE`), and a header that stands in for another (`FUSED_EDGES`). The last two are for
/// tests.
const VARIANTS: &[(&str, &str, &[&str])] = &[
    ("path_trace", "path_trace.comp", &["SUBGROUP_BALLOT=1", "KEEP_NAN=0"]),
    ("path_trace_keep_nan", "path_trace.comp", &["SUBGROUP_BALLOT=1", "KEEP_NAN=1"]),
    ("path_trace_plain", "path_trace.comp", &["SUBGROUP_BALLOT=0", "KEEP_NAN=0"]),
    ("path_trace_plain_keep_nan", "path_trace.comp", &["SUBGROUP_BALLOT=0", "KEEP_NAN=1"]),
    ("probe_floats", "probe_floats.comp", &["KEEP_NAN=0"]),
    ("probe_floats_keep_nan", "probe_floats.comp", &["KEEP_NAN=1"]),
    ("probe_sums", "probe_sums.comp", &["PRECISE=precise"]),
    ("probe_sums_loose", "probe_sums.comp", &["PRECISE="]),
    ("probe_startup", "probe_startup.comp", &["KEEP_NAN=0"]),
    ("probe_startup_keep_nan", "probe_startup.comp", &["KEEP_NAN=1"]),
    ("probe_trace", "probe_trace.comp", &["FUSED_EDGES=0"]),
    ("probe_trace_fused", "probe_trace.comp", &["FUSED_EDGES=1"]),
];

/// What a build step hands on, or the whole text to show when the build stops.
type Step<T> = Result<T, String>;

/// One SPIR-V module to build.
struct Module {
    name: String,
    source: PathBuf,
    defines: Vec<String>,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Step<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR for build scripts")?);
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=src/interface.rs");
    println!("cargo:rerun-if-changed=src/interface");
    // The folder itself, so that a new file is noticed; cargo looks at every file below it.
    println!("cargo:rerun-if-changed=glsl");
    println!("cargo:rerun-if-env-changed=GLSLANG");

    write(&out.join("interface.glsl"), &interface_glsl()?)?;
    write(&out.join("record_buffers.glsl"), &record_buffers_glsl())?;
    write(&out.join("effect_switches.glsl"), &effect_switches_glsl())?;
    write(&out.join("push.glsl"), &push_glsl())?;
    write(&out.join("constants.glsl"), &constants_glsl())?;
    let compiler = find_compiler()?;
    let mut inputs = BTreeSet::new();
    let mut shaders = String::new();
    for module in modules(Path::new("glsl"))? {
        let words = compile(&compiler, &module, &out, &mut inputs)?;
        write_module(&mut shaders, &module, &words)?;
    }
    write(&out.join("shaders.rs"), &shaders)?;
    for input in inputs {
        println!("cargo:rerun-if-changed={}", input.display());
    }
    Ok(())
}

/// A generated header: what stands in it, between its include guard's lines.
fn header(name: &str, body: &str) -> String {
    let guard = name.to_uppercase().replace('.', "_");
    format!(
        "// Written by build.rs from src/interface.rs, where each name is explained.\n\
         #ifndef {guard}\n#define {guard}\n{body}#endif\n"
    )
}

/// The contract as preprocessor lines. They are defines, not `const uint`: a define also works inside `layout(...)`,
/// where some compilers take literals only.
fn interface_glsl() -> Step<String> {
    let mut text = String::new();
    let numbers = interface::SHADER_CONSTANTS.iter().copied().flatten().copied();
    let guards = interface::GUARDS.iter().map(|&(name, number, ..)| (name, number));
    let numbers = numbers.chain(guards).map(|(name, value)| (name, format!("{value}u")));
    // All digits of an f32 are those of the f64 that equals it.
    let floats = interface::SHADER_FLOATS.iter().map(|&(name, value)| (name, format!("{:e}", f64::from(value))));
    let mut names = BTreeSet::new();
    for (name, value) in numbers.chain(floats) {
        if !names.insert(name) {
            return Err(format!("src/interface.rs lists {name} twice"));
        }
        let _ = writeln!(text, "#define {name} {value}");
    }
    Ok(header("interface.glsl", &text))
}

/// The record buffers, by the macro of `bindings.glsl`.
fn record_buffers_glsl() -> String {
    let buffer = |record: &interface::Record| format!("RECORD_BUFFER({}, {}u)\n", record.glsl(), record.binding());
    header("record_buffers.glsl", &interface::Record::ALL.iter().map(buffer).collect::<String>())
}

/// A switch for each effect: `HAS_NAME` for `EFFECT_NAME`.
fn effect_switches_glsl() -> String {
    let named = interface::EFFECT_NUMBERS.iter().filter_map(|(name, _)| name.strip_prefix("EFFECT_"));
    let switch =
        |name: &str| format!("layout(constant_id = SPEC_EFFECTS + EFFECT_{name}) const uint HAS_{name} = 1u;\n");
    header("effect_switches.glsl", &format!("#include \"interface.glsl\"\n{}", named.map(switch).collect::<String>()))
}

/// The push constants.
fn push_glsl() -> String {
    let member = |&(name, kind, offset): &interface::Field| format!("    layout(offset = {offset}) {kind} {name};\n");
    let members: String = interface::PUSH_FIELDS.iter().map(member).collect();
    header("push.glsl", &format!("layout(push_constant) uniform Push {{\n{members}}} push;\n"))
}

/// The constants of a render, and what fetches them: words of the texels behind the camera's.
fn constants_glsl() -> String {
    let fields = interface::CONSTANT_FIELDS;
    let member = |&(name, kind, _): &interface::Field| format!("    {kind} {name};\n");
    let texel = |texel: u32| format!("    uvec4 t{texel} = camera_texel(CAMERA_TEXELS + {texel}u);\n");
    let value = |&(_, kind, offset): &interface::Field| {
        let lane = format!("t{}.{}", offset / 16, ["x", "y", "z", "w"][(offset / 4 % 4) as usize]);
        if kind == "float" { format!("uintBitsToFloat({lane})") } else { lane }
    };
    let members: String = fields.iter().map(member).collect();
    let texels: String = (0..interface::CONSTANT_BYTES.div_ceil(16)).map(texel).collect();
    let values: Vec<String> = fields.iter().map(value).collect();
    let fetch = format!("{texels}    return RenderConstants({});\n", values.join(", "));
    header(
        "constants.glsl",
        &format!("struct RenderConstants {{\n{members}}};\n\nRenderConstants fetch_constants() {{\n{fetch}}}\n"),
    )
}

/// The glslang binary: `GLSLANG` if set, else the first of its two usual names that can be started.
fn find_compiler() -> Step<String> {
    const PACKAGES: &str = "Run ./setup.sh, or install it: `glslang-tools` on Debian and Ubuntu, `glslang` on Fedora and Arch; \
                            or name the binary in the environment variable GLSLANG.";
    let starts = |name: &str| match Command::new(name).arg("--version").output() {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(format!("the GLSL compiler `{name}` cannot be started: {error}")),
    };
    if let Ok(name) = env::var("GLSLANG") {
        return match starts(&name)? {
            true => Ok(name),
            false => Err(format!("GLSLANG names `{name}`, which does not exist. {PACKAGES}")),
        };
    }
    for name in ["glslangValidator", "glslang"] {
        if starts(name)? {
            return Ok(name.to_string());
        }
    }
    Err(format!("no GLSL compiler: neither `glslangValidator` nor `glslang` is on PATH. {PACKAGES}"))
}

/// Every module to build, by name.
fn modules(folder: &Path) -> Step<Vec<Module>> {
    let cannot_read = |error: std::io::Error| format!("cannot read {}: {error}", folder.display());
    let mut sources = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(cannot_read)? {
        let path = entry.map_err(cannot_read)?.path();
        if path.extension().is_some_and(|extension| extension == "comp") {
            sources.insert(path);
        }
    }
    let mut modules = Vec::new();
    for source in sources {
        let file = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let variants: Vec<_> = VARIANTS.iter().filter(|variant| variant.1 == file).collect();
        for (name, _, defines) in &variants {
            let defines = defines.iter().map(|define| define.to_string()).collect();
            modules.push(Module { name: name.to_string(), source: source.clone(), defines });
        }
        if variants.is_empty() {
            let name = file.trim_end_matches(".comp").to_string();
            modules.push(Module { name, source, defines: Vec::new() });
        }
    }
    modules.sort_by(|a, b| a.name.cmp(&b.name));
    match modules.windows(2).find(|pair| pair[0].name == pair[1].name) {
        Some(pair) => Err(format!("two shader modules are named {}", pair[0].name)),
        None => Ok(modules),
    }
}

/// Compiles one module, adds the files it was made from to `inputs`, and returns its SPIR-V words.
fn compile(compiler: &str, module: &Module, out: &Path, inputs: &mut BTreeSet<PathBuf>) -> Step<Vec<u32>> {
    let spirv = out.join(format!("{}.spv", module.name));
    let depfile = out.join(format!("{}.d", module.name));
    let output = Command::new(compiler)
        // Vulkan 1.1 is what the device must have: it fixes SPIR-V 1.3 and makes subgroup operations core.
        .args(["--target-env", "vulkan1.1", "-V"])
        .arg("-Iglsl")
        .arg(format!("-I{}", out.display()))
        .args(module.defines.iter().map(|define| format!("-D{define}")))
        .arg("--depfile")
        .arg(&depfile)
        .arg("-o")
        .arg(&spirv)
        .arg(&module.source)
        .output()
        .map_err(|error| format!("cannot run {compiler}: {error}"))?;
    let messages = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    if !output.status.success() {
        return Err(format!("{} (module {}) does not compile:\n{messages}", module.source.display(), module.name));
    }
    for warning in messages.lines().filter(|line| line.starts_with("WARNING")) {
        println!("cargo:warning={}: {warning}", module.name);
    }
    // The files made here are left out: they are newer than the build script's start, so cargo would run it each time.
    inputs.extend(read_depfile(&depfile)?.into_iter().filter(|path| !path.starts_with(out)));

    let bytes = fs::read(&spirv).map_err(|error| format!("cannot read {}: {error}", spirv.display()))?;
    let (words, rest) = bytes.as_chunks::<4>();
    if words.is_empty() || !rest.is_empty() {
        return Err(format!("{} is {} bytes long, not whole SPIR-V words", spirv.display(), bytes.len()));
    }
    Ok(words.iter().map(|word| u32::from_le_bytes(*word)).collect())
}

/// The inputs that a depfile `target: input input ...` names, as far as they exist. (A path with a blank in it falls
/// apart here; the files below `glsl` are declared with their folder all the same.)
fn read_depfile(path: &Path) -> Step<Vec<PathBuf>> {
    let text = fs::read_to_string(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let inputs = text.split_once(": ").map_or("", |(_, inputs)| inputs);
    Ok(inputs.split_whitespace().map(PathBuf::from).filter(|path| path.exists()).collect())
}

/// Appends one module as a static `ShaderModule` of `u32` words, which have the alignment that Vulkan asks of shader
/// code.
fn write_module(shaders: &mut String, module: &Module, words: &[u32]) -> Step<()> {
    let name = module.name.to_uppercase();
    if !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err(format!("shader module `{}`: letters, digits and _ only", module.name));
    }
    let source = module.source.display().to_string().replace('\\', "/");
    let defines = match module.defines.is_empty() {
        true => String::new(),
        false => format!(" with `{}`", module.defines.join("`, `")),
    };
    let _ = writeln!(shaders, "/// SPIR-V of `{source}`{defines}.");
    let _ = write!(shaders, "pub static {name}: ShaderModule = ShaderModule::built(&[");
    for (index, word) in words.iter().enumerate() {
        let separator = if index % 12 == 0 { "\n    " } else { " " };
        let _ = write!(shaders, "{separator}{word:#010x},");
    }
    shaders.push_str("\n]);\n");
    Ok(())
}

fn write(path: &Path, text: &str) -> Step<()> {
    fs::write(path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
}
