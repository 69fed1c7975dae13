//! When a render stops: each rule, rules together, what the end says of them, and that no rule changes a picture but by its samples.
//!
//! Comes in: a small room and the Cornell box, by the command line. Exact but for the clock: a time limit of 3 s may be passed by 0.5 s
//! (design, section 7). Tests of this program take turns, so that the clock is theirs.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use exr::prelude::read_first_rgba_layer_from_file;
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "[camera]\norigin = [0.0, 0.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n\
    [film]\nwidth = 64\nheight = 48\n[render]\nspp = 48\nmax_bounces = 3\n[[mesh]]\nfile = \"room.obj\"\n";
const MTL: &str =
    "newmtl floor\nKd 0.5 0.6 0.7\nnewmtl lamp\nKd 0 0 0\nKe 4 4 4\nnewmtl spark\nKd 0 0 0\nKe 100000 100000 100000\n";
const FLOOR: &str = "mtllib room.mtl\nusemtl floor\nv -2 -1 -2\nv 2 -1 -2\nv 2 -1 2\nv -2 -1 2\nf 4 3 2 1\n";
const LAMP: &str = "usemtl lamp\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\nf 5 6 7 8\n";
/// A tiny light behind the camera, which almost no path finds by chance.
const SPARK: &str = "usemtl spark\nv -.03 1 3.4\nv .03 1 3.4\nv .03 1 3.46\nv -.03 1 3.46\nf 5 6 7 8\n";

static TURN: Mutex<()> = Mutex::new(());

fn turn() -> MutexGuard<'static, ()> {
    // A test that failed in its turn has nothing that the next one could find broken.
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn folder(light: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let obj = format!("{FLOOR}{light}");
    for (name, text) in [("room.toml", SCENE), ("room.obj", obj.as_str()), ("room.mtl", MTL)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn texray(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texray"));
    command.current_dir(folder).arg("render").args(arguments).output().unwrap()
}

/// Runs, expects this exit code, and returns the document on stdout and the text on stderr.
fn json(folder: &Path, arguments: &[&str], code: i32) -> (Value, String) {
    let output = texray(folder, &[arguments, &["--json"]].concat());
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    (serde_json::from_slice(&output.stdout).unwrap(), stderr)
}

fn pixels(path: &Path) -> Vec<[u32; 3]> {
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| (size.0, vec![[0u32; 3]; size.0 * size.1]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.1 * *width + at.0] = [r.to_bits(), g.to_bits(), b.to_bits()];
        },
    );
    image.unwrap().layer_data.channel_data.pixels.1
}

#[test]
fn a_target_is_reached_and_the_picture_is_that_of_its_samples() {
    let _turn = turn();
    let folder = folder(LAMP);
    let (document, stderr) = json(folder.path(), &["room.toml", "--target-error", "2%", "-o", "target.exr"], 0);
    let error = &document["error"];
    let spp = document["spp"].as_u64().unwrap();
    assert_eq!(document["stop_reason"], "target-error");
    assert!(stderr.contains(&format!("done: error at most 2.00 % at {spp} spp")), "{stderr}");
    assert!(spp >= 32 && spp % 16 == 0, "{spp} spp");
    assert!(error["upper"].as_f64().unwrap() <= 0.02, "{error}");
    assert!(error["relative_rmse"].as_f64().unwrap() < error["upper"].as_f64().unwrap(), "{error}");
    assert_eq!((&error["target"], &error["confidence"]), (&Value::from(0.02), &Value::from(0.95)));
    assert!(error["looks"].as_u64().unwrap() >= 1 && error["forecast"]["spp"].as_u64().unwrap() >= 32, "{error}");
    json(folder.path(), &["room.toml", "--spp", &spp.to_string(), "-o", "spp.exr"], 0);
    assert_eq!(pixels(&folder.path().join("target.exr")), pixels(&folder.path().join("spp.exr")));

    // More confidence takes at least as many samples.
    let sure = ["room.toml", "--target-error", "2%", "--confidence", "99.99%", "-o", "sure.exr"];
    assert!(json(folder.path(), &sure, 0).0["spp"].as_u64().unwrap() >= spp);
}

