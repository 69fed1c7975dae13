//! What is meant by a command line that names no command, or an option that goes by another name here.
//!
//! Comes in: what clap could not parse, and the arguments. Goes out: a sentence that says what to type, if that is
//! known.

use std::path::Path;

use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

use super::{not_built, shell};

/// Options by the names that they have in other programs, and what they are called here.
const OTHER_NAMES: [(&[&str], &str); 7] = [
    (&["--samples-per-pixel", "--sample-count", "--num-samples"], "--spp N"),
    (&["--width", "--height", "--resolution"], "--size WxH"),
    (&["--bounces", "--depth", "--max-depth"], "--max-bounces N"),
    (&["--time", "--timeout", "--max-time"], "--time-limit TIME"),
    (&["--error", "--noise", "--noise-threshold"], "--target-error E"),
    (&["--gpu", "--cpu"], "--device N|NAME (`texray devices` lists them)"),
    (&["--threads"], "LP_NUM_THREADS=N in the environment, for lavapipe"),
];

/// The sentence for `error`, which parsing `arguments` (the program's own name is not among them) ended with.
pub fn of(error: &Error, arguments: &[String]) -> Option<String> {
    let named = |kind| match error.get(kind) {
        Some(ContextValue::String(name)) => Some(name.as_str()),
        _ => None,
    };
    if let Some(command) = named(ContextKind::InvalidSubcommand) {
        return without_command(command, arguments).or_else(|| not_built::command(command));
    }
    let option = named(ContextKind::InvalidArg).filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    if arguments.first().is_some_and(|first| first.starts_with('-')) {
        // Options alone, then a scene.
        let scene = arguments.iter().find(|argument| is_scene(argument))?;
        return without_command(scene, arguments);
    }
    if option == "--samples" {
        return Some(samples(arguments));
    }
    if let Some(refusal) = not_built::option(option) {
        return Some(refusal);
    }
    let (_, here) = OTHER_NAMES.iter().find(|(names, _)| names.contains(&option))?;
    Some(format!("{option} is no option of texray; use {here}"))
}

/// `--samples N` means `--spp N`; a range of samples will be an option of that name.
fn samples(arguments: &[String]) -> String {
    let at = arguments.iter().position(|argument| argument == "--samples");
    let joined = arguments.iter().find_map(|argument| argument.strip_prefix("--samples="));
    let value = joined.or_else(|| Some(arguments.get(at? + 1)?.as_str()));
    match value {
        Some(range) if range.contains("..") => not_built::refusal("--samples FIRST..END"),
        Some(count) if count.parse::<u32>().is_ok() => {
            format!("--samples {count} is not an option: for {count} samples a pixel, use --spp {count}")
        }
        _ => "--samples is not an option: for samples a pixel, use --spp N".into(),
    }
}

/// A file where a command should stand.
fn without_command(file: &str, arguments: &[String]) -> Option<String> {
    let rest: Vec<String> = arguments.iter().map(|argument| shell::word(argument)).collect();
    if is_scene(file) {
        return Some(format!("a command is missing; to render {file}: texray render {}", rest.join(" ")));
    }
    let extension = Path::new(file).extension()?.to_str()?.to_ascii_lowercase();
    if matches!(extension.as_str(), "exr" | "png" | "hdr") {
        return Some(format!("{file} is a picture, no command; to compare two: texray compare A.exr B.exr"));
    }
    texray::scene::foreign_format(Path::new(file)).map(|what| format!("{file}: {what}"))
}

fn is_scene(argument: &str) -> bool {
    let extension = Path::new(argument).extension().and_then(|extension| extension.to_str()).unwrap_or("");
    ["toml", "obj"].iter().any(|scene| extension.eq_ignore_ascii_case(scene))
}
