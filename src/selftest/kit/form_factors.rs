//! Surfaces lit by one light of a known form factor: L = albedo · F · Le.
//!
//! Comes in: a light's corners. Goes out: scenes, and form factors in closed form (Lambert's formula for polygons). The lit
//! point is the origin, its normal +y; a camera just above looks straight down on it.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::Result;
use crate::scene::Scene;
use crate::selftest::kit::scattering::{Measured, measure, smooth_settings};
use crate::selftest::kit::scenes::{SceneBuilder, camera, lambert};
use crate::selftest::kit::{TestBench, Tier};
use crate::settings::{Lights, Settings};
use crate::statistics::Finding;
use crate::statistics::random::Random;

/// Reflectance of what is lit.
pub const ALBEDO: f64 = 0.5;

/// A lit place and its form factor.
#[derive(Clone, Debug)]
pub struct Lit {
    /// What it is.
    pub name: String,
    /// Corners of the light, a convex polygon above the floor.
    pub light: Vec<DVec3>,
    /// The form factor.
    pub factor: f64,
    /// The unit square [0, 1]^2 of the floor is looked at, not the origin.
    pub square: bool,
}

impl Lit {
    /// The origin under a convex polygon.
    pub fn point(name: impl Into<String>, light: Vec<DVec3>) -> Lit {
        let factor = polygon_factor(&light);
        Lit { name: name.into(), light, factor, square: false }
    }

    /// The same with a form factor from elsewhere.
    pub fn known(name: &str, light: Vec<DVec3>, factor: f64, square: bool) -> Lit {
        Lit { name: name.into(), light, factor, square }
    }

    /// The scene; the light shines towards what is looked at.
    pub fn scene(&self) -> Scene {
        let mut builder = SceneBuilder::new();
        let (floor, light) = (builder.material(lambert(ALBEDO as f32, 0.0)), builder.material(lambert(0.0, 1.0)));
        let middle = if self.square { DVec3::new(0.5, 0.0, 0.5) } else { DVec3::ZERO };
        builder.quad([middle.x - 0.5, 0.0, middle.z - 0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], floor);
        for i in 1..self.light.len() - 1 {
            let [a, b, c] = [self.light[0], self.light[i], self.light[i + 1]];
            let away = (b - a).cross(c - a).dot(a - middle) > 0.0;
            builder.triangle(if away { [a, c, b] } else { [a, b, c] }, light);
        }
        // Below the light, so that nothing is in the way.
        let lowest = self.light.iter().map(|corner| corner.y).filter(|&y| y > 0.0).fold(1.0, f64::min);
        let height = 0.4 * lowest;
        let vfov = if self.square { 2.0 * (0.5 / height).atan().to_degrees() } else { 1e-3 };
        builder.finish(camera([middle.x, height, middle.z], [middle.x, 0.0, middle.z], vfov), None)
    }

    /// Renders it with `spp` samples for each of 32 x 32 pixels.
    pub fn measure(&self, bench: &TestBench, lights: Lights, spp: u32) -> Result<Measured> {
        let scene = self.scene();
        measure(bench, &scene, &Settings { lights, max_bounces: 1, ..smooth_settings(&scene, 32, spp) })
    }

    /// Radiance against albedo times form factor, and how well it is known.
    pub fn findings(&self, bench: &TestBench, spp: u32, error: f64) -> Result<Vec<Finding>> {
        let measured = self.measure(bench, Lights::Mis, spp)?;
        let mut findings = vec![
            Finding::z(&self.name, ALBEDO * self.factor, measured.mean, measured.variance),
            Finding::at_most(
                format!("{}: relative standard error", self.name),
                error,
                measured.relative_error(),
                "so that the verdict says something",
            ),
        ];
        if measured.invalid > 0 {
            findings.push(Finding::exact(format!("{}: samples left out", self.name), 0, measured.invalid));
        }
        Ok(findings)
    }
}

/// Findings on each, at the tier's number of samples and error.
pub fn check(bench: &TestBench, all: &[Lit]) -> Result<Vec<Finding>> {
    let error = if bench.tier() == Tier::Full { 3e-4 } else { 3e-3 };
    let mut findings = Vec::new();
    for lit in all {
        // Over a square the integrand varies more than at a point.
        let spp = bench.count(64, 512) as u32 * if lit.square { 2 } else { 1 };
        findings.extend(lit.findings(bench, spp, error)?);
    }
    Ok(findings)
}

/// Form factor of a convex polygon above the floor, seen from the origin with normal +y (Lambert 1760).
pub fn polygon_factor(corners: &[DVec3]) -> f64 {
    let directions: Vec<DVec3> = corners.iter().map(|corner| corner.normalize()).collect();
    let edge = |i: usize| {
        let (a, b) = (directions[i], directions[(i + 1) % directions.len()]);
        let normal = a.cross(b);
        let sine = normal.length();
        if sine > 0.0 { sine.atan2(a.dot(b)) * normal.y / sine } else { 0.0 }
    };
    ((0..directions.len()).map(edge).sum::<f64>() / TAU).abs()
}

/// A horizontal rectangle at a height.
pub fn ceiling([x0, x1]: [f64; 2], [z0, z1]: [f64; 2], y: f64) -> Vec<DVec3> {
    vec![DVec3::new(x0, y, z0), DVec3::new(x1, y, z0), DVec3::new(x1, y, z1), DVec3::new(x0, y, z1)]
}

/// Lights close above the point.
pub fn near() -> Vec<Lit> {
    [(1e-2, 0.99991818), (1e-4, 0.99999999)]
        .map(|(height, factor)| {
            let light = ceiling([-1.0, 1.0], [-1.0, 1.0], height);
            Lit::known(&format!("2 x 2 at height {height}"), light, factor, false)
        })
        .to_vec()
}

/// A light far above the point.
pub fn far() -> Vec<Lit> {
    vec![Lit::known("1 x 1 at height 100", ceiling([-0.5, 0.5], [-0.5, 0.5], 100.0), 3.1829928e-5, false)]
}

/// A light that stands on the floor at a distance from the point.
pub fn touching() -> Vec<Lit> {
    [0.1, 1e-3]
        .map(|distance: f64| {
            let far = (1.0 + distance * distance).sqrt();
            let factor = ((0.5 / distance).atan() - distance / far * (0.5 / far).atan()) / PI;
            let corner = |x: f64, y: f64| DVec3::new(x, y, distance);
            let light = vec![corner(-0.5, 0.0), corner(0.5, 0.0), corner(0.5, 1.0), corner(-0.5, 1.0)];
            Lit::known(&format!("1 x 1 on the floor at distance {distance}"), light, factor, false)
        })
        .to_vec()
}

/// The textbook's: points under squares, squares facing squares, and random triangles.
pub fn oblique() -> Vec<Lit> {
    let wall = vec![DVec3::ZERO, DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)];
    let unit = [0.0, 1.0];
    let mut all = vec![
        Lit::known("centred square", ceiling([-0.5, 0.5], [-0.5, 0.5], 1.0), 0.2394564705, false),
        Lit::known("square over a corner", ceiling(unit, unit, 1.0), 0.1385316060, false),
        Lit::known("parallel squares", ceiling(unit, unit, 1.0), 0.1998248957, true),
        Lit::known("perpendicular squares", wall, 0.2000437761, true),
    ];
    let mut random = Random::new(41, 0);
    for i in 1..=5 {
        let mut corner = || DVec3::new(2.0 * random.next() - 1.0, 0.2 + random.next(), 2.0 * random.next() - 1.0);
        all.push(Lit::point(format!("random triangle {i}"), vec![corner(), corner(), corner()]));
    }
    all
}
