//! The program as a user runs it: a small room in a folder of its own, commands in that folder, and what they leave.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use exr::prelude::read_first_rgba_layer_from_file;
use rustix::process::Pid;
pub use rustix::process::Signal;
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "[camera]\norigin = [0.0, 0.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n\
    [film]\nwidth = 24\nheight = 16\n[render]\nspp = 32\nmax_bounces = 3\n[[mesh]]\nfile = \"room.obj\"\n";
/// A floor under a small lamp.
const OBJ: &str = "mtllib room.mtl\nv -2 -1 -2\nv 2 -1 -2\nv 2 -1 2\nv -2 -1 2\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n\
    usemtl floor\nf 4 3 2 1\nusemtl lamp\nf 5 6 7 8\n";
const MTL: &str = "newmtl floor\nKd 0.5 0.6 0.7\nnewmtl lamp\nKd 0 0 0\nKe 4 4 4\n";

/// The program.
pub const TEXRAY: &str = env!("CARGO_BIN_EXE_texray");

/// A folder with the scene `room.toml`.
pub fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("room.toml", SCENE), ("room.obj", OBJ), ("room.mtl", MTL)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Runs the program to its end.
pub fn texray(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(TEXRAY).current_dir(folder).args(arguments).output().unwrap()
}

/// Runs a line of bash in which `$T` is the program.
pub fn bash(folder: &Path, line: &str) -> Output {
    Command::new("bash").current_dir(folder).env("T", TEXRAY).args(["-c", line]).output().unwrap()
}

/// Runs, expects this exit code, and returns what was said on stderr.
pub fn expect(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = texray(folder, arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    stderr
}

/// Bytes as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Starts the program with the signals as a terminal starts it: a test that runs in the background of a script ignores
/// some of them, and so would the program. Returns once it has named its device: it renders from then on.
pub fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new("env");
    command.args(["--default-signal=INT,TERM,HUP", TEXRAY]).args(arguments).current_dir(folder);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.starts_with("device") {
        line.clear();
        assert!(stderr.read_line(&mut line).unwrap() > 0, "the program ended before it began to render");
    }
    // What it says after that is read, so that it never waits for a reader.
    std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
    child
}

/// Sends a signal. The child may have ended already; then there is nobody to signal.
pub fn signal(child: &Child, signal: Signal) {
    let _ = rustix::process::kill_process(Pid::from_child(child), signal);
}

/// Waits for the end and returns its code; a program that does not end is killed, and has none.
pub fn code(child: &mut Child) -> Option<i32> {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
        }
        sleep(Duration::from_millis(10));
    }
    child.wait().unwrap().code()
}

/// The document on stdout of a program that has ended.
pub fn document(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

/// Width, and the bits of every pixel, of an EXR file.
pub fn exr(path: &Path) -> (usize, Vec<[u32; 3]>) {
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| (size.0, vec![[0u32; 3]; size.0 * size.1]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.1 * *width + at.0] = [r.to_bits(), g.to_bits(), b.to_bits()];
        },
    );
    image.unwrap_or_else(|error| panic!("{}: {error}", path.display())).layer_data.channel_data.pixels
}

/// The samples that an EXR file says it has.
pub fn spp(path: &Path) -> u32 {
    texray::output::Stored::read(path).get("spp").expect("a picture of texray").parse().unwrap()
}

/// Names in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| text(entry.unwrap().file_name().as_encoded_bytes())).collect();
    names.sort();
    names
}

/// Whether this is root, who may make devices and mounts, and whom no mode keeps from writing.
pub fn is_root() -> bool {
    rustix::process::geteuid().is_root()
}
