//! Files that other programs read: what of them is read, what is warned of, and what the warnings say.

use std::path::PathBuf;

use texray::interface::NO_INDEX;
use texray::scene::{MaterialKind, Scene};

const SQUARE: &str = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nf 1 2 3 4\n";

/// A folder of files; the scene is the first of them.
struct Files {
    folder: tempfile::TempDir,
    first: PathBuf,
}

impl Files {
    fn new(files: &[(&str, &[u8])]) -> Files {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        Files { first: folder.path().join(files[0].0), folder }
    }

    /// The scene, with its warnings and notes without the folder's name.
    fn load(&self) -> (Scene, Vec<String>, Vec<String>) {
        let scene = Scene::load(&self.first).unwrap_or_else(|error| panic!("{error}"));
        let prefix = format!("{}{}", self.folder.path().display(), std::path::MAIN_SEPARATOR);
        let strip = |lines: &[String]| lines.iter().map(|line| line.replace(&prefix, "")).collect();
        let (warnings, notes) = (strip(&scene.report.warnings), strip(&scene.report.notes));
        (scene, warnings, notes)
    }
}

fn load(obj: &[u8]) -> (Scene, Vec<String>) {
    let (scene, warnings, _) = Files::new(&[("a.obj", obj)]).load();
    (scene, warnings)
}

fn with_mtl(mtl: &str) -> (Scene, Vec<String>) {
    let obj = format!("mtllib a.mtl\nusemtl m\n{SQUARE}");
    let (scene, warnings, _) = Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).load();
    (scene, warnings)
}

fn same_shape(a: &Scene, b: &Scene) -> bool {
    let shape = |scene: &Scene| scene.triangles.iter().map(|triangle| triangle.positions).collect::<Vec<_>>();
    shape(a) == shape(b)
}

#[test]
fn the_same_square_however_it_is_written() {
    let (plain, _) = load(SQUARE.as_bytes());
    let square = |change: [&str; 2]| SQUARE.replace(change[0], change[1]);
    for text in [
        square(["v 3 0 0", "v 3 0 \\\n 0"]),
        square(["f 1 2 3 4", "f 1 2\\\r\n  3 \\ \n 4 # end"]),
        square(["\n", "\r"]),
        square(["\n", "\r\n"]),
        format!("# square \\\r{}", square(["\n", "\r"])),
        square(["v 3 3 0", "v 3 3 0 # corner"]),
        square(["v 3 3 0", "v 3 3 0#corner"]),
        square(["3 4\n", "3 4#"]),
        format!("{SQUARE}\0\0\0\n"),
        format!("{SQUARE}\x1a"),
        format!("{SQUARE}\r\n\x1a\x1a\0"),
        "f 1 2 3 4\nv 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\n".to_owned(),
        "v 0 0 0\nv 3 0 0\nf 1 -1 3 4\nv 3 3 0\nv 0 3 0\n".to_owned(),
        square(["f 1 2 3 4", "fo 1 2 3 4"]),
        square(["f 1 2 3 4", "vt 0 0\nf 1/1/0 2/1/0 3/1/0 4/1/0"]),
        square(["f 1 2 3 4", "f 1/0 2/0 3/0/ 4//0"]),
        square(["f 1 2 3 4", "vn 0 0 1\nf 1/0/1 2/0/1 3/0/1 4/0/1"]),
        format!("usemtl\n{SQUARE}"),
        format!("usemtl   # nothing\n{SQUARE}"),
        format!("o a#b\ng C:\\a\\\nusemtl\\\n \n{SQUARE}"),
    ] {
        let (scene, warnings) = load(text.as_bytes());
        assert!(same_shape(&scene, &plain) && warnings.is_empty(), "{text:?}: {warnings:?}");
    }
}

