//! Which child of a wide node goes to which slot.
//!
//! Comes in: the centres of a node's children and of the node. Goes out: a slot for each child, such that taking slots
//! in falling order of `slot ^ order` visits children roughly front to back, where `order` has the bit of an axis set
//! for a ray that goes up along it. May be assumed: bit 2 of a slot stands for x, bit 1 for y, bit 0 for z; a set bit
//! says that the child lies on the upper side. Any assignment is correct; this one only saves time.

use glam::Vec3;

use crate::interface::WIDE_CHILDREN;

const WIDTH: usize = WIDE_CHILDREN as usize;

/// Slots of the children: greedily, the pair of child and free slot that lies farthest along the slot's diagonal goes
/// first (Ylitie, Karras and Laine, HPG 2017, section 3.2, use an auction for the same costs).
pub(super) fn assign(centres: &[Vec3], node_centre: Vec3) -> [usize; WIDTH] {
    let mut gains = [[f32::NEG_INFINITY; WIDTH]; WIDTH];
    for (gain, &centre) in gains.iter_mut().zip(centres) {
        let offset = centre - node_centre;
        let (x, y, z) = ([-offset.x, offset.x], [-offset.y, offset.y], [-offset.z, offset.z]);
        *gain = std::array::from_fn(|slot| x[slot >> 2] + y[slot >> 1 & 1] + z[slot & 1]);
    }
    let mut slots = [0; WIDTH];
    let (mut open, mut free) = ((1u32 << centres.len().min(WIDTH)) - 1, (1u32 << WIDTH) - 1);
    while open != 0 {
        let first = (open.trailing_zeros() as usize, free.trailing_zeros() as usize);
        let mut best = (gains[first.0][first.1], first.0, first.1);
        for child in bits(open) {
            for slot in bits(free) {
                if gains[child][slot] > best.0 {
                    best = (gains[child][slot], child, slot);
                }
            }
        }
        slots[best.1] = best.2;
        open &= !(1 << best.1);
        free &= !(1 << best.2);
    }
    slots
}

/// Positions of the set bits, rising.
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < 32).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_take_their_own_slots() {
        let centres: Vec<Vec3> = (0..8)
            .rev()
            .map(|slot: i32| Vec3::new((slot >> 2) as f32, (slot >> 1 & 1) as f32, (slot & 1) as f32))
            .collect();
        assert_eq!(assign(&centres, Vec3::splat(0.5)), [7, 6, 5, 4, 3, 2, 1, 0]);
    }

    #[test]
    fn slots_are_distinct_for_equal_and_undefined_centres() {
        for centre in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            for count in 0..=8 {
                let slots = assign(&vec![centre; count], Vec3::ZERO);
                let taken = slots[..count].iter().fold(0u32, |mask, slot| mask | 1 << slot);
                assert_eq!(taken.count_ones() as usize, count);
            }
        }
    }
}
