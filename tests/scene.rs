//! The scene stage from outside: every refusal by its exact text, transforms, and the committed scenes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use texray::Error;
use texray::interface::NO_INDEX;
use texray::scene::{MaterialKind, Scene};

/// A folder of small files; the scene is the first of them.
struct Files {
    folder: tempfile::TempDir,
    first: PathBuf,
}

impl Files {
    fn new(files: &[(&str, &[u8])]) -> Files {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        let first = folder.path().join(files[0].0);
        Files { folder, first }
    }

    fn load(&self) -> texray::Result<Scene> {
        Scene::load(&self.first)
    }

    /// Text without the name of the folder.
    fn strip(&self, text: &str) -> String {
        text.replace(&format!("{}{}", self.folder.path().display(), std::path::MAIN_SEPARATOR), "")
    }
}

const CAMERA: &str = "[camera]\norigin = [0, 0, 4]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 30\n";
const MESH: &str = "[[mesh]]\nfile = \"a.obj\"\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn toml(text: &str) -> Scene {
    load_toml(text, OBJ).unwrap()
}

fn load_toml(text: &str, obj: &str) -> texray::Result<Scene> {
    let text = format!("{CAMERA}{MESH}{text}");
    Files::new(&[("a.toml", text.as_bytes()), ("a.obj", obj.as_bytes())]).load()
}

fn bare(obj: &str) -> Scene {
    Files::new(&[("a.obj", obj.as_bytes())]).load().unwrap()
}

#[test]
fn every_refusal_has_file_line_value_and_what_is_allowed() {
    let mut wrong = Vec::new();
    let mut check = |files: &[(&str, &[u8])], expected: &str| {
        let files = Files::new(files);
        let refusal = match files.load() {
            Err(error @ (Error::Scene { .. } | Error::Scenes { .. })) => files.strip(&error.to_string()),
            Err(error) => format!("the wrong kind of error: {error:?}"),
            Ok(scene) => files.strip(&format!("no refusal, warnings {:?}", scene.report.warnings)),
        };
        if refusal != expected {
            wrong.push(format!("expected: {expected}\n   found: {refusal}"));
        }
    };
    for (obj, expected) in include!("scene_refusals/obj.in") {
        check(&[("a.obj", obj)], expected);
    }
    for (mtl, expected) in include!("scene_refusals/mtl.in") {
        let obj = format!("mtllib a.mtl\nusemtl m\n{OBJ}");
        check(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl)], expected);
    }
    for (toml, expected) in include!("scene_refusals/toml.in") {
        check(&[("a.toml", toml.as_bytes()), ("a.obj", OBJ.as_bytes())], expected);
    }
    for (mesh, expected) in include!("scene_refusals/toml_below_camera.in") {
        let text = format!("{CAMERA}{mesh}");
        check(&[("a.toml", text.as_bytes()), ("a.obj", OBJ.as_bytes())], expected);
    }
    let long = format!("{OBJ}# {}\n", "x".repeat(1 << 20));
    check(&[("a.obj", long.as_bytes())], "a.obj:5: a line of 1048578 bytes; allowed are 1048576");
    assert!(wrong.is_empty(), "{} of the refusals differ:\n{}", wrong.len(), wrong.join("\n"));
}

