//! Placement of a mesh in the scene.
//!
//! Comes in: the steps of a `[[mesh]]` table. Goes out: an affine [`Transform`] in f64 that can be inverted.

use glam::{DMat3, DVec3};

/// Least volume of the parallelepiped of a transform's unit columns; below it the mesh is as good as flat.
const SINGULAR: f64 = 1e-9;

/// `world = linear * file + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform {
    linear: DMat3,
    translation: DVec3,
    normals: DMat3,
    mirrors: bool,
}

impl Transform {
    /// Leaves everything where it is.
    pub(super) const IDENTITY: Transform =
        Transform { linear: DMat3::IDENTITY, translation: DVec3::ZERO, normals: DMat3::IDENTITY, mirrors: false };

    /// The transform of a linear part and a translation, or `None` where the linear part cannot be inverted.
    pub(super) fn new(linear: DMat3, translation: DVec3) -> Option<Transform> {
        let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
        let mut unit = [DVec3::ZERO; 3];
        let mut lengths = [0.0; 3];
        for ((column, unit), length) in columns.iter().zip(&mut unit).zip(&mut lengths) {
            // Scaled before the square, which could leave the range of f64.
            let size = column.abs().max_element();
            if !(size.is_finite() && size > 0.0) {
                return None;
            }
            *length = size * (*column / size).length();
            *unit = (*column / size).normalize();
        }
        let volume = unit[0].dot(unit[1].cross(unit[2]));
        if !translation.is_finite() || !volume.is_finite() || volume.abs() <= SINGULAR {
            return None;
        }
        // Inverse transpose of the linear part up to a factor: cofactors of the unit columns, each over its length.
        let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let normals = DMat3::from_cols(
            unit[1].cross(unit[2]) / volume * (least / lengths[0]),
            unit[2].cross(unit[0]) / volume * (least / lengths[1]),
            unit[0].cross(unit[1]) / volume * (least / lengths[2]),
        );
        Some(Transform { linear, translation, normals, mirrors: volume < 0.0 })
    }

    /// Where a point goes.
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        if *self == Transform::IDENTITY { point } else { self.linear * point + self.translation }
    }

    /// Where a normal points, of any length.
    pub(super) fn normal(&self, normal: DVec3) -> DVec3 {
        if *self == Transform::IDENTITY { normal } else { self.normals * normal }
    }

    /// Whether left becomes right, so that corners must be swapped to keep a triangle's front.
    pub(super) fn mirrors(&self) -> bool {
        self.mirrors
    }
}

/// Right-handed rotation about `axis` (not zero) by degrees; multiples of 90 about a coordinate axis are exact.
pub(super) fn rotation(axis: DVec3, degrees: f64) -> DMat3 {
    let axis = (axis / axis.abs().max_element()).normalize();
    let turned = degrees.rem_euclid(360.0);
    let (sin, cos) = if turned == 0.0 {
        (0.0, 1.0)
    } else if turned == 90.0 {
        (1.0, 0.0)
    } else if turned == 180.0 {
        (0.0, -1.0)
    } else if turned == 270.0 {
        (-1.0, 0.0)
    } else {
        turned.to_radians().sin_cos()
    };
    // Rodrigues' formula, one column at a time.
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_is_right_handed_and_exact() {
        let turn = Transform::new(rotation(DVec3::Z * 1e-50, 450.0), DVec3::ZERO).unwrap();
        assert_eq!(turn.point(DVec3::new(2.0, 3.0, 5.0)), DVec3::new(-3.0, 2.0, 5.0));
        assert!(!turn.mirrors());
    }

    #[test]
    fn normals_stay_perpendicular_under_uneven_scaling() {
        let squash = Transform::new(DMat3::from_diagonal(DVec3::new(1e-60, -2.0, 1e60)), DVec3::ONE).unwrap();
        assert!(squash.mirrors());
        let (a, b) = (DVec3::new(1.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 1.0));
        let normal = squash.normal(a.cross(b));
        let along = |v: DVec3| squash.linear * v;
        assert!(normal.dot(along(a)).abs() <= 1e-12 * normal.length() * along(a).length());
        assert!(normal.dot(along(b)).abs() <= 1e-12 * normal.length() * along(b).length());
    }

    #[test]
    fn what_cannot_be_inverted_is_refused() {
        for diagonal in [[0.0, 1.0, 1.0], [f64::NAN, 1.0, 1.0], [f64::INFINITY, 1.0, 1.0]] {
            assert_eq!(Transform::new(DMat3::from_diagonal(DVec3::from_array(diagonal)), DVec3::ZERO), None);
        }
        let flat = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
        assert_eq!(Transform::new(flat, DVec3::ZERO), None);
    }
}
