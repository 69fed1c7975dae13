//! Sizes that trade memory, speed and responsiveness.
//!
//! Comes in: choices of a test or a study; a user's render has the defaults. Goes out: the same, checked where they
//! enter the renderer.

use crate::error::{Error, Result};
use crate::interface::{BLOCK_SAMPLES, EFFECTS, MAX_STEP_BUDGET, MIN_STEP_BUDGET};
use crate::render::guard::Guard;
use crate::settings::{Buffers, MAX_SIDE, in_range};

/// Sizes that no picture depends on: they trade memory, speed and responsiveness. Tests pin them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tuning {
    /// Tile size in pixels, 1 to 16384 a side, and no more tiles than [`MOST_TILES`]; otherwise the largest that fits.
    pub tile: Option<[u32; 2]>,
    /// Step budget of an invocation in a dispatch, 64 to 8191, less on a CPU whose vectors have more than 8 lanes;
    /// otherwise by the clock.
    pub budget: Option<u32>,
    /// Samples of a run, 1 to 16; otherwise by the clock.
    pub run_samples: Option<u32>,
    /// Lanes refill when fewer than this many eighths of them still trace, 0 to 8.
    pub refill_eighths: Option<u32>,
    /// Pixels of a submit, at least 1 (render/pass.rs rounds them); otherwise by the clock.
    pub slice_pixels: Option<u32>,
    /// Paths are left for the next pass when fewer than this many eighths of the lanes have samples left, 0 to 8.
    pub leave_eighths: Option<u32>,
    /// Triangles tested between two node visits, 1 or 2, or 0 for all of them; otherwise by the tree.
    pub tests_a_visit: Option<u32>,
    /// How path states are read, where they fit; otherwise as the settings say.
    pub path_buffers: Option<Buffers>,
    /// An effect (`interface::EFFECT_*`) to leave out though the scene calls for it: the control of the effects test.
    pub without_effect: Option<u32>,
    /// An effect to have though nothing calls for it: what its code alone costs.
    pub with_effect: Option<u32>,
    /// The module that leaves NaN to the driver, though the device can be asked to keep it.
    pub nan_by_driver: bool,
    /// A guard to leave out, to show what it is for. Unlike the sizes above, it changes pictures.
    pub without_guard: Option<Guard>,
}

/// Most tiles of a picture: each costs a dispatch a run at least, and the list of them is kept.
pub const MOST_TILES: u64 = 1 << 20;

impl Tuning {
    /// Refuses what is out of the range that its field states; `region` is the width and height of what is rendered.
    pub fn check(&self, region: [u32; 2]) -> Result<()> {
        for (name, value, least, most) in [
            ("tile width", self.tile.map(|tile| tile[0]), 1, MAX_SIDE),
            ("tile height", self.tile.map(|tile| tile[1]), 1, MAX_SIDE),
            ("budget", self.budget, MIN_STEP_BUDGET, MAX_STEP_BUDGET),
            ("run_samples", self.run_samples, 1, BLOCK_SAMPLES),
            ("refill_eighths", self.refill_eighths, 0, 8),
            ("slice_pixels", self.slice_pixels, 1, u32::MAX),
            ("leave_eighths", self.leave_eighths, 0, 8),
            ("tests_a_visit", self.tests_a_visit, 0, 2),
            ("without_effect", self.without_effect, 0, EFFECTS - 1),
            ("with_effect", self.with_effect, 0, EFFECTS - 1),
        ] {
            if let Some(value) = value {
                in_range(name, value, least, most)?;
            }
        }
        let [width, height] = self.tile.unwrap_or([MAX_SIDE; 2]);
        let tiles = u64::from(region[0].div_ceil(width)) * u64::from(region[1].div_ceil(height));
        match tiles {
            0..=MOST_TILES => Ok(()),
            _ => Err(Error::Usage(format!(
                "tile {width}x{height} cuts {}x{} pixels into {tiles} tiles, {MOST_TILES} at most are allowed",
                region[0], region[1]
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_range_has_both_its_ends_and_nothing_beyond() {
        type Set = fn(&mut Tuning, u32);
        let fields: [(&str, Set, u32, u32); 10] = [
            ("tile width", |tuning, value| tuning.tile = Some([value, 64]), 1, 16384),
            ("tile height", |tuning, value| tuning.tile = Some([64, value]), 1, 16384),
            ("budget", |tuning, value| tuning.budget = Some(value), 64, 8191),
            ("run_samples", |tuning, value| tuning.run_samples = Some(value), 1, 16),
            ("refill_eighths", |tuning, value| tuning.refill_eighths = Some(value), 0, 8),
            ("slice_pixels", |tuning, value| tuning.slice_pixels = Some(value), 1, u32::MAX),
            ("leave_eighths", |tuning, value| tuning.leave_eighths = Some(value), 0, 8),
            ("tests_a_visit", |tuning, value| tuning.tests_a_visit = Some(value), 0, 2),
            ("without_effect", |tuning, value| tuning.without_effect = Some(value), 0, EFFECTS - 1),
            ("with_effect", |tuning, value| tuning.with_effect = Some(value), 0, EFFECTS - 1),
        ];
        for (name, set, least, most) in fields {
            let checked = |value: u32| {
                let mut tuning = Tuning::default();
                set(&mut tuning, value);
                tuning.check([64, 64])
            };
            assert!(checked(least).is_ok() && checked(most).is_ok(), "{name}");
            for value in [least.checked_sub(1), most.checked_add(1), (most < u32::MAX).then_some(u32::MAX)] {
                let Some(value) = value else { continue };
                let error = checked(value).unwrap_err();
                let said = error.to_string();
                assert!(matches!(error, Error::Usage(_)), "{error:?}");
                assert!(
                    said.contains(name) && said.contains(&value.to_string()) && said.contains(&most.to_string()),
                    "{said}"
                );
            }
        }
    }

    #[test]
    fn more_tiles_than_a_list_should_hold_are_refused() {
        let tuning = Tuning { tile: Some([1, 1]), ..Tuning::default() };
        assert!(tuning.check([1024, 1024]).is_ok());
        let error = tuning.check([1024, 1025]).unwrap_err().to_string();
        assert!(error.contains("1049600 tiles, 1048576 at most"), "{error}");
    }
}