/// The README's first scene loads as it stands, and its recipes make the materials that they are named after.
#[test]
fn the_first_scene_and_the_recipes_of_the_readme_are_right() {
    let readme = include_str!("../README.md");
    let first = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = Files::new(&[("first.toml", first.replace("scenes/", "").as_bytes())]);
    for mesh in ["bunny.obj", "stage.obj", "stage.mtl"] {
        let from = root.join("scenes").join(mesh);
        if from.exists() {
            std::fs::copy(from, files.folder.path().join(mesh)).unwrap();
        }
    }
    let scene = files.load().unwrap();
    assert_eq!(scene.report.warnings, Vec::<String>::new());
    assert!(scene.check_emits().is_ok() && scene.sky.is_some());

    let recipes = readme.lines().skip_while(|line| !line.starts_with("| material |")).skip(2);
    let mut names = Vec::new();
    for line in recipes.take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let statements = |cell: &str| cell.split('`').skip(1).step_by(2).collect::<Vec<_>>().join("\n");
        let kinds = [
            Files::new(&[
                ("a.obj", format!("mtllib a.mtl\nusemtl m\n{OBJ}").as_bytes()),
                ("a.mtl", format!("newmtl m\n{}\n", statements(cells[2])).as_bytes()),
            ])
            .load()
            .unwrap(),
            load_toml(&format!("[material.m]\n{}\n", statements(cells[3])), &format!("usemtl m\n{OBJ}")).unwrap(),
        ]
        .map(|scene| (scene.materials[0].kind, scene.materials[0].emits()));
        assert_eq!(kinds[0], kinds[1], "{line}");
        let is_right = match (cells[1], kinds[0]) {
            ("matte", (MaterialKind::Lambert { .. }, emits)) => !emits,
            ("mirror", (MaterialKind::Mirror { .. }, _)) | ("glass", (MaterialKind::Glass { .. }, _)) => true,
            ("lamp", (MaterialKind::Lambert { .. }, emits)) => emits,
            _ => false,
        };
        assert!(is_right, "{line}: {:?}", kinds[0]);
        names.push(cells[1].to_owned());
    }
    assert_eq!(names, ["matte", "mirror", "glass", "lamp"]);
}

#[test]
fn files_that_cannot_be_read_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("d.obj");
    std::fs::create_dir(&directory).unwrap();
    let refusal = |path: &Path| Scene::load(path).unwrap_err().to_string();
    assert_eq!(refusal(&directory), format!("{}: is a directory; allowed is a file", directory.display()));
    let missing = folder.path().join("missing.obj");
    assert_eq!(refusal(&missing), format!("{}: no such file", missing.display()));
    let missing = folder.path().join("missing.toml");
    assert_eq!(refusal(&missing), format!("{}: no such file", missing.display()));
}

#[test]
fn a_scene_without_emission_is_refused_only_when_asked() {
    let scene = toml("");
    let text = scene.check_emits().unwrap_err().to_string();
    let expected = "nothing in the scene emits light; allowed are a material with ke (Ke) above 0, or [environment]";
    assert_eq!(text, format!("{}: {expected}", scene.path.display()));
    assert!(toml("[environment]\ncolor = [0, 0, 0]\n").check_emits().is_err());
    assert!(toml("[environment]\ncolor = [0, 0.5, 0]\n").check_emits().is_ok());
    // A light without an area lights nothing.
    let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl l\nf 1 1 2\n";
    assert!(load_toml("[material.l]\nke = [1, 1, 1]\n", flat).unwrap().check_emits().is_err());
}

#[test]
fn tables_reach_the_scene() {
    let scene = toml(
        "[film]\nwidth = 16\nheight = 8\nfilter = \"tent\"\n[render]\nspp = 4294967295\nmax_bounces = 65535\n\
         [environment]\ncolor = [1, 2, 3.0]\nstrength = 4\n",
    );
    assert_eq!((scene.film.width, scene.film.height, scene.film.filter), (16, 8, texray::scene::Filter::Tent));
    assert_eq!((scene.render.spp, scene.render.max_bounces), (Some(u32::MAX), Some(65535)));
    assert_eq!(scene.sky, Some([0.5, 1.0, 1.5]));
    assert_eq!(scene.scaling.radiance_exponent, -3);
    assert_eq!((scene.name.as_str(), scene.triangles.len()), ("a", 1));
    assert_eq!(scene.camera.origin, DVec3::new(-0.5, -0.5, 4.0));
}

