//! What a render writes: devices, pipes and links stay what they are, a better picture is not replaced, and a file that
//! cannot be written does not keep the others from being saved.
#![cfg(target_os = "linux")]

mod harness;

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use harness::program::{
    Signal, bash, code, document, expect, exr, is_root, names, room, signal, spp, start, texray, text,
};

/// A character device that acts like `like`: a node of the test's own as root, who could damage the real one.
fn device(folder: &Path, name: &str, like: &str) -> String {
    if !is_root() {
        return like.to_owned();
    }
    let minor = if like == "/dev/null" { "3" } else { "7" };
    assert!(Command::new("mknod").current_dir(folder).args([name, "c", "1", minor]).status().unwrap().success());
    name.to_owned()
}

const QUICK: [&str; 6] = ["render", "room.toml", "-q", "--spp", "1", "-o"];

#[test]
fn devices_stay_devices() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    let null = device(folder.path(), "null", "/dev/null");
    let before = fs::metadata(at(&null)).unwrap();
    symlink(&null, at("link.exr")).unwrap();
    symlink(&null, at("link.png")).unwrap();
    expect(folder.path(), &[&QUICK[..], &["link.exr", "--ledger", &null, "--error-map", "link.png"]].concat(), 2);
    expect(folder.path(), &[&QUICK[..], &["link.exr", "--ledger", &null]].concat(), 2);
    for arguments in [&["link.exr"][..], &["a.exr", "--ledger", &null], &["a.exr", "--error-map", "link.png"]] {
        expect(folder.path(), &[&QUICK[..], arguments].concat(), 0);
    }
    expect(folder.path(), &["compare", "a.exr", "a.exr", "--difference", "link.png"], 0);
    let after = fs::metadata(at(&null)).unwrap();
    assert!(after.file_type().is_char_device() && after.ino() == before.ino());
    assert!(at("link.exr").is_symlink() && at("link.png").is_symlink());
    // A file of a study can be a device as well.
    fs::create_dir(at("out")).unwrap();
    symlink(at(&null), at("out/spp.csv")).unwrap();
    texray::output::write_whole(&at("out/spp.csv"), false, b"scene").unwrap();
    assert!(at("out/spp.csv").is_symlink() && fs::metadata(at(&null)).unwrap().file_type().is_char_device());
}

#[test]
fn pipes_bring_what_is_written() {
    let folder = room();
    let line = "mkfifo p.exr; cat p.exr > read.exr & \"$T\" render room.toml -q --spp 1 -o p.exr -o a.exr; code=$?; wait; exit $code";
    let output = bash(folder.path(), line);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let at = |name: &str| folder.path().join(name);
    assert!(fs::metadata(at("p.exr")).unwrap().file_type().is_fifo());
    assert_eq!(fs::read(at("read.exr")).unwrap(), fs::read(at("a.exr")).unwrap());

    // A pipe of the shell, and a file that is open already: what was written to it stays.
    let line = "\"$T\" render room.toml -q --spp 1 -o a.exr --ledger >(cat > pipe.json); sleep 1; \
        { echo before; \"$T\" render room.toml -q --spp 1 -o a.exr --ledger /dev/stdout; echo after; } > open.txt";
    let output = bash(folder.path(), line);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice::<serde_json::Value>(&fs::read(at("pipe.json")).unwrap()).unwrap();
    let open = fs::read_to_string(at("open.txt")).unwrap();
    assert!(open.starts_with("before\n{") && open.ends_with("}after\n"), "{open}");

    // Nobody reads this one: the other file is saved first.
    fs::remove_file(at("a.exr")).unwrap();
    let stderr = expect(folder.path(), &[&QUICK[..], &["p.exr", "-o", "a.exr"]].concat(), 5);
    assert!(stderr.contains("error: p.exr: nobody has read the pipe for 5 s"), "{stderr}");
    assert!(at("a.exr").is_file() && fs::metadata(at("p.exr")).unwrap().file_type().is_fifo());
}

