//! A compute pipeline: a module of this crate, specialised, with the layout of what it binds.
//!
//! Comes in: a [`PipelineDesc`]. Goes out: a [`ComputePipeline`], or an error that names the device limit in the way.
//! All bindings are in descriptor set 0; push constants begin at byte 0. The layout is read off the module, so it has
//! every binding and every byte of push constants that the module uses.
//!
//! What a caller can choose, and what keeps it from harm:
//! - The module is one of [`shaders`](super::shaders): words of other origin cannot become a [`ShaderModule`].
//! - Specialisation constants may have any value. Workgroups must fit the device, arrays must be of a length that
//!   compilers take; every other constant of the modules is a switch or a number that is compared, and no value of it
//!   leads out of an array.
//! - Push constants and the content of buffers may be anything: reads and writes out of a buffer stay inside it or
//!   are dropped (`robustBufferAccess`), and indices into a shader's own arrays are bounded by the shaders.
//! - Not guarded: how long a dispatch takes. Loops end by the step budget in the push constants, which may be any
//!   number, and a device that is kept too long may be lost (an error, not undefined behaviour).

use std::fmt;
use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::declared::Declared;
use super::device_info::DeviceInfo;
use super::failure::failed;
use super::handle::Handle;
use super::shader_module::ShaderModule;
use super::specialise::specialise;
use crate::{Error, Result};

/// Kind of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BindingKind {
    /// A uniform texel buffer (`utextureBuffer`).
    Texel,
    /// A storage buffer.
    Storage,
}

/// A binding that the shader declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BindingSlot {
    /// Its number in set 0.
    pub number: u32,
    /// Its kind.
    pub kind: BindingKind,
}

/// What a pipeline is made of.
#[derive(Clone, Copy, Debug)]
pub struct PipelineDesc<'a> {
    /// Name in errors and validation messages.
    pub name: &'a str,
    /// The module, one of [`shaders`](super::shaders); its entry point is `main`.
    pub module: ShaderModule,
    /// Specialisation constants, `(id, value)`. Ids that the module lacks are ignored.
    pub specialization: &'a [(u32, u32)],
}

/// What two descriptions of one pipeline have in common: all but the name.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct PipelineKey {
    module: ShaderModule,
    specialization: Vec<(u32, u32)>,
}

impl PipelineKey {
    fn of(desc: &PipelineDesc<'_>) -> PipelineKey {
        PipelineKey { module: desc.module, specialization: desc.specialization.to_vec() }
    }
}

/// A compute pipeline.
pub struct ComputePipeline {
    // Children before parents: the pipeline, its layout, the layout of its set.
    raw: Handle<vk::Pipeline>,
    layout: Handle<vk::PipelineLayout>,
    set_layout: Handle<vk::DescriptorSetLayout>,
    /// In rising order of number.
    bindings: Vec<BindingSlot>,
    push_constant_bytes: u32,
    name: String,
}

impl ComputePipeline {
    /// The pipeline of this description: the one that the context has made before, or a new one, which it keeps.
    pub fn shared(context: &Context, desc: &PipelineDesc<'_>) -> Result<Arc<ComputePipeline>> {
        let key = PipelineKey::of(desc);
        if let Some(made) = context.pipelines().get(&key) {
            return Ok(made.clone());
        }
        // Not under the lock, which would have all wait for the compiler; who comes second replaces an equal one.
        let pipeline = ComputePipeline::new(context, desc)?;
        context.pipelines().insert(key, pipeline.clone());
        Ok(pipeline)
    }

    /// Makes the pipeline. Drivers compile here or in the first dispatch (lavapipe mostly in the latter).
    pub fn new(context: &Context, desc: &PipelineDesc<'_>) -> Result<Arc<ComputePipeline>> {
        let (device, name) = (context.device(), desc.name);
        check_constants(desc)?;
        let spirv = specialise(desc.module, desc.specialization)?;
        let declared = Declared::of(&spirv)?;
        check(&device.info, name, &declared)?;
        let Declared { bindings, push_constant_bytes, .. } = declared;

        let layout_bindings: Vec<_> = bindings.iter().map(layout_binding).collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&layout_bindings);
        // SAFETY: binding numbers are distinct, counts within limits (`check`); the handle is the only owner.
        let set_layout = unsafe {
            let raw = device.raw().create_descriptor_set_layout(&info, None);
            let raw = raw.map_err(failed(format!("vkCreateDescriptorSetLayout for `{name}`")))?;
            Handle::own(device, raw, &format!("{name} set layout"))
        };

        let set_layouts = [set_layout.raw()];
        let ranges =
            [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(push_constant_bytes)];
        // A range of no bytes is not allowed: none then.
        let ranges = if push_constant_bytes == 0 { &ranges[..0] } else { &ranges[..] };
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(ranges);
        // SAFETY: the set layout is alive; the range is a multiple of 4 within the limit; the handle is the only owner.
        let layout = unsafe {
            let raw = device.raw().create_pipeline_layout(&info, None);
            let raw = raw.map_err(failed(format!("vkCreatePipelineLayout for `{name}`")))?;
            Handle::own(device, raw, &format!("{name} layout"))
        };

