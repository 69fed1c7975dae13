//! The light tree: clusters of lights, so that one is found by what it may contribute to a point.
//!
//! Comes in: the lights' boxes, normals and powers. Goes out: nodes of four clusters as texels, and each light's way from the
//! root, two bits a level. May be assumed: every light is in exactly one leaf; no leaf is deeper than
//! [`LIGHT_TREE_LEVELS`]; a cluster's ball and cone, as the shader reads them, hold its lights. Splits go by the orientation
//! heuristic of Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018).

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::Texel;
use super::light_cone::{Cone, decode_octahedral, encode_octahedral};
use super::triangle::{geometric_normal, with_word};
use crate::bvh::Aabb;
use crate::interface::{LIGHT_NODE_TEXELS, LIGHT_TREE_CHILDREN, LIGHT_TREE_LEVELS};
use crate::scene::Triangle;

/// Parts of a range along an axis between which it may be split.
const BUCKETS: usize = 12;

/// Lights of a range that a split looks at, at most: evenly spaced ones say enough of a large one.
const LOOKED_AT: usize = 1024;

/// Least share of all power that a cluster is given, so that the shader's quotients stay clear of denormals.
const LEAST_POWER: f64 = 1e-20;

/// What the tree has to know of a light, or of several together.
#[derive(Clone, Copy, Debug)]
pub struct Emitter {
    bounds: Aabb,
    cone: Cone,
    power: f64,
}

impl Emitter {
    /// An emissive triangle; `power` in any unit, the same for all.
    pub fn new(triangle: &Triangle, power: f64) -> Emitter {
        Emitter { bounds: Aabb::of_triangle(&triangle.positions), cone: Cone::of(geometric_normal(triangle)), power }
    }

    fn union(self, other: Emitter) -> Emitter {
        Emitter {
            bounds: self.bounds.union(other.bounds),
            cone: self.cone.union(other.cone),
            power: self.power + other.power,
        }
    }

    /// How much light it sends how widely: what a split tries to keep small.
    fn cost(self) -> f64 {
        self.power * self.cone.measure() * f64::from(self.bounds.half_area())
    }
}

/// A cluster: its lights together, where they are, and how many.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    all: Emitter,
    child: u32,
    count: u32,
}

/// A tree over lights.
#[derive(Debug, Default)]
pub struct LightTree {
    nodes: Vec<Vec<Cluster>>,
    /// Power of all lights.
    power: f64,
    /// For each light its way: the slots that lead to it, two bits a level, the root's lowest.
    pub trails: Vec<u32>,
    /// Levels of the deepest leaf.
    pub levels: u32,
}

impl LightTree {
    /// Builds the tree over at least one light, at most 2^28.
    pub fn build(emitters: &[Emitter]) -> LightTree {
        let mut tree = LightTree { trails: vec![0; emitters.len()], ..LightTree::default() };
        let mut order: Vec<u32> = (0..emitters.len() as u32).collect();
        tree.power = tree.node(emitters, &mut order, 0, 0).power;
        tree
    }

    /// The node over the lights `range`, `level` nodes below the root; returns them together.
    fn node(&mut self, emitters: &[Emitter], range: &mut [u32], level: u32, trail: u32) -> Emitter {
        self.levels = self.levels.max(level + 1);
        let index = self.nodes.len();
        self.nodes.push(Vec::new());
        // A subtree of k binary levels has room for 2^k lights; each of the four clusters has two levels fewer.
        let below = 2 * (LIGHT_TREE_LEVELS - level);
        let halves = halve(emitters, range, below - 1);
        let mut parts: Vec<&mut [u32]> = Vec::with_capacity(LIGHT_TREE_CHILDREN as usize);
        for half in halves.into_iter().filter(|half| !half.is_empty()) {
            parts.extend(halve(emitters, half, below - 2).into_iter().filter(|part| !part.is_empty()));
        }
        let mut clusters = Vec::with_capacity(parts.len());
        for (slot, part) in (0..).zip(parts) {
            let trail = trail | slot << (2 * level);
            let count = part.len() as u32;
            clusters.push(match *part {
                [light] => {
                    self.trails[light as usize] = trail;
                    Cluster { all: emitters[light as usize], child: light, count }
                }
                _ => {
                    let child = self.nodes.len() as u32;
                    Cluster { all: self.node(emitters, part, level + 1, trail), child, count }
                }
            });
        }
        let together = clusters.iter().map(|cluster| cluster.all).reduce(Emitter::union);
        self.nodes[index] = clusters;
        // A node has at least one light, as every range that is handed down.
        together.unwrap_or(Emitter { bounds: Aabb::EMPTY, cone: Cone::of(DVec3::Z), power: 0.0 })
    }

