//! Files of others: as large, as deep, as oddly named and as strange as they like.
//!
//! Comes in: files that are written here. Expected: time in proportion to their size, refusals before memory runs out,
//! no character of theirs that steers a terminal, and no wait for what is no file. Limits of memory are set by the
//! shell that starts the program, so these tests are for Linux, whose shells and limits they use.
#![cfg(target_os = "linux")]

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use texray::scene::Scene;

const CAMERA: &str = "[camera]\norigin = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n\
                      [environment]\ncolor = [1, 1, 1]\n";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const FACE: &str = "f 1 2 3\n";

/// A folder of files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Folder {
        let folder = Folder(tempfile::tempdir().unwrap());
        files.iter().for_each(|(name, text)| folder.write(name, text));
        folder
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.at(name), text).unwrap();
    }

    /// Runs `texray` with these arguments, under a limit of address space in KiB (0: none).
    fn run(&self, limit: u64, arguments: &[&str]) -> Output {
        let limit = if limit == 0 { String::new() } else { format!("ulimit -v {limit} && ") };
        let mut command = Command::new("sh");
        command.args(["-c", &format!("{limit}exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_texray")]);
        command.args(arguments).env("RUST_BACKTRACE", "0").current_dir(self.0.path()).output().unwrap()
    }
}

/// `count` lines, each made of its number.
fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, i| {
        let _ = write!(text, "{}", line(i));
        text
    })
}

/// Files that took the square of their length, each so long that the square takes minutes.
#[test]
fn loading_takes_time_in_proportion_to_the_files() {
    let n = 60_000;
    let triangle = format!("{TRIANGLE}{FACE}");
    let one = "[[mesh]]\nfile = \"t.obj\"\n";
    let cases = [
        ("materials", "t.obj", lines(n, |i| format!("newmtl m{i}\nKd 0.5 0.5 0.5\n")), {
            format!("mtllib t.mtl\n{TRIANGLE}{}", lines(n, |i| format!("usemtl m{i}\n{FACE}")))
        }),
        ("unknown statements", "t.obj", format!("newmtl m\n{}", lines(n, |i| format!("zz{i} 1\n"))), {
            format!("mtllib t.mtl\n{TRIANGLE}usemtl m\n{FACE}")
        }),
        ("one material again and again", "t.obj", "newmtl m\n".repeat(n), {
            format!("mtllib t.mtl\n{TRIANGLE}usemtl m\n{FACE}")
        }),
        ("one library again and again", "t.obj", "newmtl m\n".to_owned(), {
            format!("{}{TRIANGLE}usemtl m\n{FACE}", lines(n, |i| format!("mtllib {}t.mtl\n", "./".repeat(i % 50))))
        }),
        ("images", "t.obj", format!("newmtl m\n{}", lines(n, |i| format!("map_Kd -s 1 1 1 my {i}.png\n"))), {
            format!("mtllib t.mtl\n{TRIANGLE}usemtl m\n{FACE}")
        }),
        ("meshes", &format!("{CAMERA}{}", one.repeat(n)), String::new(), triangle.clone()),
        ("meshes of many parts", &format!("{CAMERA}{}", one.repeat(n)), lines(n, |i| format!("newmtl m{i}\n")), {
            format!("mtllib t.mtl\n{TRIANGLE}{}{FACE}", lines(n, |i| format!("usemtl m{i}\n")))
        }),
        (
            "materials of the scene",
            &format!(
                "{CAMERA}{}",
                lines(n, |i| format!("{one}material = \"m{i}\"\n[material.m{i}]\nkd = [0, 0, 0.5]\n"))
            ),
            String::new(),
            triangle.clone(),
        ),
    ];
    for (name, scene, mtl, obj) in cases {
        let folder = Folder::new(&[("t.mtl", &mtl), ("t.obj", &obj), ("t.toml", scene)]);
        let started = Instant::now();
        let loaded = Scene::load(&folder.at(if scene == "t.obj" { "t.obj" } else { "t.toml" }));
        let loaded = loaded.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(started.elapsed() < Duration::from_secs(10), "{name}: {:?}", started.elapsed());
        assert!(!loaded.triangles.is_empty() && loaded.report.warnings.len() < 40, "{name}: {:?}", loaded.report);
    }
}

