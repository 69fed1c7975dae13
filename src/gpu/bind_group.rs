//! What a pipeline's bindings point at.
//!
//! Comes in: a pipeline, and a buffer for each of its bindings. Goes out: a [`BindGroup`], which keeps the buffers alive.
//! It is never changed: another choice of buffers is another bind group. Bind groups are made before a frame loop, not
//! in it, so each has a descriptor pool of its own, just as large as it needs.

use std::fmt;
use std::sync::Arc;

use ash::vk;

use super::failure::failed;
use super::handle::Handle;
use super::memory::Buffer;
use super::pipeline::{BindingKind, BindingSlot, ComputePipeline};
use super::texel_buffer::TexelBuffer;
use crate::{Error, Result};

/// A buffer to bind.
#[derive(Clone, Debug)]
pub enum Resource {
    /// As texels.
    Texel(Arc<TexelBuffer>),
    /// As a storage buffer, whole.
    Storage(Arc<Buffer>),
}

/// A written descriptor set.
pub struct BindGroup {
    /// Freed with its pool.
    raw: vk::DescriptorSet,
    _pool: Handle<vk::DescriptorPool>,
    /// The pipeline that it was made for, whose set layout it has.
    pipeline: Arc<ComputePipeline>,
    _resources: Vec<Resource>,
}

impl BindGroup {
    /// Binds a resource to each binding of `pipeline`, given by number: none missing, none over, each of its kind.
    pub fn new(pipeline: &Arc<ComputePipeline>, resources: &[(u32, Resource)]) -> Result<Arc<BindGroup>> {
        let name = pipeline.name();
        let mut resources = resources.to_vec();
        resources.sort_by_key(|(number, _)| *number);
        let given: Vec<_> = resources.iter().map(|(number, resource)| slot_of(*number, resource)).collect();
        if given != pipeline.bindings() {
            let declared = pipeline.bindings();
            return Err(Error::Internal(format!("`{name}` declares {declared:?} and was given {given:?}")));
        }
        let device = pipeline.device();
        for (_, resource) in &resources {
            let buffer = match resource {
                Resource::Texel(texels) => texels.buffer(),
                Resource::Storage(buffer) => buffer,
            };
            // Handles of another device name other objects on this one, or none.
            if !Arc::ptr_eq(buffer.device(), device) {
                return Err(Error::Internal(format!("`{}` for `{name}` belongs to another context", buffer.name())));
            }
            if let Resource::Storage(buffer) = resource {
                buffer.check_device_only("bound")?;
                if !buffer.uses().storage {
                    return Err(Error::Internal(format!("`{}` was not made as a storage buffer", buffer.name())));
                }
            }
        }

        let count = |kind| given.iter().filter(|slot| slot.kind == kind).count() as u32;
        let size =
            |kind: BindingKind| vk::DescriptorPoolSize { ty: kind.descriptor_type(), descriptor_count: count(kind) };
        // A pool size of no descriptors is not allowed: leave it out.
        let kinds = [BindingKind::Texel, BindingKind::Storage].into_iter().filter(|&kind| count(kind) > 0);
        let sizes: Vec<_> = kinds.map(size).collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: one set, each size above zero; the handle is the pool's only owner.
        let pool = unsafe {
            let raw = device.raw().create_descriptor_pool(&info, None);
            let raw = raw.map_err(failed(format!("vkCreateDescriptorPool for `{name}`")))?;
            Handle::own(device, raw, &format!("{name} bindings"))
        };
        let set_layouts = [pipeline.set_layout()];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool.raw()).set_layouts(&set_layouts);
        // SAFETY: the pool is this thread's own and has room for one set of this layout, which is alive.
        let raw = unsafe { device.raw().allocate_descriptor_sets(&info) }
            .map_err(failed(format!("vkAllocateDescriptorSets for `{name}`")))?[0];

        // Arrays first, writes after: a write points into them.
        let views: Vec<_> = resources.iter().map(|(_, resource)| [view_of(resource)]).collect();
        let ranges: Vec<_> = resources.iter().map(|(_, resource)| [range_of(resource)]).collect();
        let mut writes = Vec::with_capacity(given.len());
        for ((slot, view), range) in given.iter().zip(&views).zip(&ranges) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(raw)
                .dst_binding(slot.number)
                .descriptor_type(slot.kind.descriptor_type());
            writes.push(match slot.kind {
                BindingKind::Texel => write.texel_buffer_view(view),
                BindingKind::Storage => write.buffer_info(range),
            });
        }
        // SAFETY: no work uses the new set; each write names a binding of its kind; views and buffers have the usage
        // for it and belong to this device, storage ranges are within limits (checked when the buffer was made), and
        // all are kept alive below.
        unsafe { device.raw().update_descriptor_sets(&writes, &[]) };
        let resources = resources.into_iter().map(|(_, resource)| resource).collect();
        Ok(Arc::new(BindGroup { raw, _pool: pool, pipeline: pipeline.clone(), _resources: resources }))
    }

    /// Whether it can be bound to `pipeline`: set layouts defined alike and equal push constants make the pipelines'
    /// layouts compatible, so specialisations of one module can share a bind group.
    pub(super) fn fits(&self, pipeline: &Arc<ComputePipeline>) -> bool {
        let own = &self.pipeline;
        Arc::ptr_eq(own, pipeline)
            || (Arc::ptr_eq(own.device(), pipeline.device())
                && own.bindings() == pipeline.bindings()
                && own.push_constant_bytes() == pipeline.push_constant_bytes())
    }

    pub(super) fn raw(&self) -> vk::DescriptorSet {
        self.raw
    }
}

impl fmt::Debug for BindGroup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BindGroup({:?}, {:?})", self.pipeline, self._resources)
    }
}

fn slot_of(number: u32, resource: &Resource) -> BindingSlot {
    let kind = match resource {
        Resource::Texel(_) => BindingKind::Texel,
        Resource::Storage(_) => BindingKind::Storage,
    };
    BindingSlot { number, kind }
}

fn view_of(resource: &Resource) -> vk::BufferView {
    match resource {
        Resource::Texel(texels) => texels.view(),
        Resource::Storage(_) => vk::BufferView::null(),
    }
}

fn range_of(resource: &Resource) -> vk::DescriptorBufferInfo {
    match resource {
        Resource::Texel(_) => vk::DescriptorBufferInfo::default(),
        // The size and not WHOLE_SIZE: the range then stands in captures as it was checked.
        Resource::Storage(buffer) => {
            vk::DescriptorBufferInfo { buffer: buffer.raw(), offset: 0, range: buffer.size_bytes() }
        }
    }
}
