//! The command line without a device: usage errors, refusals by name, help, exit codes. Every refusal is one line or
//! clap's usage text on stderr, leaves stdout empty and writes nothing.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

fn texray(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texray")).current_dir(folder).args(arguments).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Runs in an empty folder and expects this exit code, this text on stderr, nothing on stdout and no file.
fn refused(arguments: &[&str], code: i32, text: &str) {
    let folder = tempfile::tempdir().unwrap();
    let output = texray(folder.path(), arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(message.starts_with("error: ") && message.contains(text), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{arguments:?} left a file");
}

fn help(arguments: &[&str]) -> String {
    let output = texray(&std::env::temp_dir(), arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    assert!(output.stderr.is_empty(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

const OPTIONS: [&str; 39] = [
    "--max-bias",
    "--aov",
    "--error-map",
    "--output",
    "--spp",
    "--time-limit",
    "--target-error",
    "--confidence",
    "--dry-run",
    "--size",
    "--crop",
    "--max-bounces",
    "--seed",
    "--sampler",
    "--filter",
    "--accel",
    "--builder",
    "--intersector",
    "--lights",
    "--light-pick",
    "--hemisphere",
    "--roulette",
    "--buffers",
    "--effects",
    "--allow-black",
    "--exposure",
    "--tonemap",
    "--device",
    "--validation",
    "--ledger",
    "--strict",
    "--no-clobber",
    "--overwrite",
    "--json",
    "--quiet",
    "--verbose",
    "--help",
    "-q,",
    "-v,",
];
const NOT_BUILT_OPTIONS: [&str; 5] = ["--samples", "--adaptive", "--checkpoint", "--checkpoint-every", "--resume"];
const NOT_BUILT_COMMANDS: [&str; 3] = ["view", "merge", "film"];

#[test]
fn help_lists_every_option_once() {
    let help = help(&["render", "--help"]);
    let defines = |line: &str, option: &str| {
        let line = line.trim_start();
        line.starts_with('-') && line.split_whitespace().take(2).any(|word| word == option)
    };
    for option in OPTIONS {
        let count = help.lines().filter(|line| defines(line, option)).count();
        assert_eq!(count, 1, "{option} in\n{help}");
    }
    let listed = help.lines().filter(|line| line.trim_start().starts_with('-') && line.contains("--")).count();
    assert_eq!(listed, OPTIONS.len() - 2, "an option is not in this test's list:\n{help}");
    for option in NOT_BUILT_OPTIONS {
        assert!(!help.split_whitespace().any(|word| word == option), "{option} is in\n{help}");
    }
}

#[test]
fn help_lists_commands() {
    let help = help(&["--help"]);
    let lists = |command: &str| help.lines().any(|line| line.split_whitespace().next() == Some(command));
    for command in ["render", "explain", "devices", "selftest", "compare"] {
        assert!(lists(command), "{command} in\n{help}");
    }
    for command in NOT_BUILT_COMMANDS {
        assert!(!lists(command), "{command} in\n{help}");
    }
}

#[test]
fn version_is_on_stdout() {
    assert_eq!(help(&["--version"]), format!("texray {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn what_is_not_built_is_refused_by_name() {
    for command in NOT_BUILT_COMMANDS {
        refused(&[command], 2, &format!("{command} is not built yet"));
        refused(&[command, "a", "--b"], 2, &format!("{command} is not built yet"));
    }
    for option in NOT_BUILT_OPTIONS {
        let text = format!("{option} is not built yet");
        refused(&["render", "scene.toml", option], 2, &text);
        refused(&["render", "scene.toml", option, "1"], 2, &text);
        refused(&["render", option, "scene.toml"], 2, &text);
        refused(&["render", "scene.toml", &format!("{option}=1")], 2, &text);
    }
}

#[test]
fn unknown_names_are_refused() {
    refused(&["rendre", "scene.toml"], 2, "unrecognized subcommand 'rendre'");
    refused(&["render", "scene.toml", "--ssp", "4"], 2, "--ssp");
    refused(&["render", "scene.toml", "other.toml"], 2, "other.toml");
    refused(&["devices", "--all"], 2, "--all");
    refused(&["selftest", "--case", "0"], 2, "--case");
    refused(&["selftest", "--case", "81"], 2, "--case");
}

#[test]
fn missing_arguments_are_refused() {
    refused(&["render"], 2, "SCENE");
    refused(&["explain"], 2, "SCENE");
    refused(&["render", "scene.toml", "--spp"], 2, "--spp");
    // Without a command the help is shown as the error.
    let output = texray(&std::env::temp_dir(), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("Usage: texray") && output.stdout.is_empty());
}

#[test]
fn values_out_of_range_are_refused() {
    for (option, values) in [
        ("--spp", &["0", "-1", "4294967296", "1.5", "many", ""][..]),
        ("--max-bounces", &["0", "65536", "-1", "x"]),
        ("--seed", &["-1", "18446744073709551616", "x", "1.0"]),
        ("--size", &["0x600", "800x0", "16385x1", "1x16385", "800", "800x600x1", "4294967297x4294967297", "x"]),
        ("--crop", &["0,0,0,1", "0,0,1", "0,0,1,1,1", "-1,0,1,1", "a,b,c,d"]),
        ("--roulette", &["0", "1.1", "-0.1", "nan", "inf", "on"]),
        ("--exposure", &["nan", "inf", "1e3", "-101", "x"]),
        ("--sampler", &["halton", ""]),
        ("--filter", &["Box", "lanczos"]),
        ("--accel", &["kd"]),
        ("--builder", &["ploc"]),
        ("--intersector", &["woop"]),
        ("--lights", &["nee"]),
        ("--light-pick", &["uniform"]),
        ("--hemisphere", &["ggx"]),
        ("--buffers", &["image"]),
        ("--effects", &["none"]),
        ("--tonemap", &["hable"]),
    ] {
        for value in values {
            refused(&["render", "scene.toml", &format!("{option}={value}")], 2, option);
        }
    }
}

#[test]
fn contradictions_are_refused() {
    refused(&["render", "scene.toml", "-q", "-v"], 2, "cannot be used with");
    refused(&["render", "scene.toml", "--spp", "1", "--spp", "2"], 2, "cannot be used multiple times");
    refused(&["render", "scene.toml", "-o", "a.exr", "-o", "./a.exr"], 2, "two outputs have this name");
    refused(&["render", "scene.toml", "-o", "a.exr", "--ledger", "a.exr"], 2, "two outputs have this name");
    refused(&["render", "scene.exr", "-o", "./scene.exr"], 2, "the output is a file of the scene itself");
    refused(&["render", "scene.toml", "--ledger", "scene.toml"], 2, "the output is a file of the scene itself");
}

/// Outputs are checked before the scene is read: the scene of these commands does not exist.
#[test]
fn outputs_are_checked_first() {
    refused(&["render", "scene.toml", "-o", "a.jpg"], 2, "a.jpg: unknown extension .jpg; use .exr, .png or .hdr");
    refused(&["render", "scene.toml", "-o", "picture"], 2, "picture: no extension; use .exr, .png or .hdr");
    refused(&["render", "scene.toml", "-o", "missing/a.exr"], 5, "missing/a.exr: the folder missing does not exist");
    refused(&["render", "scene.toml", "--ledger", "missing/a.json"], 5, "missing/a.json: the folder missing");
    // Nobody, root included, can make a file in /proc.
    #[cfg(target_os = "linux")]
    refused(&["render", "scene.toml", "-o", "/proc/a.exr"], 5, "/proc/a.exr: the folder /proc cannot be written");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("old.png"), "old").unwrap();
    let output = texray(folder.path(), &["render", "scene.toml", "-o", "old.png", "--no-clobber"]);
    assert_eq!(output.status.code(), Some(5));
    assert_eq!(stderr(&output), "error: old.png: exists already (--no-clobber)\n");
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"old");
}

#[test]
fn a_missing_scene_is_a_bad_scene() {
    refused(&["render", "scene.toml"], 3, "scene.toml");
    refused(&["explain", "scene.toml"], 3, "scene.toml");
}
