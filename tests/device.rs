//! The GPU layer on a real device, under validation: transfers byte for byte, the ledger, limits, lifetimes.
//!
//! A missing driver or validation layer fails these tests and says what to install. Contexts share nothing, so tests run
//! side by side; each that counts messages has a context of its own.

use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use texray::gpu::{
    Barrier, BindGroup, Buffer, BufferUse, ComputePipeline, Context, ContextOptions, DeviceChoice, Direction, Ledger,
    Memory, PipelineDesc, Readback, Recorder, Resource, TexelBuffer, Uploader, canary, list_devices, shaders,
};
use texray::{Error, interface};

fn context() -> Context {
    let options = ContextOptions { device: DeviceChoice::Auto, validation: true };
    Context::new(&options).unwrap_or_else(|error| panic!("{error}\nRun ./setup.sh to install what is missing."))
}

fn assert_clean(context: &Context) {
    let report = context.validation();
    assert!(report.is_clean(), "{report:#?}");
}

fn echo_pipeline(context: &Context) -> Arc<ComputePipeline> {
    let desc = PipelineDesc { name: "probe_echo", module: shaders::PROBE_ECHO, specialization: &[] };
    ComputePipeline::new(context, &desc).unwrap()
}

/// A texel buffer, a storage buffer as large, and the bind group that echoes the one into the other.
struct Echo {
    texels: Arc<TexelBuffer>,
    output: Arc<Buffer>,
    pipeline: Arc<ComputePipeline>,
    bindings: Arc<BindGroup>,
}

impl Echo {
    fn new(context: &Context, bytes: u64) -> Echo {
        let texels = TexelBuffer::new(context, "echo input", bytes).unwrap();
        let storage = BufferUse { texel: false, storage: true };
        let output = Buffer::new(context, "echo output", bytes, storage, Memory::Device).unwrap();
        let pipeline = echo_pipeline(context);
        let resources = [
            (interface::BINDING_PROBE_INPUT, Resource::Texel(texels.clone())),
            (interface::BINDING_PROBE_OUTPUT, Resource::Storage(output.clone())),
        ];
        let bindings = BindGroup::new(&pipeline, &resources).unwrap();
        Echo { texels, output, pipeline, bindings }
    }

    fn dispatch(&self, recorder: &mut Recorder) {
        let texels = (self.texels.buffer().size_bytes() / 16) as u32;
        recorder.dispatch(&self.pipeline, &self.bindings, &texels.to_ne_bytes(), [texels.div_ceil(64), 1, 1]).unwrap();
    }
}

/// Bytes of no pattern that a lost or doubled chunk could keep.
fn bytes(count: usize) -> Vec<u8> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn texels_come_back_byte_for_byte_and_every_byte_is_in_the_ledger() {
    let context = context();
    // Three chunks of the 4 MiB ring, the last one not full; fewer where a texel buffer does not hold as much.
    const CHUNK: u64 = 4 << 20;
    let most = 16 * context.device_info().max_texel_buffer_elements;
    let sent = bytes((2 * CHUNK + (1 << 20) + 48).min(most) as usize);
    let size = sent.len() as u64;
    let echo = Echo::new(&context, size);
    let mut ledger = Ledger::default();
    let mut uploader = Uploader::new(&context).unwrap();
    uploader.upload(&mut ledger, echo.texels.buffer(), 0, &sent, "the bytes to echo").unwrap();
    uploader.finish().unwrap();

    let mut back = Readback::new(&context, "echo back", size).unwrap();
    let mut recorder = Recorder::new(&context, "echo").unwrap();
    echo.dispatch(&mut recorder);
    // In two parts, to prove the offsets.
    let half = size / 32 * 16;
    back.copy_from(&mut recorder, &mut ledger, &echo.output, 0, 0, half, "compare").unwrap();
    back.copy_from(&mut recorder, &mut ledger, &echo.output, half, half, size - half, "compare").unwrap();
    assert!(back.bytes().is_err(), "bytes may not be read before the work that writes them has ended");
    let in_flight = recorder.submit().unwrap();
    assert!(back.bytes().is_err(), "bytes may not be read before the wait");
    let time = in_flight.wait().unwrap();
    assert!(time > Duration::ZERO);
    assert!(back.bytes().unwrap() == sent, "the bytes differ");

    ledger.absent("corners", "no triangle is smooth");
    assert_eq!((ledger.bytes_up(), ledger.bytes_down()), (size, size));
    assert_eq!(context.copied_bytes(), (size, size));
    let entries = ledger.entries();
    let copies: Vec<_> = entries.iter().map(|entry| (entry.direction, entry.copies)).collect();
    let chunks = size.div_ceil(CHUNK) as u32;
    assert_eq!(copies, [(Direction::Up, chunks), (Direction::Down, 2), (Direction::Absent, 0)]);
    if context.device_info().timestamp_valid_bits > 0 {
        assert!(entries[0].milliseconds > 0.0 && entries[1].milliseconds > 0.0, "{entries:#?}");
    }
    assert!(context.device_bytes_peak() >= 2 * size);
    println!("{}\n{}", context.device_info().summary(), ledger.table());
    assert_clean(&context);
}

