//! `texray study`: the rows are whole, a stopped study goes on, peers are run as their scripts want it, the report has what was
//! measured, refusals are one line.

mod harness;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use harness::device::{assert_valid, context};
use serde_json::Value;
use texray::study::{self, Amount, Ended, Kind, Origin, Plan, Rows, Watch, page, subprocess::Subprocess};

const REPEATS: usize = 3;

fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.toml")
}

fn study(arguments: &[&str], out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texray"));
    command.arg("study").args(arguments).arg("--out").arg(out);
    command
}

fn speed(out: &Path) -> Command {
    let scene = scene();
    study(&["speed", scene.to_str().expect("a path of text"), "--quick"], out)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn succeeded(output: &Output) -> String {
    assert!(output.status.success(), "{}: {}", output.status, text(&output.stderr));
    text(&output.stdout)
}

/// Stands for a Python with Mitsuba: answers the import with success, and a render with a picture and figures made before.
/// What it was asked is kept in `asked`.
#[cfg(unix)]
fn fake_python(folder: &Path) -> PathBuf {
    let picture = folder.join("peer.exr");
    let mut render = Command::new(env!("CARGO_BIN_EXE_texray"));
    render.arg("render").arg(scene()).args(["--size", "160x120", "--spp", "16", "--filter", "box", "-q", "-o"]);
    succeeded(&render.arg(&picture).output().expect("texray starts"));
    // Blender may be installed here: Cycles is to be left out.
    program(&folder.join("blender"), "#!/bin/sh\nexit 1\n");
    let python = folder.join("python");
    let asked = folder.join("asked");
    let script = format!(
        "#!/bin/sh\nset -eu\n[ \"$1\" = -c ] && exit 0\necho \"$*\" >>'{}'\nwhile [ \"$1\" != --out ]; do shift; done\n\
         cp '{}' \"$2.exr\"\necho '{{\"mpaths_s\": 2.5, \"spp\": 64, \"s_render\": 1.5}}' >\"$2.json\"\n",
        asked.display(),
        picture.display()
    );
    program(&python, &script);
    python
}

#[cfg(unix)]
fn program(path: &Path, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    fs::write(path, script).expect("the script can be written");
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("the script can be made a program");
}

#[cfg(unix)]
#[test]
fn speed_is_measured_beside_a_peer_and_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // What is remade by a command has to be quoted in it.
    let out = folder.path().join("out, it's here");
    let python = fake_python(folder.path());
    let with_peers = |mut command: Command| {
        let others = std::env::var_os("PATH").unwrap_or_default();
        let paths = [folder.path().to_owned()].into_iter().chain(std::env::split_paths(&others));
        command.env("PATH", std::env::join_paths(paths).expect("paths without a colon"));
        command.output().expect("the program starts")
    };
    let run = |json: bool| {
        let mut command = speed(&out);
        command.arg("--peers").arg(folder.path()).env("MITSUBA_PYTHON", &python).args(json.then_some("--json"));
        with_peers(command)
    };
    let first = run(false);
    let summary = succeeded(&first);
    assert!(summary.lines().all(|line| line.chars().count() <= 80), "{summary}");
    let last = summary.lines().last().unwrap_or_default();
    assert_eq!(last, format!("report: {}", out.join("report.html").display()));
    assert!(out.join("report.html").is_file());
    for words in ["cornell-box: 38 triangles", "relMSE * spp", "start to first picture", "mitsuba-no-roulette: 2.50"] {
        assert!(summary.contains(words), "{words:?} in {summary}");
    }

    let json = fs::read_to_string(out.join("speed.json")).expect("the rows are on disk");
    let mut document: Value = serde_json::from_str(&json).expect("the rows are JSON");
    let rows = document["rows"].as_array().expect("a list").clone();
    let of = |case: &str| rows.iter().filter(|row| row["case"] == case).collect::<Vec<_>>();
    for case in ["no-roulette", "default", "start", "start-cold", "mitsuba", "mitsuba-multijitter"] {
        assert_eq!(of(case).len(), REPEATS, "{case}");
    }
    // One path has fewer rays with roulette; every figure of a timed render is there and above 0.
    let rays = |case: &str| of(case)[0]["values"]["rays_per_path"].as_f64().expect("a number");
    assert!(rays("default") < rays("no-roulette") && rays("default") > 2.0);
    for (name, value) in of("default")[0]["values"].as_object().expect("figures") {
        assert!(value.as_f64().is_some_and(|value| value > 0.0), "{name} is {value}");
    }
    let error = of("error")[0]["values"]["relative_mse_spp"].as_f64().expect("a number");
    assert!((0.05..0.2).contains(&error), "relMSE * spp is {error}");
    // The peer's picture is ours, of fewer samples and another seed than the reference: as bright, and noisier.
    let ratio = of("mitsuba error")[0]["values"]["mean_to_reference"].as_f64().expect("a number");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    let asked = fs::read_to_string(folder.path().join("asked")).expect("the peer was asked");
    let no_roulette = asked.lines().find(|line| line.contains("--rr-depth 1000")).expect("once without roulette");
    for words in ["--variant llvm_ad_rgb", "--origin 2.780000000000 2.730000000000 -8.000000000000", "--bounces 8"] {
        assert!(no_roulette.contains(words), "{words:?} in {no_roulette}");
    }
    let csv = fs::read_to_string(out.join("speed.csv")).expect("the table is on disk");
    assert_eq!(csv.lines().count(), rows.len() + 1);

    // As if it had been stopped two rows early: just these are measured again.
    document["rows"].as_array_mut().expect("a list").truncate(rows.len() - 2);
    fs::write(out.join("speed.json"), document.to_string()).expect("the rows can be written");
    let again = run(true);
    let answer: Value = serde_json::from_str(&succeeded(&again)).expect("the answer is JSON");
    assert_eq!((&answer["schema"], &answer["stopped_by"]), (&Value::from(1), &Value::Null));
    assert_eq!(answer["rows"].as_array().map(Vec::len), Some(rows.len()));
    let progress = text(&again.stderr);
    assert_eq!(progress.lines().filter(|line| line.contains(&format!("/{} ", rows.len()))).count(), 2, "{progress}");
    let last = progress.lines().last().unwrap_or_default();
    assert_eq!(last, format!("report: {}", out.join("report.html").display()));

    // The command of the report goes on in the same folder, where nothing is left to do.
    let json = fs::read_to_string(out.join("speed.json")).expect("the rows are on disk");
    let document: Value = serde_json::from_str(&json).expect("the rows are JSON");
    let command = document["remade_by"].as_str().expect("a command");
    let page = fs::read_to_string(out.join("report.html")).expect("the report is there");
    let page = scraper::Html::parse_document(&page);
    let selector = scraper::Selector::parse(".command").expect("a selector");
    let shown: Vec<String> = page.select(&selector).map(|element| element.text().collect()).collect();
    assert_eq!(shown, [command]);
    for part in ["MITSUBA_PYTHON=", " --quick ", " --peers ", " --out "] {
        assert!(command.contains(part), "{command}");
    }
    let mut pasted = Command::new("sh");
    pasted.arg("-c").arg(command);
    let pasted = with_peers(pasted);
    assert_eq!(succeeded(&pasted), summary);
    assert!(!text(&pasted.stderr).contains(&format!("/{} ", rows.len())), "{}", text(&pasted.stderr));
}

