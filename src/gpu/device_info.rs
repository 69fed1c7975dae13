//! What a physical device is and can do, as far as texray asks.
//!
//! Comes in: a physical device. Goes out: [`DeviceInfo`], plain values that need no live instance. All queries are core
//! in Vulkan 1.1, or are made only where the device lists the extension that they belong to.

use std::ffi::CStr;

use ash::{ext, khr, vk};
use serde::Serialize;

use super::failure::failed;
use super::instance::Instance;
use crate::{Error, Result};

/// Kind of a device, in the order in which [`DeviceChoice::Auto`](super::DeviceChoice::Auto) prefers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DeviceKind {
    /// A graphics card with memory of its own.
    Discrete,
    /// Part of the processor, sharing its memory.
    Integrated,
    /// A device passed through to a virtual machine.
    Virtual,
    /// The processor itself (lavapipe, SwiftShader).
    Cpu,
    /// None of these.
    Other,
}

/// One memory heap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct HeapInfo {
    /// Its size in bytes.
    pub bytes: u64,
    /// Whether it is the device's own memory.
    pub device_local: bool,
}

/// A device: identity, limits, features.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviceInfo {
    /// Position in the order of `texray devices`, from 0.
    pub index: usize,
    /// Name that the driver gives it.
    pub name: String,
    /// Driver name and version, as text.
    pub driver: String,
    /// Vulkan version of the device, as text.
    pub api_version: String,
    /// Kind of device.
    pub kind: DeviceKind,
    /// What it lacks to be usable here, with have and need; `None` for a usable device.
    pub lacks: Option<String>,
    /// Queue family with compute that is used.
    pub queue_family: u32,
    /// Largest number of texels in a texel buffer.
    pub max_texel_buffer_elements: u64,
    /// Largest storage-buffer binding in bytes.
    pub max_storage_buffer_range: u64,
    /// Largest single memory allocation in bytes.
    pub max_memory_allocation_size: u64,
    /// Largest number of workgroups in a dispatch, by dimension.
    pub max_compute_work_group_count: [u32; 3],
    /// Largest number of invocations in a workgroup.
    pub max_compute_work_group_invocations: u32,
    /// Largest workgroup, by dimension.
    pub max_compute_work_group_size: [u32; 3],
    /// Push-constant bytes.
    pub max_push_constants_bytes: u32,
    /// Storage buffers that a stage may have.
    pub max_per_stage_storage_buffers: u32,
    /// Sampled images that a stage may have; uniform texel buffers count as such.
    pub max_per_stage_sampled_images: u32,
    /// Resources of all kinds that a stage may have.
    pub max_per_stage_resources: u32,
    /// Alignment of a storage-buffer binding's offset, in bytes.
    pub min_storage_buffer_offset_alignment: u64,
    /// Nanoseconds of a timestamp's tick.
    pub timestamp_period_ns: f32,
    /// Meaningful bits of a timestamp; 0: the queue has no timestamps.
    pub timestamp_valid_bits: u32,
    /// Invocations in a subgroup.
    pub subgroup_size: u32,
    /// Whether compute shaders may vote (`subgroupAny`, `subgroupAll`).
    pub subgroup_vote: bool,
    /// Whether compute shaders may ballot (`subgroupBallot`).
    pub subgroup_ballot: bool,
    /// Memory heaps.
    pub heaps: Vec<HeapInfo>,
    /// Whether shaders may use 64-bit floats (switched on where offered).
    pub shader_float64: bool,
    /// Out-of-range buffer accesses stay inside the buffer. Every device has it; it is switched on.
    pub robust_buffer_access: bool,
    /// Out-of-range buffer reads give zeros (switched on where offered).
    pub robust_buffer_access2: bool,
    /// Whether a shader may ask that signed zeros, infinities and NaN be kept for 32-bit floats.
    pub shader_signed_zero_inf_nan_preserve_float32: bool,
}

impl DeviceInfo {
    /// Bytes of the largest device-local heap.
    pub fn device_heap_bytes(&self) -> u64 {
        self.heaps.iter().filter(|heap| heap.device_local).map(|heap| heap.bytes).max().unwrap_or(0)
    }

    /// Refuses a workgroup of `size` that the device cannot run, naming the limit.
    pub fn check_workgroup(&self, size: [u32; 3]) -> Result<()> {
        let invocations = size.iter().map(|&side| u128::from(side)).product::<u128>();
        let limit = |limit: &str, need: String, have: String| {
            Err(Error::Limit { what: format!("workgroup of {size:?} ({limit})"), need, have })
        };
        if size.contains(&0) {
            return limit("sides", format!("{size:?}"), "at least 1 each".to_string());
        }
        if size.iter().zip(self.max_compute_work_group_size).any(|(&side, most)| side > most) {
            let have = format!("{:?}", self.max_compute_work_group_size);
            return limit("maxComputeWorkGroupSize", format!("{size:?}"), have);
        }
        if invocations > u128::from(self.max_compute_work_group_invocations) {
            let have = self.max_compute_work_group_invocations.to_string();
            return limit("maxComputeWorkGroupInvocations", invocations.to_string(), have);
        }
        Ok(())
    }

    /// One line: index, name, kind, driver.
    pub fn summary(&self) -> String {
        let kind = format!("{:?}", self.kind).to_lowercase();
        format!("{}: {} ({kind}; {})", self.index, self.name, self.driver)
    }

