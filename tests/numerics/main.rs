//! The plates and tables of docs/numerics.md, made by one command:
//!
//! ```text
//! cargo test --release --test numerics -- --ignored --nocapture --test-threads 1
//! ```
//!
//! Each plate shows a failure beside its cure. The tables are the catalogue's outcome at the full tier, and what becomes of
//! a case without its guard.

#[path = "../harness/mod.rs"]
mod harness;

mod plates;
mod tables;

use std::fs;
use std::path::{Path, PathBuf};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

#[test]
#[ignore = "writes docs/numerics/*.png"]
fn draw_the_plates() {
    let folder = docs().join("numerics");
    fs::create_dir_all(&folder).unwrap();
    let text = fs::read_to_string(docs().join("numerics.md")).unwrap();
    for plate in plates::plates() {
        let differing = plate.before.iter().zip(&plate.after).filter(|(a, b)| a != b).count();
        println!("{}: {differing} of {} pixels differ", plate.name, plate.before.len());
        assert!(differing > 0, "{}: the failure does not show", plate.name);
        assert!(text.contains(&format!("(numerics/{}.png)", plate.name)), "docs/numerics.md shows no {}", plate.name);
        fs::write(folder.join(plate.name).with_extension("png"), plate.png()).unwrap();
    }
}

#[test]
#[ignore = "writes the tables of docs/numerics.md; eight minutes"]
fn write_the_tables() {
    let path = docs().join("numerics.md");
    let mut text = fs::read_to_string(&path).unwrap();
    for (name, table) in [("cases", tables::cases()), ("guards", tables::guards())] {
        text = tables::put(&text, name, &table);
    }
    fs::write(path, text).unwrap();
}
