//! Group C: the tree.

use std::time::Instant;

use glam::Vec3;

use crate::Result;
use crate::bvh::{Accel, Builder, Ray, WideBvh};
use crate::interface::{MAX_TREE_DEPTH, NO_INDEX, TRIANGLE_TEXELS};
use crate::scene::Triangle;
use crate::selftest::kit::meshes;
use crate::selftest::kit::pictures::worst_error;
use crate::selftest::kit::rays::rays;
use crate::selftest::kit::scenes::{SceneBuilder, camera};
use crate::selftest::kit::test_bench::plain_settings;
use crate::selftest::kit::tracing::{Mesh, leaks, mismatches, trees};
use crate::selftest::{Case, Check, TestBench};
use crate::statistics::Finding;
use crate::statistics::random::Random;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 22,
        title: "axis-aligned rays on box planes",
        meaning: "whole objects missing in straight views",
        check: Check::Run(box_planes),
    },
    Case {
        number: 23,
        title: "boxes that round inwards",
        meaning: "holes that depend on the tree",
        check: Check::Run(rounded_boxes),
    },
    Case {
        number: 24,
        title: "boxes without thickness",
        meaning: "axis-aligned walls with holes",
        check: Check::Run(flat_boxes),
    },
    Case {
        number: 25,
        title: "equal centroids",
        meaning: "builds that never end, leaves that are slow",
        check: Check::Run(equal_centroids),
    },
    Case {
        number: 26,
        title: "stack overflow",
        meaning: "holes in scenes of great depth",
        check: Check::Run(deep_trees),
    },
    Case {
        number: 27,
        title: "vertices that are not finite",
        meaning: "everything missing",
        check: Check::Tests("tests/scene.rs, every_refusal_has_file_line_value_and_what_is_allowed"),
    },
    Case {
        number: 28,
        title: "no triangle, one triangle, 2^24 triangles",
        meaning: "wrong object at an index above 16,777,216",
        check: Check::Run(counts),
    },
    Case {
        number: 29,
        title: "rays that are not finite",
        meaning: "renders that hang",
        check: Check::Run(invalid_rays),
    },
];

/// Hits by each tree against hits by none, over meshes small enough for none to be quick; every seventh triangle emits.
fn against_brute(bench: &TestBench, named: &[(&str, Vec<Triangle>)], count: usize, seed: u64) -> Result<Vec<Finding>> {
    let emits = |id: u32| id % 7 == 3;
    let mut findings = Vec::new();
    for ((name, triangles), seed) in named.iter().zip(seed..) {
        let trees = trees(triangles);
        // The families need the wide tree's planes.
        let rays = rays(triangles, &trees[0].1, count, seed);
        let brute = Mesh::new(triangles, Accel::brute(), emits)?.trace(bench, &rays)?;
        let hits = brute.iter().filter(|answer| answer.hit.is_some()).count();
        for (tree, accel) in trees {
            let answers = Mesh::new(triangles, accel, emits)?.trace(bench, &rays)?;
            let what = format!("rays of ten families that the {tree} tree answers differently, {name} ({hits} hits)");
            findings.push(mismatches(what, &brute, &answers));
        }
    }
    Ok(findings)
}

fn box_planes(bench: &TestBench) -> Result<Vec<Finding>> {
    let named = [
        ("sphere", meshes::displaced_sphere(8, 12)),
        ("cube", meshes::cube(4)),
        ("soup", meshes::soup(150, 0.3, 1)),
        ("coplanar", meshes::coplanar(120, 3)),
        ("exponential", meshes::exponential(140)),
    ];
    against_brute(bench, &named, bench.count(20_000, 800_000), 220)
}

/// Sheets of emitters so close that their keys and their boxes come in different order.
fn sheets(count: usize) -> Vec<Triangle> {
    let mut random = Random::new(23, 0);
    (0..count)
        .map(|i| {
            let z = 0.25 + i as f32 * 2e-6;
            let at = Vec3::new(random.unit() - 0.5, random.unit() - 0.5, 0.0) * 0.2;
            let corner = |x: f32, y: f32| at + Vec3::new(x, y, z);
            meshes::triangle(corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.0, 0.5))
        })
        .collect()
}

fn rounded_boxes(bench: &TestBench) -> Result<Vec<Finding>> {
    let named = [("sheets", sheets(140)), ("clusters", meshes::clusters())];
    against_brute(bench, &named, bench.count(20_000, 200_000), 230)
}

fn flat_boxes(bench: &TestBench) -> Result<Vec<Finding>> {
    let triangles = meshes::cube(32);
    let mut random = Random::new(24, 0);
    let rays: Vec<Ray> = (0..bench.count(20_000, 200_000))
        .map(|i| {
            let origin = random.point() * 0.49;
            let mut direction = random.direction();
            if i % 2 == 0 {
                // Along an axis, in the very planes of the grid's lines.
                let axis = random.below(3);
                direction = Vec3::ZERO;
                direction[axis] = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
                let mut from = origin;
                from[(axis + 1) % 3] = random.below(31) as f32 / 32.0 - 0.46875;
                return Ray::new(from, direction);
            }
            Ray::new(origin, direction)
        })
        .collect();
    let mut findings = Vec::new();
    for (tree, accel) in trees(&triangles) {
        let answers = Mesh::new(&triangles, accel, |_| false)?.trace(bench, &rays)?;
        findings.push(leaks(format!("rays that leave a cube of flat boxes, {tree} tree"), &answers));
    }
    Ok(findings)
}

