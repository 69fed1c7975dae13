//! A plain path tracer in f64: the second opinion on every picture. It shares the scene's types with the renderer and
//! no code: own random numbers, own triangle test over all triangles, own sampling.
//!
//! Comes in: a [`Scene`], sizes, a seed, and how light is gathered. Goes out: an [`Estimate`] in scaled radiance.
//! Assumes a checked scene of extent about 1 (so that [`NEAREST`] is small) and few triangles (it tries each).
//!
//! The contract: up to `max_bounces` surface scatterings a path; emission counts at the camera's hit and after each
//! scattering, from the side from which corners turn counter-clockwise; box filter; no Russian roulette; the sky is
//! constant and found by BSDF sampling in every mode, for the same expectation. The shading normal lies on `wo`'s
//! geometric side and gives way to the geometric normal where `wo` lies behind it, or where a mirrored or refracted
//! direction would end on the wrong geometric side. `wo` and `wi` point away from the surface.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use texray::interface::NO_INDEX;
use texray::scene::{MaterialKind, Scene};

use super::random::Random;

/// Hits nearer than this are not seen. Rays skip the flat triangle that they start from; this covers its coplanar
/// neighbours, whose computed distance is rounding (1e-16) over the cosine. What it hides at concave edges is a share
/// of about 1e-9 of the rays.
const NEAREST: f64 = 1e-9;
/// An emitter's distance counts as shorter by this share, so that it wins against a coplanar surface.
const EMITTER_LEAD: f64 = 1e-9;

/// How light is gathered; all three have the same expectation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lights {
    /// Next-event estimation and BSDF sampling, weighted by the power heuristic.
    Mis,
    /// Next-event estimation; emission that a ray hits counts at the camera and after mirrors and glass only.
    Area,
    /// BSDF sampling alone.
    Bsdf,
}

/// A picture with its uncertainty, rows from the top.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Mean radiance of each pixel.
    pub mean: Vec<[f64; 3]>,
    /// Estimated variance of each number in `mean`.
    pub variance_of_mean: Vec<[f64; 3]>,
}

/// Renders `spp` (at least 2) independent samples in each pixel.
pub fn render(
    scene: &Scene,
    width: u32,
    height: u32,
    spp: u32,
    max_bounces: u32,
    seed: u64,
    lights: Lights,
) -> Estimate {
    let world = World::of(scene);
    let (basis, half) = (scene.camera.basis(height), DVec2::new(width.into(), height.into()) / 2.0);
    let (mut means, mut variances) = (Vec::new(), Vec::new());
    for pixel in 0..u64::from(width) * u64::from(height) {
        let mut random = Random::new(seed, pixel);
        let corner = DVec2::new((pixel % u64::from(width)) as f64, (pixel / u64::from(width)) as f64);
        let (mut mean, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for sample in 1..=spp {
            let film = corner + DVec2::new(random.next(), random.next()) - half;
            let direction = (basis.forward + film.x * basis.right + film.y * basis.down).normalize();
            let value = world.radiance(scene.camera.origin, direction, max_bounces, lights, &mut random);
            let change = value - mean;
            mean += change / f64::from(sample);
            squares += change * (value - mean);
        }
        means.push(mean.to_array());
        variances.push((squares / (f64::from(spp) * (f64::from(spp) - 1.0))).to_array());
    }
    Estimate { mean: means, variance_of_mean: variances }
}

/// The scene's triangles in f64, and which of them are lights.
struct World<'a> {
    scene: &'a Scene,
    triangles: Vec<Triangle>,
    /// Triangles that emit, each with the probability, in [0, 1] and rising, at which its share of the choice ends.
    lights: Vec<(usize, f64)>,
    sky: DVec3,
}

struct Triangle {
    origin: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    emission: DVec3,
    /// Density per unit area with which next-event estimation chooses a point on it; 0 where it does not emit.
    density: f64,
}

struct Hit {
    id: usize,
    distance: f64,
    weights: [f64; 3],
}

