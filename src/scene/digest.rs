//! What a scene is, as one number: by it a picture says what it is a picture of.
//!
//! Comes in: a checked scene. Goes out: 128 bits that are the same wherever and from whatever files equal scenes are
//! loaded, and differ where anything that a picture can show does.

use std::fmt;

use xxhash_rust::xxh3::Xxh3Default;

use super::{Camera, Corners, Material, MaterialKind, Scaling, Scene, Triangle};

/// The digest of a scene; shown as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u128);

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl Scene {
    /// The scene's digest (XXH3, which is the same in every version and on every machine): of geometry, materials but
    /// for their names, camera, sky and scaling. Picture size and defaults of the command line are not part of it.
    pub fn digest(&self) -> Digest {
        // Every field by name, so that a new one is not forgotten here.
        let Scene {
            name: _,
            path: _,
            camera,
            film: _,
            render: _,
            triangles,
            corners,
            materials,
            sky,
            scaling,
            report: _,
        } = self;
        let Camera { origin, target, up, vfov } = camera;
        let Scaling { centre, length_exponent, radiance_exponent } = scaling;
        let mut hasher = Hasher(Xxh3Default::new());
        for vector in [origin, target, up, centre] {
            vector.to_array().iter().for_each(|value| hasher.word(value.to_bits()));
        }
        hasher.word(vfov.to_bits());
        hasher.word(i64::from(*length_exponent) as u64);
        hasher.word(i64::from(*radiance_exponent) as u64);
        hasher.word(u64::from(sky.is_some()));
        hasher.floats(&sky.unwrap_or_default());
        // Each list after its length, so that no two lists can be read as two others.
        hasher.word(materials.len() as u64);
        for Material { name: _, kind, emission } in materials {
            let (kind, values) = match *kind {
                MaterialKind::Lambert { albedo } => (0, albedo),
                MaterialKind::Mirror { reflectance } => (1, reflectance),
                MaterialKind::Glass { ior } => (2, [ior; 3]),
            };
            hasher.word(kind);
            hasher.floats(&values);
            hasher.floats(emission);
        }
        hasher.word(triangles.len() as u64);
        for Triangle { positions, material, corners } in triangles {
            positions.iter().for_each(|position| hasher.floats(&position.to_array()));
            hasher.word(u64::from(*material) << 32 | u64::from(*corners));
        }
        hasher.word(corners.len() as u64);
        for Corners { normals, uvs } in corners {
            normals.iter().for_each(|normal| hasher.floats(&normal.to_array()));
            uvs.iter().for_each(|uv| hasher.floats(&uv.to_array()));
        }
        Digest(hasher.0.digest128())
    }
}

struct Hasher(Xxh3Default);

impl Hasher {
    fn word(&mut self, word: u64) {
        self.0.update(&word.to_le_bytes());
    }

    fn floats(&mut self, floats: &[f32]) {
        floats.iter().for_each(|float| self.0.update(&float.to_bits().to_le_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    fn load(folder: &Path, name: &str, change: [&str; 2]) -> Scene {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        for (from, to) in
            [("cornell-box.toml", name), ("cornell-box.obj", "cornell-box.obj"), ("cornell-box.mtl", "cornell-box.mtl")]
        {
            let text = fs::read_to_string(scenes.join(from)).unwrap();
            fs::write(folder.join(to), text.replacen(change[0], change[1], 1)).unwrap();
        }
        Scene::load(&folder.join(name)).unwrap()
    }

    /// The value is written down: it must not change from one version to the next.
    #[test]
    fn a_digest_is_of_what_shows() {
        let folder = tempfile::tempdir().unwrap();
        let digest = |name: &str, change: [&str; 2]| load(folder.path(), name, change).digest();
        let plain = digest("a.toml", ["", ""]);
        assert_eq!(plain.to_string(), "4142e17cdcea0d66ff40603629286117");
        assert_eq!(digest("b.toml", ["spp = 256", "spp = 4"]), plain, "neither name nor samples");
        for change in [
            ["vfov = 30.0", "vfov = 31.0"],
            ["2.78, 2.73, -8.0", "2.78, 2.73, -8.5"],
            ["Kd 0.", "Kd 0.0"],
            ["\nv ", "\nv -"],
        ] {
            assert_ne!(digest("a.toml", change), plain, "{change:?}");
        }
    }
}
