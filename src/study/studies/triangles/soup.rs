//! Scenes of any number of triangles.
//!
//! Comes in: a number and how they are placed. Goes out: a scene of so many grey triangles under one light, always the same. Their
//! area in all stays the same, as if a surface were refined: twice as many are half as large each.

use std::path::PathBuf;

use glam::Vec3;

use crate::Result;
use crate::interface::NO_INDEX;
use crate::scene::normalise::has_area;
use crate::scene::{FilmSettings, Filter, LoadReport, RenderDefaults, Scaling, Scene, Triangle};
use crate::selftest::kit::scenes::{camera, lambert};
use crate::statistics::random::Random;

/// How triangles are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Evenly over the whole scene.
    Scattered,
    /// In eight balls of an eighth of the scene's width.
    Clustered,
}

impl Placement {
    /// All of them.
    pub const ALL: [Placement; 2] = [Placement::Scattered, Placement::Clustered];

    /// Its name in rows.
    pub fn name(self) -> &'static str {
        match self {
            Placement::Scattered => "scattered",
            Placement::Clustered => "clustered",
        }
    }
}

/// Triangles of the light, which come on top.
pub const LIGHT_TRIANGLES: usize = 2;
/// Half width of the cube that the triangles are in, in scaled units.
const HALF: f32 = 0.5;
/// Length of an edge where there is one triangle, and at most.
const LONGEST_EDGE: f32 = 0.4;
/// Edge times the root of the number: the sum of all areas is some two and a half times a side of the cube.
const EDGE_OF_MANY: f32 = 2.4;
const CLUSTERS: usize = 8;
const CLUSTER_RADIUS: f32 = 0.0625;

/// The scene of `count` triangles, at least 1.
pub fn scene(count: usize, placement: Placement) -> Result<Scene> {
    let edge = (EDGE_OF_MANY / (count.max(1) as f32).sqrt()).min(LONGEST_EDGE);
    let mut random = Random::new(count as u64, placement as u64);
    let mut places = Random::new(1, 2);
    let clusters: Vec<Vec3> = (0..CLUSTERS).map(|_| places.point() * (HALF - CLUSTER_RADIUS)).collect();
    let mut triangles = Vec::with_capacity(count + LIGHT_TRIANGLES);
    while triangles.len() < count {
        let centre = match placement {
            Placement::Scattered => random.point() * (HALF - edge / 2.0),
            // Even in a ball: the radius goes with the third root.
            Placement::Clustered => {
                clusters[random.below(CLUSTERS)] + random.direction() * (CLUSTER_RADIUS * random.unit().cbrt())
            }
        };
        // Corners of an equilateral triangle in a random plane.
        let normal = random.direction();
        let (x, y) = normal.any_orthonormal_pair();
        let radius = edge / 3f32.sqrt();
        let corner = |turn: f32| centre + (x * turn.cos() + y * turn.sin()) * radius;
        let positions = [0.0, 1.0, 2.0].map(|third| corner(third * std::f32::consts::TAU / 3.0));
        if has_area(positions) {
            triangles.push(Triangle { positions, material: 0, corners: NO_INDEX });
        }
    }
    // Above the cube, its front down.
    let light = [[-0.3, -0.3], [0.3, -0.3], [0.3, 0.3], [-0.3, 0.3]].map(|[x, z]| Vec3::new(x, 0.7, z));
    for corners in [[0, 1, 2], [0, 2, 3]] {
        let positions = corners.map(|corner| light[corner]);
        triangles.push(Triangle { positions, material: 1, corners: NO_INDEX });
    }
    Ok(Scene {
        name: placement.name().into(),
        path: PathBuf::new(),
        camera: camera([0.0, 0.0, -2.4], [0.0; 3], 30.0),
        film: FilmSettings { width: 4, height: 3, filter: Filter::Box },
        render: RenderDefaults::default(),
        triangles,
        corners: Vec::new(),
        materials: vec![lambert(0.7, 0.0), lambert(0.0, 1.0)],
        sky: None,
        scaling: Scaling::NONE,
        report: LoadReport::default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texels::triangle::area;

    #[test]
    fn areas_add_up_to_the_same_and_clusters_are_dense() {
        let total = |count, placement| {
            let scene = scene(count, placement).unwrap();
            assert_eq!(scene.triangles.len(), count + LIGHT_TRIANGLES);
            scene.triangles[..count].iter().map(area).sum::<f64>()
        };
        let expected = f64::from(EDGE_OF_MANY).powi(2) * 3f64.sqrt() / 4.0;
        for placement in Placement::ALL {
            for count in [100, 10_000] {
                let total = total(count, placement);
                assert!((total / expected - 1.0).abs() < 1e-3, "{placement:?} {count}: {total} for {expected}");
            }
        }
        // The light's front looks down at the triangles.
        let light = scene(1, Placement::Scattered).unwrap().triangles[1].positions;
        assert!((light[1] - light[0]).cross(light[2] - light[0]).y < 0.0);
    }
}
