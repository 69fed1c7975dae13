//! Safe code cannot make undefined behaviour: what a caller may give the library, at its worst, is refused before it
//! reaches the driver.
//!
//! Comes in: modules, buffers of other devices, numbers out of range, a device that does not answer in time. Goes
//! out: errors, and a process that goes on; validation with synchronisation validation finds nothing.

#![forbid(unsafe_code)]

mod harness;

use std::sync::Arc;
use std::time::Duration;

use harness::device::{Silent, assert_valid, context, load, plain_settings};
use harness::draws::nothing;
use texray::Error;
use texray::film::Film;
use texray::gpu::{
    BindGroup, BindingKind, Buffer, BufferUse, ComputePipeline, Context, ContextOptions, Ledger, Memory, PipelineDesc,
    Recorder, Resource, ShaderModule, TexelBuffer, Uploader, shaders,
};
use texray::interface::*;
use texray::render::bounce_cap::cap_bias;
use texray::render::pass::Pass;
use texray::render::slice::Slice;
use texray::render::tiles::Tile;
use texray::render::{Effects, Renderer, Roulette, Settings, StopRules, Target, Tuning, startup};

fn fresh() -> Context {
    Context::new(&ContextOptions { validation: true, ..ContextOptions::default() }).expect("a device and the layer")
}

fn pipeline(
    context: &Context,
    module: ShaderModule,
    specialization: &[(u32, u32)],
) -> Result<Arc<ComputePipeline>, Error> {
    ComputePipeline::new(context, &PipelineDesc { name: "soundness", module, specialization })
}

/// A buffer for each binding of a pipeline.
fn resources(context: &Context, pipeline: &ComputePipeline, bytes: u64) -> Vec<(u32, Resource)> {
    let resource = |kind| match kind {
        BindingKind::Texel => Resource::Texel(TexelBuffer::new(context, "texels", bytes).expect("texels")),
        BindingKind::Storage => {
            let uses = BufferUse { texel: false, storage: true };
            Resource::Storage(Buffer::new(context, "words", bytes, uses, Memory::Device).expect("words"))
        }
    };
    pipeline.bindings().iter().map(|slot| (slot.number, resource(slot.kind))).collect()
}

#[test]
fn a_module_says_itself_what_is_bound() {
    let context = context();
    // The description has no place for bindings or push constants to be left out of.
    let tracer = pipeline(context, shaders::PATH_TRACE_KEEP_NAN, &[]).expect("a pipeline");
    assert_eq!((tracer.bindings().len(), tracer.push_constant_bytes()), (25, PUSH_CONSTANT_BYTES));
    assert!(matches!(BindGroup::new(&tracer, &[]), Err(Error::Internal(_))));
    let whole = resources(context, &tracer, 64);
    for left_out in 0..whole.len() {
        let mut some = whole.clone();
        some.remove(left_out);
        assert!(BindGroup::new(&tracer, &some).is_err(), "binding {} is missing", whole[left_out].0);
    }
    let group = BindGroup::new(&tracer, &whole).expect("all of them");
    let mut recorder = Recorder::new(context, "push").expect("a recorder");
    assert!(recorder.dispatch(&tracer, &group, &[], [1, 1, 1]).is_err(), "push constants left out");
    // A group of one module is none of another.
    let echo = pipeline(context, shaders::PROBE_ECHO, &[]).expect("a pipeline");
    assert!(recorder.dispatch(&echo, &group, &[0; 4], [1, 1, 1]).is_err());
    assert_valid(context);
}

#[test]
fn buffers_of_another_device_are_not_bound() {
    let (own, other) = (context(), fresh());
    let echo = pipeline(own, shaders::PROBE_ECHO, &[]).expect("a pipeline");
    let (ours, theirs) = (resources(own, &echo, 1024), resources(&other, &echo, 1024));
    assert!(BindGroup::new(&echo, &ours).is_ok());
    for foreign in 0..ours.len() {
        let mut mixed = ours.clone();
        mixed[foreign] = theirs[foreign].clone();
        let refused = BindGroup::new(&echo, &mixed);
        assert!(matches!(&refused, Err(Error::Internal(said)) if said.contains("another context")), "{refused:?}");
    }
    assert_valid(own);
    assert_valid(&other);
}

