//! The logical device: features switched on, its one queue, its memory allocator.
//!
//! Comes in: an instance and the chosen physical device. Goes out: a [`Device`] that every object keeps alive. When it
//! is dropped nothing made from it is left; memory that is, is a leak and goes to the message log.
//!
//! There is one queue, of one family. Submitted work begins in order, buffers never change their owner (a queue-family
//! ownership transfer needs two families), and barriers between the commands are all the synchronisation there is.

use std::ffi::{CStr, c_char};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::device_info::DeviceInfo;
use super::driver_threads;
use super::failure::failed;
use super::instance::{Instance, lifecycle};
use crate::{Error, Result};

/// Not in the Vulkan 1.1 headers' stable part, so ash keeps the name behind a feature of its own.
const PORTABILITY_SUBSET: &CStr = c"VK_KHR_portability_subset";

/// Size of the blocks that small buffers of the device share, and of those that the host reaches.
pub(super) const DEVICE_BLOCK_BYTES: u64 = 64 << 20;
const HOST_BLOCK_BYTES: u64 = 16 << 20;

/// The logical device.
pub(super) struct Device {
    raw: ash::Device,
    /// Identity and limits.
    pub(super) info: DeviceInfo,
    /// Memory types of the device, by index.
    pub(super) memory_types: Vec<vk::MemoryType>,
    /// Names objects, where VK_EXT_debug_utils is on.
    pub(super) debug_utils: Option<ext::debug_utils::Device>,
    queue: Mutex<vk::Queue>,
    memory: Mutex<MemoryState>,
    /// How long a wait for submitted work may take; `None`: as long as it takes.
    wait_limit: Mutex<Option<Duration>>,
    /// Bytes that copy commands were recorded to take from upload buffers and into readback buffers.
    copied_up: AtomicU64,
    copied_down: AtomicU64,
    /// Last: the instance outlives the device.
    pub(super) instance: Arc<Instance>,
}

/// The allocator and what it has given out.
pub(super) struct MemoryState {
    /// There from construction until `Drop`.
    pub(super) allocator: Option<Allocator>,
    /// Bytes given out, by heap.
    pub(super) heap_bytes: Vec<u64>,
    /// The most bytes of device-local heaps that were given out at once.
    pub(super) device_bytes_peak: u64,
}

