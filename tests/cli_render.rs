//! The command line with a device: files, JSON, exit codes of scenes and signals, crops, repeatability.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use exr::prelude::read_first_rgba_layer_from_file;
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "[camera]\norigin = [0.0, 0.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n\
    [film]\nwidth = 24\nheight = 16\n[render]\nspp = 32\nmax_bounces = 3\n[[mesh]]\nfile = \"room.obj\"\n";
/// A floor under a small lamp.
const OBJ: &str = "mtllib room.mtl\nv -2 -1 -2\nv 2 -1 -2\nv 2 -1 2\nv -2 -1 2\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n\
    usemtl floor\nf 4 3 2 1\nusemtl lamp\nf 5 6 7 8\n";
const MTL: &str = "newmtl floor\nKd 0.5 0.6 0.7\nnewmtl lamp\nKd 0 0 0\nKe 4 4 4\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("room.toml", SCENE), ("room.obj", OBJ), ("room.mtl", MTL)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texray"));
    command.current_dir(folder).args(arguments);
    command
}

fn texray(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Runs, expects exit code 0 and returns the document on stdout.
fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = texray(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str], code: i32, message: &str) {
    let output = texray(folder, arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    assert!(stderr.contains(message), "{arguments:?}: {stderr}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
}

/// Width, and the bits of every pixel.
fn exr(path: &Path) -> (usize, Vec<[u32; 3]>) {
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| (size.0, vec![[0u32; 3]; size.0 * size.1]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.1 * *width + at.0] = [r.to_bits(), g.to_bits(), b.to_bits()];
        },
    );
    image.unwrap().layer_data.channel_data.pixels
}