    /// The nodes' records, the root first.
    pub fn texels(&self) -> Vec<Texel> {
        let mut texels = Vec::with_capacity(self.nodes.len() * LIGHT_NODE_TEXELS as usize);
        for node in &self.nodes {
            texels.extend(node.iter().flat_map(|cluster| cluster_texels(cluster, self.power)));
            texels.resize(texels.len().next_multiple_of(LIGHT_NODE_TEXELS as usize), [0; 4]);
        }
        texels
    }
}

/// A cluster's two texels; `power` is that of all lights.
fn cluster_texels(cluster: &Cluster, power: f64) -> [Texel; 2] {
    let Emitter { bounds, cone, power: own } = cluster.all;
    let (low, high) = (bounds.low.as_dvec3(), bounds.high.as_dvec3());
    let centre = ((low + high) / 2.0).as_vec3();
    // The upper 16 bits of a float, rounded up, and its square clear of denormals and infinity as far as matters.
    let reach = (high - centre.as_dvec3()).max(centre.as_dvec3() - low).length();
    let radius = ((reach * (1.0 + 1e-6)).clamp(1e-30, 1e30) as f32).to_bits() & 0xffff_0000;
    let axis = encode_octahedral(cone.axis);
    // The word's axis is not quite the cone's: what it misses widens the cone. Its cosine is rounded down.
    let angle = (cone.angle + cone.axis.angle_between(decode_octahedral(axis)) + 1e-7).min(PI);
    let cosine = ((angle.cos() + 1.0) * 32_767.5).floor().clamp(0.0, 65_535.0) as u32;
    let share = if power > 0.0 { (own / power).clamp(LEAST_POWER, 1.0) } else { 1.0 };
    [with_word(centre, (radius + 0x1_0000) | cosine), [axis, (share as f32).to_bits(), cluster.child, cluster.count]]
}

/// Splits a range in two, neither larger than 2^`levels`; one light is left whole, beside nothing. The order of the lights within
/// a part means nothing, but is the same every time.
fn halve<'a>(emitters: &[Emitter], range: &'a mut [u32], levels: u32) -> [&'a mut [u32]; 2] {
    if range.len() < 2 {
        let (whole, nothing) = range.split_at_mut(range.len());
        return [whole, nothing];
    }
    let centre = |light: u32| emitters[light as usize].bounds.centre();
    let centres = range.iter().fold(Aabb::EMPTY, |bounds, &light| bounds.including(centre(light)));
    let most = 1usize << levels;
    let middle = best_split(emitters, range, &centres).and_then(|(axis, bucket)| {
        let first = partition(range, |light| bucket_of(centre(light), &centres, axis) <= bucket);
        (first.max(range.len() - first) <= most).then_some(first)
    });
    let middle = middle.unwrap_or_else(|| {
        // Nothing tells them apart, or the tree would become too deep: the median.
        let extent = centres.extent();
        let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
        let middle = range.len() / 2;
        range.select_nth_unstable_by(middle, |&a, &b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(&b)));
        middle
    });
    let (first, second) = range.split_at_mut(middle);
    [first, second]
}

/// The axis and the last bucket of the first half of the cheapest split; none where all centres coincide.
fn best_split(emitters: &[Emitter], range: &[u32], centres: &Aabb) -> Option<(usize, usize)> {
    let extent = centres.extent();
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut buckets: [Option<Emitter>; BUCKETS] = [None; BUCKETS];
        for &light in range.iter().step_by(range.len().div_ceil(LOOKED_AT)) {
            let emitter = emitters[light as usize];
            let bucket = &mut buckets[bucket_of(emitter.bounds.centre(), centres, axis)];
            *bucket = together(*bucket, Some(emitter));
        }
        let mut after: [Option<Emitter>; BUCKETS + 1] = [None; BUCKETS + 1];
        for bucket in (0..BUCKETS).rev() {
            after[bucket] = together(buckets[bucket], after[bucket + 1]);
        }
        // Thin slabs are poor clusters: a split across a short axis counts as dearer.
        let thin = f64::from(extent.max_element() / extent[axis]);
        let mut before = None;
        for bucket in 0..BUCKETS - 1 {
            before = together(before, buckets[bucket]);
            if let (Some(first), Some(second)) = (before, after[bucket + 1]) {
                let cost = thin * (first.cost() + second.cost());
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, bucket));
                }
            }
        }
    }
    best.map(|(_, axis, bucket)| (axis, bucket))
}

