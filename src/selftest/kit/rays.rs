//! Rays that trees get wrong first.
//!
//! Comes in: a mesh, its wide tree, a count and a seed. Goes out: rays of ten families in turn. May be assumed: all are
//! valid.

use crate::bvh::{Accel, Ray};
use crate::scene::Triangle;
use glam::Vec3;

use crate::statistics::random::Random;

/// Coordinates of planes on which quantised boxes end, per axis.
fn planes(accel: &Accel) -> [Vec<f32>; 3] {
    let mut planes: [Vec<f32>; 3] = Default::default();
    if let Accel::Wide(tree) = accel {
        for node in tree.nodes.iter().take(200) {
            for slot in (0..8).filter(|&slot| node.child(slot).is_some()) {
                let bounds = node.slot_bounds(slot);
                for (axis, planes) in planes.iter_mut().enumerate() {
                    planes.extend([bounds.low[axis], bounds.high[axis]]);
                }
            }
        }
    }
    planes
}

/// `count` rays, of all families.
pub fn rays(triangles: &[Triangle], accel: &Accel, count: usize, seed: u64) -> Vec<Ray> {
    let planes = planes(accel);
    let mut random = Random::new(seed, 3);
    (0..count).map(|i| ray(i % 10, triangles, &planes, &mut random)).collect()
}

fn axis_direction(random: &mut Random) -> Vec3 {
    let zero = if random.bits() & 1 == 0 { 0.0 } else { -0.0 };
    let mut direction = [zero, if random.bits() & 1 == 0 { 0.0 } else { -0.0 }, 0.0];
    direction[2] = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
    direction.rotate_left(random.below(3));
    Vec3::from_array(direction)
}

fn ray(family: usize, triangles: &[Triangle], planes: &[Vec<f32>; 3], random: &mut Random) -> Ray {
    let origin = random.point() * if random.below(16) == 0 { 50.0 } else { 1.2 };
    let random_direction = random.point() + Vec3::splat(1e-3);
    if triangles.is_empty() {
        return Ray::new(origin, random_direction);
    }
    let id = random.below(triangles.len());
    let [a, b, c] = triangles[id].positions;
    let corner = triangles[random.below(triangles.len())].positions[random.below(3)];
    let on_edge = a + (b - a) * random.unit();
    let (mut from, mut direction) = match family {
        0 => (origin, random_direction),
        1 => (origin, corner - origin),
        2 => (origin, on_edge - origin),
        // Along an axis, through a vertex; from far or from the vertex itself.
        3 => {
            let direction = axis_direction(random);
            (corner - direction * [0.0, 1.0, 0.3, 40.0][random.below(4)], direction)
        }
        // One component zero, of either sign.
        4 => {
            let mut direction = corner - origin;
            direction[random.below(3)] *= 0.0;
            (origin, direction)
        }
        // From a vertex or an edge, anywhere.
        5 => (if random.bits() & 1 == 0 { corner } else { on_edge }, random_direction),
        // Within the plane of a triangle, or nearly.
        6 => {
            let direction = (b - a) * (random.unit() - 0.5) + (c - a) * (random.unit() - 0.5);
            let tilt = Vec3::splat([0.0, 1e-7, 1e-4][random.below(3)]) * random_direction;
            (a - direction * 2.0, direction + tilt)
        }
        // On one or two planes on which quantised boxes end, along or across them.
        7 | 8 => {
            let mut from = origin;
            let mut direction = if family == 7 { axis_direction(random) } else { corner - origin };
            let first = random.below(3);
            for axis in [first, (first + 1 + random.below(2)) % 3] {
                if !planes[axis].is_empty() {
                    from[axis] = planes[axis][random.below(planes[axis].len())];
                    if family == 8 {
                        direction[axis] *= 0.0;
                    }
                }
            }
            (from, direction)
        }
        // Components far below one another.
        _ => {
            let mut direction = axis_direction(random) + random_direction * 10f32.powi(-(random.below(24) as i32));
            if random.bits() & 1 == 0 {
                direction *= 2f32.powi(random.below(40) as i32 - 20);
            }
            (corner - direction.normalize_or(Vec3::X) * random.unit(), direction)
        }
    };
    if !direction.is_finite() || direction.length_squared() < 1e-20 {
        direction = random_direction;
    }
    if !from.is_finite() {
        from = origin;
    }
    let skip = if random.below(8) == 0 { id as u32 } else { crate::interface::NO_INDEX };
    Ray { origin: from, direction, skip }
}