#[test]
fn constants_that_no_device_can_take_are_refused() {
    let context = context();
    let limits = context.device_info();
    let [x, y, _] = limits.max_compute_work_group_size;
    for constants in [
        vec![(SPEC_WORKGROUP_X, 0)],
        vec![(SPEC_WORKGROUP_Y, u32::MAX)],
        vec![(SPEC_WORKGROUP_X, x + 1), (SPEC_WORKGROUP_Y, 1)],
        vec![(SPEC_WORKGROUP_X, x), (SPEC_WORKGROUP_Y, y)],
        vec![(SPEC_STACK_ENTRIES, 0)],
        vec![(SPEC_STACK_ENTRIES, u32::MAX)],
    ] {
        let Err(Error::Limit { need, have, .. }) = pipeline(context, shaders::PATH_TRACE, &constants) else {
            panic!("{constants:?} made a pipeline");
        };
        assert!(!need.is_empty() && !have.is_empty());
    }
    assert!(pipeline(context, shaders::PATH_TRACE, &[(SPEC_LIGHTS, 0), (SPEC_LIGHTS, 1)]).is_err(), "given twice");
    assert_valid(context);
}

/// Path states, records and push constants of any content lead nowhere outside their buffers and arrays: the process
/// lives.
#[test]
fn garbage_in_buffers_and_constants_is_survived() {
    let context = context();
    // A deep stack is an array with an index; a shallow one is not (glsl/trace/traversal.glsl).
    for (entries, accel) in [(32, ACCEL_WIDE), (32, ACCEL_BINARY), (4, ACCEL_WIDE)] {
        let constants = [
            (SPEC_STACK_ENTRIES, entries),
            (SPEC_ACCEL, accel),
            (SPEC_LIGHTS, 77),
            (SPEC_ROULETTE, u32::MAX),
            (SPEC_SAMPLER, 99),
            (SPEC_REFILL_EIGHTHS, u32::MAX),
            (SPEC_TESTS_A_VISIT, u32::MAX),
        ];
        let tracer = pipeline(context, shaders::PATH_TRACE_KEEP_NAN, &constants).expect("a pipeline");
        let bound = resources(context, &tracer, 1 << 16);
        let group = BindGroup::new(&tracer, &bound).expect("a group");
        // Every phase, searching or not, with a stack far larger than the array; then words that mean nothing.
        let states = (0..64).map(|low| (0xffff_f000 | low, false)).chain([(0x0fff_0013, false)]);
        let words = [0, 0xffff_ffff, 0x7fff_ffff, 0x0fff_0013, 0xa5a5_a5a5].map(|word| (word, true));
        for (word, in_push_constants) in states.chain(words) {
            let mut recorder = Recorder::new(context, "garbage").expect("a recorder");
            for (number, resource) in &bound {
                let buffer = match resource {
                    Resource::Texel(texels) => texels.buffer(),
                    Resource::Storage(buffer) => buffer,
                };
                // Pixel 0 and its neighbours are listed, so that their states are loaded, and the render has some
                // bounces.
                let word = match *number {
                    BINDING_LISTS if !in_push_constants => 0,
                    BINDING_CAMERA if !in_push_constants => 8,
                    _ => word,
                };
                recorder.fill(buffer, 0, buffer.size_bytes(), word).expect("a fill");
            }
            recorder.barrier(texray::gpu::Barrier::TransferToCompute).expect("a barrier");
            let mut push = Push { tile_width: 8, tile_height: 8, samples: 16, listed: 64, ..Push::default() }.bytes();
            if in_push_constants {
                push.chunks_exact_mut(4).for_each(|field| field.copy_from_slice(&word.to_ne_bytes()));
            }
            let budget = std::mem::offset_of!(Push, budget);
            push[budget..][..4].copy_from_slice(&500u32.to_ne_bytes());
            recorder.dispatch(&tracer, &group, &push, [4, 4, 1]).expect("a dispatch");
            recorder.submit().expect("submitted").wait().expect("it ends");
        }
    }
    assert_valid(context);
}

