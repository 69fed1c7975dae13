//! Light records: the emissive triangles, and the probability with which each is chosen.
//!
//! Comes in: the scene and its leaf order. Goes out: one record a light, in order of rising `cdf_end`, and for each triangle
//! the density with which a point on it is chosen. Probabilities are whole numbers of 2^-32 that add up to 1 exactly, and the density stored with a
//! light is the one that these whole numbers give: what is drawn and what is divided by cannot differ.

use super::Texel;
use super::light_tree::{Emitter, LightTree};
use super::triangle::{area, geometric_normal, with_word};
use crate::error::{Error, Result};
use crate::interface::LIGHT_TEXELS;
use crate::scene::Scene;
use crate::settings::LightPick;

/// Part of the probability that is spread over the lights evenly, so that a light too faint for its share of the power is
/// found all the same: a scene may hold lights whose powers differ by 1e20.
const EVEN_SHARE: f64 = 0.05;

/// Lights of a scene.
#[derive(Debug, Default)]
pub struct Lights {
    /// One record a light.
    pub texels: Vec<Texel>,
    /// For each triangle in file order the density per unit area of light sampling on it; 0 where it does not emit.
    pub pdf_area: Vec<f32>,
    /// For each triangle in file order its way through the light tree; 0 where there is none.
    pub trails: Vec<u32>,
    /// Nodes of the light tree; empty where lights are chosen from a list.
    pub nodes: Vec<Texel>,
    /// Number of lights.
    pub count: u32,
}

/// Builds the lights. `order` is the leaf order: position `i` holds the triangle with id `order[i]`.
///
/// Fails with [`Error::Limit`] where there are more than 2^31 lights: each must get at least one of the 2^32 words.
pub fn build_lights(scene: &Scene, order: &[u32], pick: LightPick) -> Result<Lights> {
    let (mut densities, mut trails) = (vec![0.0; scene.triangles.len()], vec![0; scene.triangles.len()]);
    // Lights in file order, with their leaf position, area and weight.
    let mut lights: Vec<(u32, u32, f64, f64)> = Vec::new();
    for (position, &id) in order.iter().enumerate() {
        let triangle = &scene.triangles[id as usize];
        let material = &scene.materials[triangle.material as usize];
        let area = area(triangle);
        if material.emits() && area > 0.0 {
            let weight = match pick {
                LightPick::Power | LightPick::Tree => area * luminance(material.emission),
                LightPick::Area => area,
            };
            lights.push((id, position as u32, area, weight));
        }
    }
    lights.sort_unstable_by_key(|light| light.0);
    if lights.len() > 1 << 31 {
        return Err(Error::Limit {
            what: "emissive triangles".into(),
            need: lights.len().to_string(),
            have: (1u64 << 31).to_string(),
        });
    }
    let weights: Vec<f64> = lights.iter().map(|light| light.3).collect();
    let even_share = if pick == LightPick::Area { 0.0 } else { EVEN_SHARE };
    let ends = cumulative_words(&weights, even_share);
    let mut texels = Vec::with_capacity(lights.len() * LIGHT_TEXELS as usize);
    let mut begin = 0u64;
    for (&(id, position, area, _), &end) in lights.iter().zip(&ends) {
        let probability = (end - begin) as f64 / 4_294_967_296.0;
        let share = [begin as u32, (1.0 / (end - begin) as f32).to_bits()];
        begin = end;
        let triangle = &scene.triangles[id as usize];
        let pdf_area = (if pick == LightPick::Tree { 1.0 / area } else { probability / area }) as f32;
        densities[id as usize] = pdf_area;
        let [v0, v1, v2] = triangle.positions;
        texels.extend([
            with_word(v0, (end - 1) as u32),
            with_word(v1, position),
            with_word(v2, pdf_area.to_bits()),
            with_word(geometric_normal(triangle).as_vec3(), share[0]),
            with_word(scene.materials[triangle.material as usize].emission.into(), share[1]),
        ]);
    }
    let mut nodes = Vec::new();
    if pick == LightPick::Tree && !lights.is_empty() {
        let emitter = |&(id, _, _, power): &(u32, u32, f64, f64)| Emitter::new(&scene.triangles[id as usize], power);
        let tree = LightTree::build(&lights.iter().map(emitter).collect::<Vec<_>>());
        for (light, trail) in lights.iter().zip(&tree.trails) {
            trails[light.0 as usize] = *trail;
        }
        nodes = tree.texels();
    }
    Ok(Lights { texels, pdf_area: densities, trails, nodes, count: lights.len() as u32 })
}

/// Exclusive ends of the weights' shares of 2^32 words: rising, at least one word each, the last end 2^32.
fn cumulative_words(weights: &[f64], even_share: f64) -> Vec<u64> {
    let total: f64 = weights.iter().sum();
    let count = weights.len();
    let spare = (1u64 << 32) - count as u64;
    let mut sum = 0.0;
    (0..count)
        .map(|i| {
            sum += weights[i];
            let by_weight = if total > 0.0 { sum / total } else { (i + 1) as f64 / count as f64 };
            let share = (1.0 - even_share) * by_weight + even_share * (i + 1) as f64 / count as f64;
            let end = if i + 1 == count { spare } else { (share.clamp(0.0, 1.0) * spare as f64) as u64 };
            end + i as u64 + 1
        })
        .collect()
}

/// Luminance of linear Rec. 709.
fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_none_is_empty() {
        let weights = [1e20, 1e-20, 3e19, 0.0, 5e19];
        for even_share in [0.0, EVEN_SHARE] {
            let ends = cumulative_words(&weights, even_share);
            assert_eq!(*ends.last().unwrap(), 1 << 32);
            let mut begin = 0;
            for &end in &ends {
                assert!(end > begin);
                begin = end;
            }
        }
    }

    #[test]
    fn shares_follow_the_weights() {
        let ends = cumulative_words(&[1.0, 3.0], 0.0);
        assert!((ends[0] as f64 / 4_294_967_296.0 - 0.25).abs() < 1e-9);
    }
}
