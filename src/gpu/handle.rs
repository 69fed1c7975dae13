//! Ownership of one Vulkan object.
//!
//! Comes in: an object that was just made. Goes out: a [`Handle`] that destroys it when dropped. It may be assumed that
//! whoever drops a handle has waited for the work that uses it: `InFlight` keeps such things alive until then.

use std::ffi::CString;
use std::sync::Arc;

use ash::vk;

use super::device::Device;

/// A kind of object that a device makes and destroys.
pub(super) trait DeviceObject: vk::Handle + Copy {
    /// Destroys the object.
    ///
    /// # Safety
    /// The object is one of `device`, no submitted work uses it, and nobody uses it afterwards.
    unsafe fn destroy(self, device: &ash::Device);
}

macro_rules! device_objects {
    ($($object:ident: $destroy:ident,)*) => {
        $(impl DeviceObject for vk::$object {
            unsafe fn destroy(self, device: &ash::Device) {
                // SAFETY: the caller's promise is the valid usage of every vkDestroy command; host access to the
                // object is exclusive, since it is taken by value from its one owner.
                // SAFETY: the caller's promise; no allocation callbacks were given when it was made.
                unsafe { device.$destroy(self, None) }
            }
        })*
    };
}

device_objects! {
    Buffer: destroy_buffer,
    BufferView: destroy_buffer_view,
    CommandPool: destroy_command_pool,
    DescriptorPool: destroy_descriptor_pool,
    DescriptorSetLayout: destroy_descriptor_set_layout,
    Fence: destroy_fence,
    Pipeline: destroy_pipeline,
    PipelineLayout: destroy_pipeline_layout,
    QueryPool: destroy_query_pool,
    ShaderModule: destroy_shader_module,
}

/// The owner of one object.
pub(super) struct Handle<T: DeviceObject> {
    raw: T,
    device: Arc<Device>,
}

impl<T: DeviceObject> Handle<T> {
    /// Takes `raw` over and names it.
    ///
    /// # Safety
    /// `raw` is an object of `device` that was just made and has no other owner.
    pub(super) unsafe fn own(device: &Arc<Device>, raw: T, name: &str) -> Handle<T> {
        // SAFETY: the caller's promise.
        unsafe { device.name(raw, name) };
        Handle { raw, device: device.clone() }
    }

    /// The object, for use while this handle lives.
    pub(super) fn raw(&self) -> T {
        self.raw
    }

    /// The device that made it.
    pub(super) fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

impl<T: DeviceObject> Drop for Handle<T> {
    fn drop(&mut self) {
        // SAFETY: this is the only owner and its end; by the rule of this module no submitted work uses the object.
        unsafe { self.raw.destroy(self.device.raw()) }
    }
}

impl Device {
    /// Gives an object the name that validation messages and capture tools show.
    ///
    /// # Safety
    /// `object` is a living object of this device that no other thread uses.
    pub(super) unsafe fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let Some(debug_utils) = &self.debug_utils else { return };
        // A NUL would end the name early; there is no other text that cannot be a name.
        let Ok(name) = CString::new(name.replace('\0', " ")) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: VK_EXT_debug_utils is on where `debug_utils` is there; the rest is the caller's promise. A name is a
        // help for people, so a failure (out of memory) is not reported.
        let _ = unsafe { debug_utils.set_debug_utils_object_name(&info) };
    }
}
