//! Files of other formats: what they are, and how what is in them becomes readable.
//!
//! Comes in: a path. Goes out: a sentence for its refusal, if the extension is that of a known format.

use std::path::Path;

/// Models and scenes of modelling programs, by extension.
const MODELS: [&str; 27] = [
    "gltf", "glb", "fbx", "ply", "stl", "blend", "dae", "usd", "usda", "usdc", "usdz", "3ds", "abc", "x3d", "wrl",
    "off", "lwo", "lws", "max", "ma", "mb", "c4d", "3mf", "vdb", "skp", "step", "iges",
];
/// Scene descriptions of other renderers.
const SCENES: [&str; 8] = ["xml", "pbrt", "json", "rib", "ass", "mi", "pov", "yaml"];

/// What a file of another format is and what to do with it; `None` where the extension is of none that is known.
pub fn foreign_format(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let is_in = |list: &[&str]| list.contains(&extension.as_str());
    Some(if is_in(&MODELS) {
        format!(
            "a model in the format .{extension} cannot be read; readable are .obj models and .toml scenes that name \
             them. \
             Open or import it in Blender and export it: File > Export > Wavefront (.obj)"
        )
    } else if is_in(&SCENES) {
        format!(
            "a scene in the format .{extension} cannot be read; readable are .toml scenes (scenes/cornell-box.toml is \
             one) \
             and .obj models. Export its meshes as Wavefront .obj, and write the camera and materials into a .toml"
        )
    } else if extension == "mtl" {
        "a library of materials is no scene; give the .obj file that names it, or a .toml scene".into()
    } else if is_in(&["exr", "png", "hdr", "jpg", "jpeg"]) {
        "a picture is no scene; allowed are files that end in .toml or .obj".into()
    } else {
        return None;
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_told_how_it_becomes_readable() {
        let told = |name: &str| foreign_format(Path::new(name));
        for name in MODELS {
            let told = told(&format!("a.{}", name.to_uppercase())).unwrap();
            assert!(told.contains(&format!(".{name} ")) && told.contains("File > Export > Wavefront"), "{told}");
        }
        assert!(SCENES.iter().all(|name| told(&format!("a.b.{name}")).unwrap().contains("Wavefront .obj")));
        assert!(told("a.mtl").is_some() && told("a.exr").is_some());
        assert!(told("a.obj").is_none() && told("a.toml").is_none() && told("gltf").is_none() && told("").is_none());
    }
}