#[test]
fn what_is_no_number_matters_where_it_is_used() {
    let (plain, _) = load(SQUARE.as_bytes());
    for (text, expected) in [
        ("v nan nan nan\n", "1 vertices are no numbers; no face names them (the first is here)"),
        ("v 1 1 1 0\n", "1 vertices are no numbers; no face names them (the first is here)"),
        ("vt -nan(ind) 0\n", "1 texture coordinates (vt) are no numbers, and 0 is taken (the first is here)"),
        ("vt -1.#IND -1.#IND00\n", "1 texture coordinates (vt) are no numbers, and 0 is taken (the first is here)"),
        ("vn inf 1.#QNAN 0\n", "1 normals (vn) are no numbers, and count as of length 0 (the first is here)"),
    ] {
        let (scene, warnings) = load(format!("{SQUARE}{text}").as_bytes());
        assert!(same_shape(&scene, &plain), "{text}");
        assert_eq!(warnings, [format!("a.obj:6: {expected}")]);
    }
    let (scene, warnings) = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn nan 0 0\nvn 0.1 0 1\nf 1//1 2//2 3//2\n".as_bytes());
    assert_eq!(scene.corners[0].normals[0].to_array(), [0.0, 0.0, 1.0]);
    assert!(warnings[1].ends_with("1 corners have a normal of length 0 and take that of their triangle"));
    // A colour that is none: colours are not looked at.
    let (_, warnings) = load(SQUARE.replace("v 3 3 0", "v 3 3 0 nan 1 1").as_bytes());
    assert_eq!(warnings.len(), 1);
}

#[test]
fn a_library_or_material_that_is_not_there_is_a_warning() {
    let obj = |lib: &str| format!("{lib}usemtl brick\n{SQUARE}");
    let brick: &[u8] = b"newmtl brick\nKd 0.6 0.2 0.1\n";
    let kd = |scene: &Scene| match scene.materials[0].kind {
        MaterialKind::Lambert { albedo } => albedo,
        other => panic!("{other:?}"),
    };
    let missing = "such material; 1 face has the format's own (Kd 0.8);";
    for (lib, files, expected, red) in [
        (
            "",
            vec![],
            format!("1: usemtl \"brick\": no {missing} the file has no mtllib, and the scene defines no material"),
            false,
        ),
        ("mtllib gone.mtl\n", vec![], "1: mtllib \"gone.mtl\": no such file".into(), false),
        ("mtllib gone.mtl here.mtl\n", vec![("here.mtl", brick)], "1: mtllib \"gone.mtl\": no such file".into(), true),
        ("mtllib gone.mtl\n", vec![("a.mtl", brick)], "1: mtllib \"gone.mtl\": no such file".into(), true),
        (
            "",
            vec![("a.mtl", brick)],
            format!("1: usemtl \"brick\": no {missing} the file has no mtllib, and the scene defines no material"),
            false,
        ),
        (
            "mtllib here.mtl\n",
            vec![("here.mtl", b"newmtl brik\n")],
            format!("2: usemtl \"brick\": no {missing} the nearest that is defined is \"brik\""),
            false,
        ),
        (
            "mtllib here.mtl\n",
            vec![("here.mtl", b"")],
            format!("2: usemtl \"brick\": no {missing} no material is defined"),
            false,
        ),
        ("mtllib my own.mtl\n", vec![], "1: mtllib \"my own.mtl\": no such file".into(), false),
        ("mtllib\n", vec![], "1: mtllib without a file name (1 such lines, the first is here)".into(), false),
    ] {
        let obj = obj(lib);
        let all: Vec<_> = [("a.obj", obj.as_bytes())].into_iter().chain(files).collect();
        let (scene, warnings, notes) = Files::new(&all).load();
        assert_eq!(warnings[0], format!("a.obj:{expected}"), "{lib}");
        assert_eq!(kd(&scene), if red { [0.6, 0.2, 0.1] } else { [0.8; 3] }, "{lib}");
        let own = notes.iter().any(|note| note.contains("a.mtl, named as the OBJ file is, is read in its place"));
        assert_eq!(own, red && all.len() == 2 && lib == "mtllib gone.mtl\n", "{lib}: {notes:?}");
    }
    // A material that no face uses is nobody's.
    let (_, warnings) = load(format!("usemtl a\nusemtl b # c\nusemtl\n{SQUARE}").as_bytes());
    assert_eq!(warnings, [] as [&str; 0]);
}

