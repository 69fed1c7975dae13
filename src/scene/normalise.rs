//! File units to scaled units: f64 triangles to f32, without losing what f32 can hold.
//!
//! Comes in: a [`RawScene`] and a camera in file units. Goes out: the same moved to the origin and scaled by a power of
//! two so that the largest extent lies in [1, 2), and radiance scaled by a power of two so that the brightest channel
//! lies in [1, 2). Both scalings are exact, so a scene that is moved (by numbers that keep its coordinates exact) or
//! scaled by a power of two comes out bit for bit the same. Only materials that a triangle uses remain.

use std::convert::Infallible;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::assemble::{RawScene, RawTriangle};
use super::batches::in_batches;
use super::{Camera, Corners, Material, Scaling, Triangle};
use crate::interface::NO_INDEX;
use crate::{Error, Result};

/// Farthest that a camera may stand from the scene, in scaled units: beyond it the scene is no larger than a rounding.
const FARTHEST_CAMERA: f64 = 1e12;

/// What the scene holds, in scaled units.
pub(super) struct Normalised {
    pub camera: Camera,
    pub triangles: Vec<Triangle>,
    pub corners: Vec<Corners>,
    pub materials: Vec<Material>,
    pub sky: Option<[f32; 3]>,
    pub scaling: Scaling,
    pub degenerate: usize,
}

/// Scales the scene; `line` is that of the camera in `path`.
pub(super) fn normalise(
    path: &Path,
    line: usize,
    raw: &RawScene,
    camera: &Camera,
    sky: Option<[f64; 3]>,
) -> Result<Normalised> {
    let (centre, extent) = match bounds(&raw.triangles) {
        Some((low, high)) => (low + (high - low) / 2.0, (high - low).max_element()),
        // Without geometry only directions count, and the camera is the natural origin.
        None => (camera.origin, 1.0),
    };
    if !(1e-100..=1e100).contains(&extent) {
        let message = format!("the scene's largest extent is {extent:e}; allowed is 1e-100 to 1e100");
        return Err(Error::scene(path, 0, message));
    }
    let scaling = Scaling::of_lengths(centre, extent);
    let camera = scaling.camera(camera);
    if let Err(message) = check_camera(&camera) {
        return Err(Error::scene(path, line, message));
    }
    let mut scaled = Normalised {
        camera,
        triangles: Vec::with_capacity(raw.triangles.len()),
        corners: Vec::with_capacity(raw.corners.len()),
        materials: Vec::new(),
        sky: None,
        scaling,
        degenerate: raw.degenerate,
    };
    let material_of_raw = scaled.add_triangles(raw);
    let used = |index: usize| material_of_raw[index] != NO_INDEX;
    let emitted = raw.materials.iter().enumerate().filter(|(index, _)| used(*index)).map(|(_, (_, recipe))| recipe.ke);
    let brightest = emitted.chain(sky).flatten().fold(0.0, f64::max);
    if brightest > 0.0 {
        if brightest < 1e-36 {
            let message = format!("the brightest emission is {brightest:e}; allowed is 0, or 1e-36 to 1e36");
            return Err(Error::scene(path, 0, message));
        }
        scaled.scaling.scale_radiance(brightest);
    }
    let factor = power_of_two(scaled.scaling.radiance_exponent);
    for (index, (name, recipe)) in raw.materials.iter().enumerate() {
        let slot = material_of_raw[index];
        if slot != NO_INDEX {
            let emission = recipe.ke.map(|channel| radiance(channel * factor));
            scaled.materials[slot as usize] = Material { name: name.clone(), kind: recipe.kind(), emission };
        }
    }
    scaled.sky = sky.map(|channels| channels.map(|channel| radiance(channel * factor)));
    scaled.sky = scaled.sky.filter(|channels| channels.iter().any(|&channel| channel > 0.0));
    Ok(scaled)
}

