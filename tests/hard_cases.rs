//! Every hard case of the catalogue, as `texray selftest --full` runs them, under validation.
//!
//! One test a group, so that a failure names its subject; what was measured is printed (`-- --nocapture`, or on failure).
//! Statistical findings share a false-alarm rate of 1e-6; seeds are fixed.

mod harness;

use harness::device::{assert_valid, context};
use texray::selftest::kit::form_factors;
use texray::selftest::{CaseOutcome, GROUPS, TestBench, Tier, run_case};

/// Runs a group and fails with all that went wrong in it.
fn group(letter: char) {
    let group = GROUPS.iter().find(|group| group.letter == letter).expect("the catalogue has this group");
    let bench = TestBench::new(context(), Tier::Full);
    let mut wrong = Vec::new();
    for case in group.cases {
        let report = run_case(&bench, case);
        println!("{} {} ({:.1} s)", case.number, case.title, report.seconds);
        match &report.outcome {
            CaseOutcome::Ran(findings) => {
                for finding in findings {
                    println!(
                        "    {} {}: expected {}, got {}; {}",
                        if finding.passes { "ok  " } else { "FAIL" },
                        finding.what,
                        finding.expected,
                        finding.got,
                        finding.tolerance
                    );
                }
            }
            other => println!("    {other:?}"),
        }
        if !report.outcome.passes() {
            wrong.push(format!("{} {}: {:?}", case.number, case.title, report.outcome));
        }
    }
    assert_valid(context());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_floats_and_shader_language() {
    group('A');
}

#[test]
fn b_triangles() {
    group('B');
}

#[test]
fn c_the_tree() {
    group('C');
}

#[test]
fn d_ray_origins() {
    group('D');
}

#[test]
fn e_light_sampling() {
    group('E');
}

#[test]
fn f_scattering() {
    group('F');
}

#[test]
fn g_sums_and_random_numbers() {
    group('G');
}

#[test]
fn h_whole_scenes() {
    group('H');
}

/// Cases 38 and 40 to 42 once more, with the form factors known to a ten-thousandth.
#[test]
#[ignore = "two minutes"]
fn form_factors_to_a_ten_thousandth() {
    let bench = TestBench::new(context(), Tier::Full);
    let all = [form_factors::near(), form_factors::far(), form_factors::oblique(), form_factors::touching()];
    let mut wrong = Vec::new();
    for lit in all.into_iter().flatten() {
        for finding in lit.findings(&bench, 16_384, 1e-4).expect("the scene renders") {
            println!("{}: expected {}, got {}; {}", finding.what, finding.expected, finding.got, finding.tolerance);
            if !finding.passes {
                wrong.push(finding);
            }
        }
    }
    assert_valid(context());
    assert!(wrong.is_empty(), "{wrong:#?}");
}
