//! Damaged files: whatever the bytes are, the stage reads or refuses them, and never panics.
//!
//! Comes in: small files that use every statement and key, damaged by a seeded generator. The files stay in memory, as
//! 20,000 of them are tried.

use std::path::Path;

use super::assemble::{ObjFiles, assemble_with};
use super::mtl_scan::Library;
use super::normalise::{Normalised, normalise};
use super::obj_mesh::ObjMesh;
use super::{scene_file, source_text};
use crate::{Error, Result};

/// Numbers of a linear congruential generator (Knuth, MMIX), enough to damage files with.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n
    }
}

/// Words that have broken loaders.
const WORDS: [&[u8]; 17] = [
    b"nan",
    b"inf",
    b"1e400",
    b"1e99",
    b"-1",
    b"0",
    b"9999999999999999999",
    b"/",
    b"//",
    b"f ",
    b"l 1 2 3\n",
    b"Kd 0.5 0.5\n",
    b"\n",
    b"\t",
    b"[[",
    b"usemtl \n",
    b"\xff",
];

/// One to four bytes replaced, removed or cut off, or words put in.
fn damaged(text: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut text = text.to_vec();
    for _ in 0..=dice.below(4) {
        let at = dice.below(text.len() + 1);
        match dice.below(16) {
            0..5 if at < text.len() => text[at] = dice.below(256) as u8,
            5..10 if at < text.len() => drop(text.remove(at)),
            10 => text.truncate(at),
            _ => drop(text.splice(at..at, WORDS[dice.below(WORDS.len())].iter().copied())),
        }
    }
    text
}

/// The stage as `Scene::load` runs it, from memory.
fn load([toml, obj, mtl]: [Vec<u8>; 3]) -> Result<Normalised> {
    let path = Path::new("a.toml");
    let file = scene_file::read(path, &source_text::decode(path, toml)?)?;
    let mut library = Library::default();
    library.scan(Path::new("a.mtl"), &source_text::decode(Path::new("a.mtl"), mtl)?)?;
    let mesh = ObjMesh::from_bytes(Path::new("a.obj"), obj)?;
    let mut files = ObjFiles::from([("a.obj".into(), (mesh, Some(library)))]);
    let raw = assemble_with(path, &file.meshes, &file.materials, &mut files)?;
    normalise(path, file.camera_line, &raw, &file.camera, file.sky)
}

const TOML: &str = r#"
[camera]
origin = [0, 0, 4]
target = [0.5, 0, 0]
up = [0, 1, 0]
vfov = 30
[film]
width = 10
filter = "box"
[render]
spp = 1
[[mesh]]
file = "a.obj"
scale = [1, -2, 3]
rotate = { axis = [0, 1, 0], degrees = 30 }
translate = [1, 2, 3]
[[mesh]]
file = "a.obj"
material = "m"
matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]
[material.m]
kd = [0, 0, 1]
ni = 1.5
[environment]
color = [1, 1, 1]
strength = 2
"#;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0.5 1\nv 0 1 0\nv 1 1 0 1 1 1\nvt 0 1\nvn 0 0.5 1\no a\nusemtl m\n\
                   f 1/1/1 2/1/1 4/1/1 3/1/1\ng b\nusemtl n\nf -1//1 -2//1 -3//1\ns off\nf 1 2 3\n";

const MTL: &str = "newmtl m\nKd 0.1 0.2 0.3\nKe 1 2 3\nnewmtl n\nKs 1 1 1\nillum 7\nNi 1.5\nd 0.5\nmap_Kd x.png\n";

#[test]
fn damaged_files_are_read_or_refused() {
    let committed = [
        include_bytes!("../../scenes/cornell-box.toml").to_vec(),
        include_bytes!("../../scenes/cornell-box.obj").to_vec(),
        include_bytes!("../../scenes/cornell-box.mtl").to_vec(),
    ];
    let committed =
        committed.map(|text| String::from_utf8(text).unwrap().replace("cornell-box.obj", "a.obj").into_bytes());
    let small = [TOML, OBJ, MTL].map(|text| text.as_bytes().to_vec());
    let mut dice = Dice(2022);
    let (mut loaded, mut refused) = (0, 0);
    for family in [committed, small] {
        assert!(load(family.clone()).is_ok());
        for _ in 0..10_000 {
            let mut files = family.clone();
            let which = dice.below(3);
            files[which] = damaged(&files[which], &mut dice);
            match load(files) {
                Ok(scene) => {
                    loaded += 1;
                    assert!(scene.triangles.iter().flat_map(|t| t.positions).all(|p| p.abs().max_element() <= 1.0));
                    assert!(scene.corners.iter().flat_map(|c| c.normals).all(|n| n.is_normalized()));
                    assert!(scene.materials.iter().flat_map(|m| m.emission).all(|e| (0.0..2.0).contains(&e)));
                    assert!(scene.camera.basis(600).right.is_finite() && scene.camera.basis(600).down.is_finite());
                }
                Err(Error::Scene { .. } | Error::Scenes { .. }) => refused += 1,
                Err(error) => panic!("not a refusal: {error}"),
            }
        }
    }
    assert!(loaded > 1000 && refused > 1000, "{loaded} loaded, {refused} refused");
}
