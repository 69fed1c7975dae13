//! Damaged files: whatever their bytes are, they are read or refused, in little time and memory, and never with a
//! panic.
//!
//! Comes in: small scenes, OBJ, MTL and OpenEXR files, damaged by a seeded generator and written to a folder. Each is
//! loaded as a user's would be; of the scenes that load, one in twenty is rendered. Seeds are fixed: what a run finds,
//! the next finds again.

#[path = "../harness/mod.rs"]
mod harness;
mod mutate;
mod originals;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use harness::device::context;
use mutate::Dice;
use texray::Error;
use texray::compare::Comparison;
use texray::compare::read::read;
use texray::render::{Renderer, Settings, Tuning};
use texray::scene::Scene;

/// Longest that reading one file, or rendering it, may take.
const LONGEST: Duration = Duration::from_secs(5);
/// Most memory that reading one file of some kilobytes may take.
const MOST_BYTES: u64 = 1 << 30;

/// What became of the files.
#[derive(Debug, Default)]
struct Tally {
    loaded: usize,
    refused: usize,
    rendered: usize,
    compared: usize,
}

/// Ends the program where a file holds it up: a test that hangs says nothing.
struct Watchdog(&'static AtomicUsize);

impl Watchdog {
    fn new(name: &'static str) -> Watchdog {
        let case: &'static AtomicUsize = Box::leak(Box::new(AtomicUsize::new(0)));
        std::thread::spawn(move || {
            let mut last = (0, Instant::now());
            loop {
                std::thread::sleep(Duration::from_millis(500));
                let now = case.load(Ordering::Relaxed);
                if now == usize::MAX {
                    return;
                }
                if now != last.0 {
                    last = (now, Instant::now());
                } else if now > 0 && last.1.elapsed() > 12 * LONGEST {
                    eprintln!("{name}: case {now} hangs");
                    std::process::exit(101);
                }
            }
        });
        Watchdog(case)
    }

    fn begin(&self, case: usize) {
        self.0.store(case + 1, Ordering::Relaxed);
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.0.store(usize::MAX, Ordering::Relaxed);
    }
}

/// Runs `work`, which must take little time and memory.
fn bounded<T>(what: &str, work: impl FnOnce() -> T) -> T {
    // The system counts the peak anew; where it does not, the peak of all cases is held against the bound.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let before = resident("VmRSS:");
    let started = Instant::now();
    let result = work();
    let took = started.elapsed();
    assert!(took < LONGEST, "{what}: {took:?}");
    if let (Some(before), Some(peak)) = (before, resident("VmHWM:")) {
        assert!(peak.saturating_sub(before) < MOST_BYTES, "{what}: {} MiB", peak.saturating_sub(before) >> 20);
    }
    result
}

fn resident(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

/// No text of a file steers the terminal, and none is long.
fn assert_legible(what: &str, text: &str) {
    assert!(!text.contains(texray::quote::is_hidden), "{what}: {text:?}");
    assert!(text.chars().count() < 1000, "{what}: {} characters: {text}", text.chars().count());
}

fn scenes(count: usize, seed: u64) -> Tally {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let families = originals::scenes();
    let mut dice = Dice(seed);
    let mut tally = Tally::default();
    let watchdog = Watchdog::new("scenes");
    for case in 0..count {
        watchdog.begin(case);
        let family = &families[case % families.len()];
        let damaged = dice.below(3);
        for (i, name) in ["a.toml", "a.obj", "a.mtl"].into_iter().enumerate() {
            let text = if i == damaged { mutate::text(&family[i], &mut dice) } else { family[i].clone().into_bytes() };
            std::fs::write(at(name), text).expect("a file can be written");
        }
        let bare = damaged > 0 && dice.below(4) == 0;
        let path = at(if bare { "a.obj" } else { "a.toml" });
        let what = format!("seed {seed}, case {case}");
        match bounded(&what, || Scene::load(&path)) {
            Ok(scene) => {
                check(&what, &scene);
                tally.loaded += 1;
                // A scene without light is refused by the renderer.
                if tally.loaded % 20 == 0 && scene.check_emits().is_ok() {
                    render(&what, &scene);
                    tally.rendered += 1;
                }
            }
            Err(error @ (Error::Scene { .. } | Error::Scenes { .. })) => {
                error.to_string().lines().for_each(|line| assert_legible(&what, line));
                tally.refused += 1;
            }
            Err(error) => panic!("{what}: not a refusal: {error}"),
        }
    }
    tally
}

/// What follows may assume of a scene.
fn check(what: &str, scene: &Scene) {
    assert!(scene.triangles.iter().flat_map(|t| t.positions).all(|p| p.abs().max_element() <= 1.0), "{what}");
    assert!(scene.corners.iter().flat_map(|c| c.normals).all(|n| n.is_normalized()), "{what}");
    // Below 2 before it is rounded to f32.
    assert!(scene.materials.iter().flat_map(|m| m.emission).all(|e| (0.0..=2.0).contains(&e)), "{what}");
    assert!(scene.camera.basis(600).right.is_finite() && scene.camera.basis(600).down.is_finite(), "{what}");
    scene.report.warnings.iter().for_each(|warning| assert_legible(what, warning));
}

fn render(what: &str, scene: &Scene) {
    let settings = Settings { width: 8, height: 8, spp: 1, max_bounces: 4, ..Settings::for_scene(scene) };
    bounded(what, || {
        let renderer = Renderer::new(context(), scene, &settings, &Tuning::default());
        let renderer = renderer.unwrap_or_else(|error| panic!("{what}: {error}"));
        let rendered = renderer.render(&mut harness::device::Silent).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(rendered.film.mean().iter().flatten().all(|channel| channel.is_finite()), "{what}");
    });
}

fn pictures(count: usize, seed: u64) -> Tally {
    let folder = tempfile::tempdir().expect("a folder");
    let originals = originals::pictures(folder.path());
    let path = folder.path().join("a.exr");
    for (i, original) in originals.iter().enumerate() {
        std::fs::write(&path, original).expect("a file");
        read_picture(&path).unwrap_or_else(|error| panic!("original {i}: {error}"));
    }
    let mut dice = Dice(seed);
    let mut tally = Tally::default();
    let watchdog = Watchdog::new("pictures");
    for case in 0..count {
        watchdog.begin(case);
        let what = format!("seed {seed}, case {case}");
        std::fs::write(&path, mutate::binary(&originals[case % originals.len()], &mut dice)).expect("a file");
        match bounded(&what, || read_picture(&path)) {
            Ok(picture) => {
                tally.loaded += 1;
                if tally.loaded % 20 == 0 {
                    let found = bounded(&what, || Comparison::of(&picture, &picture, None)).expect("one window");
                    let all = found.not_finite == picture.rgb.len();
                    assert_eq!(found.hdr_flip.map(|flip| flip.mean), (!all).then_some(0.0), "{what}");
                    tally.compared += 1;
                }
            }
            Err(error @ (Error::Scene { .. } | Error::Limit { .. })) => {
                assert_legible(&what, &error.to_string());
                tally.refused += 1;
            }
            Err(error) => panic!("{what}: not a refusal: {error}"),
        }
    }
    tally
}

fn read_picture(path: &Path) -> texray::Result<texray::compare::read::ExrPicture> {
    read(path, None).or_else(|_| read(path, Some("p")))
}

#[test]
fn some_damaged_scenes_are_read_or_refused() {
    let tally = scenes(3000, 2022);
    println!("{tally:?}");
    assert!(tally.loaded > 100 && tally.refused > 100 && tally.rendered > 5, "{tally:?}");
}

#[test]
fn some_damaged_pictures_are_read_or_refused() {
    let tally = pictures(4000, 2023);
    println!("{tally:?}");
    assert!(tally.loaded > 100 && tally.refused > 100 && tally.compared > 5, "{tally:?}");
}

/// Takes about three minutes with the pictures below, on two cores that are busy.
#[test]
#[ignore = "the full tier: 20,000 files, some two minutes"]
fn damaged_scenes_are_read_or_refused() {
    let tally = scenes(20_000, 1);
    println!("{tally:?}");
    assert!(tally.loaded > 1000 && tally.refused > 1000 && tally.rendered > 50, "{tally:?}");
}

#[test]
#[ignore = "the full tier: 20,000 files, some two minutes"]
fn damaged_pictures_are_read_or_refused() {
    let tally = pictures(20_000, 2);
    println!("{tally:?}");
    assert!(tally.loaded > 1000 && tally.refused > 1000 && tally.compared > 50, "{tally:?}");
}