impl<'a> World<'a> {
    fn of(scene: &'a Scene) -> World<'a> {
        let mut triangles: Vec<Triangle> = Vec::new();
        for triangle in &scene.triangles {
            let [origin, second, third] = triangle.positions.map(|position| position.as_dvec3());
            let edges = [second - origin, third - origin];
            let emission = colour(scene.materials[triangle.material as usize].emission);
            // Lights are chosen by their power, so the density per area is the emission over the sum of all powers.
            let normal = edges[0].cross(edges[1]);
            triangles.push(Triangle {
                origin,
                edges,
                normal: normal.normalize(),
                emission,
                density: emission.max_element(),
            });
        }
        let area = |triangle: &Triangle| triangle.edges[0].cross(triangle.edges[1]).length() / 2.0;
        let power: f64 = triangles.iter().map(|triangle| triangle.density * area(triangle)).sum();
        let (mut lights, mut end) = (Vec::new(), 0.0);
        for (id, triangle) in triangles.iter_mut().enumerate().filter(|(_, triangle)| triangle.density > 0.0) {
            triangle.density /= power;
            end += triangle.density * area(triangle);
            lights.push((id, end));
        }
        World { scene, triangles, lights, sky: colour(scene.sky.unwrap_or_default()) }
    }

    /// Radiance that arrives at `origin` from `direction`, one sample.
    fn radiance(&self, mut origin: DVec3, mut direction: DVec3, bounces: u32, lights: Lights, u: &mut Random) -> DVec3 {
        let (mut radiance, mut throughput) = (DVec3::ZERO, DVec3::ONE);
        // Density per solid angle of the last direction: infinite where next-event estimation had no chance to find it.
        let (mut density, mut start) = (f64::INFINITY, usize::MAX);
        for bounce in 0..=bounces {
            let Some(hit) = self.closest(origin, direction, start) else {
                return radiance + throughput * self.sky;
            };
            let (triangle, wo) = (&self.triangles[hit.id], -direction);
            let front = triangle.normal.dot(wo) > 0.0;
            if front && triangle.density > 0.0 {
                let light = triangle.density * hit.distance * hit.distance / triangle.normal.dot(wo);
                let weight = match lights {
                    _ if density.is_infinite() => 1.0,
                    Lights::Bsdf => 1.0,
                    Lights::Area => 0.0,
                    Lights::Mis => power_heuristic(density, light),
                };
                radiance += throughput * triangle.emission * weight;
            }
            if bounce == bounces {
                break;
            }
            let geometric = if front { triangle.normal } else { -triangle.normal };
            let shading = self.shading_normal(&hit, geometric, wo);
            origin += direction * hit.distance;
            start = hit.id;
            let material = &self.scene.materials[self.scene.triangles[hit.id].material as usize];
            match material.kind {
                MaterialKind::Lambert { albedo } => {
                    throughput *= colour(albedo);
                    if lights != Lights::Bsdf && !self.lights.is_empty() {
                        radiance += throughput * self.direct(origin, geometric, shading, start, lights, u);
                    }
                    direction = cosine_direction(shading, u);
                    density = shading.dot(direction) / PI;
                    if geometric.dot(direction) <= 0.0 || density <= 0.0 {
                        break;
                    }
                }
                MaterialKind::Mirror { reflectance } => {
                    throughput *= colour(reflectance);
                    direction = mirrored(wo, shading, geometric);
                    density = f64::INFINITY;
                }
                MaterialKind::Glass { ior } => {
                    let eta = if front { f64::from(ior) } else { 1.0 / f64::from(ior) };
                    let refracted = (u.next() >= fresnel(shading.dot(wo), eta))
                        .then(|| {
                            refracted(wo, shading, eta)
                                .filter(|wi| wi.dot(geometric) < 0.0)
                                .or_else(|| refracted(wo, geometric, eta))
                        })
                        .flatten();
                    // Radiance over the squared index is what stays along a refracted ray.
                    throughput /= if refracted.is_some() { eta * eta } else { 1.0 };
                    direction = refracted.unwrap_or_else(|| mirrored(wo, shading, geometric));
                    density = f64::INFINITY;
                }
            }
        }
        radiance
    }

    /// Next-event estimation at a Lambert surface of albedo 1: radiance towards `wo` by light from one point chosen
    /// on the emitters. A light is seen where the closest hit towards it is that light.
    fn direct(&self, point: DVec3, ng: DVec3, ns: DVec3, start: usize, lights: Lights, u: &mut Random) -> DVec3 {
        let pick = u.next();
        // Rounding may end the last share just below 1.
        let &(id, _) = self.lights.iter().find(|&&(_, end)| pick < end).unwrap_or(&self.lights[self.lights.len() - 1]);
        let light = &self.triangles[id];
        let (root, v) = (u.next().sqrt(), u.next());
        let to_light = light.origin + (root * (1.0 - v)) * light.edges[0] + (root * v) * light.edges[1] - point;
        let wi = to_light.normalize();
        let (cosine, light_cosine) = (ns.dot(wi), -light.normal.dot(wi));
        if cosine <= 0.0 || ng.dot(wi) <= 0.0 || light_cosine <= 0.0 {
            return DVec3::ZERO;
        }
        if self.closest(point, wi, start).is_none_or(|hit| hit.id != id) {
            return DVec3::ZERO;
        }
        let density = light.density * to_light.length_squared() / light_cosine;
        let weight = if lights == Lights::Mis { power_heuristic(density, cosine / PI) } else { 1.0 };
        light.emission * (cosine / PI / density * weight)
    }

    /// The nearest triangle along a ray (Möller and Trumbore 1997), both sides, without the one it starts from.
    fn closest(&self, origin: DVec3, direction: DVec3, start: usize) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut best_key = f64::INFINITY;
        for (id, triangle) in self.triangles.iter().enumerate().filter(|&(id, _)| id != start) {
            let [e1, e2] = triangle.edges;
            let across = direction.cross(e2);
            let determinant = e1.dot(across);
            if determinant == 0.0 {
                continue;
            }
            let from = (origin - triangle.origin) / determinant;
            let v = from.dot(across);
            let turned = from.cross(e1);
            let w = direction.dot(turned);
            let distance = e2.dot(turned);
            if v < 0.0 || w < 0.0 || v + w > 1.0 || distance < NEAREST {
                continue;
            }
            let key = if triangle.density > 0.0 { distance * (1.0 - EMITTER_LEAD) } else { distance };
            if key < best_key {
                best_key = key;
                best = Some(Hit { id, distance, weights: [1.0 - v - w, v, w] });
            }
        }
        best
    }