#[test]
fn what_comes_first_counts() {
    let _turn = turn();
    let folder = folder(LAMP);
    let far = ["room.toml", "--target-error", "0.001%", "--spp", "48", "-o", "far.exr", "--time-limit", "10m"];
    let (document, stderr) = json(folder.path(), &far, 6);
    assert_eq!((&document["stop_reason"], &document["spp"]), (&"spp".into(), &48.into()));
    assert!(stderr.contains("error: --target-error 0.00100 % is not met: the error is at most"), "{stderr}");
    assert!(folder.path().join("far.exr").exists(), "the picture is saved");

    let (document, stderr) =
        json(folder.path(), &["room.toml", "--target-error", "1%", "--spp", "8", "-o", "few.exr"], 6);
    assert_eq!(document["error"], Value::Null);
    assert!(stderr.contains("8 spp are too few to know the error"), "{stderr}");

    let near = ["room.toml", "--target-error", "50%", "--spp", "4000", "--time-limit", "10m", "-o", "near.exr"];
    assert_eq!(json(folder.path(), &near, 0).0["stop_reason"], "target-error");

    let (document, _) = json(folder.path(), &["room.toml", "-o", "none.exr"], 0);
    assert_eq!((&document["stop_reason"], &document["error"]["target"]), (&"spp".into(), &Value::Null));
    assert!(document["error"]["upper"].as_f64().unwrap() > document["error"]["relative_rmse"].as_f64().unwrap());
}

#[test]
fn a_time_limit_is_kept_with_a_whole_picture() {
    let _turn = turn();
    let folder = folder(LAMP);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box.toml");
    let started = Instant::now();
    let limited = [scene, "--size", "320x240", "--time-limit", "3s", "-o", "limited.exr", "-o", "limited.png"];
    let (document, stderr) = json(folder.path(), &limited, 0);
    let seconds = started.elapsed().as_secs_f64();
    assert!(seconds < 3.5, "a limit of 3 s took {seconds} s");
    let spp = document["spp"].as_u64().unwrap();
    assert_eq!(document["stop_reason"], "time-limit");
    assert!(spp > 1 && stderr.contains(&format!("stopped by --time-limit at {spp} spp")), "{stderr}");
    json(folder.path(), &[scene, "--size", "320x240", "--spp", &spp.to_string(), "-o", "spp.exr"], 0);
    assert_eq!(pixels(&folder.path().join("limited.exr")), pixels(&folder.path().join("spp.exr")));

    let (document, stderr) =
        json(folder.path(), &[scene, "--size", "64x64", "--time-limit", "0.001s", "-o", "late.exr"], 0);
    assert_eq!((&document["spp"], &document["stop_reason"]), (&1.into(), &"time-limit".into()));
    assert!(stderr.contains("late: the first sample was finished after"), "{stderr}");
}

#[test]
fn a_dry_run_says_what_it_would_take_and_writes_nothing() {
    let _turn = turn();
    let folder = folder(LAMP);
    let files = || fs::read_dir(folder.path()).unwrap().count();
    let before = files();
    let (document, _) = json(folder.path(), &["room.toml", "--dry-run", "--spp", "3200"], 0);
    assert_eq!(files(), before);
    assert_eq!((&document["dry_run"], &document["pilot"]["spp"]), (&true.into(), &32.into()));
    let asked = &document["asked"];
    assert_eq!(asked["spp"], 3200);
    // The squared error of Sobol' points is taken to fall as samples to the power -1.1.
    let expected = document["pilot"]["relative_rmse"].as_f64().unwrap() / 100f64.powf(0.55);
    assert!((asked["relative_rmse"].as_f64().unwrap() / expected - 1.0).abs() < 1e-9, "{document}");
    assert!(
        document["bytes"]["film"].as_u64().unwrap() > 64 * 48 * 48 && document["bytes"]["device"].as_u64().unwrap() > 0
    );
    let spp: Vec<u64> =
        document["targets"].as_array().unwrap().iter().map(|target| target["spp"].as_u64().unwrap()).collect();
    assert!(
        spp.len() == 4 && spp.is_sorted() && spp[3] > 7 * spp[2],
        "0.3 of the error takes 8.9 times the samples, to a look a quarter away: {spp:?}"
    );

    let output = texray(folder.path(), &["room.toml", "--dry-run", "--target-error", "1%"]);
    let stdout = String::from_utf8(output.stdout).unwrap();
    for line in ["pilot: 32 spp in", "error 1.00 %: about", "error 0.500 %: about", "memory: film", "emitters"] {
        assert!(stdout.contains(line), "{line} in\n{stdout}");
    }
    assert_eq!(files(), before);
}

#[test]
fn a_heavy_tail_is_said_and_not_trusted() {
    let _turn = turn();
    let folder = folder(SPARK);
    let (document, stderr) = json(
        folder.path(),
        &["room.toml", "--lights", "bsdf", "--target-error", "1000%", "--spp", "64", "-o", "spark.exr"],
        6,
    );
    assert_eq!(
        (&document["error"]["heavy_tailed"], &document["stop_reason"]),
        (&true.into(), &"spp".into()),
        "{document}"
    );
    assert!(stderr.contains("warning: heavy tail: 0.1 % of the pixels hold"), "{stderr}");
    assert!(stderr.contains("is not met: the error has a heavy tail"), "{stderr}");
    assert!(document["error"]["dark_pixels"].as_u64().unwrap() > 0);
}

