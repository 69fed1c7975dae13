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

const OPTIONS: [&str; 40] = [
    "--deny-warnings",
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
const NOT_BUILT_OPTIONS: [&str; 4] = ["--adaptive", "--checkpoint", "--checkpoint-every", "--resume"];
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

/// What is typed by someone who does not know texray yet leads to what they mean.
#[test]
fn other_words_lead_to_the_right_ones() {
    for (arguments, text) in [
        (&["scene.toml"][..], "a command is missing; to render scene.toml: texray render scene.toml\n"),
        (&["a b/it's.obj", "--spp", "4"], "texray render 'a b/it'\\''s.obj' --spp 4\n"),
        (&["--spp", "4", "scene.toml"], "texray render --spp 4 scene.toml\n"),
        (&["a.exr"], "texray compare A.exr B.exr"),
        (&["model.glb"], "File > Export > Wavefront (.obj)"),
        (
            &["render", "scene.toml", "--samples", "16"],
            "--samples 16 is not an option: for 16 samples a pixel, use --spp 16",
        ),
        (&["render", "scene.toml", "--samples=16"], "use --spp 16"),
        (&["render", "--samples", "many", "scene.toml"], "use --spp N"),
        (&["render", "scene.toml", "--samples"], "use --spp N"),
        (&["render", "scene.toml", "--samples=0..16"], "--samples FIRST..END is not built yet"),
        (&["render", "scene.toml", "--width", "640"], "--width is no option of texray; use --size WxH"),
        (&["render", "scene.toml", "--bounces=4"], "use --max-bounces N"),
        (&["render", "scene.toml", "--target-error", "1"], "use 1% or 0.01 for 1 per cent"),
        (&["render", "scene.toml", "--max-bias=2.5"], "use 2.5% or 0.025 for 2.5 per cent"),
        (&["render", "scene.toml", "--target-error=1%", "--confidence", "95"], "use 95%"),
    ] {
        refused(arguments, 2, text);
    }
    // What clap knows itself is left to it.
    refused(&["selftset"], 2, "a similar subcommand exists: 'selftest'");
}

/// A model in another format is told what to do with it, alone or named by a scene.
#[test]
fn models_of_other_formats_are_told_how_they_become_readable() {
    for extension in ["gltf", "GLB", "fbx", "ply", "stl", "blend", "dae", "usdz", "3ds", "abc"] {
        let text = format!("model.{extension}: a model in the format .{} cannot be read", extension.to_lowercase());
        for command in ["render", "explain"] {
            refused(&[command, &format!("model.{extension}")], 3, &text);
        }
        refused(&["render", &format!("model.{extension}")], 3, "File > Export > Wavefront (.obj)");
    }
    for extension in ["xml", "pbrt", "json"] {
        refused(&["render", &format!("scene.{extension}")], 3, "Export its meshes as Wavefront .obj");
    }
    refused(&["render", "a.mtl"], 3, "give the .obj file that names it");
    refused(&["render", "scene"], 3, "not a scene; allowed are files that end in .toml or .obj");
}

/// Every line of an answer with several errors begins as one error does.
#[test]
fn all_errors_of_a_file_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene =
        "[camera]\nlook_at = [0, 0, 0]\nup = [0, 1]\n[[sphere]]\n[[mesh]]\nfile = \"a.gltf\"\n[material.m]\nkd = 2\n";
    fs::write(folder.path().join("a.toml"), scene).unwrap();
    let output = texray(folder.path(), &["render", "a.toml"]);
    let message = stderr(&output);
    let places: Vec<&str> = message.lines().map(|line| &line[..line.len().min(15)]).collect();
    let of = |line: usize| format!("error: a.toml:{line}");
    let expected: Vec<String> = [1, 1, 1, 2, 3, 4, 6, 8].map(of).into();
    assert!(places.iter().zip(&expected).all(|(line, place)| line.starts_with(place)), "{message}");
    assert_eq!((places.len(), output.status.code()), (expected.len(), Some(3)), "{message}");
}

/// A warning of loading is told, or with --deny-warnings refused; notes are told alone.
#[test]
fn warnings_can_be_denied() {
    let folder = tempfile::tempdir().unwrap();
    let square = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nf 1 2 3 4\n";
    fs::write(folder.path().join("a.obj"), format!("mtllib gone.mtl\nusemtl brick\n{square}")).unwrap();
    fs::write(folder.path().join("plain.obj"), square).unwrap();
    let explain = |arguments: &[&str]| texray(folder.path(), &[&["explain"], arguments].concat());
    let told = explain(&["a.obj"]);
    assert_eq!(told.status.code(), Some(0));
    let lines = ["a.obj:1: mtllib \"gone.mtl\": no such file", "a.obj:2: usemtl \"brick\": no such material; "];
    assert!(lines.iter().all(|line| stderr(&told).contains(&format!("warning: {line}"))), "{}", stderr(&told));
    assert!(stderr(&told).contains("note: a.obj: an OBJ file has no camera; "));
    for arguments in [&["explain", "a.obj", "--deny-warnings"][..], &["render", "a.obj", "--deny-warnings", "-q"]] {
        let denied = texray(folder.path(), arguments);
        assert_eq!(denied.status.code(), Some(3));
        assert!(lines.iter().all(|line| stderr(&denied).contains(&format!("error: {line}"))), "{}", stderr(&denied));
        assert!(!stderr(&denied).contains("warning: "));
    }
    assert_eq!(explain(&["plain.obj", "--deny-warnings"]).status.code(), Some(0));
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