fn together(a: Option<Emitter>, b: Option<Emitter>) -> Option<Emitter> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union(b)),
        (one, None) | (None, one) => one,
    }
}

fn bucket_of(centre: Vec3, centres: &Aabb, axis: usize) -> usize {
    let place = (centre[axis] - centres.low[axis]) / (centres.high[axis] - centres.low[axis]);
    ((place * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

/// Moves the lights of which `first` holds to the front, in their order, and the others behind them; returns how many they are.
fn partition(range: &mut [u32], first: impl Fn(u32) -> bool) -> usize {
    let (front, back): (Vec<u32>, Vec<u32>) = range.iter().partition(|&&light| first(light));
    range[..front.len()].copy_from_slice(&front);
    range[front.len()..].copy_from_slice(&back);
    front.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::NO_INDEX;

    fn triangle(corner: Vec3, size: f32, turn: u32) -> Triangle {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
        let (a, b) = (axes[turn as usize % 6], axes[(turn as usize + 1) % 6]);
        Triangle { positions: [corner, corner + a * size, corner + b * size], material: 0, corners: NO_INDEX }
    }

    fn scattered(count: u32) -> Vec<Triangle> {
        let place = |i: u32, step: u32| (i.wrapping_mul(step) >> 8) as f32 / (1 << 24) as f32 - 0.5;
        let corner = |i| Vec3::new(place(i, 2_654_435_761), place(i, 1_779_033_703), place(i, 3_144_134_277));
        (0..count).map(|i| triangle(corner(i), 0.01, i)).collect()
    }

    /// Follows each light's trail through the texels, and holds it against every ball and cone on the way.
    fn check(triangles: &[Triangle], powers: impl Fn(usize) -> f64) -> LightTree {
        let emitters: Vec<_> = triangles.iter().enumerate().map(|(i, t)| Emitter::new(t, powers(i))).collect();
        let tree = LightTree::build(&emitters);
        let texels = tree.texels();
        assert_eq!(tree.trails.len(), triangles.len());
        for (light, (&whole, triangle)) in tree.trails.iter().zip(triangles).enumerate() {
            let (mut node, mut count, mut trail, mut levels) = (0, 2, whole, 0);
            while count > 1 {
                let first = (LIGHT_NODE_TEXELS * node + 2 * (trail & 3)) as usize;
                let [[x, y, z, spread], [axis, power, child, lights]] = [texels[first], texels[first + 1]];
                let centre = Vec3::from_array([x, y, z].map(f32::from_bits)).as_dvec3();
                let radius = f64::from(f32::from_bits(spread & 0xffff_0000));
                let cosine = f64::from(spread & 0xffff) / 32_767.5 - 1.0;
                assert!(triangle.positions.iter().all(|v| v.as_dvec3().distance(centre) <= radius), "ball of {light}");
                let normal = geometric_normal(triangle);
                assert!(normal.dot(decode_octahedral(axis)) >= cosine, "cone of {light}");
                assert!(f32::from_bits(power) > 0.0 && lights >= 1);
                (node, count, trail, levels) = (child, lights, trail >> 2, levels + 1);
            }
            assert_eq!((node as usize, trail), (light, 0), "the end of trail {whole:x}");
            assert!(levels <= tree.levels && tree.levels <= LIGHT_TREE_LEVELS);
        }
        tree
    }

    #[test]
    fn every_trail_leads_to_its_light() {
        for count in [1, 2, 3, 4, 5, 17, 200, 20_000] {
            let tree = check(&scattered(count), |i| 10f64.powi(i as i32 % 41 - 20));
            println!("{count} lights: {} levels", tree.levels);
        }
    }

    #[test]
    fn no_arrangement_makes_it_deep() {
        // All in one place, so that nothing tells them apart; each half as far from the first as the one before; no power at all.
        check(&vec![triangle(Vec3::ZERO, 0.1, 0); 3000], |_| 1.0);
        let spiral: Vec<_> =
            (0..120).map(|i| triangle(Vec3::X * 0.5f32.powi(i), 0.5f32.powi(i + 2), i as u32)).collect();
        let tree = check(&spiral, |i| 0.1f64.powi(i as i32));
        assert!(tree.levels > 4, "the arrangement is one that tempts: {} levels", tree.levels);
        check(&scattered(50), |_| 0.0);
    }
}