fn equal_centroids(bench: &TestBench) -> Result<Vec<Finding>> {
    let triangles = meshes::copies(100_000);
    let mut findings = Vec::new();
    for builder in [Builder::Sah, Builder::Median] {
        // The quicker of two: other work on the machine is no fault of the builder.
        let seconds = [0; 2]
            .map(|_| {
                let started = Instant::now();
                std::hint::black_box(WideBvh::build(&triangles, builder));
                started.elapsed().as_secs_f64()
            })
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        let accel: Accel = WideBvh::build(&triangles, builder).into();
        let name = format!("{builder:?}");
        findings.push(Finding::at_most(
            format!("seconds to build over 100,000 copies, {name}"),
            2.0,
            seconds,
            "the catalogue's",
        ));
        let depth = f64::from(accel.stack_entries());
        findings.push(Finding::at_most(
            format!("depth, {name}"),
            f64::from(MAX_TREE_DEPTH),
            depth,
            "the builder's bound",
        ));
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let hit = Mesh::new(&triangles, accel, |_| false)?.trace(bench, &[ray])?[0].hit;
        findings.push(Finding::exact(
            format!("the copy that is hit, {name}"),
            "0".to_owned(),
            hit.map_or("none".to_owned(), |hit| hit.id.to_string()),
        ));
    }
    Ok(findings)
}

/// Triangles at x = 2^-k make the deepest trees.
fn deep_trees(bench: &TestBench) -> Result<Vec<Finding>> {
    let triangles = meshes::exponential(140);
    let count = bench.count(5_000, 50_000);
    let mut random = Random::new(26, 0);
    let rays: Vec<Ray> = (0..count)
        .map(|_| {
            let tilt = Vec3::new(0.0, random.unit(), random.unit()) * 0.1;
            Ray::new(Vec3::new(-1e-25, 0.0, 0.0), Vec3::X + tilt)
        })
        .collect();
    let brute = Mesh::new(&triangles, Accel::brute(), |_| false)?.trace(bench, &rays)?;
    let mut findings = Vec::new();
    for (tree, accel) in trees(&triangles) {
        let depth = accel.stack_entries();
        let what = format!("depth of the {tree} tree over spacing by halves");
        findings.push(Finding::at_most(what, f64::from(MAX_TREE_DEPTH), f64::from(depth), "the builder's bound"));
        let answers = Mesh::new(&triangles, accel, |_| false)?.trace(bench, &rays)?;
        findings.push(mismatches(
            format!("rays through all levels of the {tree} tree that lose something"),
            &brute,
            &answers,
        ));
        let hits = answers.iter().filter(|answer| answer.hit.is_some()).count();
        findings.push(Finding::holds("hits among them", "some", hits.to_string(), hits > 0));
        let overflows = answers.iter().map(|answer| u64::from(answer.overflows)).sum();
        findings.push(Finding::never(format!("stack overflows of the {tree} tree"), overflows, answers.len() as u64));
    }
    Ok(findings)
}

fn counts(bench: &TestBench) -> Result<Vec<Finding>> {
    let sky = SceneBuilder::new().finish(camera([0.0; 3], [0.0, 0.0, 1.0], 40.0), Some([1.0; 3]));
    let error = worst_error(bench, &sky, &plain_settings(&sky, 8, 8, 4), 1.0)?;
    let mut findings = vec![Finding::at_most("error of the background without triangles", 0.0, error, "exact")];
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    let one = Mesh::wide(&meshes::copies(1))?.trace(bench, &[ray])?[0];
    findings.push(Finding::exact("triangles hit of one", 1, u32::from(one.hit.is_some())));
    // Ids beyond what a float can count, the larger one first in the leaf: integers all the way keep them apart.
    let mut two = Mesh::new(&meshes::copies(2), WideBvh::build(&meshes::copies(2), Builder::Sah).into(), |_| false)?;
    let ids = [16_777_217, 16_777_216];
    for (place, id) in ids.into_iter().enumerate() {
        if let Some(texel) = two.data_mut().triangles.get_mut(place * TRIANGLE_TEXELS as usize) {
            texel[3] = id;
        }
    }
    let hit = two.trace(bench, &[ray])?[0].hit.map_or(NO_INDEX, |hit| hit.id);
    findings.push(Finding::exact("the smaller of the ids 16,777,217 and 16,777,216", 16_777_216, hit));
    Ok(findings)
}

fn invalid_rays(bench: &TestBench) -> Result<Vec<Finding>> {
    let triangles = meshes::displaced_sphere(17, 32);
    let mut random = Random::new(29, 0);
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let rays: Vec<Ray> = (0..bench.count(12_000, 100_000))
        .map(|i| {
            let (mut origin, mut direction) = (random.point(), random.point());
            match i % 3 {
                0 => origin[random.below(3)] = values[random.below(3)],
                1 => direction[random.below(3)] = values[random.below(3)],
                _ => direction = Vec3::ZERO,
            }
            Ray::new(origin, direction)
        })
        .collect();
    let mut findings = Vec::new();
    for (tree, accel) in trees(&triangles) {
        let answers = Mesh::new(&triangles, accel, |_| false)?.trace(bench, &rays)?;
        let hits = answers.iter().filter(|answer| answer.hit.is_some()).count() as u64;
        findings.push(Finding::never(
            format!("hits of rays that are not finite, {tree} tree"),
            hits,
            rays.len() as u64,
        ));
        let nodes: u64 = answers.iter().map(|answer| u64::from(answer.nodes)).sum();
        findings.push(Finding::exact(format!("nodes that they visit, {tree} tree"), 0, nodes));
    }
    Ok(findings)
}
