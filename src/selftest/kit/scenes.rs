//! Scenes built in code, for tests that need no file.
//!
//! Comes in: triangles in any units, materials, a camera, perhaps a sky. Goes out: a [`Scene`] that keeps what loading
//! promises: centred, extent in [1, 2), brightest emission in [1, 2), unit vertex normals. Emission 1 stays 1.

use std::path::PathBuf;

use crate::interface::NO_INDEX;
use crate::scene::{
    Camera, Corners, FilmSettings, Filter, LoadReport, Material, MaterialKind, RenderDefaults, Scaling, Scene, Triangle,
};
use glam::{DVec3, Vec2};

/// A Lambert surface of grey albedo and emission.
pub fn lambert(albedo: f32, emission: f32) -> Material {
    material(MaterialKind::Lambert { albedo: [albedo; 3] }, [emission; 3])
}

/// A mirror of grey reflectance and emission.
pub fn mirror(reflectance: f32, emission: f32) -> Material {
    material(MaterialKind::Mirror { reflectance: [reflectance; 3] }, [emission; 3])
}

/// Glass of an index of refraction.
pub fn glass(ior: f32) -> Material {
    material(MaterialKind::Glass { ior }, [0.0; 3])
}

/// Any material, without a name.
pub fn material(kind: MaterialKind, emission: [f32; 3]) -> Material {
    Material { name: String::new(), kind, emission }
}

/// A camera that looks from `origin` to `target`; `up` is any axis that is not the view's.
pub fn camera(origin: [f64; 3], target: [f64; 3], vfov: f64) -> Camera {
    let (origin, target) = (DVec3::from_array(origin), DVec3::from_array(target));
    let view = (target - origin).normalize();
    let up = if view.y.abs() < 0.9 { DVec3::Y } else { DVec3::Z };
    Camera { origin, target, up, vfov }
}

/// A scene under construction, in units of its own.
#[derive(Default)]
pub struct SceneBuilder {
    triangles: Vec<([DVec3; 3], Option<[DVec3; 3]>, u32)>,
    materials: Vec<Material>,
}

