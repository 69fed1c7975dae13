//! How a polygon becomes triangles: by a fan from its first corner where that covers it once, else by clipping ears.
//!
//! Comes in: the corners of one face. Goes out: a [`Split`]. A hole is a polygon whose line leads to it and back, as
//! programs write it. Everything is done in the polygon's own plane and at its own size, so neither products nor
//! tolerances depend on the file's units.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// A polygon may lie this far out of its plane, relative to its size: what decimals of six digits cannot help.
const PLANARITY: f64 = 1e-4;
/// How far the area of the triangles may be from the polygon's, both relative to the square of its size.
const SAME_AREA: f64 = 1e-6;
/// Twice the area that a polygon has at least, relative to the square of its size, to have a plane.
const LEAST_AREA: f64 = 1e-14;
/// Pairs of edges that are looked at in all polygons of a file: some seconds. Ears are clipped in about as many steps.
const MOST_PAIRS: u64 = 1 << 30;

/// The triangles of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Split<'a> {
    /// The fan from its first corner.
    Fan {
        /// Its corners do not lie in one plane.
        bent: bool,
        /// It is no simple polygon, or there are too many of them: its fan overlaps itself.
        overlaps: bool,
    },
    /// Corners of triangles, which turn as the polygon does.
    Ears {
        /// Its corners do not lie in one plane.
        bent: bool,
        /// Places in the list of its corners.
        triangles: &'a [[usize; 3]],
    },
}

/// Splits polygons; keeps its lists from one to the next.
pub(super) struct Splitter {
    flat: Vec<[f64; 2]>,
    ears: Earcut<f64>,
    indices: Vec<usize>,
    triangles: Vec<[usize; 3]>,
    pairs_left: u64,
}

impl Splitter {
    /// For the polygons of one file.
    pub(super) fn new() -> Splitter {
        Splitter {
            flat: Vec::new(),
            ears: Earcut::new(),
            indices: Vec::new(),
            triangles: Vec::new(),
            pairs_left: MOST_PAIRS,
        }
    }

    /// Splits the polygon with these corners.
    pub(super) fn split(&mut self, corners: &[DVec3]) -> Split<'_> {
        let plain = Split::Fan { bent: false, overlaps: false };
        if corners.len() < 4 {
            return plain;
        }
        let size = corners.iter().map(|&corner| (corner - corners[0]).abs().max_element()).fold(0.0, f64::max);
        if size == 0.0 {
            return plain;
        }
        let local = |i: usize| (corners[i % corners.len()] - corners[0]) / size;
        // Newell's normal: twice the area vector of the polygon, whatever its shape.
        let newell: DVec3 = (0..corners.len()).map(|i| local(i).cross(local(i + 1))).sum();
        // Of a line, roundings are left.
        let Some(normal) = newell.try_normalize().filter(|_| newell.length() > LEAST_AREA) else { return plain };
        let bent = (1..corners.len()).any(|i| local(i).dot(normal).abs() > PLANARITY);
        let folds = |i: usize| local(i).cross(local(i + 1)).dot(normal) < -PLANARITY * PLANARITY;
        if !(1..corners.len() - 1).any(folds) {
            return Split::Fan { bent, overlaps: false };
        }
        let (right, up) = normal.any_orthonormal_pair();
        self.flat.clear();
        self.flat.extend((0..corners.len()).map(|i| [local(i).dot(right), local(i).dot(up)]));
        match self.clip(newell.length() / 2.0) {
            true => Split::Ears { bent, triangles: &self.triangles },
            false => Split::Fan { bent, overlaps: true },
        }
    }

    /// Clips the ears of the flat polygon of this area, which turns counter-clockwise; whether they cover it.
    fn clip(&mut self, area: f64) -> bool {
        let pairs = (self.flat.len() as u64).saturating_mul(self.flat.len() as u64) / 2;
        if pairs > self.pairs_left {
            return false;
        }
        self.pairs_left -= pairs;
        // Ears of a line that crosses itself take long to find, and cover nothing that it means.
        if crosses_itself(&self.flat) {
            return false;
        }
        self.ears.earcut(self.flat.iter().copied(), &[], &mut self.indices);
        self.triangles.clear();
        let mut covered = 0.0;
        for ear in self.indices.chunks_exact(3) {
            let [a, b, c] = [ear[0], ear[1], ear[2]];
            let Some(twice) = turn(&self.flat, a, b, c) else { return false };
            covered += twice.abs() / 2.0;
            self.triangles.push(if twice < 0.0 { [a, c, b] } else { [a, b, c] });
        }
        (covered - area).abs() <= SAME_AREA
    }
}

/// Twice the area of a triangle of the list's points, above 0 where it turns counter-clockwise.
fn turn(flat: &[[f64; 2]], a: usize, b: usize, c: usize) -> Option<f64> {
    let [a, b, c] = [flat.get(a)?, flat.get(b)?, flat.get(c)?].map(|&point| DVec2::from_array(point));
    Some((b - a).perp_dot(c - a))
}

