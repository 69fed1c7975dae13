//! Passes: how the dispatches of a run go through a tile's pixels.
//!
//! The first pass takes the tile's rows, and each one after it the pixels that the one before has left unfinished, packed, until none
//! is left. In a pass a slice is what one dispatch works on. Whatever the slices, every pixel takes the same samples.

use crate::interface::{LIST_ROW, LISTS};
use crate::render::slice::{Place, Slice, WORKGROUP};
use crate::render::tiles::Tile;

/// Fewer pixels than this are not worth another pass: they run to their ends.
const FEW_PIXELS: u32 = 256;

/// Listed pixels in a row of workgroups.
const GROUP_ROW_PIXELS: u32 = LIST_ROW * WORKGROUP[1];

/// A pass over a tile, which hands out its slices one after the other.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Pixels in a row of the slices: the tile's, or 1 where they are listed.
    width: u32,
    /// Whether the pixels are listed, by the pass before; the first one takes rows.
    is_listed: bool,
    /// Rows, or listed pixels, of the pass,
    total: u32,
    /// and how many of these have been handed out.
    taken: u32,
    /// Where the next slice's unfinished pixels go: behind those of the slices before it.
    fills: Place,
}

impl Pass {
    /// The first pass of a run.
    pub fn over(tile: Tile) -> Pass {
        Pass { width: tile.width, is_listed: false, total: tile.height, taken: 0, fills: Place { list: 0, at: 0 } }
    }

    /// Whether its slices are of listed pixels.
    pub fn is_listed(&self) -> bool {
        self.is_listed
    }

    /// The next slice, of about `pixels` pixels and a row at least. It fills whole rows of workgroups where it has more than one: a
    /// driver that deals workgroups out to its threads in equal numbers would leave one of them with half-empty ones.
    pub fn next_slice(&mut self, pixels: u32) -> Option<Slice> {
        if self.taken == self.total {
            return None;
        }
        let first = self.taken;
        let wanted = if self.is_listed {
            (pixels / GROUP_ROW_PIXELS * GROUP_ROW_PIXELS).max(GROUP_ROW_PIXELS)
        } else {
            let rows = pixels / self.width.max(1);
            if rows < WORKGROUP[1] { rows.max(1) } else { rows / WORKGROUP[1] * WORKGROUP[1] }
        };
        let count = wanted.min(self.total - first);
        self.taken += count;
        Some(if self.is_listed { Slice::Listed { first, count } } else { Slice::Rows { first, count } })
    }

    /// Where the unfinished pixels of the last slice go.
    pub fn fills(&self) -> Place {
        self.fills
    }

    /// When the slices leave paths unfinished (`Dispatch::leave_eighths`): where `eighths` says, or never if they are few.
    pub fn leave_eighths(&self, eighths: u32) -> u32 {
        if u64::from(self.total) * u64::from(self.width) < FEW_PIXELS.into() { 0 } else { eighths }
    }

    /// Takes note that the last slice has left `unfinished` pixels.
    pub fn note(&mut self, unfinished: u32) {
        self.fills.at = self.fills.at.saturating_add(unfinished);
    }

    /// Whether every slice was handed out and left nothing.
    pub fn is_last(&self) -> bool {
        self.taken == self.total && self.fills.at == 0
    }

    /// The pass over what this one has left, if it has.
    pub fn next(self) -> Option<Pass> {
        let Place { list, at: count } = self.fills;
        let fills = Place { list: (list + 1) % LISTS, at: 0 };
        (count > 0).then_some(Pass { width: 1, is_listed: true, total: count, taken: 0, fills })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_cover_rows_and_then_what_they_left() {
        let mut pass = Pass::over(Tile { x: 3, y: 5, width: 100, height: 20 });
        assert_eq!(pass.fills(), Place { list: 0, at: 0 });
        assert_eq!(pass.leave_eighths(5), 5);
        assert_eq!(pass.next_slice(850), Some(Slice::Rows { first: 0, count: 8 }));
        pass.note(730);
        assert_eq!(pass.fills(), Place { list: 0, at: 730 });
        assert_eq!(pass.next_slice(5000), Some(Slice::Rows { first: 8, count: 12 }));
        pass.note(170);
        assert_eq!(pass.next_slice(5000), None);

        let mut pass = pass.next().unwrap();
        assert_eq!(pass.fills(), Place { list: 1, at: 0 });
        assert_eq!(pass.next_slice(200), Some(Slice::Listed { first: 0, count: 512 }));
        assert_eq!(pass.next_slice(2000), Some(Slice::Listed { first: 512, count: 388 }));
        pass.note(7);
        assert!(!pass.is_last());

        let mut pass = pass.next().unwrap();
        assert_eq!((pass.fills(), pass.leave_eighths(5)), (Place { list: 0, at: 0 }, 0));
        assert_eq!(pass.next_slice(1), Some(Slice::Listed { first: 0, count: 7 }));
        assert!(pass.is_last());
        assert!(pass.next().is_none());
    }

    #[test]
    fn a_slice_is_a_row_at_least() {
        let mut pass = Pass::over(Tile { x: 0, y: 0, width: 4000, height: 2 });
        assert_eq!(pass.next_slice(0), Some(Slice::Rows { first: 0, count: 1 }));
        assert_eq!(pass.next_slice(u32::MAX), Some(Slice::Rows { first: 1, count: 1 }));
    }
}