#[test]
fn a_small_ring_an_offset_and_reuse_change_nothing() {
    let context = context();
    let sent = bytes(1000 * 16);
    let echo = Echo::new(&context, sent.len() as u64);
    let mut ledger = Ledger::default();
    let mut uploader = Uploader::with_ring(&context, 3, 100).unwrap();
    let (first, second) = sent.split_at(333 * 16);
    let mut back = [0, 1].map(|index| Readback::new(&context, &format!("back {index}"), sent.len() as u64).unwrap());
    for round in 0..4 {
        uploader.upload(&mut ledger, echo.texels.buffer(), first.len() as u64, second, "second part").unwrap();
        uploader.upload(&mut ledger, echo.texels.buffer(), 0, first, "first part").unwrap();
        // No wait between upload and dispatch: the barriers alone order them.
        let mut recorder = Recorder::new(&context, "echo").unwrap();
        recorder.fill(&echo.output, 0, echo.output.size_bytes(), 0xdead_beef).unwrap();
        recorder.barrier(Barrier::TransferToCompute).unwrap();
        echo.dispatch(&mut recorder);
        let readback = &mut back[round % 2];
        let bytes = sent.len() as u64;
        readback.copy_from(&mut recorder, &mut ledger, &echo.output, 0, 0, bytes, "compare").unwrap();
        recorder.submit().unwrap().wait().unwrap();
        assert!(readback.bytes().unwrap() == sent, "round {round}");
    }
    drop(uploader);
    assert_eq!(context.copied_bytes(), (ledger.bytes_up(), ledger.bytes_down()));
    assert_eq!(ledger.bytes_up(), 4 * sent.len() as u64);
    assert_clean(&context);
}

#[test]
fn copies_within_device_memory_are_not_transfers() {
    let context = context();
    let make = |name: &str| Buffer::new(&context, name, 64, BufferUse::default(), Memory::Device).unwrap();
    let (a, b) = (make("a"), make("b"));
    let mut ledger = Ledger::default();
    let mut back = Readback::new(&context, "back", 64).unwrap();
    let mut recorder = Recorder::new(&context, "fill and copy").unwrap();
    recorder.fill(&a, 0, 64, 0x0403_0201).unwrap();
    recorder.barrier(Barrier::TransferToTransfer).unwrap();
    recorder.copy(&a, 0, &b, 32, 32).unwrap();
    recorder.fill(&b, 0, 32, 0).unwrap();
    recorder.barrier(Barrier::TransferToTransfer).unwrap();
    back.copy_from(&mut recorder, &mut ledger, &b, 0, 0, 64, "compare").unwrap();
    recorder.submit().unwrap().wait().unwrap();
    assert_eq!(back.bytes().unwrap(), [[0; 32], 0x0403_0201u32.to_le_bytes().repeat(8).try_into().unwrap()].concat());
    assert_eq!(context.copied_bytes(), (0, 64));
    assert_clean(&context);
}

#[test]
fn dropping_a_recorder_or_work_in_flight_is_safe() {
    let context = context();
    let echo = Echo::new(&context, 1 << 20);
    let mut ledger = Ledger::default();
    let mut back = Readback::new(&context, "back", 1 << 20).unwrap();
    let mut recorder = Recorder::new(&context, "never submitted").unwrap();
    echo.dispatch(&mut recorder);
    back.copy_from(&mut recorder, &mut ledger, &echo.output, 0, 0, 1 << 20, "nothing").unwrap();
    drop(recorder);
    assert!(back.bytes().unwrap().iter().all(|&byte| byte == 0), "nothing was copied");

    // The guard holds the last reference to all that the work uses.
    let mut recorder = Recorder::new(&context, "dropped").unwrap();
    echo.dispatch(&mut recorder);
    let in_flight = recorder.submit().unwrap();
    drop(echo);
    drop(in_flight);
    assert_clean(&context);
}

