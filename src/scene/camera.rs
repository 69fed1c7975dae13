//! The pinhole camera and its basis.

use glam::DVec3;

/// A pinhole camera in scaled scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the pinhole.
    pub origin: DVec3,
    /// Point that the picture's centre looks at; differs from `origin`.
    pub target: DVec3,
    /// Direction that points up in the picture; not parallel to the view.
    pub up: DVec3,
    /// Vertical field of view in degrees, inside (0, 180).
    pub vfov: f64,
}

/// Vectors that take a film point in pixels to a direction: see `interface::CAMERA_TEXELS`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraBasis {
    /// Unit vector towards the target.
    pub forward: DVec3,
    /// Direction change of one pixel to the right.
    pub right: DVec3,
    /// Direction change of one pixel down.
    pub down: DVec3,
}

impl Camera {
    /// The basis for a picture of `height` pixels; pixels are square.
    pub fn basis(&self, height: u32) -> CameraBasis {
        let forward = (self.target - self.origin).normalize();
        let right = forward.cross(self.up).normalize();
        let down = forward.cross(right);
        let pixel = 2.0 * (self.vfov.to_radians() / 2.0).tan() / f64::from(height);
        CameraBasis { forward, right: right * pixel, down: down * pixel }
    }
}