/// Whether two edges cross at a point that is inside both: those of a line that leads to a hole and back do not.
fn crosses_itself(flat: &[[f64; 2]]) -> bool {
    let count = flat.len();
    let point = |i: usize| DVec2::from_array(flat[i % count]);
    // Roundings of the projection are far below.
    let side = |a: DVec2, b: DVec2, c: DVec2| {
        let twice = (b - a).perp_dot(c - a);
        if twice.abs() <= 1e-12 { 0.0 } else { twice }
    };
    (0..count).any(|i| {
        let (a, b) = (point(i), point(i + 1));
        let (low, high) = (a.min(b), a.max(b));
        (i + 2..count).any(|j| {
            let (c, d) = (point(j), point(j + 1));
            let apart = c.max(d).cmplt(low).any() || c.min(d).cmpgt(high).any();
            !apart && side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Vec<DVec3> {
        let tilt = glam::DQuat::from_rotation_x(1.0) * glam::DQuat::from_rotation_y(0.5);
        corners.iter().map(|corner| tilt * DVec3::new(corner[0], corner[1], 0.0) * 1e-30).collect()
    }

    fn area(corners: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        let of = |[a, b, c]: &[usize; 3]| (corners[*b] - corners[*a]).cross(corners[*c] - corners[*a]).length() / 2.0;
        triangles.iter().map(of).sum::<f64>() * 1e60
    }

    #[test]
    fn convex_polygons_and_flat_or_empty_ones_are_fans() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut splitter = Splitter::new();
        assert_eq!(splitter.split(&polygon(&square)), Split::Fan { bent: false, overlaps: false });
        let mut bent = polygon(&square);
        bent[2] *= 1.1;
        bent[2].x += 1e-31;
        assert_eq!(splitter.split(&bent), Split::Fan { bent: true, overlaps: false });
        assert_eq!(splitter.split(&[DVec3::ONE; 5]), Split::Fan { bent: false, overlaps: false });
        assert!(!splitter.split(&polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])).bent());
    }

    #[test]
    fn ears_cover_a_polygon_once_and_turn_as_it_does() {
        let arrow = vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, 0.5]];
        let frame = vec![
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let comb: Vec<[f64; 2]> = (0..50)
            .flat_map(|i| [[f64::from(i), 0.0], [f64::from(i) + 0.5, 2.0]])
            .chain([[50.0, -1.0], [0.0, -1.0]])
            .collect();
        for (corners, expected) in [(arrow, 0.5), (frame, 12.0), (comb, 99.75)] {
            for reversed in [false, true] {
                let mut corners = polygon(&corners);
                if reversed {
                    corners.reverse();
                }
                for first in 0..corners.len() {
                    corners.rotate_left(first.min(1));
                    let mut splitter = Splitter::new();
                    let newell: DVec3 =
                        (0..corners.len()).map(|i| corners[i].cross(corners[(i + 1) % corners.len()])).sum();
                    let fan: Vec<_> = (1..corners.len() - 1).map(|i| [0, i, i + 1]).collect();
                    let triangles = match splitter.split(&corners) {
                        Split::Ears { triangles, bent: false } => triangles.to_vec(),
                        Split::Fan { bent: false, overlaps: false } => fan,
                        other => panic!("{other:?}"),
                    };
                    assert!((area(&corners, &triangles) - expected).abs() < 1e-9 * expected);
                    for [a, b, c] in triangles {
                        let normal = (corners[b] - corners[a]).cross(corners[c] - corners[a]);
                        assert!(normal.dot(newell) >= -1e-130, "{normal} {newell}");
                    }
                }
            }
        }
    }

    /// A line that crosses itself has no inside, and many long polygons would take long.
    #[test]
    fn what_cannot_be_clipped_is_a_fan_that_overlaps() {
        let star: Vec<[f64; 2]> = (0..5)
            .map(|i| (f64::from(i) * 4.0 * std::f64::consts::PI / 5.0).sin_cos())
            .map(|(y, x)| [x, y * 1.1])
            .collect();
        let mut bow = vec![[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 1.0]];
        bow.push([-1.0, 0.5]);
        let mut splitter = Splitter::new();
        assert_eq!(splitter.split(&polygon(&bow)), Split::Fan { bent: false, overlaps: true });
        assert!(matches!(splitter.split(&polygon(&star)), Split::Fan { bent: false, .. }));
        let wave: Vec<[f64; 2]> = (0..40_000).map(|i| [f64::from(i), f64::from(i % 2)]).chain([[2e4, -1e4]]).collect();
        assert_eq!(splitter.split(&polygon(&wave)), Split::Fan { bent: false, overlaps: true });
        let arrow = polygon(&[[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, 0.5]]);
        assert!(matches!(splitter.split(&arrow), Split::Ears { .. }), "the others still have room");
    }

    impl Split<'_> {
        fn bent(&self) -> bool {
            let (Split::Fan { bent, .. } | Split::Ears { bent, .. }) = self;
            *bent
        }
    }
}