#[test]
fn a_chunk_whose_wait_failed_is_never_written_again() {
    let context = fresh();
    let target = Buffer::new(&context, "target", 256 << 20, BufferUse::default(), Memory::Device).expect("a buffer");
    let mut uploader = Uploader::with_ring(&context, 1, 1 << 20).expect("a ring");
    let mut ledger = Ledger::default();
    // The copy waits behind fills that take far longer than the wait may.
    let mut recorder = Recorder::new(&context, "long").expect("a recorder");
    for word in 0..8 {
        recorder.barrier(texray::gpu::Barrier::TransferToTransfer).expect("a barrier");
        recorder.fill(&target, 0, target.size_bytes(), word).expect("a fill");
    }
    let long = recorder.submit().expect("submitted");
    uploader.upload(&mut ledger, &target, 0, &[1; 64], "first").expect("nothing to wait for yet");
    context.limit_waits(Some(Duration::ZERO));
    for attempt in 0..2 {
        let refused = uploader.upload(&mut ledger, &target, 0, &[2; 64], "second");
        assert!(refused.is_err(), "attempt {attempt} wrote a chunk that the device may still read");
    }
    context.limit_waits(None);
    // The chunk stays taken, for good: whether its copy has ended nobody knows.
    assert!(uploader.upload(&mut ledger, &target, 0, &[3; 64], "third").is_err());
    assert!(uploader.finish().is_err());
    long.wait().expect("the fills end");
    drop(uploader);
    assert_valid(&context);
}

#[test]
fn a_device_is_asked_once_by_whoever_renders_first() {
    let context = fresh();
    let scene = nothing();
    let settings = Settings { allow_black: true, ..plain_settings(&scene, 4, 4, 1) };
    let limit = Some(Duration::from_secs(300));
    context.limit_waits(limit);
    let make = || Renderer::new(&context, &scene, &settings, &Tuning::default()).expect("a renderer");
    let copied_down = |make: &dyn Fn()| {
        let before = context.copied_bytes().1;
        make();
        context.copied_bytes().1 - before
    };
    assert!(copied_down(&|| drop(make())) > 0, "the first renderer asks, and the answers come back");
    assert_eq!(copied_down(&|| drop(make())), 0, "the second one knows");
    let (first, second) = (startup::probe(&context).expect("known"), startup::probe(&context).expect("known"));
    assert!(Arc::ptr_eq(&first, &second) && first.iter().all(|finding| finding.passes), "{first:?}");
    assert_eq!(context.limit_waits(None), limit, "the caller's bound on waits is in place again");
    assert_valid(&context);
}

#[test]
fn a_device_that_does_not_answer_is_an_error() {
    let context = fresh();
    let target = Buffer::new(&context, "target", 256 << 20, BufferUse::default(), Memory::Device).expect("a buffer");
    let mut recorder = Recorder::new(&context, "long fill").expect("a recorder");
    recorder.fill(&target, 0, target.size_bytes(), 7).expect("a fill");
    let work = recorder.submit().expect("submitted");
    context.limit_waits(Some(Duration::ZERO));
    let error = work.wait().expect_err("256 MiB take longer than nothing");
    assert_eq!(error.exit_code(), 4);
    assert!(error.to_string().contains("does not answer: `long fill` has not ended in 0 s"), "{error}");
    context.limit_waits(None);
    // What the work uses stays; new work goes on.
    let held = context.device_bytes();
    drop(target);
    assert_eq!(context.device_bytes(), held);
    let recorder = Recorder::new(&context, "next").expect("a recorder");
    recorder.submit().expect("submitted").wait().expect("it ends");
    assert_valid(&context);
}

