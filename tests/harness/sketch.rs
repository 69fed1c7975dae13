//! Random scenes of at most 200 triangles that shrink: boxes, balls and triangles of every material under a lamp.
//!
//! Comes in: proptest's choices. Goes out: a scene, and settings for exact pictures or for means of tiles.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::{Strategy, any};
use texray::interface::BLOCK_SAMPLES;
use texray::scene::{Filter, Scene};
use texray::settings::{Sampler, Settings};

use super::scenes::{SceneBuilder, camera, glass, lambert, mirror};

/// Side of the tiles that are compared, in pixels.
pub const TILE: u32 = 8;

/// Something in the scene, its numbers in units of 2^-10.
#[derive(Clone, Debug)]
pub struct Object {
    /// 0: triangle, 1: box, 2: ball of flat triangles, 3: ball with vertex normals.
    shape: u8,
    centre: [i16; 3],
    size: [i16; 3],
    /// 0 and 1: Lambert, 2: mirror, 3: glass, 4: a light.
    material: u8,
}

/// All that a random scene is made of.
#[derive(Clone, Debug)]
pub struct Sketch {
    pub objects: Vec<Object>,
    /// Walls around; otherwise a sky.
    pub room: bool,
    /// Half the width of the lamp below the ceiling, in units of 2^-10.
    pub lamp: i16,
    pub target: [i16; 3],
    pub filter: bool,
    pub seed: u64,
}

pub fn sketches() -> impl Strategy<Value = Sketch> {
    let place = || [-700i16..700, -700i16..700, -300i16..700];
    let object = (0u8..4, place(), [60i16..300, 60i16..300, 60i16..300], 0u8..5)
        .prop_map(|(shape, centre, size, material)| Object { shape, centre, size, material });
    (
        vec(object, 0..6),
        any::<bool>(),
        150i16..700,
        [-200i16..200, -200i16..200, 0i16..200],
        any::<bool>(),
        0u64..1 << 40,
    )
        .prop_map(|(objects, room, lamp, target, filter, seed)| Sketch {
            objects,
            room,
            lamp,
            target,
            filter,
            seed,
        })
}

/// Radiance of lamp, luminous objects and sky.
pub type Light = [f32; 3];
pub const ALL: Light = [1.5, 0.75, 0.5];

impl Sketch {
    pub fn scene(&self) -> Scene {
        self.lit(ALL)
    }

    /// The scene under other light.
    pub fn lit(&self, [lamp, glow, sky]: Light) -> Scene {
        self.builder([lamp, glow]).finish(self.camera(), if self.room { None } else { Some([sky; 3]) })
    }

    pub fn camera(&self) -> texray::scene::Camera {
        camera([0.05, 0.1, -1.05], self.target.map(units), 60.0)
    }

    pub fn builder(&self, [lamp, glow]: [f32; 2]) -> SceneBuilder {
        let mut builder = SceneBuilder::new();
        let kinds = [
            lambert(0.7, 0.0),
            lambert(0.3, 0.0),
            mirror(0.8, 0.0),
            glass(1.5),
            lambert(0.4, glow),
            lambert(0.2, lamp),
        ];
        let materials = kinds.map(|kind| builder.material(kind));
        if self.room {
            builder.cuboid([-1.125, -1.125, -1.25], [1.125; 3], materials[0], true);
        }
        let half = units(self.lamp);
        builder.quad([-half, 1.0, -half], [2.0 * half, 0.0, 0.0], [0.0, 0.0, 2.0 * half], materials[5]);
        for object in &self.objects {
            let (centre, size) = (object.centre.map(units), object.size.map(units));
            let material = materials[usize::from(object.material)];
            match object.shape {
                0 => {
                    let [x, y, z] = size;
                    let at = DVec3::from_array(centre);
                    let corners = [DVec3::new(-x, 0.0, z), DVec3::new(x, y, 0.0), DVec3::new(0.0, -y, -z)];
                    builder.triangle(corners.map(|corner| at + corner), material);
                }
                1 => {
                    let far = [0, 1, 2].map(|axis| centre[axis] + size[axis]);
                    builder.cuboid(centre, far, material, false);
                }
                shape => builder.sphere(centre, size[0], 1, material, shape == 3),
            }
        }
        builder
    }

    /// Settings that take no part of the renderer's choices away.
    pub fn settings(&self, scene: &Scene) -> Settings {
        Settings {
            width: 21,
            height: 17,
            spp: 3,
            max_bounces: 4,
            seed: self.seed,
            filter: if self.filter { Filter::BlackmanHarris } else { Filter::Box },
            ..Settings::for_scene(scene)
        }
    }

    /// Settings for tiles: independent samples, a block for each of four replicates.
    pub fn many(&self, scene: &Scene, seed: u64) -> Settings {
        Settings {
            width: 3 * TILE,
            height: 2 * TILE,
            spp: 4 * BLOCK_SAMPLES,
            replicates: Some(4),
            seed: self.seed ^ seed,
            sampler: Sampler::Independent,
            ..self.settings(scene)
        }
    }
}

fn units(number: i16) -> f64 {
    f64::from(number) / 1024.0
}
