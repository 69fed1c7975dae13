//! What one dispatch works on.
//!
//! Comes in: rows of a tile, or places in a list of pixels. Goes out: what a pass hands out and a kernel is told.

/// Workgroup of 8 x 8 pixels: neighbours trace alike, and no shape was faster on lavapipe.
pub const WORKGROUP: [u32; 2] = [8, 8];

/// Pixels of a dispatch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slice {
    /// The run begins for `count` rows of the tile from `first` on.
    Rows {
        /// First row.
        first: u32,
        /// Number of rows.
        count: u32,
    },
    /// It goes on for `count` pixels of the list that the last pass has filled, wherever they are in the tile.
    Listed {
        /// Place of the first of them in the list.
        first: u32,
        /// How many.
        count: u32,
    },
}

/// A place in one of the two lists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Which list.
    pub list: u32,
    /// Pixels before it.
    pub at: u32,
}