        let info = vk::ShaderModuleCreateInfo::default().code(&spirv);
        // SAFETY: the words are glslang's output for Vulkan 1.1, since a `ShaderModule` has no other; its
        // specialisation constants are made ordinary ones of the same types, arrays among them are of valid length;
        // the handle is the only owner.
        let module = unsafe {
            let raw = device.raw().create_shader_module(&info, None);
            Handle::own(device, raw.map_err(failed(format!("vkCreateShaderModule for `{name}`")))?, name)
        };

        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw())
            .name(c"main");
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw())];
        // SAFETY: module and layout are alive; the layout was read off the module, so it has every binding of it with
        // its kind, and all of its push constants; the workgroup is within limits (`check`). The module may go once
        // the pipeline is made. The one new pipeline is owned by the handle alone; a failed call makes none.
        let raw = unsafe {
            let made = device.raw().create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            let made = made.map_err(|(_, code)| failed(format!("vkCreateComputePipelines for `{name}`"))(code))?;
            Handle::own(device, made[0], name)
        };
        let name = name.to_string();
        Ok(Arc::new(ComputePipeline { raw, layout, set_layout, bindings, push_constant_bytes, name }))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its bindings, in rising order of number.
    pub fn bindings(&self) -> &[BindingSlot] {
        &self.bindings
    }

    /// Bytes of push constants that each dispatch gives.
    pub fn push_constant_bytes(&self) -> u32 {
        self.push_constant_bytes
    }

    pub(super) fn device(&self) -> &Arc<super::device::Device> {
        self.raw.device()
    }

    pub(super) fn raw(&self) -> vk::Pipeline {
        self.raw.raw()
    }

    pub(super) fn layout(&self) -> vk::PipelineLayout {
        self.layout.raw()
    }

    pub(super) fn set_layout(&self) -> vk::DescriptorSetLayout {
        self.set_layout.raw()
    }
}

impl fmt::Debug for ComputePipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ComputePipeline(`{}`)", self.name)
    }
}

impl BindingKind {
    pub(super) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            BindingKind::Texel => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
            BindingKind::Storage => vk::DescriptorType::STORAGE_BUFFER,
        }
    }
}

fn layout_binding(slot: &BindingSlot) -> vk::DescriptorSetLayoutBinding<'static> {
    vk::DescriptorSetLayoutBinding::default()
        .binding(slot.number)
        .descriptor_type(slot.kind.descriptor_type())
        .descriptor_count(1)
        .stage_flags(vk::ShaderStageFlags::COMPUTE)
}

/// Refuses what the device has too little of.
fn check(info: &DeviceInfo, name: &str, declared: &Declared) -> Result<()> {
    let count = |kind| declared.bindings.iter().filter(|slot| slot.kind == kind).count() as u32;
    let (texel, storage) = (count(BindingKind::Texel), count(BindingKind::Storage));
    for (limit, unit, need, have) in [
        // Vulkan counts uniform texel buffers among the sampled images.
        ("maxPerStageDescriptorSampledImages", "texel buffers", texel, info.max_per_stage_sampled_images),
        ("maxPerStageDescriptorStorageBuffers", "storage buffers", storage, info.max_per_stage_storage_buffers),
        ("maxPerStageResources", "bindings", texel + storage, info.max_per_stage_resources),
        ("maxPushConstantsSize", "bytes", declared.push_constant_bytes, info.max_push_constants_bytes),
    ] {
        if need > have {
            return Err(Error::Limit {
                what: format!("pipeline `{name}` ({limit})"),
                need: format!("{need} {unit}"),
                have: format!("{have} {unit}"),
            });
        }
    }
    info.check_workgroup(declared.workgroup)
}

/// Refuses a constant with two values.
fn check_constants(desc: &PipelineDesc<'_>) -> Result<()> {
    let mut ids: Vec<u32> = desc.specialization.iter().map(|constant| constant.0).collect();
    ids.sort_unstable();
    match ids.windows(2).find(|pair| pair[0] == pair[1]) {
        None => Ok(()),
        Some(pair) => Err(Error::Internal(format!("pipeline `{}`: constant {} is given twice", desc.name, pair[0]))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::choice::tests::device;
    use super::super::device_info::DeviceKind;
    use super::*;

    #[test]
    fn limits_are_refused_by_name() {
        let info = device(0, "least", DeviceKind::Cpu);
        let slots = |kind, count| (0..count).map(|number| BindingSlot { number, kind }).collect::<Vec<_>>();
        let declared = |bindings, push_constant_bytes, workgroup| Declared { bindings, push_constant_bytes, workgroup };
        let storage = |count| declared(slots(BindingKind::Storage, count), 4, [8, 8, 1]);
        assert!(check(&info, "modest", &storage(info.max_per_stage_storage_buffers)).is_ok());
        for (greedy, limit) in [
            (storage(info.max_per_stage_storage_buffers + 1), "maxPerStageDescriptorStorageBuffers"),
            (
                declared(slots(BindingKind::Texel, info.max_per_stage_sampled_images + 1), 0, [1; 3]),
                "maxPerStageDescriptorSampledImages",
            ),
            (declared(Vec::new(), info.max_push_constants_bytes + 4, [1; 3]), "maxPushConstantsSize"),
            (declared(Vec::new(), 0, [u32::MAX; 3]), "maxComputeWorkGroupSize"),
            (declared(Vec::new(), 0, [64, 64, 1]), "maxComputeWorkGroupInvocations"),
            (declared(Vec::new(), 0, [8, 0, 1]), "at least 1"),
        ] {
            let error = check(&info, "greedy", &greedy).unwrap_err();
            assert!(matches!(error, Error::Limit { .. }) && error.to_string().contains(limit), "{limit}: {error}");
        }
    }
}