/// Lets a number of measurements be made, then asks for a stop.
struct Patience {
    left: usize,
}

impl Watch for Patience {
    fn measured(&mut self, _done: usize, _total: usize, _line: &str) {
        self.left -= 1;
    }

    fn warn(&mut self, line: &str) {
        panic!("{line}");
    }

    fn stop_requested(&self) -> bool {
        self.left == 0
    }
}

fn least(kind: &Kind, out: &Path, patience: usize) -> (Ended, Rows) {
    let plan = Plan {
        scenes: if kind.takes_scenes() { vec![scene()] } else { Vec::new() },
        amount: Amount::Least,
        folder: out.into(),
        subprocess: Subprocess { program: env!("CARGO_BIN_EXE_texray").into(), device: None },
        peers: None,
    };
    let origin = Origin {
        study: kind.name.into(),
        version: "test".into(),
        kernel: "test".into(),
        device: context().device_info().name.clone(),
        driver: context().device_info().driver.clone(),
        cores: 1,
        command: format!("texray study {}", kind.name),
    };
    let mut rows = Rows::open(out, origin, None).expect("the folder can be written");
    let mut patience = Patience { left: patience };
    let mut study = kind.open(context(), &plan, &mut patience).expect("the study can be made");
    let ended = study::run(study.as_mut(), &mut rows, &mut patience).expect("the study ends");
    (ended, rows)
}