#[test]
fn default_pictures_are_named_on_the_last_line() {
    let folder = folder();
    let output = texray(folder.path(), &["render", "room.toml"]);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(output.stdout.is_empty());
    assert_eq!(stderr.lines().last(), Some("done: all 32 spp; wrote room.exr, room.png"), "{stderr}");
    assert!(stderr.contains("estimated relative RMSE"), "{stderr}");
    let picture = image::open(folder.path().join("room.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (24, 16));
    let (width, pixels) = exr(&folder.path().join("room.exr"));
    assert_eq!((width, pixels.len()), (24, 24 * 16));
    assert!(pixels.iter().flatten().any(|&bits| f32::from_bits(bits) > 0.0));
    refused(folder.path(), &["render", "room.toml", "--no-clobber"], 5, "room.exr: exists already");
}

#[test]
fn quiet_says_nothing() {
    let folder = folder();
    let output = texray(folder.path(), &["render", "room.toml", "-q", "-o", "a.hdr"]);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
    assert!(output.stdout.is_empty() && folder.path().join("a.hdr").is_file());
}

#[test]
fn json_is_one_document() {
    let folder = folder();
    let document = json(folder.path(), &["render", "room.toml", "--json", "-o", "a.exr", "--spp", "48", "--seed", "7"]);
    for key in [
        "schema",
        "scene",
        "device",
        "driver",
        "width",
        "height",
        "spp",
        "max_bounces",
        "seed",
        "triangles",
        "effects",
        "stop_reason",
        "seconds",
        "paths_per_second",
        "rays_per_second",
        "error",
        "bias",
        "invalid_samples",
        "bytes",
        "peak_rss_bytes",
    ] {
        assert!(document.get(key).is_some(), "{key} in {document:#}");
    }
    for key in ["load", "bvh", "upload", "pipeline", "render", "estimate", "readback", "write", "total"] {
        assert!(document["seconds"][key].as_f64().is_some_and(|seconds| seconds >= 0.0), "{key} in {document:#}");
    }
    assert_eq!((&document["schema"], &document["spp"], &document["seed"]), (&1.into(), &48.into(), &7.into()));
    assert_eq!((&document["stop_reason"], &document["triangles"]), (&"spp".into(), &4.into()));
    assert!(document["error"]["relative_rmse"].as_f64().is_some_and(|error| error > 0.0));
    assert!(document["bias"]["bounce_cap"].is_null());
    for cause in ["sum", "camera", "emission", "sky", "light", "lambert", "mirror", "glass"] {
        assert_eq!(document["invalid_samples"][cause], 0);
    }
    for kind in ["nan", "infinite", "negative"] {
        assert_eq!(document["invalid_kinds"][kind], 0);
    }
    assert!(document["bytes"]["uploaded"].as_u64().is_some_and(|bytes| bytes > 0));
}

#[test]
fn error_is_null_before_two_blocks() {
    let folder = folder();
    for (spp, is_null) in [("1", true), ("31", true), ("32", false)] {
        let document = json(folder.path(), &["render", "room.toml", "--json", "-o", "a.exr", "--spp", spp]);
        assert_eq!(document["error"].is_null(), is_null, "{spp} spp");
    }
}

/// A picture's name cannot be that of a mesh, but a ledger's can.
#[test]
fn files_of_the_scene_are_not_overwritten() {
    let folder = folder();
    for (file, text) in [("room.toml", SCENE), ("room.obj", OBJ), ("room.mtl", MTL)] {
        let output = texray(folder.path(), &["render", "room.toml", "--ledger", file, "--spp", "1"]);
        assert_eq!(output.status.code(), Some(2), "{file}");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(message.contains("the output is a file of the scene itself"), "{file}: {message}");
        assert_eq!(fs::read_to_string(folder.path().join(file)).unwrap(), text);
    }
}

#[test]
fn equal_renders_are_equal_files() {
    let folder = folder();
    for name in ["a.exr", "b.exr"] {
        json(folder.path(), &["render", "room.toml", "--json", "-o", name]);
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("a.exr") == read("b.exr"));
}

#[test]
fn a_crop_is_that_part_of_the_whole() {
    let folder = folder();
    json(folder.path(), &["render", "room.toml", "--json", "-o", "whole.exr"]);
    json(folder.path(), &["render", "room.toml", "--json", "-o", "crop.exr", "--crop", "5,3,11,7"]);
    let (_, whole) = exr(&folder.path().join("whole.exr"));
    let (width, crop) = exr(&folder.path().join("crop.exr"));
    assert_eq!((width, crop.len()), (11, 77));
    for (i, pixel) in crop.iter().enumerate() {
        assert_eq!(*pixel, whole[(3 + i / 11) * 24 + 5 + i % 11], "pixel {i}");
    }
    refused(folder.path(), &["render", "room.toml", "--crop", "20,0,5,1"], 2, "reaches beyond the picture of 24x16");
}

#[test]
fn the_ledger_and_the_document_agree_on_bytes() {
    let folder = folder();
    let arguments = ["render", "room.toml", "--json", "-o", "a.exr", "--ledger", "ledger.json"];
    let document = json(folder.path(), &arguments);
    let ledger: Value = serde_json::from_slice(&fs::read(folder.path().join("ledger.json")).unwrap()).unwrap();
    for (total, key) in [("bytes_up", "uploaded"), ("bytes_down", "read_back")] {
        assert!(ledger[total].as_u64().is_some_and(|bytes| bytes > 0), "{ledger:#}");
        assert_eq!(ledger[total], document["bytes"][key], "{total}");
    }
    assert!(ledger["entries"].as_array().unwrap().iter().any(|entry| entry["direction"] == "absent"), "{ledger:#}");
}

#[test]
fn verbose_prints_effects() {
    let folder = folder();
    let output = texray(folder.path(), &["render", "room.toml", "-v", "-o", "a.png"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).contains("emitters"), "{}", text(&output.stderr));
}

#[test]
fn bad_scenes_are_refused() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("room.mtl", &MTL.replace("0.5 0.6", "0.5 -0.6"));
    refused(folder.path(), &["render", "room.toml"], 3, "room.mtl:2");
    write("room.mtl", &MTL.replace("Ke 4 4 4", "Ke 0 0 0"));
    refused(folder.path(), &["render", "room.toml"], 3, "room.toml");
    assert!(!folder.path().join("room.exr").exists());
    json(folder.path(), &["render", "room.toml", "--json", "-o", "black.exr", "--allow-black"]);
    assert!(exr(&folder.path().join("black.exr")).1.iter().flatten().all(|&bits| bits == 0));
}

#[test]
fn devices_are_listed_and_refused() {
    let folder = folder();
    let devices = json(folder.path(), &["devices", "--json"]);
    assert!(devices["devices"].as_array().is_some_and(|devices| !devices.is_empty()));
    let probes = devices["devices"][0]["startup"].as_array().expect("a usable device is probed");
    for name in ["nan", "loops", "rounding", "sine and cosine", "division", "square root", "denormals"] {
        let probe = probes.iter().find(|probe| probe["what"] == name).unwrap_or_else(|| panic!("{name} in {probes:?}"));
        assert_eq!(probe["passes"], true, "{probe}");
    }
    let verbose = texray(folder.path(), &["devices", "-v"]);
    assert!(text(&verbose.stdout).contains("probe: loops"), "{}", text(&verbose.stdout));
    refused(folder.path(), &["render", "room.toml", "--device", "999"], 2, "999");
    refused(folder.path(), &["render", "room.toml", "--device", "no such device"], 2, "no such device");
}

#[test]
fn explain_gives_reasons() {
    let folder = folder();
    let effects = |arguments: &[&str]| -> Vec<(String, bool)> {
        let document = json(folder.path(), arguments);
        let line = |line: &Value| (line["name"].as_str().unwrap().to_string(), line["on"].as_bool().unwrap());
        document["effects"].as_array().unwrap().iter().map(line).collect()
    };
    let least = effects(&["explain", "room.toml", "--json", "--filter", "box"]);
    assert_eq!(least.iter().filter(|(_, on)| *on).map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["emitters"]);
    assert!(effects(&["explain", "room.toml", "--json", "--effects", "all"]).iter().all(|(_, on)| *on));
}

/// Starts an endless render, sends it these signals once it has run for a while, and returns what it left.
#[cfg(unix)]
fn interrupted(folder: &Path, signals: &[&str]) -> (Option<i32>, String, Duration) {
    let arguments = ["render", "room.toml", "--spp", "4294967295", "--json", "-o", "a.exr"];
    // Started in the background of a script, the tests ignore SIGINT, and so would texray, which keeps what it is started with.
    // GNU's `env` sets signals back before it becomes the program.
    let mut started = match cfg!(target_os = "linux") {
        true => Command::new("env"),
        false => command(folder, &[]),
    };
    if cfg!(target_os = "linux") {
        started.args(["--default-signal=INT,TERM,HUP", env!("CARGO_BIN_EXE_texray")]);
    }
    let mut child =
        started.current_dir(folder).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    stderr.read_line(&mut line).unwrap();
    assert!(line.starts_with("device"), "{line}");
    sleep(Duration::from_secs(3));
    let sent = Instant::now();
    for signal in signals {
        assert!(Command::new("kill").args([*signal, &child.id().to_string()]).status().unwrap().success());
    }
    // A render that does not answer is ended: the code is none then, and the test fails instead of waiting for ever.
    while child.try_wait().unwrap().is_none() {
        if sent.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
        }
        sleep(Duration::from_millis(20));
    }
    let mut stdout = String::new();
    child.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
    (child.wait().unwrap().code(), stdout, sent.elapsed())
}

