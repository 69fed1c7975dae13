//! The catalogue: one file per group, and beside them the cases that fill a file of their own.

mod a_floats;
mod b_triangles;
mod c_tree;
mod d_origins;
mod directions;
mod e_lights;
mod f_bsdfs;
mod g_accumulation;
mod h_scenes;
mod light_trees;
mod lobes;
mod microfacets;
mod roulette;
mod shadow_rays;

use super::Group;

/// The groups, in order.
pub const GROUPS: [Group; 8] = [
    Group { letter: 'A', name: "floats and shader language", cases: a_floats::CASES },
    Group { letter: 'B', name: "triangles", cases: b_triangles::CASES },
    Group { letter: 'C', name: "the tree", cases: c_tree::CASES },
    Group { letter: 'D', name: "ray origins", cases: d_origins::CASES },
    Group { letter: 'E', name: "light sampling", cases: e_lights::CASES },
    Group { letter: 'F', name: "scattering", cases: f_bsdfs::CASES },
    Group { letter: 'G', name: "sums, random numbers, transport", cases: g_accumulation::CASES },
    Group { letter: 'H', name: "whole scenes", cases: h_scenes::CASES },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogue_counts_from_1_to_80() {
        let numbers: Vec<u8> = GROUPS.iter().flat_map(|group| group.cases).map(|case| case.number).collect();
        assert_eq!(numbers, (1..=80).collect::<Vec<u8>>());
    }
}