impl Normalised {
    /// Adds every triangle that keeps an area in f32. Goes out: the index of each raw material, by first use.
    fn add_triangles(&mut self, raw: &RawScene) -> Vec<u32> {
        let mut material_of_raw = vec![NO_INDEX; raw.materials.len()];
        let scaling = self.scaling;
        // Scaled positions with the raw indices; nothing where no area is left.
        let scale = |raw: &RawTriangle| {
            let positions = raw.positions.map(|corner| scaling.point(corner).as_vec3());
            has_area(positions).then_some(Triangle { positions, material: raw.material, corners: raw.corners })
        };
        let scaled = |_, part: &[RawTriangle]| part.iter().map(scale).collect::<Vec<_>>();
        // The addition of a part cannot fail.
        let added: std::result::Result<(), Infallible> = in_batches(&raw.triangles, scaled, |part| {
            for triangle in part {
                let Some(triangle) = triangle else {
                    self.degenerate += 1;
                    continue;
                };
                let material = &mut material_of_raw[triangle.material as usize];
                if *material == NO_INDEX {
                    *material = self.materials.len() as u32;
                    let kind = raw.materials[triangle.material as usize].1.kind();
                    self.materials.push(Material { name: String::new(), kind, emission: [0.0; 3] });
                }
                let material = *material;
                let mut corners = NO_INDEX;
                if let Some(smooth) = raw.corners.get(triangle.corners as usize) {
                    corners = self.corners.len() as u32;
                    self.corners.push(Corners {
                        normals: smooth.normals.map(|normal| normal.as_vec3()),
                        uvs: smooth.uvs.map(|uv| uv.as_vec2()),
                    });
                }
                self.triangles.push(Triangle { material, corners, ..triangle });
            }
            Ok(())
        });
        let Ok(()) = added;
        material_of_raw
    }
}

/// Corners of the box around all triangles.
pub(super) fn bounds(triangles: &[RawTriangle]) -> Option<(DVec3, DVec3)> {
    let mut corners = triangles.iter().flat_map(|triangle| triangle.positions);
    let first = corners.next()?;
    Some(corners.fold((first, first), |(low, high), corner| (low.min(corner), high.max(corner))))
}

/// Whether the triangle has an area that f32 can hold as a normal number; its reciprocal is finite then.
pub(crate) fn has_area(positions: [Vec3; 3]) -> bool {
    let [a, b, c] = positions.map(|position| position.as_dvec3());
    let area = 0.5 * (b - a).cross(c - a).length();
    area as f32 >= f32::MIN_POSITIVE
}

/// A radiance in f32; what is so dim beside the brightest that f32 holds it as a denormal is black.
fn radiance(channel: f64) -> f32 {
    let channel = channel as f32;
    if channel < f32::MIN_POSITIVE { 0.0 } else { channel }
}

impl Scaling {
    /// Nothing is moved or scaled.
    pub const NONE: Scaling = Scaling { centre: DVec3::ZERO, length_exponent: 0, radiance_exponent: 0 };

    /// What brings geometry of this centre and largest extent (above 0) to the origin and into [1, 2); radiance stays.
    pub fn of_lengths(centre: DVec3, extent: f64) -> Scaling {
        Scaling { centre, length_exponent: -exponent(extent), radiance_exponent: 0 }
    }

    /// Also brings the brightest channel of all radiance, above 0, into [1, 2).
    pub fn scale_radiance(&mut self, brightest: f64) {
        self.radiance_exponent = -exponent(brightest);
    }

    /// A point, scaled.
    pub fn point(&self, point: DVec3) -> DVec3 {
        (point - self.centre) * power_of_two(self.length_exponent)
    }

    /// A camera, scaled.
    pub fn camera(&self, camera: &Camera) -> Camera {
        Camera { origin: self.point(camera.origin), target: self.point(camera.target), ..*camera }
    }
}

/// Refuses a camera that has lost its direction or its distance to the numbers' range.
fn check_camera(camera: &Camera) -> std::result::Result<(), String> {
    let distance = camera.origin.abs().max_element();
    if distance > FARTHEST_CAMERA {
        return Err(format!("the camera is {distance:e} times the scene's size away; allowed is up to 1e12"));
    }
    let view = (camera.target - camera.origin).abs().max_element();
    if !(1e-100..=1e100).contains(&view) {
        return Err(format!("the camera's target is {view:e} times the scene's size away; allowed is 1e-100 to 1e100"));
    }
    let direction = ((camera.target - camera.origin) / view).normalize();
    if direction.cross(camera.up).length() < 1e-10 {
        return Err("the camera's up is parallel to its view; allowed is any other direction".to_owned());
    }
    Ok(())
}

