//! The start-up probe: what every picture rests on, asked of a device before its first render.
//!
//! Comes in: a device. Goes out: one finding a question, in milliseconds: one small kernel, one dispatch. A device that
//! fails one cannot be used: its pictures would be wrong without a word. A context keeps what was found, so that its
//! device is asked once: [`Renderer::new`](crate::render::Renderer::new) asks, so every render is on a device that has
//! passed.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use crate::gpu::{
    Barrier, BindGroup, Buffer, BufferUse, ComputePipeline, Context, Ledger, Memory, PipelineDesc, Readback, Recorder,
    Resource, Uploader, shaders,
};
use crate::interface::{BINDING_PROBE_INPUT, BINDING_PROBE_OUTPUT, BUDGET_LANES, MAX_STEP_BUDGET, Push};
use crate::statistics::Finding;
use crate::statistics::random::Random;
use crate::texels::Texel;
use crate::{Error, Result};

/// What the finding about NaN looks at.
pub const NAN: &str = "nan";
/// What the finding about loops looks at.
pub const LOOPS: &str = "loops";

/// How long the device may take to answer. The kernel is small: lavapipe takes a fraction of a second, nearly all of
/// it to compile. A driver that has lost one of its threads never answers.
const ANSWER_LIMIT: Duration = Duration::from_secs(60);
/// Invocations: one workgroup.
const CALLS: usize = 64;
/// Iterations that the probe's loop asks for.
const ITERATIONS: u32 = 1 << 17;
/// Iterations that the step budget needs: the lanes of a vector may loop one after the other, and a driver may count them together.
const NEEDED_ITERATIONS: u32 = BUDGET_LANES * MAX_STEP_BUDGET;
/// NaN questions of the kernel, by bit.
const NAN_QUESTIONS: [&str; 5] = ["0 * inf", "inf - inf", "0 / 0", "inf / inf", "sqrt(-1)"];

/// What the context's device answers: asked at the first call, kept for all others.
pub fn probe(context: &Context) -> Result<Arc<[Finding]>> {
    context.findings(ask)
}

/// Asks the device, which has a minute to answer.
fn ask(context: &Context) -> Result<Vec<Finding>> {
    let mut random = Random::new(1, 7);
    let mut questions = Vec::with_capacity(CALLS);
    for call in 0..CALLS {
        let magnitude = |random: &mut Random| (random.unit() + 1.0) * 2f32.powi(random.below(20) as i32 - 10);
        let (a, b) = (magnitude(&mut random), magnitude(&mut random));
        // Half of them cancel: a multiply-add rounded once would leave the product's rounding error.
        let c = if call % 2 == 0 { -(a * b) } else { magnitude(&mut random) };
        let angle = (2.0 * random.next() - 1.0) * std::f64::consts::PI;
        questions.push([a, b, c, angle as f32]);
    }
    // The bound is the probe's alone: some drivers compile for minutes in a render's first dispatch.
    let limit = context.limit_waits(Some(ANSWER_LIMIT));
    let answers = answers(context, &questions);
    context.limit_waits(limit);
    let answers = answers?;
    let answers: Vec<[Texel; 3]> = answers.as_chunks::<3>().0.to_vec();
    Ok(vec![
        nan(&answers),
        loops(&answers),
        rounding(&questions, &answers),
        largest(
            "sine and cosine",
            &questions,
            &answers,
            2f64.powi(-11),
            "absolute error on [-pi, pi]: Vulkan's bound",
            |q, a| {
                let angle = f64::from(q[3]);
                (float(a[1][0]) - angle.sin()).abs().max((float(a[1][1]) - angle.cos()).abs())
            },
        ),
        largest("division", &questions, &answers, 2.5, "units in the last place: Vulkan's bound", |q, a| {
            ulps(float(a[1][2]), f64::from(q[0]) / f64::from(q[1]))
        }),
        largest(
            "square root",
            &questions,
            &answers,
            5.0,
            "units in the last place: 1 / inversesqrt, 2.5 + 2",
            |q, a| ulps(float(a[1][3]), f64::from(q[0]).sqrt()),
        ),
        largest("inverse square root", &questions, &answers, 2.0, "units in the last place: Vulkan's bound", |q, a| {
            ulps(float(a[2][0]), 1.0 / f64::from(q[0]).sqrt())
        }),
        denormals(&answers),
    ])
}

