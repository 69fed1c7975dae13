//! How many statements of each kind a text holds, counted before anything is made of them: what it will ask for.
//!
//! Comes in: the text of an OBJ or MTL file. Goes out: a [`Census`], and from it bytes of memory. The constants are
//! sizes of what the stage and `tobj` keep of a statement, with the room that growing lists waste (up to as much
//! again).

use super::obj_mesh::{ObjCorners, ObjTriangle};

/// Statements of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Census {
    /// `v` statements.
    pub positions: usize,
    /// `vt` statements.
    pub uvs: usize,
    /// `vn` statements.
    pub normals: usize,
    /// `f` statements.
    pub faces: usize,
    /// Corners of `f` statements.
    pub corners: usize,
    /// `usemtl` and `newmtl` statements.
    pub materials: usize,
    /// Words of `mtllib` statements and of those that may name an image.
    pub names: usize,
}

impl Census {
    /// Counts the statements of `text`.
    pub(super) fn of(text: &str) -> Census {
        let mut census = Census::default();
        let blank = |byte: &u8| byte.is_ascii_whitespace();
        for line in text.as_bytes().split(|&byte| byte == b'\n') {
            let line = line.trim_ascii_start();
            let length = line.iter().position(blank).unwrap_or(line.len());
            let words = || line[length..].split(blank).filter(|word| !word.is_empty()).count();
            match &line[..length] {
                b"v" => census.positions += 1,
                b"vt" => census.uvs += 1,
                b"vn" => census.normals += 1,
                b"f" | b"fo" => {
                    census.faces += 1;
                    census.corners += words();
                }
                b"usemtl" | b"newmtl" => census.materials += 1,
                b"mtllib" | b"norm" | b"bump" | b"disp" | b"decal" | b"refl" => census.names += words(),
                keyword if keyword.starts_with(b"map_") => census.names += words(),
                _ => {}
            }
        }
        census
    }

    /// Triangles that the faces are split into.
    pub(super) fn triangles(&self) -> usize {
        self.corners.saturating_sub(self.faces.saturating_mul(2))
    }

    /// Bytes that reading the text of an OBJ file takes beside the text and its canonical form.
    ///
    /// The scan keeps 24 a position. `tobj` keeps 48 a position or normal and 32 a texture coordinate; 208 a face and
    /// 24 a corner of its own, and of each corner at most a position, an index and an entry of a map (24 + 8 + 40,
    /// twice where the list grows), as much again for normals and texture coordinates where there are any; 1280 a
    /// change of material, for its name, mesh and map.
    pub(super) fn obj_bytes(&self) -> u64 {
        // Without normals, texture coordinates are left out; with them, corners that have none get one.
        let lists = if self.normals > 0 { 3 } else { 1 };
        // A corner that shares its position with others adds an index alone.
        let points =
            self.corners.min(self.positions.max(self.uvs).max(self.normals).saturating_add(3 * self.materials));
        let smooth = if self.normals > 0 { size_of::<ObjCorners>() } else { 0 };
        sum(&[
            (self.positions, 24 + 48),
            (self.normals, 48),
            (self.uvs, 32),
            (self.faces, 208),
            (self.corners, 24 + 16 * lists),
            (points, 112 * lists),
            (self.triangles(), size_of::<ObjTriangle>() + smooth),
            (self.materials, 1280),
            (self.names, NAME_BYTES),
        ])
    }

    /// Bytes that reading the text of an MTL file takes beside the text: 1024 a material (its recipe while it is read
    /// and after, its name twice, entries of two maps, what is wrong with it).
    pub(super) fn mtl_bytes(&self) -> u64 {
        sum(&[(self.materials, 1024), (self.names, NAME_BYTES)])
    }
}

/// A name of a file, with its folder, in a list.
const NAME_BYTES: usize = 256;

fn sum(terms: &[(usize, usize)]) -> u64 {
    terms.iter().map(|&(count, bytes)| (count as u64).saturating_mul(bytes as u64)).fold(0, u64::saturating_add)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_counted_as_the_scans_read_them() {
        let census = Census::of(
            "v 1 2 3\r\n\tv 1 2 3\nvt 1 2\nvn 1 2 3\nf 1 2 3 4\nf  1/2 2 3 \nvertex\nusemtl a b\nmtllib a b\n",
        );
        let expected = Census { positions: 2, uvs: 1, normals: 1, faces: 2, corners: 7, materials: 1, names: 2 };
        assert_eq!((census, census.triangles()), (expected, 3));
        assert_eq!(Census::of("newmtl a\nmap_Kd -s 1 a.png\nnewmtl b").mtl_bytes(), 2 * 1024 + 3 * 256);
    }
}
