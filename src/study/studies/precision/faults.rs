//! Rays that go wrong without a guard: leaks, hits that depend on the tree, hits of the triangle that a ray leaves.
//!
//! Comes in: a bench of the self-test, a number of rays. Goes out: how many of them go wrong, with the guard and without it.

use glam::Vec3;

use crate::Result;
use crate::bvh::{Accel, Builder, Intersector, Ray, WideBvh};
use crate::interface::NO_INDEX;
use crate::render::Guard;
use crate::scene::Triangle;
use crate::selftest::TestBench;
use crate::selftest::kit::meshes;
use crate::selftest::kit::rays::rays;
use crate::selftest::kit::tracing::{Answer, Departure, Leaving, Mesh};
use crate::statistics::random::Random;
use crate::study::engine::spread::digits;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Rows, Values};

/// Something that may go wrong, and what is left out to see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Rays from inside a closed mesh, aimed at its corners and edges, that leave it.
    Leak(Test),
    /// Rays whose hit differs from that of no tree.
    Tree(Option<Guard>),
    /// Rays that hit the triangle that they leave, with these of their guards.
    SelfHit(Origin),
}

/// A triangle test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Test {
    /// Ours.
    Watertight,
    /// Ours where the driver fuses a multiplication and a subtraction into one rounding.
    Fused,
    /// Möller and Trumbore's.
    MollerTrumbore,
}

/// What keeps a ray off the triangle that it leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Both that follow.
    Guarded,
    /// It starts beyond the error of its point.
    OffsetAlone,
    /// It skips that triangle's index.
    IndexAlone,
    /// Neither.
    Bare,
}

impl Fault {
    /// Each fault with all guards, then without those that are there for it.
    pub fn all() -> Vec<Fault> {
        let leaks = [Test::Watertight, Test::Fused, Test::MollerTrumbore].map(Fault::Leak);
        let trees =
            [None, Some(Guard::NodePad), Some(Guard::TriangleBox), Some(Guard::DirectionFloor)].map(Fault::Tree);
        let hits = [Origin::Guarded, Origin::OffsetAlone, Origin::IndexAlone, Origin::Bare].map(Fault::SelfHit);
        leaks.into_iter().chain(trees).chain(hits).collect()
    }

    /// Its name in rows.
    pub fn name(self) -> String {
        let without = |what: &str, guard: Option<Guard>| match guard {
            None => what.to_owned(),
            Some(guard) => format!("{what}, without {}", super::plain(guard)),
        };
        match self {
            Fault::Leak(Test::Watertight) => "leaks".into(),
            Fault::Leak(Test::Fused) => "leaks, products fused".into(),
            Fault::Leak(Test::MollerTrumbore) => "leaks, Moller-Trumbore".into(),
            Fault::Tree(guard) => without("hits lost by the tree", guard),
            Fault::SelfHit(Origin::Guarded) => "hits of the own triangle".into(),
            Fault::SelfHit(Origin::OffsetAlone) => "hits of the own triangle, offset alone".into(),
            Fault::SelfHit(Origin::IndexAlone) => "hits of the own triangle, index alone".into(),
            Fault::SelfHit(Origin::Bare) => "hits of the own triangle, no guard".into(),
        }
    }

    /// Traces `count` rays.
    pub fn measure(self, bench: &TestBench, count: usize) -> Result<Values> {
        let (faults, rays) = match self {
            Fault::Leak(test) => leaks(bench, test, count)?,
            Fault::Tree(guard) => lost_by_tree(&without(bench, guard), count)?,
            Fault::SelfHit(origin) => self_hits(bench, origin, count)?,
        };
        Ok(vec![
            ("rays", rays as f64),
            ("faults", faults as f64),
            ("faults_per_million", 1e6 * faults as f64 / rays.max(1) as f64),
        ])
    }
}

fn without(bench: &TestBench, guard: Option<Guard>) -> TestBench {
    guard.map_or_else(|| bench.clone(), |guard| bench.without(guard))
}

/// Rays that leave a closed mesh, and all of them.
fn leaks(bench: &TestBench, test: Test, count: usize) -> Result<(usize, usize)> {
    let sphere = meshes::displaced_sphere(17, 32);
    let bench = if test == Test::Fused { bench.without(Guard::UnfusedEdges) } else { bench.clone() };
    let intersector = if test == Test::MollerTrumbore { Intersector::MollerTrumbore } else { Intersector::Watertight };
    let mut random = Random::new(12, 0);
    let aimed: Vec<Ray> = (0..count)
        .map(|index| {
            let origin = random.point() * 0.1;
            let [a, b, c] = sphere[random.below(sphere.len())].positions;
            let target = if index % 2 == 0 { [a, b, c][random.below(3)] } else { a + (b - a) * random.unit() };
            Ray::new(origin, target - origin)
        })
        .collect();
    let answers = Mesh::wide(&sphere)?.with_intersector(intersector).trace(&bench, &aimed)?;
    Ok((answers.iter().filter(|answer| answer.hit.is_none()).count(), answers.len()))
}