/// Refuses a device that fails a probe, by the probe's name.
pub fn check(context: &Context) -> Result<()> {
    verdict(&context.device_info().summary(), &probe(context)?)
}

fn verdict(device: &str, findings: &[Finding]) -> Result<()> {
    match findings.iter().find(|finding| !finding.passes) {
        None => Ok(()),
        Some(Finding { what, expected, got, .. }) => {
            Err(Error::NoDevice(format!("{device}: start-up probe `{what}` failed: expected {expected}, got {got}")))
        }
    }
}

/// Iterations after which the kernel's generator is in `state`, if it gets there at all.
fn iterations(state: u32) -> Option<u32> {
    let mut current = 1u32;
    (0..=ITERATIONS).find(|_| {
        let found = current == state;
        current = current.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        found
    })
}

fn nan(answers: &[[Texel; 3]]) -> Finding {
    let flags = answers.iter().fold(u32::MAX, |flags, answer| flags & answer[0][0]);
    let missed: Vec<&str> =
        NAN_QUESTIONS.iter().enumerate().filter(|(bit, _)| flags >> bit & 1 == 0).map(|(_, name)| *name).collect();
    let got = if missed.is_empty() { "all of them".to_owned() } else { format!("not {}", missed.join(", ")) };
    Finding::holds(NAN, format!("{} give NaN", NAN_QUESTIONS.join(", ")), got, missed.is_empty())
}

fn loops(answers: &[[Texel; 3]]) -> Finding {
    // Mostly one state: each is looked for once.
    let states: BTreeSet<u32> = answers.iter().map(|answer| answer[0][1]).collect();
    let least = states.into_iter().map(|state| iterations(state).unwrap_or(0)).min().unwrap_or(0);
    let got = if least == ITERATIONS { format!("{least}, all that were asked for") } else { least.to_string() };
    Finding::holds(LOOPS, format!("at least {NEEDED_ITERATIONS} iterations"), got, least >= NEEDED_ITERATIONS)
}

/// Sums, products and both together, each rounded on its own to the nearest: the tests of edges and boxes rest on it.
fn rounding(questions: &[[f32; 4]], answers: &[[Texel; 3]]) -> Finding {
    let wrong = questions.iter().zip(answers).filter(|(question, answer)| {
        let [a, b, c, _] = **question;
        [answer[0][2], answer[2][1], answer[2][2]] != [a * b + c, a + b, a * b].map(f32::to_bits)
    });
    Finding::never("rounding", wrong.count() as u64, answers.len() as u64)
}

fn largest(
    name: &str,
    questions: &[[f32; 4]],
    answers: &[[Texel; 3]],
    limit: f64,
    why: &str,
    error: impl Fn(&[f32; 4], &[Texel; 3]) -> f64,
) -> Finding {
    // A maximum would let a NaN go.
    let worse = |worst: f64, error: f64| if worst.is_nan() || error <= worst { worst } else { error };
    let worst = questions.iter().zip(answers).map(|(question, answer)| error(question, answer)).fold(0.0, worse);
    Finding::at_most(name, limit, worst, why)
}

/// No picture rests on denormals; reported alone.
fn denormals(answers: &[[Texel; 3]]) -> Finding {
    let kept = answers.iter().all(|answer| answer[2][3] == f32::MIN_POSITIVE.to_bits() / 2 && answer[0][3] != 0);
    Finding::holds("denormals", "kept or flushed to zero", if kept { "kept" } else { "flushed to zero" }, true)
}

fn float(bits: u32) -> f64 {
    f64::from(f32::from_bits(bits))
}

/// Distance in units in the last place of the exact value.
fn ulps(got: f64, exact: f64) -> f64 {
    let unit = 2f64.powi(((exact.to_bits() >> 52 & 0x7ff) as i32) - 1023 - 23);
    (got - exact).abs() / unit
}