#[test]
fn links_are_followed_and_files_keep_what_they_are() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("far")).unwrap();
    symlink("far/later.exr", at("dangling.exr")).unwrap();
    symlink("dangling.exr", at("twice.exr")).unwrap();
    expect(folder.path(), &[&QUICK[..], &["twice.exr"]].concat(), 0);
    assert!(at("twice.exr").is_symlink() && at("dangling.exr").is_symlink() && at("far/later.exr").is_file());
    symlink("nowhere/a.exr", at("lost.exr")).unwrap();
    let stderr = expect(folder.path(), &[&QUICK[..], &["lost.exr"]].concat(), 5);
    assert!(stderr.contains("lost.exr: the folder nowhere does not exist"), "{stderr}");
    symlink("round.exr", at("round.exr")).unwrap();
    expect(folder.path(), &[&QUICK[..], &["round.exr"]].concat(), 5);

    // Modes stay, and owners, and other names of the same file.
    fs::write(at("private.exr"), "old").unwrap();
    fs::set_permissions(at("private.exr"), fs::Permissions::from_mode(0o640)).unwrap();
    fs::write(at("named.exr"), "old").unwrap();
    fs::hard_link(at("named.exr"), at("other.exr")).unwrap();
    if is_root() {
        std::os::unix::fs::chown(at("private.exr"), Some(64321), Some(64322)).unwrap();
    }
    let before = fs::metadata(at("private.exr")).unwrap();
    expect(folder.path(), &[&QUICK[..], &["private.exr", "-o", "named.exr"]].concat(), 0);
    let after = fs::metadata(at("private.exr")).unwrap();
    assert_eq!((after.mode(), after.uid(), after.gid()), (before.mode(), before.uid(), before.gid()));
    assert_eq!(fs::read(at("named.exr")).unwrap(), fs::read(at("other.exr")).unwrap());
    assert_eq!(exr(&at("named.exr")), exr(&at("private.exr")));

    // A name that is no text is kept.
    let named = |end: &[u8]| folder.path().join(OsStr::from_bytes(&[b"n\xff", end].concat()));
    fs::copy(at("room.toml"), named(b".toml")).unwrap();
    let mut run = Command::new(harness::program::TEXRAY);
    run.current_dir(folder.path()).arg("render").arg(named(b".toml")).args(["-q", "--spp", "1"]);
    assert!(run.status().unwrap().success());
    assert!(named(b".exr").is_file() && named(b".png").is_file());
    assert!(names(folder.path()).iter().all(|name| !name.starts_with(".texray-")));
}

/// A file that cannot be renamed over is written in place: a mount point for root, a file in a folder without rights
/// for others, and for a root that may not mount (as in a container) the same as another user.
#[test]
fn what_cannot_be_replaced_is_written_in_place() {
    let folder = room();
    fs::create_dir(folder.path().join("shut")).unwrap();
    fs::write(folder.path().join("shut/a.exr"), "old").unwrap();
    let mounts = bash(folder.path(), "unshare -m true").status.success();
    let (line, written) = match (is_root(), mounts) {
        (true, true) => (
            "touch host.exr && \
             unshare -m sh -c 'mount --bind host.exr shut/a.exr && \"$T\" render room.toml -q -o shut/a.exr'",
            "host.exr",
        ),
        (true, false) => (
            "chmod 755 . && chown 64321 shut/a.exr && \
             setpriv --reuid=64321 --regid=64321 --clear-groups \"$T\" render room.toml -q -o shut/a.exr",
            "shut/a.exr",
        ),
        (false, _) => (
            "chmod 555 shut && \"$T\" render room.toml -q -o shut/a.exr; code=$?; chmod 755 shut; exit $code",
            "shut/a.exr",
        ),
    };
    let output = bash(folder.path(), line);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(spp(&folder.path().join(written)), 32);

    // A file that may not be written is refused before anything is rendered.
    let line = match is_root() {
        true => {
            "mkdir -m 1777 sticky && echo old > sticky/a.exr && chmod 755 . && \
            setpriv --reuid=64321 --regid=64321 --clear-groups \"$T\" render none.toml -o sticky/a.exr"
        }
        false => {
            "mkdir sticky && echo old > sticky/a.exr && chmod 444 sticky/a.exr && \"$T\" render none.toml -o sticky/a.exr"
        }
    };
    let output = bash(folder.path(), line);
    assert_eq!(output.status.code(), Some(5), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("sticky/a.exr: cannot be written"), "{}", text(&output.stderr));
    let long = format!("{}.png", "a".repeat(252));
    let stderr = expect(folder.path(), &["render", "none.toml", "-o", &long], 5);
    assert!(stderr.contains("File name too long"), "{stderr}");
}

