//! The entry to the layer: a device, ready for work.
//!
//! Comes in: which device, and whether to validate. Goes out: a [`Context`], cheap to clone and to share between
//! threads. Contexts share nothing: each has an instance, a device and messages of its own.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::choice::DeviceChoice;
use super::command_slot::CommandSlot;
use super::device::Device;
use super::device_info::DeviceInfo;
use super::instance::Instance;
use super::messages::{ValidationReport, ValidationWatch};
use super::pipeline::{ComputePipeline, PipelineKey};
use crate::Result;
use crate::statistics::Finding;

/// What a context is made with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ContextOptions {
    /// Which device.
    pub device: DeviceChoice,
    /// Whether to switch on the validation layers with synchronisation validation, and to count their messages.
    pub validation: bool,
}

/// A device and what is recycled on it. Clones are the same context.
#[derive(Clone)]
pub struct Context(Arc<Inner>);

struct Inner {
    /// Command slots that no recorder and no work in flight uses.
    free_slots: Mutex<Vec<CommandSlot>>,
    /// Every pipeline that was asked for by its description: some drivers take more than a minute to compile one.
    pipelines: Mutex<HashMap<PipelineKey, Arc<ComputePipeline>>>,
    /// What was found of the device before it was used.
    findings: Mutex<Option<Arc<[Finding]>>>,
    device: Arc<Device>,
}

impl Context {
    /// Makes a context.
    ///
    /// Errors: [`NoDevice`](crate::Error::NoDevice) where loader, driver, device or validation layer is missing, saying
    /// what to install; [`Usage`](crate::Error::Usage) where the choice fits no device or more than one.
    pub fn new(options: &ContextOptions) -> Result<Context> {
        let instance = Instance::new(options.validation)?;
        let physical = instance.physical_devices()?;
        let devices = query_all(&instance, &physical)?;
        let info = options.device.pick(&devices)?.clone();
        let physical = physical[info.index];
        let device = Device::new(instance, physical, info)?;
        Ok(Context(Arc::new(Inner {
            free_slots: Mutex::default(),
            pipelines: Mutex::default(),
            findings: Mutex::default(),
            device,
        })))
    }

    /// Identity and limits of the device.
    pub fn device_info(&self) -> &DeviceInfo {
        &self.0.device.info
    }

    /// Validation messages so far. Without validation always clean.
    pub fn validation(&self) -> ValidationReport {
        self.0.device.instance.log.report()
    }

    /// The same messages, readable after the last clone of this context is gone.
    pub fn validation_watch(&self) -> ValidationWatch {
        ValidationWatch(self.0.device.instance.log.clone())
    }

    /// Bytes copied from host to device and from device to host, as counted at the copy commands themselves. A ledger
    /// must come to the same totals.
    pub fn copied_bytes(&self) -> (u64, u64) {
        self.0.device.copied_bytes()
    }

    /// Bounds how long a wait for submitted work may take, `None`: as long as it takes, which is how a context
    /// begins. A wait that runs out of time fails, and what the work uses is kept for good, since the work may still
    /// run. Returns the bound before.
    pub fn limit_waits(&self, limit: Option<Duration>) -> Option<Duration> {
        self.0.device.limit_waits(limit)
    }

    /// What was found of the device: `ask` is called once, and what it finds is kept for as long as the context lives.
    /// An error is not kept.
    pub(crate) fn findings(&self, ask: impl FnOnce(&Context) -> Result<Vec<Finding>>) -> Result<Arc<[Finding]>> {
        // Held while the device is asked: another thread that wants to know waits for the answer.
        let mut findings = self.0.findings.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(findings) = findings.as_ref() {
            return Ok(findings.clone());
        }
        let found: Arc<[Finding]> = ask(self)?.into();
        *findings = Some(found.clone());
        Ok(found)
    }

    /// Bytes of device-local memory that buffers hold now. (Where host and device share one memory, as on CPUs, staging
    /// and readback buffers are in it too.)
    pub fn device_bytes(&self) -> u64 {
        let heaps = &self.0.device.info.heaps;
        let memory = self.0.device.memory();
        heaps.iter().zip(&memory.heap_bytes).filter(|(heap, _)| heap.device_local).map(|(_, bytes)| bytes).sum()
    }

    /// The most that [`device_bytes`](Context::device_bytes) has been.
    pub fn device_bytes_peak(&self) -> u64 {
        self.0.device.memory().device_bytes_peak
    }

    pub(super) fn device(&self) -> &Arc<Device> {
        &self.0.device
    }

    /// Pipelines by what they are made of, for as long as the context lives.
    pub(super) fn pipelines(&self) -> MutexGuard<'_, HashMap<PipelineKey, Arc<ComputePipeline>>> {
        self.0.pipelines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A command slot: a used one where there is one, else a new one.
    pub(super) fn take_slot(&self) -> Result<CommandSlot> {
        let free = self.0.free_slots.lock().unwrap_or_else(PoisonError::into_inner).pop();
        free.map_or_else(|| CommandSlot::new(&self.0.device), Ok)
    }

    /// Takes back a slot whose work has ended, or was never submitted.
    pub(super) fn return_slot(&self, slot: CommandSlot) {
        self.0.free_slots.lock().unwrap_or_else(PoisonError::into_inner).push(slot);
    }
}

impl fmt::Debug for Context {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Context({})", self.device_info().summary())
    }
}

/// Every device, usable or not, in the order of [`DeviceChoice::Index`]. An error where there is none.
pub fn list_devices() -> Result<Vec<DeviceInfo>> {
    let instance = Instance::new(false)?;
    let devices = query_all(&instance, &instance.physical_devices()?)?;
    // Any choice refuses an empty list in the same words.
    if devices.is_empty() {
        DeviceChoice::Auto.pick(&devices)?;
    }
    Ok(devices)
}

fn query_all(instance: &Instance, physical: &[ash::vk::PhysicalDevice]) -> Result<Vec<DeviceInfo>> {
    physical.iter().enumerate().map(|(index, &physical)| DeviceInfo::query(instance, physical, index)).collect()
}