    /// Asks the device. `index` is its place in the loader's order.
    pub(super) fn query(instance: &Instance, physical: vk::PhysicalDevice, index: usize) -> Result<DeviceInfo> {
        let raw = instance.raw();
        // SAFETY: `physical` is one of this instance's devices; the call changes nothing.
        let offered = unsafe { raw.enumerate_device_extension_properties(physical) }
            .map_err(failed("vkEnumerateDeviceExtensionProperties"))?;
        let is_offered = |name: &CStr| offered.iter().any(|found| found.extension_name_as_c_str() == Ok(name));
        let has_driver = is_offered(khr::driver_properties::NAME);
        let has_float_controls = is_offered(khr::shader_float_controls::NAME);
        let has_robustness2 = is_offered(ext::robustness2::NAME);

        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut float_controls = vk::PhysicalDeviceFloatControlsProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut maintenance3 = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut properties =
            vk::PhysicalDeviceProperties2::default().push_next(&mut subgroup).push_next(&mut maintenance3);
        if has_driver {
            properties = properties.push_next(&mut driver);
        }
        if has_float_controls {
            properties = properties.push_next(&mut float_controls);
        }
        let mut robustness2 = vk::PhysicalDeviceRobustness2FeaturesEXT::default();
        let mut features = vk::PhysicalDeviceFeatures2::default();
        if has_robustness2 {
            features = features.push_next(&mut robustness2);
        }
        // The loader passes the Vulkan 1.1 queries on to 1.0 devices too (it emulates them), so they may be asked first
        // and judged afterwards.
        // SAFETY: each chained structure is core in 1.1 or belongs to an extension that the device lists; all of them
        // live until after the calls.
        let (queues, memory) = unsafe {
            raw.get_physical_device_properties2(physical, &mut properties);
            raw.get_physical_device_features2(physical, &mut features);
            (
                raw.get_physical_device_queue_family_properties(physical),
                raw.get_physical_device_memory_properties(physical),
            )
        };
        let vk::PhysicalDeviceProperties2 { properties, .. } = properties;
        let features = features.features;
        let limits = properties.limits;

        // The first family with compute, one with timestamps before one without. On desktop cards that is the universal
        // family; a family for compute alone would gain nothing, since this program keeps only one kind of work.
        let compute = |family: &&vk::QueueFamilyProperties| family.queue_flags.contains(vk::QueueFlags::COMPUTE);
        let timed = queues.iter().position(|family| compute(&family) && family.timestamp_valid_bits > 0);
        let family = timed.or_else(|| queues.iter().position(|family| compute(&family)));
        let lacks = if properties.api_version < vk::API_VERSION_1_1 {
            Some(format!("Vulkan 1.1 needed, {} offered", version(properties.api_version)))
        } else if family.is_none() {
            Some("a queue with compute needed, none offered".to_string())
        } else {
            None
        };
        let in_compute = |operation: vk::SubgroupFeatureFlags| {
            subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
                && subgroup.supported_operations.contains(operation)
        };
        Ok(DeviceInfo {
            index,
            name: text(properties.device_name_as_c_str().ok()),
            driver: match has_driver {
                true => {
                    let name = text(driver.driver_name_as_c_str().ok());
                    format!("{name} {}", text(driver.driver_info_as_c_str().ok())).trim_end().to_string()
                }
                // Without the extension there is only a number, whose layout is the vendor's own.
                false => format!("driver version {:#x}", properties.driver_version),
            },
            api_version: version(properties.api_version),
            kind: match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
                _ => DeviceKind::Other,
            },
            lacks,
            queue_family: family.unwrap_or(0) as u32,
            max_texel_buffer_elements: limits.max_texel_buffer_elements.into(),
            max_storage_buffer_range: limits.max_storage_buffer_range.into(),
            max_memory_allocation_size: maintenance3.max_memory_allocation_size,
            max_compute_work_group_count: limits.max_compute_work_group_count,
            max_compute_work_group_invocations: limits.max_compute_work_group_invocations,
            max_compute_work_group_size: limits.max_compute_work_group_size,
            max_push_constants_bytes: limits.max_push_constants_size,
            max_per_stage_storage_buffers: limits
                .max_per_stage_descriptor_storage_buffers
                .min(limits.max_descriptor_set_storage_buffers),
            max_per_stage_sampled_images: limits
                .max_per_stage_descriptor_sampled_images
                .min(limits.max_descriptor_set_sampled_images),
            max_per_stage_resources: limits.max_per_stage_resources,
            min_storage_buffer_offset_alignment: limits.min_storage_buffer_offset_alignment,
            timestamp_period_ns: limits.timestamp_period,
            timestamp_valid_bits: family.map_or(0, |family| queues[family].timestamp_valid_bits),
            subgroup_size: subgroup.subgroup_size,
            subgroup_vote: in_compute(vk::SubgroupFeatureFlags::VOTE),
            subgroup_ballot: in_compute(vk::SubgroupFeatureFlags::BALLOT),
            heaps: memory
                .memory_heaps_as_slice()
                .iter()
                .map(|heap| HeapInfo {
                    bytes: heap.size,
                    device_local: heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL),
                })
                .collect(),
            shader_float64: features.shader_float64 == vk::TRUE,
            robust_buffer_access: features.robust_buffer_access == vk::TRUE,
            robust_buffer_access2: robustness2.robust_buffer_access2 == vk::TRUE,
            shader_signed_zero_inf_nan_preserve_float32: float_controls.shader_signed_zero_inf_nan_preserve_float32
                == vk::TRUE,
        })
    }
}

fn text(name: Option<&CStr>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn version(api: u32) -> String {
    format!("{}.{}.{}", vk::api_version_major(api), vk::api_version_minor(api), vk::api_version_patch(api))
}
