//! Every hard case of the catalogue under validation: as `texray selftest` runs them, and, ignored, as
//! `texray selftest --full` does.
//!
//! Each group is a test, so that a failure names its subject; what was measured is printed (`-- --nocapture`, or on
//! failure). Statistical findings share a false-alarm rate of 1e-6; seeds are fixed.

mod harness;

use harness::device::{assert_valid, context};
use texray::selftest::kit::form_factors;
use texray::selftest::{CaseOutcome, GROUPS, TestBench, Tier, run_case};

/// Runs a group and fails with all that went wrong in it.
fn group(letter: char, tier: Tier) {
    let group = GROUPS.iter().find(|group| group.letter == letter).expect("the catalogue has this group");
    let bench = TestBench::new(context(), tier);
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

/// Two tests for each group: the fast tier, and the full one, which takes ten times the samples.
macro_rules! groups {
    ($($letter:literal $name:ident,)*) => {
        $(
            #[test]
            fn $name() {
                group($letter, Tier::Fast);
            }
        )*

        /// All groups in full.
        mod full {
            use super::{Tier, group};

            $(
                #[test]
                #[ignore = "the full tier of all groups takes some five minutes"]
                fn $name() {
                    group($letter, Tier::Full);
                }
            )*
        }

        #[test]
        fn every_group_is_run() {
            let letters: Vec<char> = GROUPS.iter().map(|group| group.letter).collect();
            assert_eq!(letters, [$($letter),*]);
        }
    };
}

groups! {
    'A' a_floats_and_shader_language,
    'B' b_triangles,
    'C' c_the_tree,
    'D' d_ray_origins,
    'E' e_light_sampling,
    'F' f_scattering,
    'G' g_sums_and_random_numbers,
    'H' h_whole_scenes,
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