#[test]
fn triangles_keep_file_order_across_objects_and_materials() {
    let mut obj = String::new();
    for i in 0..12 {
        obj +=
            &format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\no part{}\nusemtl m{}\nf -3 -2 -1\nl 1 2 3\np 1\n", i / 5, i % 3);
    }
    let materials =
        "[material.m0]\nkd = [0, 0, 0]\n[material.m1]\nillum = 3\n[material.m2]\nd = 0.5\nillum = 4\nni = 2\n";
    let scene = load_toml(materials, &obj).unwrap();
    let x = |i: usize| f64::from(scene.triangles[i].positions[0].x) * 8.0 + 5.5;
    assert_eq!((0..12).map(x).collect::<Vec<_>>(), (0..12).map(f64::from).collect::<Vec<_>>());
    assert!((0..12).all(|i| scene.materials[scene.triangles[i].material as usize].name == format!("m{}", i % 3)));
    assert_eq!(scene.materials[1].kind, MaterialKind::Mirror { reflectance: [1.0; 3] });
    assert_eq!(scene.materials[2].kind, MaterialKind::Glass { ior: 2.0 });
}

#[test]
fn a_face_is_smooth_where_every_corner_has_a_normal() {
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.1 0 2\nvt 0.5 0.25\n";
    let smooth = bare(&format!("{head}f 1/1/1 2/1/1 3/1/1\n"));
    assert_eq!((smooth.triangles[0].corners, smooth.corners.len()), (0, 1));
    assert_eq!(smooth.corners[0].uvs[2].to_array(), [0.5, 0.25]);
    // One that is flat leaves the others as they are, and so does one without texture coordinates.
    let mixed = bare(&format!("{head}f 1 2 3\nf 1//1 2/1/1 3//1\nf 1//1 2//1 3\nf 1/1/1 2/1/1 3/1/1\nf 1/1 2/1 3/1\n"));
    let corners: Vec<_> = mixed.triangles.iter().map(|triangle| triangle.corners).collect();
    assert_eq!(corners, [NO_INDEX, 0, NO_INDEX, 1, NO_INDEX]);
    assert_eq!(mixed.corners[0].normals, mixed.corners[1].normals);
    assert_eq!([0, 1].map(|i| mixed.corners[i].uvs[1].to_array()), [[0.0, 0.0], [0.5, 0.25]]);
}