#[test]
fn libraries_are_found_under_the_names_of_other_systems() {
    let red: &[u8] = b"newmtl red # the red one\nKd 1 0 0\n";
    for (name, file, noted) in [
        (".\\sub\\m.mtl", "sub/m.mtl", false),
        ("\"my m.mtl\"", "my m.mtl", false),
        ("my m.mtl", "my m.mtl", false),
        ("m.mtl # materials", "m.mtl", false),
        ("M.MTL", "m.mtl", true),
        ("C:\\models\\m.mtl", "m.mtl", true),
    ] {
        for material in ["red", "red # and so on", "red # the red one"] {
            let obj = format!("mtllib {name}\nusemtl {material}\n{SQUARE}");
            let (scene, warnings, notes) = Files::new(&[("a.obj", obj.as_bytes()), (file, red)]).load();
            assert!(warnings.is_empty(), "{name}: {warnings:?}");
            assert_eq!(scene.materials[0].kind, MaterialKind::Lambert { albedo: [1.0, 0.0, 0.0] }, "{name}");
            assert_eq!(notes.iter().any(|note| note.ends_with("is read in its place")), noted, "{name}: {notes:?}");
        }
    }
    // A hash may be part of a name, with a blank before it where that is the name that is defined.
    let obj = format!("mtllib a.mtl\nusemtl Material #2\n{SQUARE}usemtl a#b\nf 1 2 3\n");
    let mtl = b"newmtl Material #1\nKd 0 0 0\nnewmtl Material #2\nKd 1 1 1\nnewmtl a#b\nKd 0.5 0.5 0.5\n";
    let (scene, warnings, _) = Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl)]).load();
    let kinds: Vec<_> = scene.materials.iter().map(|material| material.kind).collect();
    assert_eq!(kinds, [1.0, 0.5].map(|albedo| MaterialKind::Lambert { albedo: [albedo; 3] }));
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn values_are_refused_where_the_look_hangs_on_them() {
    let lambert = |albedo: f32| MaterialKind::Lambert { albedo: [albedo; 3] };
    for (mtl, kind) in [
        ("Kd 0.5", lambert(0.5)),
        ("Kd 0.5 # half", lambert(0.5)),
        ("Kd 0.5 0.5 \\\n 0.5", lambert(0.5)),
        ("Kd 0.5 0.5 0.5 1", lambert(0.5)),
        ("Kd 0.5\nNi 0\nd x\nillum 2", lambert(0.5)),
        ("Kd 9\nKs 0.5\nillum 3", MaterialKind::Mirror { reflectance: [0.5; 3] }),
        ("Kd nan 0 0\nNi 1.5\nillum 7", MaterialKind::Glass { ior: 1.5 }),
        ("Kd x\nKd 0.5", lambert(0.5)),
        ("d -halo 0.5\nNi 1.5\nillum 7", MaterialKind::Glass { ior: 1.5 }),
    ] {
        let (scene, _) = with_mtl(&format!("newmtl m\n{mtl}\nnewmtl other\nKd 7 7 7\nillum 99\n"));
        assert_eq!(scene.materials[0].kind, kind, "{mtl}");
    }
    let (scene, warnings) = with_mtl("newmtl m\nKd 1.000001 1 -0.0001\nKs 1.0001 1 1\nillum 1\n");
    assert_eq!(scene.materials[0].kind, MaterialKind::Lambert { albedo: [1.0, 1.0, 0.0] });
    assert_eq!(
        warnings,
        ["a.mtl:2: values of 1 material are less than 1e-4 out of range: the nearest in range are taken"]
    );
    // What the scene file says takes the place of a value that is wrong.
    let toml = "[camera]\norigin = [0, 0, 4]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 30\n\
                [[mesh]]\nfile = \"a.obj\"\n[material.m]\nkd = [0.25, 0.25, 0.25]\n";
    let obj = format!("mtllib a.mtl\nusemtl m\n{SQUARE}");
    let files = [("a.toml", toml.as_bytes()), ("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl m\nKd 9 9 9\n")];
    assert_eq!(Files::new(&files).load().0.materials[0].kind, lambert(0.25));
}