/// Every measurement is made once, next to nothing of it, under validation; a study that was stopped goes on where it was; the report
/// has a section a study, with its command and its pictures.
#[test]
fn studies_measure_every_case_and_are_reported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path();
    let mut last = None;
    // Those with few kernels: drivers take half a second to compile one.
    for (kind, measurements) in [("spp", 6), ("bounces", 21), ("transfer", 0)] {
        let kind = study::named(kind).expect("a study of this name");
        let (ended, rows) = least(kind, out, 5);
        assert_eq!((ended, rows.all().len()), (Ended::Stopped, 5), "{kind:?}");
        let kept = rows.all().to_vec();
        let (ended, rows) = least(kind, out, usize::MAX);
        assert_eq!((ended, &rows.all()[..5]), (Ended::Whole, &kept[..]), "{kind:?}");
        assert!(measurements == 0 || rows.all().len() == measurements, "{kind:?}: {}", rows.all().len());
        for row in rows.all() {
            assert!(row.values.values().all(|value| value.is_finite()), "{row:?}");
        }
        let summary = (kind.summary)(&rows, out);
        assert!(!summary.findings.is_empty() && !summary.tables().is_empty(), "{kind:?}");
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
        last = Some(rows);
    }
    assert_valid(context());

    let rows = last.expect("there were studies");
    page::write(out, rows.origin()).expect("the report can be written");
    let html = fs::read_to_string(out.join(page::FILE)).expect("the report is on disk");
    for words in ["texray study spp", "texray study bounces", "texray study transfer", "by the most bounces of a path"]
    {
        assert!(html.contains(words), "{words:?} is not in the report");
    }
    // Six pictures and a reference; seven caps, whole and as a detail.
    let exrs = fs::read_dir(out).expect("a folder").filter(|entry| {
        entry.as_ref().is_ok_and(|entry| entry.path().extension().is_some_and(|extension| extension == "exr"))
    });
    assert_eq!(exrs.count(), 7 + 14);
    assert!(html.matches("data:image/png").count() >= 7 + 14);
}

#[test]
fn refusals() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let refused = |command: &mut Command| {
        let output = command.output().expect("texray starts");
        let message = text(&output.stderr);
        (output.status.code(), message.lines().last().unwrap_or_default().to_owned())
    };
    let out = folder.path().join("out");
    let (code, message) = refused(&mut study(&["triangles", "scenes/cornell-box.toml"], &out));
    assert_eq!((code, message.as_str()), (Some(2), "error: study triangles makes its own scenes; give it none"));
    let twice = ["spp", "scenes/room.toml", "elsewhere/room.toml"];
    let (code, message) = refused(&mut study(&twice, &out));
    assert_eq!((code, message.as_str()), (Some(2), "error: elsewhere/room.toml: there are two scenes named room"));
    let (code, _) = refused(&mut study(&["weather"], &out));
    assert_eq!(code, Some(2));
    let (code, message) = refused(&mut study(&["speed", "no-such-scene.toml", "--quick"], &out));
    assert!(code == Some(3) && message.starts_with("error: no-such-scene.toml"), "{code:?} {message}");

    // Rows of something else stay as they are.
    fs::create_dir_all(&out).expect("the folder can be made");
    fs::write(out.join("speed.json"), "{}").expect("a file can be written");
    let (code, message) = refused(&mut speed(&out));
    assert!(code == Some(5) && message.contains("no rows of a study"), "{code:?} {message}");
    assert_eq!(fs::read_to_string(out.join("speed.json")).expect("it is there"), "{}");
    fs::write(folder.path().join("file"), "").expect("a file can be written");
    let (code, message) = refused(&mut speed(&folder.path().join("file")));
    assert!(code == Some(5) && message.contains("file"), "{code:?} {message}");
}
