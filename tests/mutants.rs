//! Guards taken out, one at a time: the hard case that names a guard has to fail without it.

mod harness;

use std::ops::RangeInclusive;

use harness::device::context;
use texray::gpu::shaders;
use texray::render::Guard;
use texray::selftest::kit::streams;
use texray::selftest::{CaseOutcome, TestBench, Tier, case, run_case};

/// Guards that have to be missed by a second case too.
const MORE: [(Guard, u8); 5] = [
    (Guard::CompensatedSum, 6),
    (Guard::UnfusedEdges, 12),
    (Guard::Rescale, 15),
    (Guard::TriangleBox, 22),
    (Guard::SpawnOffset, 32),
];

/// Fails for each guard of these cases whose case does not notice that it is out.
fn assert_all_bite(cases: RangeInclusive<u8>) {
    let bench = TestBench::new(context(), Tier::Fast);
    let mut silent = Vec::new();
    let pairs = Guard::ALL.iter().map(|&guard| (guard, guard.case())).chain(MORE);
    for (guard, number) in pairs.filter(|(_, number)| cases.contains(number)) {
        let report = run_case(&bench.without(guard), case(number).expect("the catalogue has this case"));
        let CaseOutcome::Ran(findings) = &report.outcome else {
            // An error or a test elsewhere shows nothing about the guard.
            silent.push(format!("{guard:?}: case {number} did not run: {:?}", report.outcome));
            continue;
        };
        match findings.iter().find(|finding| !finding.passes) {
            None => silent.push(format!("{guard:?}: case {number} passes without it")),
            Some(finding) => println!(
                "without {guard:?}, case {number}, {}: expected {}, got {}",
                finding.what, finding.expected, finding.got
            ),
        }
    }
    assert!(silent.is_empty(), "{silent:#?}");
}

#[test]
fn guards_of_floats_and_triangles() {
    assert_all_bite(1..=21);
}

#[test]
fn guards_of_the_tree() {
    assert_all_bite(22..=29);
}

#[test]
fn guards_of_ray_origins() {
    assert_all_bite(30..=37);
}

#[test]
fn guards_of_lights_and_scattering() {
    assert_all_bite(38..=57);
}

#[test]
fn guards_of_sums_and_random_numbers() {
    assert_all_bite(58..=69);
}

#[test]
fn guards_of_whole_scenes() {
    assert_all_bite(70..=80);
}

/// Without `precise` a driver may fold the compensation away; lavapipe does, and the sum of case 6 drifts as a naive one. A
/// driver that does not is none the worse.
#[test]
fn sums_need_precise() {
    let bench = TestBench::new(context(), Tier::Fast);
    let dispatches = 16;
    let expected = streams::sum(0, dispatches * streams::STEPS);
    let sum = |module| streams::compensated(&bench, module, dispatches).expect("the probe runs")[0];
    let error = |sum: f32| (f64::from(sum) / expected - 1.0).abs();
    let (precise, loose) = (sum(shaders::PROBE_SUMS), sum(shaders::PROBE_SUMS_LOOSE));
    println!("10^6 x 0.1: {:.1e} with precise, {:.1e} without", error(precise), error(loose));
    assert!(error(precise) < 1e-6);
    if bench.context().device_info().name.contains("llvmpipe") {
        assert!(error(loose) > 1e-4, "precise is no guard here: {loose} for {expected}");
    }
}