#[test]
fn the_canary_is_heard_once_for_core_and_once_for_synchronisation() {
    let context = context();
    assert_clean(&context);
    canary::provoke(&context).unwrap();
    let report = context.validation();
    let count = |text: &str| report.messages.iter().filter(|message| message.contains(text)).count();
    assert_eq!(count("VUID-VkBufferCreateInfo-usage"), 1, "{report:#?}");
    assert_eq!(count("SYNC-HAZARD-WRITE-AFTER-WRITE"), 1, "{report:#?}");
    assert_eq!((report.errors, report.warnings), (2, 0), "{report:#?}");

    let quiet = Context::new(&ContextOptions::default()).unwrap();
    assert!(matches!(canary::provoke(&quiet), Err(Error::Internal(_))));
}

#[test]
fn limits_are_refused_by_name() {
    let context = context();
    let info = context.device_info().clone();
    let refused = |result: Result<(), Error>, name: &str, limit: &str| match result {
        Err(Error::Limit { what, need, have }) => {
            assert!(what.contains(name) && what.contains(limit), "{what}: {need} needed, {have} available");
        }
        other => panic!("{limit}: {other:?}"),
    };
    let texels = info.max_texel_buffer_elements + 1;
    refused(TexelBuffer::new(&context, "nodes", texels * 16).map(drop), "nodes", "maxTexelBufferElements");
    let storage = BufferUse { texel: false, storage: true };
    let too_long = Buffer::new(&context, "paths", info.max_storage_buffer_range + 1, storage, Memory::Device);
    refused(too_long.map(drop), "paths", "maxStorageBufferRange");
    let plain = BufferUse::default();
    for bytes in [info.max_memory_allocation_size + 1, u64::MAX] {
        let too_large = Buffer::new(&context, "film", bytes, plain, Memory::Device);
        refused(too_large.map(drop), "film", "maxMemoryAllocationSize");
    }
    // The heap: held buffers count.
    let mut held = Vec::new();
    let half = info.device_heap_bytes() / 2;
    if half < info.max_memory_allocation_size && half <= 2 << 30 {
        held.push(Buffer::new(&context, "first half", half, plain, Memory::Device).unwrap());
        let second = Buffer::new(&context, "second half", half + 16, plain, Memory::Device);
        refused(second.map(drop), "second half", "heap");
    }
    drop(held);
    assert_eq!(context.device_bytes(), 0);

    let specialization =
        [(interface::SPEC_WORKGROUP_X, info.max_compute_work_group_size[0] + 1), (interface::SPEC_WORKGROUP_Y, 1)];
    let desc = PipelineDesc { name: "wide", module: shaders::PATH_TRACE, specialization: &specialization };
    refused(ComputePipeline::new(&context, &desc).map(drop), "workgroup", "maxComputeWorkGroupSize");
    refused(info.check_workgroup([u32::MAX, 1, 1]), "workgroup", "maxComputeWorkGroupSize");
    let [x, y, z] = info.max_compute_work_group_size;
    if u64::from(x) * u64::from(y) * u64::from(z) > u64::from(info.max_compute_work_group_invocations) {
        refused(info.check_workgroup([x, y, z]), "workgroup", "maxComputeWorkGroupInvocations");
    }
    assert!(info.check_workgroup([8, 8, 1]).is_ok());
    assert_clean(&context);
}

#[test]
fn misuse_is_an_error_before_it_reaches_the_device() {
    let context = context();
    let echo = Echo::new(&context, 64);
    let internal = |result: Result<(), Error>| assert!(matches!(result, Err(Error::Internal(_))), "{result:?}");
    let staging = Buffer::new(&context, "staging", 64, BufferUse::default(), Memory::Upload).unwrap();
    let mut recorder = Recorder::new(&context, "misuse").unwrap();
    internal(recorder.dispatch(&echo.pipeline, &echo.bindings, &[], [1, 1, 1]));
    internal(recorder.copy(&staging, 0, &echo.output, 0, 64));
    internal(recorder.fill(&staging, 0, 64, 0));
    internal(recorder.fill(&echo.output, 2, 4, 0));
    internal(recorder.fill(&echo.output, 32, 48, 0));
    internal(recorder.copy(&echo.output, 0, &echo.output, 0, 16));
    internal(recorder.copy(&echo.output, u64::MAX, echo.texels.buffer(), 0, 16));
    let half = [(interface::BINDING_PROBE_INPUT, Resource::Texel(echo.texels.clone()))];
    internal(BindGroup::new(&echo.pipeline, &half).map(drop));
    let swapped = [
        (interface::BINDING_PROBE_INPUT, Resource::Storage(echo.output.clone())),
        (interface::BINDING_PROBE_OUTPUT, Resource::Texel(echo.texels.clone())),
    ];
    internal(BindGroup::new(&echo.pipeline, &swapped).map(drop));
    let other = self::context();
    let mut foreign = Recorder::new(&other, "foreign").unwrap();
    internal(foreign.fill(&echo.output, 0, 64, 0));
    assert_clean(&context);
    assert_clean(&other);
}