/// In a closed box whose walls all emit 1 and reflect a half, each bounce brings half of what the last did: paths of at most n bounces bring
/// 2 - 2^-n of 2, so a cap of 3 cuts off 1/16. The estimate has one noise, whether roulette ends a path; z at most 5.
#[test]
fn the_bias_of_the_cap_is_what_it_cuts_off() {
    let _turn = turn();
    let folder = folder(LAMP);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml");
    let capped = [scene, "--size", "64x48", "--spp", "16", "--max-bounces", "3", "-o", "f.exr"];
    let (document, stderr) = json(folder.path(), &[&capped[..], &["--max-bias", "10%"]].concat(), 0);
    let figure = |name: &str| document["bias"][name].as_f64().unwrap();
    let (share, error) = (figure("bounce_cap"), figure("standard_error"));
    assert!((share - 0.0625).abs() < 5.0 * error + 1e-5 && error < 0.002, "{share} ± {error}, should be 0.0625");
    assert_eq!(document["bias"]["up_to_bounces"], 88);
    assert!(stderr.contains("bias: the cap of 3 bounces cuts off 6.2"), "{stderr}");

    let (_, stderr) = json(folder.path(), &[&capped[..], &["--max-bias", "5%"]].concat(), 6);
    assert!(stderr.contains("error: --max-bias 5.00 % is not kept: the bounce cap cuts off 6.2"), "{stderr}");

    // Nothing is beyond the first bounce where the floor sees itself nowhere; and a small render that is not asked says nothing.
    let (document, _) =
        json(folder.path(), &["room.toml", "--max-bounces", "2", "--max-bias", "0.0001%", "-o", "r.exr"], 0);
    assert_eq!(document["bias"]["bounce_cap"], 0.0);
    assert_eq!(json(folder.path(), &capped, 0).0["bias"]["bounce_cap"], Value::Null);
}

/// A furnace of albedo 1 keeps paths alive to the last bounce, and the estimate of what the cap cuts off would take
/// minutes: the limit holds for it too, and what it does not let be known is not kept.
#[test]
fn a_time_limit_holds_with_the_bias_of_the_cap() {
    let _turn = turn();
    let folder = folder(LAMP);
    let furnace = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml")).unwrap();
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.obj");
    let (furnace, _) = furnace.split_once("[material.wall]").unwrap();
    let white = furnace.replace("furnace.obj", mesh) + "[material.wall]\nkd = [1, 1, 1]\nke = [1, 1, 1]\n";
    fs::write(folder.path().join("white.toml"), white).unwrap();
    for bounces in ["300", "1000"] {
        let started = Instant::now();
        let limited = [
            "white.toml",
            "--size",
            "64x64",
            "--max-bounces",
            bounces,
            "--time-limit",
            "2s",
            "--max-bias",
            "1%",
            "-o",
            "w.exr",
        ];
        let (document, stderr) = json(folder.path(), &limited, 6);
        let seconds = started.elapsed().as_secs_f64();
        assert!(seconds < 2.5, "a limit of 2 s took {seconds} s at {bounces} bounces");
        assert!(document["bias"]["bounce_cap"].is_null() && document["spp"].as_u64().unwrap() >= 1, "{document}");
        let missing =
            "--max-bias 1.00 % is not met: what the bounce cap cuts off is not known: the time limit ended before";
        assert!(stderr.contains(missing), "{stderr}");
        assert!(folder.path().join("w.exr").is_file());
    }
    // Where there is time for it, it is known, and the picture says so.
    let (document, _) =
        json(folder.path(), &["room.toml", "--time-limit", "8s", "--max-bias", "50%", "-o", "r.exr"], 0);
    let share = document["bias"]["bounce_cap"].as_f64().unwrap();
    let stored = texray::output::Stored::read(&folder.path().join("r.exr"));
    assert_eq!(stored.get("bias_bounce_cap").unwrap().parse::<f64>().unwrap(), share);
}

#[test]
fn refusals() {
    let _turn = turn();
    let folder = folder(LAMP);
    for (arguments, message) in [
        (&["room.toml", "--target-error", "0"][..], "use a ratio above 0"),
        (&["room.toml", "--confidence", "90%"], "--target-error"),
        (&["room.toml", "--target-error", "1%", "--confidence", "1"], "use a probability from 50 %"),
        (&["room.toml", "--time-limit", "soon"], "use a time above 0"),
        (&["room.toml", "--target-error", "1%", "--sampler", "table"], "the replicates of a table are not independent"),
    ] {
        let output = texray(folder.path(), arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(message) && output.stdout.is_empty(), "{arguments:?}: {stderr}");
    }
}
