//! Shadow rays to lights near and far, with nothing and with a blocker in between (hard case 33).
//!
//! Comes in: a bench. Goes out: how many rays were stopped where none should be, or went on where none should.

use glam::{DMat3, DVec3, Vec3};

use crate::Result;
use crate::bvh::{Builder, WideBvh};
use crate::scene::Triangle;
use crate::selftest::TestBench;
use crate::selftest::kit::meshes;
use crate::selftest::kit::tracing::{Departure, Leaving, Mesh};
use crate::statistics::Finding;
use crate::statistics::random::Random;

/// Floor, light close above it, and between them nothing or a blocker.
pub fn check(bench: &TestBench) -> Result<Vec<Finding>> {
    // Off the origin and turned, so that planes round.
    let place = DVec3::new(0.61, 0.37, -0.53);
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let square = |height: f64, size: f64, up: bool| {
        let at = |x: f64, z: f64| (place + turn * DVec3::new(x * size, height, z * size)).as_vec3();
        let (a, b, c, d) = (at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0));
        match up {
            true => [meshes::triangle(a, c, b), meshes::triangle(a, d, c)],
            false => [meshes::triangle(a, b, c), meshes::triangle(a, c, d)],
        }
    };
    let shadowed = |height: f64, blocker: Option<f64>| -> Result<[u64; 2]> {
        let mut triangles = square(0.0, 0.2, true).to_vec();
        triangles.extend(square(height, 0.2, false));
        if let Some(gap) = blocker {
            triangles.extend(square(height - gap, 0.3, true));
        }
        let mesh = Mesh::new(&triangles, WideBvh::build(&triangles, Builder::Sah).into(), |id| (2..4).contains(&id))?;
        let mut random = Random::new(33, 0);
        let departures: Vec<Departure> = (0..bench.count(50_000, 500_000))
            .map(|i| {
                let light = 2 + (i % 2) as u32;
                let [a, b, c] = triangles[light as usize].positions;
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                // Every fourth on the edge that the light's triangles share.
                let (u, v) = match (i / 4 % 4, light) {
                    (0, 2) => (0.0, v),
                    (0, _) => (u, 0.0),
                    _ => (u, v),
                };
                let (s, t) = (random.unit(), random.unit());
                let barycentrics = if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
                let d = a + (b - a) * u + (c - a) * v;
                Departure { id: (i / 2 % 2) as u32, barycentrics, wo: (turn * DVec3::Y).as_vec3(), d, light }
            })
            .collect();
        let arrivals = mesh.leave(bench, &departures, Leaving::Shadow)?;
        Ok([arrivals.iter().filter(|arrival| arrival.hit.is_some()).count() as u64, departures.len() as u64])
    };
    let mut findings = Vec::new();
    for height in [0.5, 1e-2, 1e-3, 1e-4] {
        let [blocked, rays] = shadowed(height, None)?;
        findings.push(Finding::never(
            format!("shadow rays to a light {height} above that meet something"),
            blocked,
            rays,
        ));
    }
    for (height, gap) in [(0.5, 1e-4), (1e-2, 1e-4), (1e-3, 1e-4)] {
        let [blocked, rays] = shadowed(height, Some(gap))?;
        let what = format!("shadow rays to a light {height} above that pass a blocker {gap} before it");
        findings.push(Finding::never(what, rays - blocked, rays));
    }
    findings
        .push(needle_light(bench, &square(0.0, 0.2, true), &|x, z| (place + turn * DVec3::new(x, 0.05, z)).as_vec3())?);
    Ok(findings)
}

/// A light a million times as long as wide: its barycentrics are good to some hundredths, and so is the distance at which its
/// own shadow ray meets it. `at` gives points of its plane, which faces the floor.
fn needle_light(bench: &TestBench, floor: &[Triangle], at: &dyn Fn(f64, f64) -> Vec3) -> Result<Finding> {
    let light = meshes::triangle(at(-0.4, -0.3), at(0.4, 0.3), at(0.4, 0.3 + 8e-7));
    let triangles = [floor, &[light]].concat();
    let id = floor.len() as u32;
    let mesh = Mesh::new(&triangles, WideBvh::build(&triangles, Builder::Sah).into(), |triangle| triangle == id)?;
    let mut random = Random::new(33, 1);
    let [a, b, c] = light.positions;
    let departures: Vec<Departure> = (0..bench.count(50_000, 500_000))
        .map(|i| {
            let (u, v) = (random.unit(), random.unit() * 0.5);
            let d = a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
            Departure {
                id: i as u32 % id,
                barycentrics: [random.unit() * 0.5, random.unit() * 0.5],
                wo: d,
                d,
                light: id,
            }
        })
        .collect();
    let arrivals = mesh.leave(bench, &departures, Leaving::Shadow)?;
    let blocked = arrivals.iter().filter(|arrival| arrival.hit.is_some()).count() as u64;
    Ok(Finding::never("shadow rays to a light of 1e6 : 1 that meet something", blocked, departures.len() as u64))
}