/// Runs the kernel.
fn answers(context: &Context, questions: &[[f32; 4]]) -> Result<Vec<Texel>> {
    let keep_nan = context.device_info().shader_signed_zero_inf_nan_preserve_float32;
    let pipeline = ComputePipeline::shared(
        context,
        &PipelineDesc {
            name: "start-up probe",
            module: if keep_nan { shaders::PROBE_STARTUP_KEEP_NAN } else { shaders::PROBE_STARTUP },
            specialization: &[],
        },
    )?;
    // From a buffer, so that no compiler can work anything out beforehand.
    let special = [0.0, f32::INFINITY, -1.0, f32::MIN_POSITIVE];
    let input: Vec<[f32; 4]> = questions.iter().flat_map(|&question| [question, special]).collect();
    let bytes = 16 * 3 * questions.len() as u64;
    let uses = BufferUse { storage: true, texel: false };
    let asked = Buffer::new(context, "probe questions", 16 * input.len() as u64, uses, Memory::Device)?;
    let output = Buffer::new(context, "probe answers", bytes, uses, Memory::Device)?;
    let mut ledger = Ledger::default();
    let mut uploader = Uploader::with_ring(context, 1, 16 * input.len() as u64)?;
    uploader.upload(&mut ledger, &asked, 0, bytemuck::cast_slice(&input), "questions")?;
    uploader.finish()?;
    let resources =
        [(BINDING_PROBE_INPUT, Resource::Storage(asked)), (BINDING_PROBE_OUTPUT, Resource::Storage(output.clone()))];
    let group = BindGroup::new(&pipeline, &resources)?;
    let push = Push { budget: ITERATIONS, ..Push::default() }.bytes();
    let mut recorder = Recorder::new(context, "start-up probe")?;
    recorder.barrier(Barrier::TransferToCompute)?;
    recorder.dispatch(&pipeline, &group, &push, [1, 1, 1])?;
    let mut readback = Readback::new(context, "probe answers", bytes)?;
    readback.copy_from(&mut recorder, &mut ledger, &output, 0, 0, bytes, "answers")?;
    recorder.submit()?.wait()?;
    Ok(bytemuck::pod_collect_to_vec(&readback.bytes()?[..bytes as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The generator's state after so many iterations.
    fn state(count: u32) -> u32 {
        (0..count).fold(1u32, |state, _| state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223))
    }

    #[test]
    fn iterations_are_read_off_the_generator() {
        for count in [0, 1, 65_535, ITERATIONS] {
            assert_eq!(iterations(state(count)), Some(count));
        }
        assert_eq!(iterations(state(ITERATIONS + 1)), None);
    }

    #[test]
    fn faults_are_found() {
        let answer = |flags: u32, count: u32| [[flags, state(count), 0, 0], [0; 4], [0; 4]];
        assert!(nan(&[answer(31, 0)]).passes && !nan(&[answer(31, 0), answer(29, 0)]).passes);
        assert!(nan(&[answer(29, 0)]).got.contains("inf - inf"));
        assert!(loops(&[answer(0, 65_535), answer(0, ITERATIONS)]).passes);
        assert!(!loops(&[answer(0, ITERATIONS), answer(0, 65_527)]).passes);
        // 3 x 1/3 - 1, rounded once, is the product's rounding error.
        let question = [3.0f32, 1.0 / 3.0, -1.0, 0.0];
        let [a, b, c, _] = question;
        let given = |sum: f32| [[0, 0, sum.to_bits(), 0], [0; 4], [0, (a + b).to_bits(), (a * b).to_bits(), 0]];
        assert!(rounding(&[question], &[given(a * b + c)]).passes);
        assert!(!rounding(&[question], &[given(a.mul_add(b, c))]).passes);
        let error = verdict("0: a device", &[nan(&[answer(31, 0)]), loops(&[answer(0, 9)])]).unwrap_err();
        assert_eq!(error.exit_code(), 4);
        assert!(error.to_string().contains("`loops` failed: expected at least 65528 iterations, got 9"), "{error}");
        let nan_first = |question: &[f32; 4], _: &[Texel; 3]| if question[0] == 0.0 { f64::NAN } else { 0.0 };
        assert!(!largest("", &[[0.0; 4], question], &[given(0.0); 2], 1.0, "", nan_first).passes);
    }
}