#[test]
fn negated_short_or_missing_normals_of_a_flat_wall_change_nothing() {
    for normals in ["0 0 1", "0 0 -1", "0 0 0.001", "0 0 0", "0 0 1e-90", "0 0 -1e90"] {
        let scene = bare(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn {normals}\nf 1//1 2//1 3//1\n"));
        assert!(scene.corners.is_empty() && scene.triangles[0].corners == NO_INDEX, "{normals}");
    }
    let tilted = |sign: f64| bare(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn {sign} 0 {sign}\nf 1//1 2//1 3//1\n"));
    assert_eq!(tilted(1.0).corners[0].normals, tilted(-2.0).corners[0].normals);
}

/// The sign of a triangle's normals is one decision: a corner that looks away from the others is bent to the horizon.
#[test]
fn normals_are_turned_as_a_triangle() {
    for sign in [1.0, -1.0] {
        let vn = |y: f64, z: f64| format!("vn 0 {} {}\n", y * sign, z * sign);
        let (towards, away) = (vn(0.8, 0.6), vn(0.8, -0.6));
        let scene = bare(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{towards}{away}f 1//1 2//1 3//2\n"));
        let expected = [[0.0, 0.8, 0.6], [0.0, 0.8, 0.6], [0.0, 1.0, 0.0]].map(Vec3::from);
        for (normal, expected) in scene.corners[0].normals.into_iter().zip(expected) {
            assert!((normal - expected).length() < 1e-6, "sign {sign}: {normal} for {expected}");
        }
    }
}

#[test]
fn a_mirrored_mesh_keeps_its_fronts_and_its_normals() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.25 0 1\nvn 0 0.25 1\nvn 0 0 1\nf 1//1 2//2 3//3\n";
    let front = |scene: &Scene| {
        let [a, b, c] = scene.triangles[0].positions;
        (b - a).cross(c - a).normalize()
    };
    for (transform, expected) in [
        ("scale = [-1, 1, 1]\n", [0.0, 0.0, 1.0]),
        ("scale = [1, 1, -3]\n", [0.0, 0.0, -1.0]),
        ("scale = -1\n", [0.0, 0.0, -1.0]),
        ("matrix = [0,1,0,5, 1,0,0,5, 0,0,1,5, 0,0,0,1]\n", [0.0, 0.0, 1.0]),
        ("rotate = { axis = [1, 0, 0], degrees = 90 }\n", [0.0, -1.0, 0.0]),
    ] {
        let scene = load_toml(transform, obj).unwrap();
        assert_eq!(front(&scene).to_array(), expected, "{transform}");
        let corners = scene.corners[0];
        assert!(corners.normals.iter().all(|normal| normal.dot(front(&scene)) > 0.5), "{transform}");
        // The flat normal belongs to the third corner of the file, whatever its place now.
        let flat = corners.normals.iter().position(|normal| normal.dot(front(&scene)) > 0.9999);
        assert_eq!(flat, Some(if transform.contains("rotate") { 2 } else { 1 }), "{transform}");
    }
}

#[test]
fn degenerate_triangles_are_counted_and_do_not_move_the_scene() {
    let plain = bare(OBJ);
    let mut obj = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 99 99 99\nv 0.5 0 0\n");
    obj += &"f 4 4 1\nf 1 2 5\n".repeat(500);
    let scene = bare(&(obj + "f 1 2 3\n"));
    assert_eq!((scene.triangles.len(), scene.report.degenerate_triangles), (1, 1000));
    assert_eq!(scene.triangles[0].positions, plain.triangles[0].positions);
    assert_eq!((scene.scaling, scene.camera), (plain.scaling, plain.camera));
    assert!(scene.report.warnings[0].ends_with("a.obj: 1000 degenerate triangles removed"));
}

#[test]
fn a_scene_moved_or_scaled_with_its_camera_is_bit_identical() {
    let load = |scale: f64, x: f64| {
        let camera = format!(
            "[camera]\norigin = [{}, {}, {}]\ntarget = [{x}, {x}, {x}]\nup = [0, 1, 0]\nvfov = 30\n",
            0.5 * scale + x,
            0.25 * scale + x,
            4.0 * scale + x
        );
        let text = format!("{camera}{MESH}scale = {scale}\ntranslate = [{x}, {x}, {x}]\n");
        Files::new(&[("a.toml", text.as_bytes()), ("a.obj", OBJ.as_bytes())]).load().unwrap()
    };
    let plain = load(1.0, 0.0);
    for (scale, x) in
        [(1.0, 1e6), (1.0, -123456789.0), (2f64.powi(20), 0.0), (2f64.powi(-20), 0.0), (2f64.powi(-100), 0.0)]
    {
        let scene = load(scale, x);
        assert_eq!(scene.triangles[0].positions, plain.triangles[0].positions, "{scale} {x}");
        assert_eq!(scene.camera, plain.camera, "{scale} {x}");
    }
}

#[test]
fn warnings_say_what_is_ignored_or_doubtful() {
    let warnings = |obj: &str| {
        let files = Files::new(&[("a.obj", obj.as_bytes())]);
        files.load().unwrap().report.warnings.iter().map(|text| files.strip(text)).collect::<Vec<_>>()
    };
    assert_eq!(warnings(OBJ), [] as [&str; 0]);
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 Z\nv 0 1 0\nf 1 2 3 4\n";
    assert_eq!(
        warnings(&square.replace('Z', "0.5")),
        ["a.obj:5: 1 polygons are not planar and were split into fans (the first is here)"]
    );
    assert_eq!(
        warnings(&format!("face 1 2 3\n{OBJ}curv 1 2\n")),
        [
            "a.obj:1: \"face\" is no statement of the OBJ format: 1 such lines ignored (the first is here)",
            "a.obj:6: \"curv\": 1 lines of curves and curved surfaces ignored (the first is here)"
        ]
    );
}

#[test]
fn one_obj_file_serves_several_meshes() {
    let scene =
        toml("[[mesh]]\nfile = \"a.obj\"\ntranslate = [0, 0, 1]\nmaterial = \"m\"\n[material.m]\nke = [1, 1, 1]\n");
    assert_eq!((scene.triangles.len(), scene.materials.len()), (2, 2));
    assert!(scene.materials[1].emits() && scene.check_emits().is_ok());
}

fn committed(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("toml");
    let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let report = &scene.report;
    assert!(report.warnings.is_empty() && report.degenerate_triangles == 0, "{report:?}");
    scene.check_emits().unwrap();
    scene
}

/// Edges that are not met once in each direction, and the volume that the fronts enclose (negative: they face inward).
fn closedness(scene: &Scene, material: &str) -> (usize, f64) {
    let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    let mut volume = 0.0;
    for triangle in &scene.triangles {
        if scene.materials[triangle.material as usize].name != material {
            continue;
        }
        let [a, b, c] = triangle.positions.map(|position| position.as_dvec3());
        volume += a.dot(b.cross(c)) / 6.0;
        let bits = triangle.positions.map(|position| position.to_array().map(f32::to_bits));
        for i in 0..3 {
            *edges.entry([bits[i], bits[(i + 1) % 3]]).or_default() += 1;
            *edges.entry([bits[(i + 1) % 3], bits[i]]).or_default() -= 1;
        }
    }
    (edges.values().filter(|&&balance| balance != 0).count(), volume)
}

#[test]
fn the_committed_scenes_hold_what_they_say() {
    for (name, triangles) in [
        ("cornell-box", 38),
        ("cornell-coplanar", 32),
        ("cornell-mirror", 38),
        ("cornell-glass", 5148),
        ("furnace", 12),
    ] {
        assert_eq!(committed(name).triangles.len(), triangles, "{name}");
    }
    assert_eq!(committed("bunny").triangles.len(), 3674 + 4);
    let teapot = committed("teapot");
    assert_eq!(teapot.triangles.len(), 992 + 4);
    assert!(teapot.corners.len() > 900);
    assert_eq!(committed("room").triangles.len(), 12 + 5 * 12 + 4 * 12 + 2 + 2 + 3674 + 992);
    let light = |scene: &Scene| {
        let emits = |triangle: &&texray::scene::Triangle| scene.materials[triangle.material as usize].emits();
        let [a, b, c] = scene.triangles.iter().find(emits).unwrap().positions;
        (b - a).cross(c - a).normalize().y
    };
    for name in ["cornell-box", "cornell-coplanar", "cornell-mirror", "cornell-glass", "bunny", "teapot"] {
        assert_eq!(light(&committed(name)), -1.0, "{name}: the light shines down");
    }
}

#[test]
fn closed_meshes_are_closed_and_face_the_right_way() {
    let (open, volume) = closedness(&committed("cornell-glass"), "glass");
    // The ball of radius 0.9 in scaled units (a quarter), less what 5,120 facets cut off.
    let ball = 4.0 / 3.0 * std::f64::consts::PI * (0.9f64 / 4.0).powi(3);
    assert!(open == 0 && volume < ball && volume > 0.99 * ball, "{open} {volume} {ball}");
    let (open, volume) = closedness(&committed("bunny"), "bunny");
    assert!(open == 0 && volume > 0.0, "{open} {volume}");
    let (open, volume) = closedness(&committed("furnace"), "wall");
    assert_eq!((open, volume), (0, -1.0), "a cube of extent 1 whose fronts face inward");
    let (open, volume) = closedness(&committed("room"), "wall");
    assert!(open == 0 && volume < 0.0, "{open} {volume}");
}

/// How long the largest fetched dragon takes: `scenes/fetch.sh`, then `cargo test --release --test scene -- --ignored`.
#[test]
#[ignore = "needs scenes/fetch.sh"]
fn the_fetched_dragon_loads_in_seconds() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/fetched");
    for (name, triangles) in
        [("dragon-res4", 11_102), ("dragon-res3", 47_794), ("dragon-res2", 202_520), ("dragon", 871_414)]
    {
        let start = Instant::now();
        let scene = Scene::load(&folder.join(name).with_extension("toml")).unwrap_or_else(|error| panic!("{error}"));
        println!("{name}: {} triangles in {:?}, {:?}", scene.triangles.len(), start.elapsed(), scene.report);
        assert_eq!(scene.triangles.len() + scene.report.degenerate_triangles, triangles + 18);
        // About 1.5 s of one core; the rest is for machines that are busy.
        assert!(start.elapsed() < Duration::from_secs(20));
    }
}
