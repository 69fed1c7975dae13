//! What is wrong with a polygon that is about to be split into a fan of triangles.
//!
//! Comes in: the corners of one face. Goes out: its flaw, if it has one; triangles have none.

use glam::DVec3;

/// A polygon may lie this far out of its plane, relative to its size: what decimals of six digits cannot help.
const PLANARITY: f64 = 1e-4;

/// A flaw of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flaw {
    /// Its corners do not lie in one plane.
    Bent,
    /// The fan from its first corner folds over itself.
    Folded,
}

/// The flaw of the polygon with these corners.
pub(super) fn flaw(corners: &[DVec3]) -> Option<Flaw> {
    if corners.len() < 4 {
        return None;
    }
    // Scaled to its own size, so that neither products nor tolerances depend on the file's units.
    let size = corners.iter().map(|&corner| (corner - corners[0]).abs().max_element()).fold(0.0, f64::max);
    if size == 0.0 {
        return None;
    }
    let local = |i: usize| (corners[i % corners.len()] - corners[0]) / size;
    // Newell's normal: twice the area vector of the polygon, whatever its shape.
    let newell: DVec3 = (0..corners.len()).map(|i| local(i).cross(local(i + 1))).sum();
    let normal = newell.try_normalize()?;
    if (1..corners.len()).any(|i| local(i).dot(normal).abs() > PLANARITY) {
        return Some(Flaw::Bent);
    }
    let folds = |i: usize| local(i).cross(local(i + 1)).dot(normal) < -PLANARITY * PLANARITY;
    (1..corners.len() - 1).any(folds).then_some(Flaw::Folded)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 3]]) -> Vec<DVec3> {
        corners.iter().map(|&corner| DVec3::from_array(corner) * 1e-30).collect()
    }

    #[test]
    fn flaws_are_told_apart_at_any_scale() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(flaw(&polygon(&square)), None);
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]];
        assert_eq!(flaw(&polygon(&bent)), Some(Flaw::Bent));
        let arrow = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.5, 0.0]];
        assert_eq!(flaw(&polygon(&arrow)), Some(Flaw::Folded));
        assert_eq!(flaw(&polygon(&[[1.0; 3]; 5])), None);
    }
}