impl Device {
    /// Makes the device of `physical`, which `info` describes.
    pub(super) fn new(instance: Arc<Instance>, physical: vk::PhysicalDevice, info: DeviceInfo) -> Result<Arc<Device>> {
        driver_threads::check(&info)?;
        // SAFETY: `physical` is a device of this instance; the calls change nothing.
        let (offered, memory) = unsafe {
            (
                instance
                    .raw()
                    .enumerate_device_extension_properties(physical)
                    .map_err(failed("vkEnumerateDeviceExtensionProperties"))?,
                instance.raw().get_physical_device_memory_properties(physical),
            )
        };
        let is_offered = |name: &CStr| offered.iter().any(|found| found.extension_name_as_c_str() == Ok(name));
        let mut extensions: Vec<*const c_char> = Vec::new();
        for wanted in [
            // For a module that asks to keep signed zeros, infinities and NaN.
            khr::shader_float_controls::NAME,
            // Reads out of range give zeros instead of any bytes of the buffer.
            ext::robustness2::NAME,
            // A device that lists it (MoltenVK) requires that it be switched on.
            PORTABILITY_SUBSET,
        ] {
            if is_offered(wanted) {
                extensions.push(wanted.as_ptr());
            }
        }
        let features = vk::PhysicalDeviceFeatures::default()
            // An index out of range must not reach memory of other programs, or lose the device; free on lavapipe.
            .robust_buffer_access(true)
            .shader_float64(info.shader_float64);
        let mut robustness2 = vk::PhysicalDeviceRobustness2FeaturesEXT::default().robust_buffer_access2(true);
        let priorities = [1.0];
        let queues =
            [vk::DeviceQueueCreateInfo::default().queue_family_index(info.queue_family).queue_priorities(&priorities)];
        let mut create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features);
        if info.robust_buffer_access2 {
            create = create.push_next(&mut robustness2);
        }
        let created = {
            let _lifecycle = lifecycle();
            // SAFETY: extensions and features were offered by this device; the family has at least one queue, and the
            // arrays live until the call returns. The instance outlives the device, which holds an `Arc` of it.
            unsafe { instance.raw().create_device(physical, &create, None) }
        };
        let raw = created.map_err(failed(format!("vkCreateDevice on {}", info.name)))?;
        // SAFETY: the family and index are the ones that the device was made with.
        let queue = unsafe { raw.get_device_queue(info.queue_family, 0) };
        let debug_utils = instance.names_objects.then(|| ext::debug_utils::Device::new(instance.raw(), &raw));
        let memory_state = MemoryState { allocator: None, heap_bytes: vec![0; info.heaps.len()], device_bytes_peak: 0 };
        // From here on the device is owned: an error below destroys it.
        let device = Device {
            raw,
            memory_types: memory.memory_types_as_slice().to_vec(),
            debug_utils,
            queue: Mutex::new(queue),
            memory: Mutex::new(memory_state),
            wait_limit: Mutex::new(None),
            copied_up: AtomicU64::new(0),
            copied_down: AtomicU64::new(0),
            info,
            instance,
        };
        let mut debug_settings = AllocatorDebugSettings::default();
        debug_settings.log_leaks_on_shutdown = false; // `Drop` below reports them where they are counted.
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance.raw().clone(),
            device: device.raw.clone(),
            physical_device: physical,
            debug_settings,
            // Shaders get descriptors, not addresses: addresses were 3 to 4 times slower on lavapipe.
            buffer_device_address: false,
            // Small buffers share blocks of these sizes; a larger buffer gets an allocation of its own.
            allocation_sizes: AllocationSizes::new(DEVICE_BLOCK_BYTES, HOST_BLOCK_BYTES),
        })
        .map_err(|error| Error::Internal(format!("the memory allocator cannot be made: {error}")))?;
        device.memory().allocator = Some(allocator);
        // SAFETY: device and queue are alive, and no other thread knows them yet.
        unsafe {
            device.name(device.raw.handle(), "texray device");
            device.name(queue, "compute queue");
        }
        Ok(Arc::new(device))
    }

    /// The device's functions.
    pub(super) fn raw(&self) -> &ash::Device {
        &self.raw
    }

    /// The queue. Vulkan asks that a queue be used by one thread at a time: hold the guard during the call.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The allocator and its counters.
    pub(super) fn memory(&self) -> MutexGuard<'_, MemoryState> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How long a wait may take.
    pub(super) fn wait_limit(&self) -> Option<Duration> {
        *self.wait_limit.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bounds the waits from now on; the bound before.
    pub(super) fn limit_waits(&self, limit: Option<Duration>) -> Option<Duration> {
        std::mem::replace(&mut *self.wait_limit.lock().unwrap_or_else(PoisonError::into_inner), limit)
    }

    /// Counts a recorded copy out of an upload buffer.
    pub(super) fn count_up(&self, bytes: u64) {
        self.copied_up.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Counts a recorded copy into a readback buffer.
    pub(super) fn count_down(&self, bytes: u64) {
        self.copied_down.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Bytes counted so far, up and down.
    pub(super) fn copied_bytes(&self) -> (u64, u64) {
        (self.copied_up.load(Ordering::Relaxed), self.copied_down.load(Ordering::Relaxed))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let allocator = self.memory().allocator.take();
        if let Some(allocator) = allocator {
            let leaked = allocator.generate_report();
            for allocation in &leaked.allocations {
                let text = format!("leak: `{}` still has {} bytes of memory", allocation.name, allocation.size);
                self.instance.log.error(&text);
            }
            // The allocator frees its memory blocks through the device, so it goes before the device.
            drop(allocator);
        }
        let _lifecycle = lifecycle();
        // SAFETY: every object holds an `Arc` of this device, so none is left; work in flight was waited for by the
        // guard that held those objects; `&mut self` makes this the only use.
        unsafe { self.raw.destroy_device(None) }
    }
}