/// Largest `e` with `2^e <= value`, for a positive normal `value`: the exponent field of IEEE 754.
pub(super) fn exponent(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// `2^e`, for `e` from -1022 to 1023: both ends are far beyond what files may hold.
pub(super) fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((e.clamp(-1022, 1023) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::super::recipe::Recipe;
    use super::*;

    fn raw(scale: f64, offset: f64, ke: f64) -> (RawScene, Camera) {
        let place = |x: f64, y: f64, z: f64| DVec3::new(x * scale + offset, y * scale + offset, z * scale + offset);
        let triangle = |material| RawTriangle {
            positions: [place(0.0, 0.0, 0.0), place(3.25, 0.0, 0.0), place(0.0, 1.5, -0.125)],
            material,
            corners: NO_INDEX,
        };
        let dark = Recipe { ke: [1e30; 3], ..Recipe::default() };
        let light = Recipe { ke: [ke, 0.3 * ke, 0.0], ..Recipe::default() };
        let materials = vec![("unused".to_owned(), dark), ("light".to_owned(), light)];
        let camera = Camera { origin: place(0.5, 0.5, 4.0), target: place(0.5, 0.5, 0.0), up: DVec3::Y, vfov: 40.0 };
        (RawScene { triangles: vec![triangle(1); 2], materials, ..RawScene::default() }, camera)
    }

    fn run(scale: f64, offset: f64, ke: f64) -> Normalised {
        let (raw, camera) = raw(scale, offset, ke);
        normalise(Path::new("a"), 1, &raw, &camera, None).unwrap()
    }

    /// Everything that the picture depends on, as bits.
    fn bits(scene: &Normalised) -> (Vec<u32>, [u64; 6], [u32; 3]) {
        let positions = scene.triangles.iter().flat_map(|triangle| triangle.positions);
        let (origin, target) = (scene.camera.origin.to_array(), scene.camera.target.to_array());
        let camera = [0, 1, 2, 3, 4, 5].map(|i| if i < 3 { origin[i].to_bits() } else { target[i - 3].to_bits() });
        let emission = scene.materials[0].emission.map(f32::to_bits);
        (positions.flat_map(|position| position.to_array().map(f32::to_bits)).collect(), camera, emission)
    }

    #[test]
    fn moved_and_scaled_scenes_are_the_same_bit_for_bit() {
        let plain = run(1.0, 0.0, 17.0);
        for (scale, offset) in
            [(1.0, 1e6), (1.0, -1e9), (2f64.powi(20), 0.0), (2f64.powi(-20), 0.0), (2f64.powi(-100), 0.0)]
        {
            assert_eq!(bits(&run(scale, offset, 17.0)), bits(&plain), "{scale} {offset}");
        }
        assert_eq!(bits(&run(1.0, 0.0, 17.0 * 2f64.powi(-100))), bits(&plain));
    }

    #[test]
    fn extent_and_brightest_emission_lie_from_1_to_2() {
        let scene = run(1.0, 0.0, 17.0);
        assert_eq!(
            scene.scaling,
            Scaling { centre: DVec3::new(1.625, 0.75, -0.0625), length_exponent: -1, radiance_exponent: -4 }
        );
        assert_eq!(
            scene.materials.len(),
            1,
            "a material that no triangle uses is left out, and does not set the scale"
        );
        assert_eq!(scene.materials[0].emission[0], 17.0 / 16.0);
    }

    #[test]
    fn triangles_that_vanish_in_f32_are_dropped_before_ids_are_given() {
        let (mut raw, camera) = raw(1.0, 0.0, 1.0);
        let far = DVec3::splat(1.0);
        raw.triangles.insert(
            0,
            RawTriangle { positions: [far, far + DVec3::X * 1e-12, far + DVec3::Y * 1e-12], ..raw.triangles[0] },
        );
        let scene = normalise(Path::new("a"), 1, &raw, &camera, None).unwrap();
        assert_eq!((scene.triangles.len(), scene.degenerate), (2, 1));
    }

    #[test]
    fn an_environment_alone_is_legal() {
        let (_, camera) = raw(1.0, 1e6, 1.0);
        let scene = normalise(Path::new("a"), 1, &RawScene::default(), &camera, Some([3.0, 2.0, 0.0])).unwrap();
        assert_eq!((scene.triangles.len(), scene.sky), (0, Some([1.5, 1.0, 0.0])));
    }

    #[test]
    fn exponents_are_exact() {
        for e in [-300, -1, 0, 1, 300] {
            assert_eq!(exponent(power_of_two(e)), e);
            assert_eq!(exponent(power_of_two(e) * (2.0 - f64::EPSILON)), e);
        }
    }
}