impl SceneBuilder {
    /// An empty scene.
    pub fn new() -> SceneBuilder {
        SceneBuilder::default()
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a flat triangle; its front sees the corners turn counter-clockwise.
    pub fn triangle(&mut self, corners: [DVec3; 3], material: u32) {
        self.triangles.push((corners, None, material));
    }

    /// Adds a triangle with vertex normals.
    pub fn smooth_triangle(&mut self, corners: [DVec3; 3], normals: [DVec3; 3], material: u32) {
        self.triangles.push((corners, Some(normals), material));
    }

    /// Adds the parallelogram `corner`, `corner + a`, `corner + a + b`, `corner + b`; its front is the side of a × b.
    pub fn quad(&mut self, corner: [f64; 3], a: [f64; 3], b: [f64; 3], material: u32) {
        let [corner, a, b] = [corner, a, b].map(DVec3::from_array);
        self.triangle([corner, corner + a, corner + a + b], material);
        self.triangle([corner, corner + a + b, corner + b], material);
    }

    /// Adds a box along the axes; its front is the outside, or the inside where `inward`.
    pub fn cuboid(&mut self, low: [f64; 3], high: [f64; 3], material: u32, inward: bool) {
        let size: [f64; 3] = std::array::from_fn(|axis| high[axis] - low[axis]);
        for axis in 0..3 {
            let edge = |along: usize| {
                let mut edge = [0.0; 3];
                edge[along] = size[along];
                edge
            };
            let (a, b) = (edge((axis + 1) % 3), edge((axis + 2) % 3));
            let mut far = low;
            far[axis] = high[axis];
            // a × b points up the axis: outwards on the far side, inwards on the near one.
            let (near_side, far_side) = if inward { ((a, b), (b, a)) } else { ((b, a), (a, b)) };
            self.quad(low, near_side.0, near_side.1, material);
            self.quad(far, far_side.0, far_side.1, material);
        }
    }

    /// Adds a sphere of 8 · 4^`divisions` triangles (an octahedron, each edge halved `divisions` times), front outside.
    pub fn sphere(&mut self, centre: [f64; 3], radius: f64, divisions: u32, material: u32, smooth: bool) {
        let centre = DVec3::from_array(centre);
        let mut faces = Vec::new();
        for octant in 0..8 {
            let sign = |axis: u32| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let [x, y, z] = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
            faces.push(if sign(0) * sign(1) * sign(2) > 0.0 { [x, y, z] } else { [x, z, y] });
        }
        for _ in 0..divisions {
            let halved = |[a, b, c]: [DVec3; 3]| {
                let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            };
            faces = faces.into_iter().flat_map(halved).collect();
        }
        for normals in faces {
            let corners = normals.map(|normal| centre + radius * normal);
            match smooth {
                true => self.smooth_triangle(corners, normals, material),
                false => self.triangle(corners, material),
            }
        }
    }

    /// Adds a sphere of radius 1 around the origin, its front inside, of which the cap around +y of about `fraction` of its
    /// area has the second material. Returns the cap's true share.
    pub fn cap_sphere(&mut self, divisions: u32, [wall, cap]: [u32; 2], fraction: f64) -> f64 {
        let first = self.triangles.len();
        self.sphere([0.0; 3], 1.0, divisions, wall, false);
        // A cap's area goes with its height: 2 of the whole sphere.
        let lowest = 1.0 - 2.0 * fraction;
        let (mut whole, mut part) = (0.0, 0.0);
        for (corners, _, material) in &mut self.triangles[first..] {
            corners.swap(1, 2);
            let [a, b, c] = *corners;
            let area = (b - a).cross(c - a).length();
            whole += area;
            if ((a + b + c) / 3.0).normalize().y > lowest {
                *material = cap;
                part += area;
            }
        }
        part / whole
    }

    /// What loading would scale the scene by.
    pub fn scaling(&self, sky: Option<[f32; 3]>) -> Scaling {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &position in self.triangles.iter().flat_map(|(corners, _, _)| corners) {
            (low, high) = (low.min(position), high.max(position));
        }
        let mut scaling = match self.triangles.is_empty() {
            true => Scaling::NONE,
            false => Scaling::of_lengths(low + (high - low) / 2.0, (high - low).max_element()),
        };
        let emissions = self.materials.iter().map(|material| material.emission).chain(sky);
        let brightest = emissions.flatten().fold(0.0, f32::max);
        if brightest > 0.0 && brightest.is_finite() {
            scaling.scale_radiance(f64::from(brightest));
        }
        scaling
    }

    /// The scene, seen by a camera in the same units.
    pub fn finish(self, camera: Camera, sky: Option<[f32; 3]>) -> Scene {
        let scaling = self.scaling(sky);
        self.finish_scaled(camera, sky, scaling)
    }

    /// The same, scaled by whatever is given.
    pub fn finish_scaled(self, camera: Camera, sky: Option<[f32; 3]>, scaling: Scaling) -> Scene {
        let bright = |rgb: [f32; 3]| rgb.map(|channel| channel * 2f32.powi(scaling.radiance_exponent));

        let (mut triangles, mut all_corners) = (Vec::new(), Vec::new());
        for (positions, normals, material) in self.triangles {
            let corners = normals.map_or(NO_INDEX, |_| all_corners.len() as u32);
            all_corners
                .extend(normals.map(|n| Corners { normals: n.map(|n| n.normalize().as_vec3()), uvs: [Vec2::ZERO; 3] }));
            triangles.push(Triangle { positions: positions.map(|p| scaling.point(p).as_vec3()), material, corners });
        }
        let mut materials = self.materials;
        for material in &mut materials {
            material.emission = bright(material.emission);
        }
        Scene {
            name: "built-in-code".into(),
            path: PathBuf::new(),
            camera: scaling.camera(&camera),
            film: FilmSettings { width: 1, height: 1, filter: Filter::Box },
            render: RenderDefaults::default(),
            triangles,
            corners: all_corners,
            materials,
            sky: sky.map(bright),
            scaling,
            report: LoadReport::default(),
        }
    }
}