#[cfg(unix)]
#[test]
fn a_signal_saves_the_picture() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        let folder = folder();
        let (status, stdout, _) = interrupted(folder.path(), &[signal]);
        assert_eq!(status, Some(code), "{signal}");
        let document: Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(document["stop_reason"], "interrupted");
        let spp = document["spp"].as_u64().unwrap();
        assert!((1..4_294_967_295).contains(&spp), "{signal}: {spp} spp");
        assert_eq!(exr(&folder.path().join("a.exr")).1.len(), 24 * 16);
    }
}

#[test]
fn the_self_test_tells_of_each_case() {
    let folder = folder();
    let document = json(folder.path(), &["selftest", "--case", "4", "--case", "17", "--json"]);
    assert_eq!(
        (&document["schema"], &document["passes"], &document["tier"]),
        (&1.into(), &true.into(), &"fast".into())
    );
    let cases = document["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 2);
    assert_eq!((&cases[0]["case"], &cases[0]["verdict"]), (&4.into(), &"pass".into()));
    assert!(!cases[0]["findings"].as_array().unwrap().is_empty());
    assert_eq!(cases[1]["verdict"], "shown_by_tests");
    assert!(document["verdict"].as_str().is_some_and(|verdict| verdict.starts_with("1 case passed")));

    let output = texray(folder.path(), &["selftest", "--case", "4", "--case", "17", "--case", "75", "--verbose"]);
    assert_eq!(output.status.code(), Some(0));
    let table = text(&output.stdout);
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    let last = table.lines().last().unwrap_or_default();
    assert_eq!(last, "verdict: 1 case passed; the device can be trusted as far as that goes");
    for line in ["  4  ok     min, max and clamp of NaN", " 17  tests  triangles without area", " 75  later  "] {
        assert!(table.contains(line), "{line} in\n{table}");
    }
}

/// Threads of the driver (lavapipe takes `LP_NUM_THREADS`) and of the host's own work: the file is the same, byte for byte.
#[test]
fn threads_do_not_show() {
    let folder = folder();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-glass.toml");
    let render = |file: &str, driver: &str, host: &str| {
        let arguments = ["render", scene, "--size", "61x47", "--spp", "20", "--aov", "variance", "-q", "-o", file];
        let mut command = command(folder.path(), &arguments);
        let output = command.env("LP_NUM_THREADS", driver).env("RAYON_NUM_THREADS", host).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
        fs::read(folder.path().join(file)).unwrap()
    };
    let one = render("one.exr", "1", "1");
    for (file, driver, host) in [("driver.exr", "2", "1"), ("host.exr", "1", "3"), ("both.exr", "4", "2")] {
        assert!(render(file, driver, host) == one, "{driver} threads of the driver and {host} of the host show");
    }
}

#[test]
fn layers_and_error_map() {
    let folder = folder();
    let asked =
        ["render", "room.toml", "--aov", "variance,samples", "--error-map", "error.png", "-o", "a.exr", "--json"];
    let document = json(folder.path(), &asked);
    assert_eq!(document["outputs"], serde_json::json!(["a.exr", "error.png"]));
    let image = exr::prelude::read_all_flat_layers_from_file(folder.path().join("a.exr")).unwrap();
    let channel = |name: &str| -> Vec<f32> {
        let channels = &image.layer_data[0].channel_data.list;
        let channel =
            channels.iter().find(|channel| channel.name.to_string() == name).unwrap_or_else(|| panic!("{name}"));
        channel.sample_data.values_as_f32().collect()
    };
    assert!(channel("samples.Y").iter().all(|&count| count == 32.0));
    let variance = channel("variance.G");
    assert!(variance.iter().all(|&v| v >= 0.0) && variance.iter().any(|&v| v > 0.0));
    // The picture is the same as without layers.
    json(folder.path(), &["render", "room.toml", "-o", "b.exr", "--json"]);
    assert_eq!(exr(&folder.path().join("a.exr")), exr(&folder.path().join("b.exr")));

    let decoder = png::Decoder::new(BufReader::new(fs::File::open(folder.path().join("error.png")).unwrap()));
    let reader = decoder.read_info().unwrap();
    let info = reader.info();
    assert_eq!((info.width, info.height), (24, 16));
    let text = &info.uncompressed_latin1_text;
    assert!(text.iter().any(|text| text.keyword == "Description" && text.text.starts_with("relative standard error")));

    // With variances, `compare` tells noise from difference.
    json(folder.path(), &["render", "room.toml", "--aov", "variance", "--seed", "1", "-o", "c.exr", "--json"]);
    let compared = texray(folder.path(), &["compare", "a.exr", "c.exr", "--max-failed-tests", "0"]);
    assert_eq!(compared.status.code(), Some(0), "{}", text_of(&compared));

    refused(
        folder.path(),
        &["render", "room.toml", "--aov", "variance", "-o", "a.png"],
        2,
        "layers are for .exr files",
    );
    refused(
        folder.path(),
        &["render", "room.toml", "--aov", "depth", "-o", "d.exr"],
        2,
        "possible values: variance, samples",
    );
    refused(folder.path(), &["render", "room.toml", "--error-map", "map.exr"], 2, "use a name that ends in .png");
    refused(
        folder.path(),
        &["render", "room.toml", "--error-map", "e.png", "-o", "e.png"],
        2,
        "two outputs have this name",
    );
}

fn text_of(output: &Output) -> String {
    format!("{}{}", text(&output.stdout), text(&output.stderr))
}

/// A picture without light is told to be black, not to have no error; what is taken for granted is told but for -q.
#[test]
fn a_black_picture_is_told_to_be_black() {
    let folder = folder();
    let path = folder.path();
    let expect = |arguments: &[&str]| {
        let output = texray(path, arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stderr)
    };
    fs::write(path.join("back.obj"), "mtllib room.mtl\nusemtl lamp\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 3 2 1\n").unwrap();
    for (spp, error) in [("32", "error unknown: the picture is black"), ("4", "error unknown before two blocks")] {
        let arguments = ["render", "back.obj", "--size", "8x8", "--spp", spp, "-o", "back.exr", "--overwrite"];
        let told = expect(&arguments);
        for part in
            ["note: back.obj: an OBJ file has no camera", "warning: the picture is black", "backs of lamps", error]
        {
            assert!(told.contains(part), "{part}: {told}");
        }
    }
    let quiet = expect(&["render", "back.obj", "--size", "8x8", "--spp", "32", "-o", "b.exr", "-q"]);
    assert!(quiet.contains("warning: the picture is black") && !quiet.contains("note: "), "{quiet}");
    let lit = expect(&["render", "room.toml", "--spp", "32", "-o", "room.exr"]);
    assert!(!lit.contains("black"), "{lit}");
}