#[test]
fn one_file_that_fails_does_not_lose_the_others() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    let full = device(folder.path(), "full", "/dev/full");
    symlink(&full, at("full.exr")).unwrap();
    let files =
        ["full.exr", "-o", "a.exr", "-o", "b.png", "--error-map", "m.png", "--aov", "variance,samples,variance"];
    let output = texray(folder.path(), &[&QUICK[..], &files, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(5));
    assert!(text(&output.stderr).contains("error: full.exr: No space left on device"), "{}", text(&output.stderr));
    let document = document(&output);
    assert_eq!(document["outputs"], serde_json::json!(["a.exr", "b.png", "m.png"]));
    assert_eq!(document["not_written"].as_array().unwrap().len(), 1, "{document}");
    assert!(["a.exr", "b.png", "m.png"].iter().all(|name| at(name).is_file()));

    // Beyond the limit of file sizes a file fails like on a full disk: what is small enough is written, what was there
    // stays.
    fs::write(at("old.exr"), "old").unwrap();
    let line = "ulimit -f 20; exec \"$T\" render room.toml -q --spp 1 --size 200x150 -o big.exr -o old.exr -o small.png \
                --ledger small.json";
    let output = bash(folder.path(), line);
    assert_eq!(output.status.code(), Some(5), "{}", text(&output.stderr));
    for name in ["big.exr", "old.exr"] {
        assert!(text(&output.stderr).contains(&format!("error: {name}: File too large")), "{}", text(&output.stderr));
    }
    assert!(at("small.png").is_file() && at("small.json").is_file() && !at("big.exr").exists());
    assert_eq!(fs::read(at("old.exr")).unwrap(), b"old", "what was there stays");

    // The failure of a file counts for more than the signal.
    let endless = ["render", "room.toml", "--spp", "4294967295", "-o", "full.exr", "-o", "c.exr"];
    let mut child = start(folder.path(), &endless);
    signal(&child, Signal::TERM);
    assert_eq!(code(&mut child), Some(5));
    assert!(spp(&at("c.exr")) >= 1);
    assert!(names(folder.path()).iter().all(|name| !name.starts_with(".texray-")), "{:?}", names(folder.path()));
}

#[test]
fn what_the_scene_is_made_of_is_not_overwritten() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    fs::hard_link(at("room.mtl"), at("hard.json")).unwrap();
    for file in ["room.obj", "room.mtl", "./room.toml"] {
        let stderr = expect(folder.path(), &[&QUICK[..], &["a.exr", "--ledger", file]].concat(), 2);
        assert!(stderr.contains("the output is a file of the scene itself"), "{stderr}");
    }
    symlink("room.mtl", at("link.json")).unwrap();
    expect(folder.path(), &[&QUICK[..], &["a.exr", "--ledger", "link.json"]].concat(), 2);
    expect(folder.path(), &[&QUICK[..], &["a.exr", "--ledger", "hard.json"]].concat(), 2);
    // An image that the MTL file names, though it is not read.
    let mtl =
        fs::read_to_string(at("room.mtl")).unwrap().replace("newmtl lamp", "map_Kd -s 1 1 1 floor.png\nnewmtl lamp");
    fs::write(at("room.mtl"), mtl).unwrap();
    fs::write(at("floor.png"), "an image").unwrap();
    expect(folder.path(), &[&QUICK[..], &["floor.png"]].concat(), 2);
    assert_eq!(fs::read(at("floor.png")).unwrap(), b"an image");
    // Two names of one file that is not there yet are one file, too.
    symlink("new.exr", at("same.json")).unwrap();
    let stderr = expect(folder.path(), &[&QUICK[..], &["new.exr", "--ledger", "same.json"]].concat(), 2);
    assert!(stderr.contains("two outputs have this name"), "{stderr}");
}