#[test]
fn destruction_leaves_no_message() {
    let context = context();
    let watch = context.validation_watch();
    let echo = Echo::new(&context, 1 << 16);
    let mut uploader = Uploader::new(&context).unwrap();
    uploader.upload(&mut Ledger::default(), echo.texels.buffer(), 0, &bytes(1 << 16), "echo").unwrap();
    // The context goes first: what was made of it keeps the device alive.
    drop(context);
    drop(echo);
    drop(uploader);
    let report = watch.report();
    assert!(report.is_clean(), "{report:#?}");
}

#[test]
fn a_leak_is_reported_when_the_device_goes() {
    let context = context();
    let watch = context.validation_watch();
    canary::leak(&context).unwrap();
    assert!(watch.report().is_clean(), "{:#?}", watch.report());
    drop(context);
    let report = watch.report();
    let count = |text: &str| report.messages.iter().filter(|message| message.contains(text)).count();
    assert_eq!(count("leak: `canary memory`"), 1, "{report:#?}");
    assert_eq!(count("VUID-vkDestroyDevice-device"), 1, "{report:#?}");
    assert_eq!((report.errors, report.warnings), (2, 0), "{report:#?}");
}

#[test]
fn a_forgotten_buffer_keeps_its_device_alive() {
    let context = context();
    let watch = context.validation_watch();
    let buffer = Buffer::new(&context, "forgotten", 64, BufferUse::default(), Memory::Device).unwrap();
    std::mem::forget(buffer);
    assert!(context.device_bytes() >= 64);
    drop(context);
    // Had the device been destroyed under the buffer, the layers would say so.
    assert!(watch.report().is_clean(), "{:#?}", watch.report());
}

#[test]
fn devices_are_listed_and_chosen() {
    let devices = list_devices().unwrap();
    let context = context();
    let info = context.device_info();
    assert_eq!(&devices[info.index], info, "a device is described the same with and without validation");
    assert!(!info.name.is_empty() && !info.driver.is_empty() && info.lacks.is_none());
    assert!(info.device_heap_bytes() > 0 && info.robust_buffer_access);
    let choose = |device| Context::new(&ContextOptions { device, validation: false });
    assert_eq!(choose(DeviceChoice::Index(info.index)).unwrap().device_info().name, info.name);
    assert!(matches!(choose(DeviceChoice::Index(devices.len())), Err(Error::Usage(_))));
    assert!(matches!(choose(DeviceChoice::Name("no such device".to_string())), Err(Error::Usage(_))));
}

/// Set in the child of the test below.
const CHILD: &str = "TEXRAY_TEST_NO_DRIVER";

#[test]
fn without_a_driver_or_layer_the_error_says_what_to_install() {
    if std::env::var_os(CHILD).is_some() {
        let validated = ContextOptions { validation: true, ..ContextOptions::default() };
        let error = Context::new(&validated).unwrap_err();
        assert!(matches!(&error, Error::NoDevice(text) if text.contains("vulkan-validationlayers")), "{error}");
        for error in [Context::new(&ContextOptions::default()).unwrap_err(), list_devices().unwrap_err()] {
            for words in ["VK_DRIVER_FILES=/dev/null", "mesa-vulkan-drivers"] {
                assert!(matches!(&error, Error::NoDevice(text) if text.contains(words)), "{error}");
            }
        }
        return;
    }
    // The loader reads its environment once a process, so the case without drivers and layers needs a process of its own.
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "without_a_driver_or_layer_the_error_says_what_to_install", "--nocapture"])
        .env(CHILD, "1")
        .env("VK_DRIVER_FILES", "/dev/null")
        // The same under the older name, for loaders before 1.3.207.
        .env("VK_ICD_FILENAMES", "/dev/null")
        .env("VK_LAYER_PATH", "/dev/null")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
}