#[test]
fn looks_that_are_left_out_are_told_once_with_a_count() {
    let told = |mtl: &str| with_mtl(&format!("newmtl m\n{mtl}\n")).1;
    for silent in [
        "Ks 0 0 0\nNs 100",
        "Ks 0.5\nillum 1",
        "Ns 100",
        "d 1\nTr 0\nTf 1 1 1\nKa 1 1 1",
        "Kd 0 0 0\nKs 1\nillum 3",
        "Kd 0\nKs 1\nTf 1 1 1\nNi 1.5\nd 0.1\nNs 10\nillum 7",
        "Pm 0\nPs 0\nPc 0.0\nPcr 0.03\naniso 0\nanisor 0\nmap_Ka a.png",
        "Tf 0 1 0\nillum 2",
    ] {
        assert_eq!(told(silent), [] as [&str; 0], "{silent}");
    }
    for (mtl, expected) in [
        (
            "Kd 0\nKs 0.7 0.7 0.7\nNs 200\nillum 2",
            "a.mtl:3: Ks and Ns of 1 material are ignored: there are no glossy surfaces yet",
        ),
        ("Kd 0.8\nd 0.2", "a.mtl:3: d (or Tr) of 1 material is ignored: see-through is only glass (illum 4, 6 or 7)"),
        ("Tr 0.2", "a.mtl:2: d (or Tr) of 1 material is ignored: see-through is only glass (illum 4, 6 or 7)"),
        (
            "Kd 1 0.77 0.34\nKs 0.5\nillum 3",
            "a.mtl:2: Kd of 1 material is ignored: a mirror (illum 3 or 5) reflects by its Ks alone",
        ),
        (
            "Kd 0\nTf 1 0 0\nNi 1.5\nillum 6",
            "a.mtl:3: Kd, Ks or Tf of 1 material is ignored: glass (illum 4, 6 or 7) is clear and uncoloured",
        ),
        (
            "Tf 1 0 0\nillum 4",
            "a.mtl:2: Tf of 1 material is ignored: what is opaque filters no light; glass has illum 4, 6 or 7 and Ni above 1",
        ),
        ("Ke 1\nillum 3", "a.mtl:3: illum 3 to 7 of 1 material is ignored: what emits (Ke) reflects diffusely"),
        (
            "illum 9",
            "a.mtl:2: illum 8, 9 or 10 of 1 material is not supported: the surface is opaque and matte (glass has illum 4, 6 or 7)",
        ),
        (
            "Kd spectral a.rfl 1",
            "a.mtl:2: spectral or xyz colours of 1 material are not supported: their defaults are taken",
        ),
        (
            "Kd xyz 0.1 0.2 0.3",
            "a.mtl:2: spectral or xyz colours of 1 material are not supported: their defaults are taken",
        ),
        (
            "map_Kd a.png\nPr 0.5",
            "a.mtl:2: \"map_Kd\", \"Pr\": not supported yet and ignored, though they would change the look",
        ),
    ] {
        assert_eq!(told(mtl), [expected], "{mtl}");
    }
    let mtl = "newmtl a\nKs 1\nnewmtl b\nKs 1\nmap_Kd b.png\nnewmtl unused\nKs 1\nd 0\nPr 1\nnewmtl c\nKs 0\n";
    let obj = format!(
        "mtllib a.mtl\nusemtl a\n{SQUARE}usemtl b\nf 1 2 3\nusemtl unused\nusemtl c\nf 1 2 3\nusemtl a\nf 1 2 3\n"
    );
    let (_, warnings, _) = Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).load();
    assert_eq!(
        warnings,
        [
            "a.mtl:2: Ks and Ns of 2 materials are ignored: there are no glossy surfaces yet",
            "a.mtl:5: \"map_Kd\": not supported yet and ignored, though they would change the look",
        ]
    );
    let colours = SQUARE.replace(" 0\n", " 0 1 0 0\n").replace("v 0 3 0 1 0 0", "v 0 3 0 1 1 1");
    let text =
        "a.obj:1: colours of 3 vertices are ignored: a surface has the colour of its material (the first is here)";
    assert_eq!(load(colours.as_bytes()).1, [text]);
}