#[test]
fn an_early_stop_keeps_a_better_picture() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    let outputs = ["-o", "a.exr", "-o", "a.png", "-o", "a.hdr", "--error-map", "m.png"];
    let endless = [&["render", "room.toml", "--spp", "4294967295", "--size", "8x8"][..], &outputs].concat();
    let files = || ["a.exr", "a.png", "a.hdr", "m.png"].map(|name| fs::read(at(name)).unwrap());
    let many = [&["render", "room.toml", "-q", "--spp", "4096", "--size", "8x8"][..], &outputs].concat();
    expect(folder.path(), &many, 0);
    let before = files();
    let early = |more: &[&str]| {
        text(&texray(folder.path(), &[&endless[..], &["-q", "--time-limit", "0.001s"], more].concat()).stderr)
    };

    let stderr = early(&[]);
    let kept = "warning: a.exr holds more samples of this picture and is kept; this one is in a.partial-1spp.exr";
    assert!(stderr.contains(kept), "{stderr}");
    assert!(before == files());
    for name in ["a.partial-1spp.exr", "a.partial-1spp.png", "a.partial-1spp.hdr", "m.partial-1spp.png"] {
        assert_eq!(spp(&at(name)), 1, "{name}");
        fs::write(at(name), "of somebody else").unwrap();
    }

    // A signal's end is told by its code; a partial picture of something else is not replaced.
    let mut child = start(folder.path(), &endless);
    signal(&child, Signal::TERM);
    assert_eq!(code(&mut child), Some(143));
    assert!(before == files());
    early(&[]);
    assert_eq!(fs::read(at("a.partial-1spp.exr")).unwrap(), b"of somebody else");
    let partial = |name: &String| name.starts_with("a.partial-") && name.ends_with("spp-2.exr");
    assert!(names(folder.path()).iter().any(partial), "{:?}", names(folder.path()));

    // Another seed, size, or exposure is another picture.
    early(&["--exposure", "1"]);
    assert_eq!((spp(&at("a.exr")), spp(&at("a.png"))), (4096, 1));
    early(&["--seed", "1"]);
    assert_eq!((spp(&at("a.exr")), spp(&at("a.hdr"))), (1, 1));

    // Fewer samples are replaced, by an early stop too; more only if they are to be.
    expect(folder.path(), &["render", "room.toml", "-q", "--spp", "64", "-o", "b.exr"], 0);
    assert!(!early(&["-o", "b.exr"]).contains("b.exr"), "b.exr is of another size");
    expect(folder.path(), &["render", "room.toml", "-q", "--spp", "64", "-o", "b.exr"], 0);
    let over = ["render", "room.toml", "-q", "--spp", "100000", "--time-limit", "0.001s", "-o", "b.exr", "--overwrite"];
    expect(folder.path(), &over, 0);
    assert_eq!(spp(&at("b.exr")), 1);
    expect(folder.path(), &["render", "room.toml", "-q", "--spp", "16", "-o", "b.exr"], 0);
    assert_eq!(spp(&at("b.exr")), 16, "a whole render replaces");
}

/// Where the address space ends between rendering and saving, the render is refused before it begins: no run ends by a
/// signal, and each that ends well has its pictures.
#[test]
fn no_memory_is_found_out_before_rendering() {
    let folder = room();
    let line = |kib: u32| {
        format!(
            "ulimit -v {kib}; rm -f big.*; exec \"$T\" render room.toml --size 1200x900 --spp 1 --max-bounces 1 -q -o big.exr \
             -o big.png -o big.hdr --aov variance,samples"
        )
    };
    let mut saved = 0;
    for kib in (1_000_000..2_200_000).step_by(100_000) {
        let output = bash(folder.path(), &line(kib));
        let files = ["big.exr", "big.png", "big.hdr"].iter().filter(|name| folder.path().join(name).exists()).count();
        match output.status.code() {
            Some(0) => assert_eq!(files, 3, "{kib} KiB"),
            Some(4) => assert_eq!(files, 0, "{kib} KiB"),
            other => panic!("{kib} KiB: {other:?}: {}", text(&output.stderr)),
        }
        saved += usize::from(output.status.success());
    }
    assert!(saved > 0);
}
