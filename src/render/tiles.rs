//! Tiles: the part of the picture that is on the device at once.
//!
//! Comes in: the region to render and what the device can hold. Goes out: rectangles that cover the region. A tile is the
//! whole region where its path states fit the memory budget and every buffer fits the device's limits; a picture does not
//! depend on how it is cut.

use crate::error::{Error, Result};
use crate::interface::{LISTS, PATH_TEXELS, STACK_ENTRIES_A_TEXEL};

/// A rectangle of pixels of the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Width, at least 1.
    pub width: u32,
    /// Height, at least 1.
    pub height: u32,
}

impl Tile {
    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// Bytes of a pixel's path state with a traversal stack of `stack_entries`.
pub fn path_bytes(stack_entries: u32) -> u64 {
    16 * (u64::from(PATH_TEXELS) + u64::from(stack_entries.div_ceil(STACK_ENTRIES_A_TEXEL)))
}

/// Bytes of a pixel's places in the lists of pixels.
pub const LIST_BYTES: u64 = 4 * LISTS as u64;

/// Bytes of a pixel's open sum.
pub const SUM_BYTES: u64 = 16;

/// The largest tile of a `width` x `height` region whose path states take at most `buffer_bytes` in one buffer and, with lists
/// and open sums, at most `memory_bytes` in all. Rows stay whole where one fits.
pub fn largest_tile(
    width: u32,
    height: u32,
    stack_entries: u32,
    buffer_bytes: u64,
    memory_bytes: u64,
) -> Result<[u32; 2]> {
    if width == 0 || height == 0 {
        return Err(Error::Internal(format!("a tile of a region of {width}x{height} pixels")));
    }
    let path = path_bytes(stack_entries);
    let all = path + LIST_BYTES + SUM_BYTES;
    let pixels = (buffer_bytes / path).min(memory_bytes / all);
    if pixels == 0 {
        return Err(Error::Limit {
            what: "memory for the path state of one pixel".into(),
            need: format!("{all} bytes"),
            have: format!("{} bytes", buffer_bytes.min(memory_bytes)),
        });
    }
    if pixels < u64::from(width) {
        return Ok([pixels as u32, 1]);
    }
    let rows = (pixels / u64::from(width)).min(u64::from(height)) as u32;
    // Bands of equal height rather than a sliver at the end.
    Ok([width, height.div_ceil(height.div_ceil(rows))])
}

/// The tiles of `region` (`[x, y, width, height]`), row by row, none larger than `size`, which is not empty.
pub fn tiles(region: [u32; 4], size: [u32; 2]) -> Result<Vec<Tile>> {
    let [x, y, width, height] = region;
    if size.contains(&0) || x.checked_add(width).is_none() || y.checked_add(height).is_none() {
        return Err(Error::Internal(format!("tiles of {size:?} pixels in {region:?}")));
    }
    let mut tiles = Vec::new();
    for top in (0..height).step_by(size[1] as usize) {
        for left in (0..width).step_by(size[0] as usize) {
            tiles.push(Tile {
                x: x + left,
                y: y + top,
                width: size[0].min(width - left),
                height: size[1].min(height - top),
            });
        }
    }
    Ok(tiles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_region_once() {
        let region = [3, 5, 17, 11];
        for size in [[17, 11], [4, 3], [17, 2], [1, 1], [5, 11]] {
            let mut seen = vec![0; 17 * 11];
            for tile in tiles(region, size).unwrap() {
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        seen[((y - 5) * 17 + (x - 3)) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&count| count == 1), "{size:?}");
        }
    }

    #[test]
    fn what_cannot_be_cut_is_refused() {
        for (region, size) in [
            ([0, 0, 4, 4], [0, 1]),
            ([0, 0, 4, 4], [1, 0]),
            ([u32::MAX, 0, 1, 1], [1, 1]),
            ([0, 1, 1, u32::MAX], [1, 1]),
        ] {
            assert!(tiles(region, size).is_err(), "{region:?} {size:?}");
        }
        for [width, height] in [[0, 1], [1, 0]] {
            assert!(largest_tile(width, height, 4, u64::MAX, u64::MAX).is_err(), "{width} {height}");
        }
        assert_eq!(largest_tile(1, 1, u32::MAX, u64::MAX, u64::MAX).unwrap(), [1, 1]);
    }

    #[test]
    fn a_tile_fits_both_limits() {
        let path = path_bytes(4);
        assert_eq!(largest_tile(100, 100, 4, path * 10_000, u64::MAX).unwrap(), [100, 100]);
        assert_eq!(largest_tile(100, 100, 4, path * 5_000, u64::MAX).unwrap(), [100, 50]);
        assert_eq!(largest_tile(100, 100, 4, path * 60, u64::MAX).unwrap(), [60, 1]);
        assert!(largest_tile(100, 100, 4, path - 1, u64::MAX).is_err());
        let all = path + LIST_BYTES + SUM_BYTES;
        assert_eq!(largest_tile(100, 100, 4, u64::MAX, all * 5_000).unwrap(), [100, 50]);
        assert_eq!(
            largest_tile(100, 100, 4, u64::MAX, all * 5_000 - 1).unwrap(),
            [100, 34],
            "three bands of 49 rows or less"
        );
        assert!(largest_tile(100, 100, 4, u64::MAX, all - 1).is_err());
    }
}
