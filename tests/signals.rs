//! Signals: none loses a picture, whatever comes how often, and a killed program leaves the old file.
#![cfg(target_os = "linux")]

mod harness;

use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};

use harness::program::{Signal, bash, code, document, expect, names, room, signal, spp, start, text};

/// Numbers of a linear congruential generator (Knuth, MMIX) with a fixed seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % n
    }
}

const ENDLESS: [&str; 6] = ["render", "room.toml", "--spp", "4294967295", "-o", "a.exr"];

/// One to three signals within 50 ms, at a random time of a render; fails where no picture is there after it.
fn burst(dice: &mut Dice) {
    let folder = room();
    let mut child = start(folder.path(), &ENDLESS);
    sleep(Duration::from_millis(dice.below(1500)));
    let mut sent = Vec::new();
    for _ in 0..=dice.below(3) {
        let (name, number) = [(Signal::INT, 130), (Signal::TERM, 143), (Signal::HUP, 129)][dice.below(3) as usize];
        signal(&child, name);
        sent.push(number);
        sleep(Duration::from_millis(dice.below(25)));
    }
    let code = code(&mut child).expect("the program ends");
    assert!(sent.contains(&code), "{sent:?} ended with {code}");
    let path = folder.path().join("a.exr");
    assert!(path.exists(), "{sent:?}: no picture in {:?}", names(folder.path()));
    assert!(spp(&path) >= 1);
}

/// Kills the program at a random time around that when it writes a large picture over another, and looks for what is
/// left of it.
fn kill(dice: &mut Dice) {
    let folder = room();
    let path = folder.path().join("a.exr");
    let render = |spp| ["render", "room.toml", "--size", "600x450", "--max-bounces", "1", "--spp", spp, "-o", "a.exr"];
    expect(folder.path(), &render("2"), 0);
    let second = fs::read(&path).unwrap();
    expect(folder.path(), &render("1"), 0);
    let first = fs::read(&path).unwrap();
    let begun = Instant::now();
    let mut child = start(folder.path(), &render("2"));
    let named = begun.elapsed();
    let whole = {
        code(&mut child);
        begun.elapsed()
    };
    fs::write(&path, &first).unwrap();
    let mut child = start(folder.path(), &render("2"));
    // The writing is in the last third of what follows the device's name.
    sleep((whole - named).mul_f64(0.6 + dice.below(450) as f64 / 1000.0));
    signal(&child, Signal::KILL);
    let _ = code(&mut child);
    let left = fs::read(&path).unwrap();
    assert!(left == first || left == second, "{} of {} bytes are left", left.len(), first.len());
    assert_eq!(names(folder.path()), ["a.exr", "room.mtl", "room.obj", "room.toml"]);
}

/// Runs `times` of them on as many threads as there are cores.
fn many(times: u64, seed: u64, one: fn(&mut Dice)) {
    let workers = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    scope(|scope| {
        for worker in 0..workers {
            scope.spawn(move || {
                let mut dice = Dice(seed + worker);
                (worker..times).step_by(workers as usize).for_each(|_| one(&mut dice));
            });
        }
    });
}

#[test]
fn bursts_of_signals_lose_no_picture() {
    many(12, 1, burst);
}

#[test]
fn a_killed_program_leaves_the_old_picture() {
    many(8, 2, kill);
}

/// 200 bursts and 50 kills: some 4 minutes on two cores.
#[test]
#[ignore = "minutes: the fast tests are a part of it"]
fn many_signals_lose_no_picture() {
    many(200, 3, burst);
    many(50, 4, kill);
}

/// A terminal that is closed sends two, one by the kernel and one by the shell; `timeout` signals its child and then
/// the group.
#[test]
fn signals_that_come_twice_are_one() {
    let folder = room();
    let mut child = start(folder.path(), &[&ENDLESS[..], &["--json"]].concat());
    sleep(Duration::from_millis(1500));
    for pause in [1, 0] {
        signal(&child, Signal::HUP);
        sleep(Duration::from_millis(pause));
    }
    assert_eq!(code(&mut child), Some(129));
    let output = child.wait_with_output().unwrap();
    assert_eq!(document(&output)["stop_reason"], "interrupted");
    for name in ["INT", "TERM", "HUP"] {
        let _ = fs::remove_file(folder.path().join("a.exr"));
        // Long enough to begin even on a busy machine.
        let line = format!(
            "setsid -w timeout -s {name} --preserve-status 5 \"$T\" render room.toml -q --spp 4294967295 -o a.exr"
        );
        let output = bash(folder.path(), &line);
        assert!(picture(folder.path()), "{name}: {:?} {}", output.status.code(), text(&output.stderr));
    }
}

fn picture(folder: &Path) -> bool {
    folder.join("a.exr").is_file()
}

/// A second signal that is meant as one ends the program at once, whatever it waits for.
#[test]
fn a_second_signal_a_while_later_quits_at_once() {
    let folder = room();
    bash(folder.path(), "mkfifo a.exr");
    // A pipe holds less than this picture, and its reader takes nothing.
    let mut reader = Command::new("sh");
    let mut reader = reader.current_dir(folder.path()).args(["-c", "exec 3< a.exr; exec sleep 60"]).spawn().unwrap();
    let mut child = start(folder.path(), &[&ENDLESS[..], &["--size", "200x150"]].concat());
    sleep(Duration::from_millis(1000));
    signal(&child, Signal::INT);
    sleep(Duration::from_millis(2000));
    assert!(child.try_wait().unwrap().is_none(), "it waits for the reader");
    let sent = Instant::now();
    signal(&child, Signal::INT);
    let ended = code(&mut child);
    assert!(ended == Some(130) && sent.elapsed() < Duration::from_secs(1), "{ended:?} after {:?}", sent.elapsed());
    reader.kill().unwrap();
    reader.wait().unwrap();
}
