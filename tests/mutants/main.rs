//! Guards taken out, one at a time: the hard case that names a guard has to fail without it.
//!
//! One list a group of cases. A guard that is in no list is a guard that nothing tests, and a failure.

#[path = "../harness/mod.rs"]
mod harness;

mod ag;
mod b;
mod c;
mod d;
mod ef;
mod h;

use harness::device::context;
use texray::render::Guard;
use texray::selftest::{Bench, Outcome, Tier, case, run_case};

/// Fails for each guard whose case does not notice that it is out.
fn assert_all_bite(mutants: &[(Guard, u8)]) {
    let bench = Bench::new(context(), Tier::Fast);
    let mut silent = Vec::new();
    for &(guard, number) in mutants {
        let report = run_case(&bench.without(guard), case(number).expect("the catalogue has this case"));
        let Outcome::Ran(findings) = &report.outcome else {
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
fn every_guard_is_tried_with_its_case() {
    let tried: Vec<_> =
        [ag::MUTANTS, b::MUTANTS, c::MUTANTS, d::MUTANTS, ef::MUTANTS, h::MUTANTS].into_iter().flatten().collect();
    for &guard in Guard::ALL {
        assert!(tried.contains(&&(guard, guard.case())), "{guard:?} is not tried with case {}", guard.case());
    }
}

#[test]
fn guards_of_triangles() {
    assert_all_bite(b::MUTANTS);
}

#[test]
fn guards_of_the_tree() {
    assert_all_bite(c::MUTANTS);
}

#[test]
fn guards_of_ray_origins() {
    assert_all_bite(d::MUTANTS);
}

#[test]
fn guards_of_lights_and_scattering() {
    assert_all_bite(ef::MUTANTS);
}

#[test]
fn guards_of_floats_sums_and_random_numbers() {
    assert_all_bite(ag::MUTANTS);
}

#[test]
fn sums_need_precise() {
    ag::loose_sums(&Bench::new(context(), Tier::Fast));
}

#[test]
fn guards_of_whole_scenes() {
    assert_all_bite(h::MUTANTS);
}
