//! A minimal OBJ and MTL reader: the second opinion on the loader, for scenes that are known to be sound.
//!
//! Comes in: the path of an OBJ, its MTL beside it. Goes out: a [`SceneBuilder`] in the file's units. Assumes that the
//! loader has accepted the file: anything unexpected panics. Rules of materials: the scene contract of the README.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use texray::scene::{Material, MaterialKind};

use super::scenes::{SceneBuilder, material};

/// Numbers and vectors of an MTL material, by key.
#[derive(Clone, Default)]
struct Entry(HashMap<String, Vec<f64>>);

impl Entry {
    fn number(&self, key: &str, default: f64) -> f64 {
        self.0.get(key).map_or(default, |values| values[0])
    }

    fn colour(&self, key: &str, default: f32) -> [f32; 3] {
        self.0.get(key).map_or([default; 3], |values| std::array::from_fn(|i| values[i.min(values.len() - 1)] as f32))
    }

    fn material(&self) -> Material {
        let illum = self.number("illum", 2.0) as u32;
        let (ior, dissolve) = (self.number("Ni", 1.0), self.number("d", 1.0));
        let kind = match illum {
            3 | 5 => MaterialKind::Mirror { reflectance: self.colour("Ks", 1.0) },
            4 | 6 | 7 if ior != 1.0 || dissolve < 1.0 => MaterialKind::Glass { ior: ior as f32 },
            _ => MaterialKind::Lambert { albedo: self.colour("Kd", 0.8) },
        };
        material(kind, self.colour("Ke", 0.0))
    }
}

/// A face: positions and normals by index from 0, and the name of its material.
type Face = (Vec<(usize, Option<usize>)>, String);

/// Reads a scene.
pub fn read(path: &Path) -> SceneBuilder {
    let (mut positions, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::<Face>::new());
    let (mut entries, mut current) = (HashMap::new(), String::new());
    for line in text(path).lines() {
        let Some((key, rest)) = line.trim().split_once(char::is_whitespace) else { continue };
        match key {
            "v" => positions.push(vector(rest)),
            "vn" => normals.push(vector(rest)),
            "usemtl" => current = rest.trim().to_string(),
            "mtllib" => entries.extend(read_mtl(&path.with_file_name(rest.trim()))),
            "f" => {
                let corner = |word: &str| {
                    let mut fields = word.split('/').map(|field| field.parse::<i64>().ok());
                    let from = |index: i64, count: usize| {
                        if index > 0 { index as usize - 1 } else { count - index.unsigned_abs() as usize }
                    };
                    let position = from(fields.next().flatten().expect("an index of a position"), positions.len());
                    (position, fields.nth(1).flatten().map(|index| from(index, normals.len())))
                };
                faces.push((rest.split_whitespace().map(corner).collect(), current.clone()));
            }
            _ => {}
        }
    }
    let mut builder = SceneBuilder::new();
    let mut materials: HashMap<&str, (u32, bool)> = HashMap::new();
    for (corners, name) in &faces {
        let has_normals = corners.iter().all(|(_, normal)| normal.is_some());
        let entry = || entries.get(name).cloned().unwrap_or_default().material();
        let (_, smooth) = materials.entry(name).or_insert_with(|| (builder.material(entry()), true));
        *smooth &= has_normals;
    }
    for (corners, name) in &faces {
        let (material, smooth) = materials[name.as_str()];
        for i in 2..corners.len() {
            let fan = [corners[0], corners[i - 1], corners[i]];
            let places = fan.map(|(position, _)| positions[position]);
            match smooth {
                true => {
                    let turned = fan.map(|(_, normal)| normals[normal.expect("a smooth part's normals")]);
                    builder.smooth_triangle(places, turned, material);
                }
                false => builder.triangle(places, material),
            }
        }
    }
    builder
}

fn read_mtl(path: &Path) -> HashMap<String, Entry> {
    let mut entries: HashMap<String, Entry> = HashMap::new();
    let mut current = String::new();
    for line in text(path).lines() {
        let Some((key, rest)) = line.trim().split_once(char::is_whitespace) else { continue };
        if key == "newmtl" {
            current = rest.trim().to_string();
            entries.entry(current.clone()).or_default();
        } else if matches!(key, "Kd" | "Ks" | "Ke" | "Ni" | "d" | "illum") {
            let values = rest.split_whitespace().map(|word| word.parse().expect("a number")).collect();
            entries.entry(current.clone()).or_default().0.insert(key.to_string(), values);
        }
    }
    entries
}

fn vector(text: &str) -> DVec3 {
    let values: Vec<f64> = text.split_whitespace().map(|word| word.parse().expect("a coordinate")).collect();
    DVec3::from_slice(&values)
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