/// Rays of the self-test's hard families that the wide tree answers otherwise than no tree does, both with the same guards.
fn lost_by_tree(bench: &TestBench, count: usize) -> Result<(usize, usize)> {
    let named = [meshes::displaced_sphere(8, 12), meshes::cube(4), meshes::exponential(140), meshes::clusters()];
    let (mut faults, mut all) = (0, 0);
    for (triangles, seed) in named.iter().zip(220..) {
        let tree: Accel = WideBvh::build(triangles, Builder::Sah).into();
        let hard = rays(triangles, &tree, count / named.len(), seed);
        let brute = Mesh::new(triangles, Accel::brute(), |_| false)?.trace(bench, &hard)?;
        let wide = Mesh::new(triangles, tree, |_| false)?.trace(bench, &hard)?;
        let differs = |(a, b): &(&Answer, &Answer)| a.bits() != b.bits();
        faults += brute.iter().zip(&wide).filter(differs).count();
        all += hard.len();
    }
    Ok((faults, all))
}

/// Rays that leave triangles of all sizes and hit them at once.
fn self_hits(bench: &TestBench, origin: Origin, count: usize) -> Result<(usize, usize)> {
    let by_index = matches!(origin, Origin::Guarded | Origin::IndexAlone);
    let by_offset = matches!(origin, Origin::Guarded | Origin::OffsetAlone);
    let bench = if by_index { bench.clone() } else { bench.without(Guard::SkipSource) };
    let leaving = if by_offset { Leaving::Extension } else { Leaving::Bare };
    let mut random = Random::new(30, 0);
    let triangles: Vec<Triangle> = (0..count / 4)
        .map(|_| {
            let (at, size) = (random.point() * 0.5, 0.4 * 10f32.powf(-8.0 * random.unit()));
            let mut corner = || at + random.point() * size;
            meshes::triangle(corner(), corner(), corner())
        })
        .filter(|triangle| crate::scene::normalise::has_area(triangle.positions))
        .collect();
    let departures: Vec<Departure> = (0..4 * triangles.len())
        .map(|index| {
            let (u, v) = (random.unit(), random.unit());
            let barycentrics = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            let id = (index % triangles.len()) as u32;
            Departure { id, barycentrics, wo: random.direction(), d: random.direction(), light: NO_INDEX }
        })
        .filter(|departure| departure.d != Vec3::ZERO)
        .collect();
    let arrivals = Mesh::wide(&triangles)?.leave(&bench, &departures, leaving)?;
    let own = departures.iter().zip(&arrivals).filter(|(departure, arrival)| arrival.hit == Some(departure.id)).count();
    Ok((own, departures.len()))
}

/// How many rays of a million go wrong.
pub fn summary(rows: &Rows, scene: &str) -> Summary {
    let mut table =
        Table::new("Rays that go wrong, of a million hard ones", &["fault", "faults", "rays", "in a million"]);
    let figure = |fault: Fault, value: &str| rows.median(scene, &fault.name(), value);
    for fault in Fault::all() {
        let Some(rate) = figure(fault, "faults_per_million") else { continue };
        let whole = |value| figure(fault, value).map_or("?".into(), |value| format!("{value:.0}"));
        table.rows.push(vec![fault.name(), whole("faults"), whole("rays"), digits(rate)]);
    }
    let mut summary = Summary::default();
    if table.rows.is_empty() {
        return summary;
    }
    let rate = |fault| figure(fault, "faults_per_million").map_or("?".into(), digits);
    summary.findings.push(format!(
        "Of a million rays at corners and edges of a closed mesh {} leave it by the watertight test, {} where a driver fuses its \
         products, {} by Moller and Trumbore's test. Without padded boxes the tree loses {} hits of a million hard rays, with them {}. Of a \
         million rays that leave a triangle {} hit it at once where nothing guards them, {} with the offset alone, {} with the index.",
        rate(Fault::Leak(Test::Watertight)),
        rate(Fault::Leak(Test::Fused)),
        rate(Fault::Leak(Test::MollerTrumbore)),
        rate(Fault::Tree(Some(Guard::NodePad))),
        rate(Fault::Tree(None)),
        rate(Fault::SelfHit(Origin::Bare)),
        rate(Fault::SelfHit(Origin::OffsetAlone)),
        rate(Fault::SelfHit(Origin::IndexAlone)),
    ));
    summary.table(table);
    summary
}
