//! A compute pipeline: SPIR-V, specialised, with the layout of what it binds.
//!
//! Comes in: a [`PipelineDesc`]. Goes out: a [`ComputePipeline`], or an error that names the device limit in the way. All
//! bindings are in descriptor set 0; push constants begin at byte 0.

use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::device_info::DeviceInfo;
use super::failure::failed;
use super::handle::Handle;
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
    pub spirv: &'a [u32],
    /// Every binding that the module declares, used or not.
    pub bindings: &'a [BindingSlot],
    /// Size of its push-constant block in bytes, a multiple of 4.
    pub push_constant_bytes: u32,
    /// Specialisation constants, `(id, value)`. Ids that the module lacks are ignored.
    pub specialization: &'a [(u32, u32)],
}

/// What two descriptions of one pipeline have in common: all but the name. Modules go by their hash: of so few, no two share
/// 64 bits.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct PipelineKey {
    spirv_hash: u64,
    bindings: Vec<BindingSlot>,
    push_constant_bytes: u32,
    specialization: Vec<(u32, u32)>,
}

impl PipelineKey {
    fn of(desc: &PipelineDesc<'_>) -> PipelineKey {
        let mut hasher = DefaultHasher::new();
        desc.spirv.hash(&mut hasher);
        PipelineKey {
            spirv_hash: hasher.finish(),
            bindings: desc.bindings.to_vec(),
            push_constant_bytes: desc.push_constant_bytes,
            specialization: desc.specialization.to_vec(),
        }
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
        check(&device.info, desc)?;
        let mut bindings = desc.bindings.to_vec();
        bindings.sort_unstable();

        let layout_bindings: Vec<_> = bindings.iter().map(layout_binding).collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&layout_bindings);
        // SAFETY: binding numbers are distinct, counts within limits (`check`); the handle is the only owner.
        let set_layout = unsafe {
            let raw = device.raw().create_descriptor_set_layout(&info, None);
            let raw = raw.map_err(failed(format!("vkCreateDescriptorSetLayout for `{name}`")))?;
            Handle::own(device, raw, &format!("{name} set layout"))
        };

        let set_layouts = [set_layout.raw()];
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(desc.push_constant_bytes)];
        // A range of no bytes is not allowed: none then.
        let ranges = if desc.push_constant_bytes == 0 { &ranges[..0] } else { &ranges[..] };
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(ranges);
        // SAFETY: the set layout is alive; the range is a multiple of 4 within the limit; the handle is the only owner.
        let layout = unsafe {
            let raw = device.raw().create_pipeline_layout(&info, None);
            let raw = raw.map_err(failed(format!("vkCreatePipelineLayout for `{name}`")))?;
            Handle::own(device, raw, &format!("{name} layout"))
        };

        let spirv = specialise(desc.spirv, desc.specialization)?;
        let info = vk::ShaderModuleCreateInfo::default().code(&spirv);
        // SAFETY: the words are glslang's output for Vulkan 1.1 (`shaders`), its specialisation constants made ordinary ones of
        // the same types; the handle is the only owner.
        let module = unsafe {
            let raw = device.raw().create_shader_module(&info, None);
            Handle::own(device, raw.map_err(failed(format!("vkCreateShaderModule for `{name}`")))?, name)
        };

        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw())
            .name(c"main");
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw())];
        // SAFETY: module and layout are alive, the layout has every binding of the module. The module may go once the pipeline
        // is made. The one new pipeline is owned by the handle alone; a failed call makes none.
        let raw = unsafe {
            let made = device.raw().create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            let made = made.map_err(|(_, code)| failed(format!("vkCreateComputePipelines for `{name}`"))(code))?;
            Handle::own(device, made[0], name)
        };
        let (push_constant_bytes, name) = (desc.push_constant_bytes, name.to_string());
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

/// Refuses what the device has too little of, and descriptions that contradict themselves.
fn check(info: &DeviceInfo, desc: &PipelineDesc<'_>) -> Result<()> {
    let name = desc.name;
    let count = |kind| desc.bindings.iter().filter(|slot| slot.kind == kind).count() as u32;
    let (texel, storage) = (count(BindingKind::Texel), count(BindingKind::Storage));
    for (limit, unit, need, have) in [
        // Vulkan counts uniform texel buffers among the sampled images.
        ("maxPerStageDescriptorSampledImages", "texel buffers", texel, info.max_per_stage_sampled_images),
        ("maxPerStageDescriptorStorageBuffers", "storage buffers", storage, info.max_per_stage_storage_buffers),
        ("maxPerStageResources", "bindings", texel + storage, info.max_per_stage_resources),
        ("maxPushConstantsSize", "bytes", desc.push_constant_bytes, info.max_push_constants_bytes),
    ] {
        if need > have {
            return Err(Error::Limit {
                what: format!("pipeline `{name}` ({limit})"),
                need: format!("{need} {unit}"),
                have: format!("{have} {unit}"),
            });
        }
    }
    let distinct = |mut numbers: Vec<u32>| {
        numbers.sort_unstable();
        numbers.windows(2).all(|pair| pair[0] != pair[1])
    };
    let consistent = distinct(desc.bindings.iter().map(|slot| slot.number).collect())
        && distinct(desc.specialization.iter().map(|constant| constant.0).collect())
        && desc.push_constant_bytes.is_multiple_of(4)
        // The first word of every SPIR-V module.
        && desc.spirv.first() == Some(&0x0723_0203);
    match consistent {
        true => Ok(()),
        false => Err(Error::Internal(format!(
            "pipeline `{name}`: a binding or constant listed twice, push constants not whole words, or no SPIR-V"
        ))),
    }
}
