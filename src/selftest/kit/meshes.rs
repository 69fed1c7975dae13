//! Meshes that are easy, hard and cruel to a tree, and the random numbers that make them.
//!
//! Comes in: sizes and seeds. Goes out: triangles within [-1, 1]^3. May be assumed: the same seed gives the same mesh.

use crate::interface::NO_INDEX;
use crate::scene::Triangle;
use glam::Vec3;

use crate::statistics::random::Random;

/// A flat triangle of material 0.
pub fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    Triangle { positions: [a, b, c], material: 0, corners: NO_INDEX }
}

/// A closed sphere of `rings * sectors * 2 - 2 * sectors` triangles, radius 0.3 to 0.7.
pub fn displaced_sphere(rings: usize, sectors: usize) -> Vec<Triangle> {
    use std::f64::consts::PI;
    let vertex = |ring: usize, sector: usize| {
        // Poles and the seam give one vertex each, whatever the sector's number, so that the mesh is closed.
        let sector = if ring == 0 || ring == rings { 0 } else { sector % sectors };
        let (theta, phi) = (PI * ring as f64 / rings as f64, 2.0 * PI * sector as f64 / sectors as f64);
        let radius = 0.5 + 0.2 * (5.0 * theta).sin() * (3.0 * phi).cos() * theta.sin() * theta.sin();
        let unit = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
        Vec3::from_array(unit.map(|x| (radius * x) as f32))
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for sector in 0..sectors {
            let corners = [(ring, sector), (ring, sector + 1), (ring + 1, sector), (ring + 1, sector + 1)];
            let [a, b, c, d] = corners.map(|(ring, sector)| vertex(ring, sector));
            if ring > 0 {
                triangles.push(triangle(a, b, c));
            }
            if ring + 1 < rings {
                triangles.push(triangle(b, d, c));
            }
        }
    }
    triangles
}

/// A closed cube whose faces are grids of axis-aligned quads: every box is flat, every plane shared.
pub fn cube(cells: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-0.5f32, 0.5] {
            let at = |i: usize, j: usize| {
                let mut p = [side; 3];
                p[(axis + 1) % 3] = i as f32 / cells as f32 - 0.5;
                p[(axis + 2) % 3] = j as f32 / cells as f32 - 0.5;
                Vec3::from_array(p)
            };
            for i in 0..cells {
                for j in 0..cells {
                    triangles.push(triangle(at(i, j), at(i + 1, j), at(i, j + 1)));
                    triangles.push(triangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)));
                }
            }
        }
    }
    triangles
}

/// Random triangles of edges up to about `size`.
pub fn soup(count: usize, size: f32, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed, 0);
    let mut place = || random.point() * (1.0 - size);
    let centres: Vec<Vec3> = (0..count).map(|_| place()).collect();
    let mut random = Random::new(seed, 1);
    let mut corner = |centre: Vec3| centre + random.point() * size;
    centres.into_iter().map(|centre| triangle(corner(centre), corner(centre), corner(centre))).collect()
}

/// Triangles at x = 2^-k, as small as they are near to the origin.
pub fn exponential(count: usize) -> Vec<Triangle> {
    (0..count)
        .map(|k| {
            let x = 2f32.powi(-(k as i32 % 140));
            triangle(Vec3::new(x, 0.0, 0.0), Vec3::new(x, x * 0.1, 0.0), Vec3::new(x, 0.0, x * 0.1))
        })
        .collect()
}

/// Copies of one triangle.
pub fn copies(count: usize) -> Vec<Triangle> {
    vec![triangle(Vec3::new(-0.5, -0.5, 0.25), Vec3::new(0.5, -0.5, 0.25), Vec3::new(0.0, 0.5, 0.25)); count]
}

/// Coplanar, overlapping triangles of different shapes in two axis-aligned planes and an oblique one.
pub fn coplanar(count: usize, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed, 0);
    (0..count)
        .map(|i| {
            let mut corner = || {
                let p = random.point();
                match i % 3 {
                    0 => Vec3::new(p.x, p.y, 0.125),
                    1 => Vec3::new(-0.3, p.y, p.z),
                    _ => Vec3::new(p.x, p.y * 0.5, p.x * 0.25 + p.y * 0.5),
                }
            };
            triangle(corner(), corner(), corner())
        })
        .collect()
}

/// A soup, a cluster of extent 1e-30 and one of extent 0, far apart.
pub fn clusters() -> Vec<Triangle> {
    let mut triangles = soup(60, 0.2, 11);
    for (i, at) in [Vec3::ZERO, Vec3::splat(0.25), Vec3::new(-0.75, 0.5, 0.0)].into_iter().enumerate() {
        let scale = [1e-30, 1e-7, 0.0][i];
        for small in soup(40, 0.3, 17 + i as u64) {
            let [a, b, c] = small.positions.map(|p| at + p * scale);
            triangles.push(triangle(a, b, c));
        }
    }
    triangles
}