/// Refusals look for the nearest of many names, and quote what is long.
#[test]
fn refusals_of_many_and_long_names_are_quick_and_short() {
    let long = "x".repeat(1 << 19);
    let many = lines(60_000, |i| format!("newmtl {i:060}\n"));
    let obj = format!("mtllib t.mtl\n{TRIANGLE}usemtl {}\n{FACE}", "9".repeat(60));
    let deep = |open: &str, close: &str| format!("a = {}1{}\n", open.repeat(100_000), close.repeat(100_000));
    for (name, file, text) in [
        ("a name that is nowhere defined", "t.obj", obj.as_str()),
        ("a long name", "t.obj", &format!("{TRIANGLE}usemtl {long}\n{FACE}")),
        ("a long library", "t.obj", &format!("mtllib {long}\n{TRIANGLE}{FACE}")),
        ("a long number", "t.obj", &format!("v {long} 0 0\n")),
        ("a long key", "t.toml", &format!("{CAMERA}[film]\n{long} = 1\n")),
        ("a long value", "t.toml", &format!("{CAMERA}[film]\nwidth = \"{long}\"\n")),
        ("a long mesh", "t.toml", &format!("{CAMERA}[[mesh]]\nfile = \"{long}\"\n")),
        ("deep arrays", "t.toml", &deep("[", "]")),
        ("deep tables", "t.toml", &deep("{a = ", "}")),
        ("deep keys", "t.toml", &format!("a{} = 1\n", ".a".repeat(100_000))),
        ("a deep header", "t.toml", &format!("[a{}]\n", ".a".repeat(100_000))),
    ] {
        let folder = Folder::new(&[("t.mtl", &many), (file, text)]);
        let started = Instant::now();
        let output = folder.run(0, &["explain", "--deny-warnings", file]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{name}: {message}");
        assert!(message.starts_with(&format!("error: {file}")) && message.len() < 400, "{name}: {message}");
        assert!(started.elapsed() < Duration::from_secs(10), "{name}: {:?}", started.elapsed());
    }
}

/// A few kilobytes may name as many triangles as they like: what they take is known before they are placed.
#[test]
fn a_scene_that_asks_for_too_much_is_refused_with_need_and_have() {
    let mesh = "[[mesh]]\nfile = \"bunny.obj\"\nmaterial = \"m\"\n";
    let text = format!("{CAMERA}{}[material.m]\nkd = [0.5, 0.5, 0.5]\n", mesh.repeat(8000));
    let folder = Folder::new(&[("many.toml", &text)]);
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bunny.obj"), folder.at("bunny.obj")).unwrap();
    let output = folder.run(2_500_000, &["explain", "many.toml"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{message}");
    // The line is that of the mesh with which memory is exceeded: neither the first nor the last.
    let line: usize = message.split(':').nth(2).and_then(|line| line.parse().ok()).unwrap();
    assert!((3000..23_000).contains(&line), "{message}");
    assert!(message.contains(": memory for 29392000 triangles: ") && message.contains(" MiB needed, "), "{message}");
    assert!(message.ends_with(" of the address space that RLIMIT_AS allows available\n"), "{message}");
}

/// Whatever the limit, a file is read or refused: an allocation that fails ends the program without a word of the file.
#[test]
fn no_limit_of_memory_ends_in_an_abort() {
    let n = 30_000;
    let names = lines(n, |i| format!("usemtl m{i}\n"));
    let quads = lines(n, |i| format!("v {i} 0 0\nv {i} 1 0\nvn 0 0 1\nvt 0 0\n"))
        + &lines(n - 1, |i| {
            let [a, b, c, d] = [2 * i + 1, 2 * i + 2, 2 * i + 4, 2 * i + 3];
            format!("f {a}/1/{} {b}/1/1 {c}/1/1 {d}/1/1\n", i + 1)
        });
    let materials = lines(n / 4, |i| format!("[material.m{i}]\nkd = [0, 0, 0.5]\n"));
    let meshes = "[[mesh]]\nfile = \"t.obj\"\n".repeat(n / 4);
    for (file, text) in [
        ("names.obj", format!("{TRIANGLE}{names}{FACE}")),
        ("quads.obj", quads),
        ("tables.toml", format!("{CAMERA}{meshes}{materials}")),
        ("keys.toml", lines(n / 4, |i| format!("a{i}{} = 1\n", ".a".repeat(30)))),
        ("array.toml", format!("a = [{}]\n", "0,\n".repeat(4 * n))),
    ] {
        let folder = Folder::new(&[("t.obj", &format!("{TRIANGLE}{FACE}")), (file, &text)]);
        let mut refused = 0;
        for limit in (40_000..400_000).step_by(24_000) {
            let output = folder.run(limit, &["explain", file]);
            let message = String::from_utf8(output.stderr).unwrap();
            assert!(matches!(output.status.code(), Some(0 | 3)), "{file} under {limit} KiB: {message}");
            refused += usize::from(message.contains("RLIMIT_AS"));
        }
        assert!(refused > 0, "{file} is never too large");
    }
}

/// A header of some bytes may claim any size. Fields of a small picture's header are forged, one or two at a time.
#[test]
fn no_forged_header_ends_in_an_abort() {
    use exr::prelude::{AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
    let folder = Folder::new(&[]);
    let channel = |name: &'static str| exr::prelude::AnyChannel::new(name, FlatSamples::F32(vec![0.5; 40 * 30]));
    let channels = AnyChannels::sort(["B", "G", "R"].map(channel).into_iter().collect());
    let layer = Layer::new((40, 30), LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(folder.at("whole.exr")).unwrap();
    let whole = std::fs::read(folder.at("whole.exr")).unwrap();
    let behind = |name: &[u8]| whole.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
    let window = behind(b"dataWindow\0box2i\0");
    let tiles = behind(b"tiles\0tiledesc\0");
    let compression = behind(b"compression\0compression\0");
    let word = |value: i64| (value as u32).to_le_bytes().to_vec();
    let sides = [-1, 0, 41, 16_383, 1 << 24, 1 << 29, i64::from(i32::MAX)];
    let mut forged: Vec<Vec<(usize, Vec<u8>)>> = Vec::new();
    forged.extend(sides.map(|side| vec![(window + 8, word(side))]));
    forged.extend(sides.map(|side| vec![(window + 8, word(side)), (window + 12, word(side))]));
    forged.extend(sides.map(|side| vec![(tiles, word(side)), (tiles + 4, word(side))]));
    forged.extend(sides.map(|side| vec![(tiles, word(1)), (tiles + 4, word(1)), (window + 8, word(side))]));
    forged.extend((0..12).map(|kind| vec![(compression, vec![kind]), (window + 12, word(500))]));
    forged.push(vec![(tiles + 8, vec![2]), (window + 8, word(1 << 30)), (window + 12, word(1 << 30))]);
    forged.push(vec![(window - 4, word(i64::from(i32::MAX)))]);
    forged.push(vec![(window - 4, word(-1))]);
    for fields in forged {
        let mut bytes = whole.clone();
        for (at, field) in &fields {
            bytes[*at..at + field.len()].copy_from_slice(field);
        }
        std::fs::write(folder.at("forged.exr"), bytes).unwrap();
        for limit in [100_000, 1_000_000] {
            let output = folder.run(limit, &["compare", "forged.exr", "whole.exr"]);
            let message = String::from_utf8(output.stderr).unwrap();
            // Refused as a file or for want of memory; where nothing is wrong with it, its window is another.
            assert!(matches!(output.status.code(), Some(0 | 2 | 3 | 4)), "{fields:?}: {message}");
            // A warning of little address space may stand above.
            let errors = message.lines().filter(|line| !line.starts_with("warning: there is little address space"));
            assert_eq!(errors.count(), usize::from(output.status.code() != Some(0)), "{fields:?}: {message}");
        }
    }
}

/// What a file or an argument says is shown, not obeyed.
#[test]
fn no_text_of_a_file_steers_the_terminal() {
    let evil = "\u{9b}31m\u{202e}\u{7f}\u{200b}";
    let mtl = format!("newmtl {evil}\nnewmtl {evil}\nKe 1 1 1\nzz{evil} 1\n");
    let obj = format!("mtllib t.mtl\n{TRIANGLE}usemtl {evil}\n{FACE}bad{evil} 1\n");
    let folder = Folder::new(&[("t.mtl", &mtl), ("t.obj", &obj)]);
    let named = format!("\u{1b}[2J{evil}.obj");
    folder.write(&named, &obj);
    folder.write("bad.obj", &format!("{TRIANGLE}usemtl {evil}\n{FACE}"));
    folder.write("lib.obj", &format!("mtllib {evil}.mtl\n{TRIANGLE}{FACE}"));
    folder.write("bad.toml", &format!("{CAMERA}[film]\n\"{evil}\" = 1\n"));
    folder.write("value.toml", &format!("{CAMERA}[film]\nwidth = \"{evil}\"\n"));
    folder.write("mesh.toml", &format!("{CAMERA}[[mesh]]\nfile = \"{evil}\"\n"));
    folder.write("syntax.toml", &format!("{CAMERA}{evil}\n"));
    let missing = "\u{1b}[31m\n.exr";
    for arguments in [
        &["explain", "t.obj"][..],
        &["explain", "t.obj", "--json"],
        &["explain", &named],
        &["explain", "bad.obj"],
        &["explain", "lib.obj"],
        &["explain", "bad.toml"],
        &["explain", "value.toml"],
        &["explain", "mesh.toml"],
        &["explain", "syntax.toml"],
        &["explain", "t.obj", &named],
        &["compare", missing, missing],
        &["compare", missing, missing, "--difference", &named],
    ] {
        let output = folder.run(0, arguments);
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8(text).unwrap();
        let steers = |character: char| texray::quote::is_hidden(character) && character != '\n';
        assert!(!text.is_empty() && !text.contains(steers), "{arguments:?}: {text:?}");
    }
    let output = folder.run(0, &["explain", "t.obj"]);
    assert!(String::from_utf8(output.stdout).unwrap().contains("material `\\u{9b}31m\\u{202e}\\u{7f}\\u{200b}`"));
}

/// A pipe without a writer, a device, a folder, an endless file: refused at once, whoever names them.
#[test]
fn what_is_no_file_is_refused_at_once() {
    let folder = Folder::new(&[]);
    for name in ["pipe.mtl", "pipe.obj", "pipe.toml", "pipe.exr"] {
        assert!(Command::new("mkfifo").arg(folder.at(name)).status().unwrap().success());
    }
    std::os::unix::fs::symlink("pipe.mtl", folder.at("link.mtl")).unwrap();
    for name in ["pipe.mtl", "link.mtl", "/dev/zero", "/dev/tty", "/proc/self/status", "/proc/self/mem", "."] {
        folder.write("a.obj", &format!("mtllib {name}\n{TRIANGLE}{FACE}"));
        let started = Instant::now();
        let output = folder.run(0, &["explain", "a.obj"]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{name}: {message}");
        assert!(message.starts_with(&format!("error: a.obj:1: mtllib \"{name}\": ")), "{message}");
        assert!(started.elapsed() < Duration::from_secs(3), "{name}: {:?}", started.elapsed());
    }
    let (regular, unwritten) = ("is not a regular file", "is a pipe that nobody writes to");
    folder.write("a.toml", &format!("{CAMERA}[[mesh]]\nfile = \"pipe.obj\"\n"));
    for arguments in [
        &["explain", "a.toml"][..],
        &["explain", "pipe.obj"],
        &["explain", "pipe.toml"],
        &["compare", "pipe.exr", "pipe.exr"],
    ] {
        let output = folder.run(0, arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.code() == Some(3) && [regular, unwritten].iter().any(|text| message.contains(text)),
            "{message}"
        );
    }
}

/// What the scene names is listed whether it was read or not, so that no output takes its place.
#[test]
fn every_file_that_a_scene_names_is_listed() {
    let mtl = "newmtl m\nmap_Kd -s 1 1 1 my wood.png\nnorm n.png\n";
    let folder = Folder::new(&[
        ("a.obj", &format!("mtllib a.mtl\n{TRIANGLE}usemtl m\n{FACE}")),
        ("b.obj", &format!("mtllib later.mtl other.mtl\n{TRIANGLE}{FACE}")),
        ("a.mtl", mtl),
        (
            "s.toml",
            &format!(
                "{CAMERA}[[mesh]]\nfile = \"a.obj\"\n[[mesh]]\nfile = \"b.obj\"\nmaterial = \"m\"\n\
                 [material.m]\nkd = [0, 0, 0]\n"
            ),
        ),
    ]);
    let scene = Scene::load(&folder.at("s.toml")).unwrap();
    for name in ["a.obj", "a.mtl", "b.obj", "later.mtl", "other.mtl", "later.mtl other.mtl", "my wood.png", "n.png"] {
        assert!(scene.report.files.contains(&folder.at(name)), "{name}: {:?}", scene.report.files);
    }
    let output = folder.run(0, &["render", "s.toml", "--spp", "1", "--size", "8x8", "-o", "my wood.png"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && message.contains("the output is a file of the scene itself"),
        "{message}"
    );
    assert!(!folder.at("my wood.png").exists());
}