    fn shading_normal(&self, hit: &Hit, geometric: DVec3, wo: DVec3) -> DVec3 {
        let corners = self.scene.triangles[hit.id].corners;
        if corners == NO_INDEX {
            return geometric;
        }
        let normals = self.scene.corners[corners as usize].normals.map(|normal| normal.as_dvec3());
        let sum: DVec3 = (0..3).map(|i| hit.weights[i] * normals[i]).sum();
        let normal = sum.normalize_or(geometric);
        let normal = if normal.dot(geometric) < 0.0 { -normal } else { normal };
        if normal.dot(wo) > 0.0 { normal } else { geometric }
    }
}

fn colour(rgb: [f32; 3]) -> DVec3 {
    DVec3::from_array(rgb.map(f64::from))
}

fn power_heuristic(mine: f64, other: f64) -> f64 {
    mine * mine / (mine * mine + other * other)
}

fn cosine_direction(normal: DVec3, u: &mut Random) -> DVec3 {
    let (radius, angle) = (u.next().sqrt(), TAU * u.next());
    let (x, y) = normal.any_orthonormal_pair();
    radius * angle.cos() * x + radius * angle.sin() * y + (1.0 - radius * radius).sqrt() * normal
}

fn mirrored(wo: DVec3, shading: DVec3, geometric: DVec3) -> DVec3 {
    let wi = 2.0 * shading.dot(wo) * shading - wo;
    if wi.dot(geometric) > 0.0 { wi.normalize() } else { (2.0 * geometric.dot(wo) * geometric - wo).normalize() }
}

/// Snell's law; `eta` is the index beyond the surface over that on `wo`'s side. `None`: total internal reflection.
fn refracted(wo: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = normal.dot(wo);
    let squared = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    (squared > 0.0).then(|| (-wo / eta + (cosine / eta - squared.sqrt()) * normal).normalize())
}

/// Reflectance of a smooth dielectric for unpolarised light.
fn fresnel(cosine: f64, eta: f64) -> f64 {
    let squared = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    if squared <= 0.0 {
        return 1.0;
    }
    let beyond = squared.sqrt();
    let parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
    let perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
    (parallel * parallel + perpendicular * perpendicular) / 2.0
}