#[test]
fn concave_polygons_and_holes_are_covered_once() {
    let area = |scene: &Scene| -> f64 {
        let scale = 2f64.powi(-scene.scaling.length_exponent);
        let of = |triangle: &texray::scene::Triangle| {
            let [a, b, c] = triangle.positions.map(|corner| corner.as_dvec3() * scale);
            (b - a).cross(c - a).z / 2.0
        };
        let areas: Vec<f64> = scene.triangles.iter().map(of).collect();
        assert!(areas.iter().all(|&area| area > 0.0), "all turn as their polygon does: {areas:?}");
        areas.iter().sum()
    };
    let frame = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\n";
    for (face, expected) in [
        ("f 1 2 3 4 1 5 6 7 8 5", 12.0),
        ("f 5 6 7 8 5 1 2 3 4 1", 12.0),
        ("f 1 2 3 7 6 5", 10.0),
        ("f 4 1 2 8 5 6", 6.0),
    ] {
        let (scene, warnings) = load(format!("{frame}{face}\n").as_bytes());
        assert!((area(&scene) - expected).abs() < 1e-5, "{face}: {}", area(&scene));
        assert!(warnings.is_empty(), "{warnings:?}");
    }
    // Normals and texture coordinates go with their corners.
    let arrow = "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 0.5 0\nvt 1 0\nvt 0 1\nvt -1 0\nvt 0 0.5\n\
                 vn 0.1 0 1\nvn 0 0.1 1\nvn -0.1 0 1\nvn 0 0.05 1\n";
    let (scene, _) = load(format!("{arrow}f 1/1/1 2/2/2 3/3/3 4/4/4\n").as_bytes());
    assert_eq!((scene.triangles.len(), scene.corners.len()), (2, 2));
    for triangle in &scene.triangles {
        assert_ne!(triangle.corners, NO_INDEX);
        let corners = &scene.corners[triangle.corners as usize];
        for ((position, uv), normal) in triangle.positions.iter().zip(corners.uvs).zip(corners.normals) {
            let centre = scene.scaling.centre.as_vec3();
            let file = *position * 2f32.powi(-scene.scaling.length_exponent) + centre;
            assert!((file.truncate() - uv).length() < 1e-6, "{file} {uv}");
            assert!((normal.truncate() / normal.z - uv / 10.0).length() < 1e-6, "{normal} {uv}");
        }
    }
    let (_, warnings) = load(b"v 0 0 0\nv 3 3 0\nv 3 0 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n");
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("1 polygons cross themselves or have too many corners"), "{warnings:?}");
}

#[test]
fn a_bare_obj_says_what_it_takes_for_granted() {
    let notes =
        |obj: &str| Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl m\nKd 0 0 0\nKe 1 1 1\n")]).load();
    let (_, warnings, told) = notes(SQUARE);
    assert!(warnings.is_empty() && told.len() == 2, "{told:?}");
    assert!(
        told[0].starts_with("a.obj: an OBJ file has no camera; one at (1.5000, 1.5000, ")
            && told[0].contains("along -z")
    );
    assert_eq!(told[1], "a.obj: nothing in it emits; a white sky of radiance 1 lights it");
    let lamp = format!("mtllib a.mtl\nusemtl m\n{SQUARE}");
    let (_, warnings, told) = notes(&lamp);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(told[1], "a.obj: its 2 triangles that emit (Ke) light it; there is no sky");
    let (_, warnings, _) = notes(&lamp.replace("1 2 3 4", "4 3 2 1"));
    assert!(warnings.len() == 1 && warnings[0].contains("nothing but backs of lamps"), "{warnings:?}");
    // What it lights may be seen.
    let lit = format!("{}usemtl\nf 1 2 3\n", lamp.replace("1 2 3 4", "4 3 2 1"));
    assert!(notes(&lit).1.is_empty());
}

/// A smoothing group asks for normals that the file does not have.
#[test]
fn smoothing_groups_without_normals_are_told() {
    let square = |group: &str, face: &str| load(SQUARE.replace("f 1 2 3 4", &format!("{group}\n{face}")).as_bytes()).1;
    for (group, face) in [("s off", "f 1 2 3 4"), ("s 0", "f 1 2 3 4"), ("s 1\nvn 0 0 1", "f 1//1 2//1 3//1")] {
        assert_eq!(square(group, face), [] as [&str; 0], "{group}");
    }
    let text = "faces without normals (vn) are flat, though a smoothing group (s) is on (the first is here)";
    assert_eq!(square("s 1", "f 1 2 3 4\ns off\nf 1 2 3"), [format!("a.obj:6: 1 {text}")]);
}
