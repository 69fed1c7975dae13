//! Invariant 13: different drivers show the same picture, judged by Welch's test in tiles of 8x8 pixels.
//!
//! A long study, run by `tests/drivers.sh -w`, which unpacks the drivers and sets DRIVERS_FOLDER to where their descriptions
//! (`lavapipe.json` and others) stand. A process keeps its drivers, so this program starts itself once for each: the pictures of
//! a scene then share one pipeline, which SwiftShader takes minutes to compile. Pictures of one driver differ by seed, so their
//! tile means are independent; no seed is used by two drivers.

mod harness;

use std::path::{Path, PathBuf};
use std::process::Command;

use harness::device::{load, render};
use harness::statistics::{Moments, welch_test};
use texray::scene::Filter;
use texray::settings::Settings;
use texray::statistics::{FAMILY_ALPHA, sidak};

const SCENES: [&str; 3] = ["cornell-box", "cornell-mirror", "cornell-glass"];
const SIZE: [usize; 2] = [32, 24];
const TILE: usize = 8;
/// Pictures of a scene and driver: fewer than 32 would leave the t distribution with heavy tails at this level.
const SEEDS: u64 = 32;
/// Set in a process that renders for another: the file that takes the tile means, and the first of its seeds.
const PART_FILE: &str = "DRIVERS_PART_FILE";
const PART_SEED: &str = "DRIVERS_PART_SEED";

/// Means of each tile and channel of a picture.
fn tile_means(scene: &str, seed: u64) -> Vec<f64> {
    let scene = load(scene);
    let [width, height] = SIZE.map(|side| side as u32);
    let settings = Settings { width, height, spp: 16, filter: Filter::Box, seed, ..Settings::for_scene(&scene) };
    let mut sums = vec![0.0; SIZE[0] / TILE * (SIZE[1] / TILE) * 3];
    for (index, pixel) in render(&scene, &settings).film.mean().into_iter().enumerate() {
        let tile = index / SIZE[0] / TILE * (SIZE[0] / TILE) + index % SIZE[0] / TILE;
        (0..3).for_each(|channel| sums[3 * tile + channel] += f64::from(pixel[channel]));
    }
    sums.iter().map(|sum| sum / (TILE * TILE) as f64).collect()
}

/// The part of a process that renders for another: the tile means of every scene and seed, as JSON.
fn write_part(file: &Path) {
    let first: u64 = std::env::var(PART_SEED).expect("set beside the file").parse().expect("a number");
    let pictures = |scene| (first..first + SEEDS).map(|seed| tile_means(scene, seed)).collect::<Vec<_>>();
    let part: Vec<Vec<Vec<f64>>> = SCENES.into_iter().map(pictures).collect();
    std::fs::write(file, serde_json::to_string(&part).expect("numbers are JSON")).expect("the part can be written");
}

/// Starts this program on the driver that the file describes; for each scene, what its tiles are over the seeds.
fn read_part(driver: &Path, first_seed: u64) -> Vec<Vec<Moments>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("part.json");
    let mut command = Command::new(std::env::current_exe().expect("this program has a file"));
    command.args(["--ignored", "--exact", "drivers_agree", "--nocapture"]);
    command.env("VK_DRIVER_FILES", driver).env(PART_FILE, &file).env(PART_SEED, first_seed.to_string());
    if let Some(libraries) = libraries(driver) {
        command.env("LD_LIBRARY_PATH", libraries);
    }
    let ended = command.output().expect("this program starts");
    assert!(ended.status.success(), "{}: {}", driver.display(), String::from_utf8_lossy(&ended.stderr));
    let text = std::fs::read_to_string(&file).expect("the part was written");
    let part: Vec<Vec<Vec<f64>>> = serde_json::from_str(&text).expect("the part is JSON");
    let over_seeds = |pictures: &Vec<Vec<f64>>| {
        let mut tiles = vec![Moments::default(); pictures[0].len()];
        pictures.iter().for_each(|means| tiles.iter_mut().zip(means).for_each(|(tile, &mean)| tile.add(mean)));
        tiles
    };
    part.iter().map(over_seeds).collect()
}

/// The folder that holds a driver, where its own libraries may stand; none where that has a Vulkan loader, which belongs to
/// something else.
fn libraries(driver: &Path) -> Option<PathBuf> {
    let text = std::fs::read_to_string(driver).expect("the driver's description can be read");
    let value: serde_json::Value = serde_json::from_str(&text).expect("the driver's description is JSON");
    let folder = Path::new(value["ICD"]["library_path"].as_str()?).parent()?.to_owned();
    (!folder.join("libvulkan.so.1").exists()).then_some(folder)
}

#[test]
#[ignore = "needs the drivers that tests/drivers.sh unpacks, and minutes"]
fn drivers_agree() {
    if let Some(file) = std::env::var_os(PART_FILE) {
        return write_part(Path::new(&file));
    }
    let folder =
        PathBuf::from(std::env::var_os("DRIVERS_FOLDER").expect("DRIVERS_FOLDER is set: run tests/drivers.sh -w"));
    let mut drivers: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("DRIVERS_FOLDER can be read")
        .map(|entry| entry.expect("DRIVERS_FOLDER can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .collect();
    drivers.sort();
    assert!(drivers.len() >= 2, "{} describes {} drivers; two are needed", folder.display(), drivers.len());
    let pairs = drivers.len() * (drivers.len() - 1) / 2;
    let tests = SCENES.len() * pairs * SIZE[0] / TILE * (SIZE[1] / TILE) * 3;
    let parts: Vec<_> = drivers.iter().enumerate().map(|(i, driver)| read_part(driver, 1000 * i as u64)).collect();
    let mut apart = Vec::new();
    for (number, scene) in SCENES.into_iter().enumerate() {
        for (i, a) in parts.iter().map(|scenes| &scenes[number]).enumerate() {
            for (j, b) in parts.iter().map(|scenes| &scenes[number]).enumerate().skip(i + 1) {
                let verdicts: Vec<_> = a.iter().zip(b).map(|(a, b)| welch_test(a, b)).collect();
                let worst = verdicts.iter().min_by(|a, b| a.p.total_cmp(&b.p)).expect("there are tiles");
                let mean = |tiles: &[Moments]| tiles.iter().map(|tile| tile.mean).sum::<f64>() / tiles.len() as f64;
                let names = [i, j].map(|i| drivers[i].file_stem().unwrap_or_default().to_string_lossy().into_owned());
                println!(
                    "{scene}: {} and {}, worst of {} tiles t {:.2} p {:.1e} (limit {:.1e}), means {:.6} and {:.6}",
                    names[0],
                    names[1],
                    verdicts.len(),
                    worst.statistic,
                    worst.p,
                    sidak(FAMILY_ALPHA, tests),
                    mean(a),
                    mean(b)
                );
                if !worst.passes(tests) {
                    apart.push(format!("{scene}: {names:?}"));
                }
            }
        }
    }
    assert!(apart.is_empty(), "these show different pictures: {apart:#?}");
}
