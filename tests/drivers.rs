//! Invariant 13: different drivers show the same picture, judged by Welch's test in tiles of 8x8 pixels.
//!
//! A long study, run by `tests/drivers.sh -w`, which unpacks the drivers and sets DRIVERS_FOLDER to where their descriptions
//! (`lavapipe.json` and others) stand. Each picture is rendered by `texray` in a process of its own, as a process keeps its
//! drivers. Pictures of one driver differ by seed, so their tile means are independent; no seed is used by two drivers.

mod harness;

use std::path::{Path, PathBuf};
use std::process::Command;

use exr::prelude::read_first_rgba_layer_from_file;
use harness::statistics::{Moments, welch_test};
use texray::selftest::statistics::{FAMILY_ALPHA, sidak};

const SCENES: [&str; 3] = ["cornell-box", "cornell-mirror", "cornell-glass"];
const SIZE: [usize; 2] = [32, 24];
const TILE: usize = 8;
/// Pictures of a scene and driver: fewer than 32 would leave the t distribution with heavy tails at this level.
const SEEDS: u64 = 32;

/// Linear pixels of a picture by the driver that the file describes.
fn render(driver: &Path, scene: &str, seed: u64, folder: &Path) -> Vec<[f32; 3]> {
    let output = folder.join("picture.exr");
    let mut command = Command::new(env!("CARGO_BIN_EXE_texray"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    command.arg("render").arg(root.join("scenes").join(format!("{scene}.toml"))).arg("--output").arg(&output);
    command.args(["--filter", "box", "--spp", "16", "--quiet", "--seed", &seed.to_string()]);
    command.args(["--size", &format!("{}x{}", SIZE[0], SIZE[1])]).env("VK_DRIVER_FILES", driver);
    if let Some(libraries) = libraries(driver) {
        command.env("LD_LIBRARY_PATH", libraries);
    }
    let ended = command.output().expect("texray starts");
    assert!(ended.status.success(), "{}: {}", driver.display(), String::from_utf8_lossy(&ended.stderr));
    let image = read_first_rgba_layer_from_file(
        &output,
        |_, _| vec![[0.0; 3]; SIZE[0] * SIZE[1]],
        |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.1 * SIZE[0] + at.0] = [r, g, b],
    );
    image.expect("texray writes EXR").layer_data.channel_data.pixels
}

/// The folder that holds a driver, where its own libraries may stand; none where that has a Vulkan loader, which belongs to
/// something else.
fn libraries(driver: &Path) -> Option<PathBuf> {
    let text = std::fs::read_to_string(driver).expect("the driver's description can be read");
    let value: serde_json::Value = serde_json::from_str(&text).expect("the driver's description is JSON");
    let folder = Path::new(value["ICD"]["library_path"].as_str()?).parent()?.to_owned();
    (!folder.join("libvulkan.so.1").exists()).then_some(folder)
}

/// Tile means of each channel over the seeds.
fn tiles(driver: &Path, scene: &str, first_seed: u64) -> Vec<Moments> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut tiles = vec![Moments::default(); SIZE[0] / TILE * (SIZE[1] / TILE) * 3];
    for seed in first_seed..first_seed + SEEDS {
        let mut sums = vec![0.0; tiles.len()];
        for (index, pixel) in render(driver, scene, seed, folder.path()).into_iter().enumerate() {
            let tile = index / SIZE[0] / TILE * (SIZE[0] / TILE) + index % SIZE[0] / TILE;
            (0..3).for_each(|channel| sums[3 * tile + channel] += f64::from(pixel[channel]));
        }
        tiles.iter_mut().zip(sums).for_each(|(tile, sum)| tile.add(sum / (TILE * TILE) as f64));
    }
    tiles
}

#[test]
#[ignore = "needs the drivers that tests/drivers.sh unpacks, and minutes"]
fn drivers_agree() {
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
    let mut apart = Vec::new();
    for scene in SCENES {
        let pictures: Vec<_> =
            drivers.iter().enumerate().map(|(i, driver)| tiles(driver, scene, 1000 * i as u64)).collect();
        for (i, a) in pictures.iter().enumerate() {
            for (j, b) in pictures.iter().enumerate().skip(i + 1) {
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