/// Every field, out of its range, where it enters: `Renderer::new`.
#[test]
fn settings_and_tuning_out_of_range_are_refused_by_name() {
    let scene = load("cornell-box");
    let plain = Settings { width: 8, height: 8, spp: 1, ..Settings::for_scene(&scene) };
    type Change = fn(&mut Settings, &mut Tuning);
    let changes: [(&str, Change); 21] = [
        ("tile", |_, tuning| tuning.tile = Some([0, 0])),
        ("tile", |_, tuning| tuning.tile = Some([65536, 65536])),
        ("slice_pixels", |_, tuning| tuning.slice_pixels = Some(0)),
        ("budget", |_, tuning| tuning.budget = Some(0)),
        ("budget", |_, tuning| tuning.budget = Some(u32::MAX)),
        ("run_samples", |_, tuning| tuning.run_samples = Some(0)),
        ("run_samples", |_, tuning| tuning.run_samples = Some(17)),
        ("refill_eighths", |_, tuning| tuning.refill_eighths = Some(9)),
        ("leave_eighths", |_, tuning| tuning.leave_eighths = Some(9)),
        ("tests_a_visit", |_, tuning| tuning.tests_a_visit = Some(3)),
        ("without_effect", |_, tuning| tuning.without_effect = Some(EFFECTS)),
        ("with_effect", |_, tuning| tuning.with_effect = Some(u32::MAX)),
        ("max_bounces", |settings, _| settings.max_bounces = 0),
        ("max_bounces", |settings, _| settings.max_bounces = u32::MAX),
        ("spp", |settings, _| settings.spp = 0),
        ("replicates", |settings, _| settings.replicates = Some(0)),
        ("replicates", |settings, _| settings.replicates = Some(257)),
        ("width", |settings, _| settings.width = 0),
        ("height", |settings, _| settings.height = 16385),
        ("crop", |settings, _| settings.crop = Some([100, 100, 8, 8])),
        ("roulette", |settings, _| settings.roulette = Roulette::Fixed(f32::NAN)),
    ];
    for (name, change) in changes {
        let (mut settings, mut tuning) = (plain.clone(), Tuning::default());
        change(&mut settings, &mut tuning);
        let error = Renderer::new(context(), &scene, &settings, &tuning).err();
        let error = error.unwrap_or_else(|| panic!("{name}: {settings:?} {tuning:?} made a renderer"));
        assert!(matches!(&error, Error::Usage(said) if said.contains(name)), "{name}: {error}");
        if tuning == Tuning::default() {
            let error = cap_bias(context(), &scene, &settings, None, &mut Silent).expect_err(name);
            assert!(matches!(&error, Error::Usage(said) if said.contains(name)), "{name}: {error}");
        }
    }
    let rules = StopRules { target: Some(Target { error: f64::NAN, confidence: 0.95 }), ..StopRules::default() };
    let renderer = Renderer::new(context(), &scene, &plain, &Tuning::default()).expect("a renderer");
    assert!(matches!(renderer.stop_by(rules).render(&mut Silent), Err(Error::Usage(_))));
    assert_valid(context());
}

#[test]
fn a_scene_made_by_hand_may_lack_what_its_triangles_name() {
    let whole = load("teapot");
    let settings = Settings { width: 8, height: 8, spp: 1, ..Settings::for_scene(&whole) };
    let refused = |change: fn(&mut texray::scene::Scene)| {
        let mut scene = whole.clone();
        change(&mut scene);
        let settings = Settings { allow_black: true, ..settings.clone() };
        let data = texray::texels::TexelData::pack(&scene, &texray::bvh::Accel::brute(), &settings);
        assert!(matches!(data, Err(Error::Internal(_))), "a triangle that names nothing");
        assert!(Effects::of(&scene, &settings).names().len() <= EFFECTS as usize);
    };
    refused(|scene| scene.triangles[3].material = u32::MAX);
    refused(|scene| scene.corners.truncate(1));
}

#[test]
fn numbers_without_a_scene_are_no_panic() {
    for (width, height) in [(0, 0), (0, 7), (7, 0), (u32::MAX, u32::MAX)] {
        let mut pass = Pass::over(Tile { x: 0, y: 0, width, height });
        let slice = pass.next_slice(u32::MAX);
        assert_eq!(slice.is_some(), height > 0);
        if let Some(Slice::Rows { first, count }) = slice {
            assert!(first == 0 && count >= 1 && count <= height);
        }
        pass.note(u32::MAX);
        pass.note(u32::MAX);
        assert!(pass.leave_eighths(8) <= 8);
        assert!(Film::new(width, height, 4, i32::MAX).is_err());
    }
    for replicates in [0, 257, u32::MAX] {
        assert!(Film::new(4, 4, replicates, 0).is_err());
    }
    assert!(!Effects::of(&load("cornell-box"), &Settings::for_scene(&load("cornell-box"))).is_on(u32::MAX));
    assert!(context().device_info().check_workgroup([u32::MAX; 3]).is_err());
}
