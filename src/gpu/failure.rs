//! Vulkan result codes as the library's errors.
//!
//! Comes in: a code, and the call that gave it. Goes out: [`Error::DeviceLost`] for a lost device, [`Error::Vulkan`]
//! for the rest. The text of a code is its name in the Vulkan specification.

use ash::vk;

use crate::Error;

/// For `map_err`: the error of `call`, which names the call and what it was made on.
pub(super) fn failed(call: impl Into<String>) -> impl FnOnce(vk::Result) -> Error {
    let call = call.into();
    move |code| match code {
        vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost(format!("found by {call}")),
        code => Error::Vulkan { call, code: format!("{code:?}") },
    }
}
