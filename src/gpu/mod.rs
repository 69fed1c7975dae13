//! The layer beneath the stages: Vulkan objects, their ownership, and every transfer between CPU and GPU.
//!
//! Comes in: sizes, bytes, kernels of this crate. Goes out: buffers, pipelines, recorded and submitted work, and a
//! ledger of every byte that crossed. It knows nothing of scenes. This folder alone names Vulkan and may use
//! `unsafe`.
//!
//! ```text
//! Instance ← Device ← Handle (buffer, view, pipeline, pool, fence ...)      ← reads "is kept alive by"
//!                   ← Context: device + recycled command slots
//!                        ← Recorder → InFlight (holds an Arc of all that the submitted work uses)
//! ```
//!
//! Ownership, stated once:
//! - A `Handle` owns one Vulkan object and an `Arc` of its device, and destroys the object when dropped. It takes the
//!   object over the moment the object exists, so that `?` frees it.
//! - Whatever submitted work may touch is handed out in an `Arc`; [`InFlight`] holds those until the device's fence
//!   says that the work has ended. Nothing in use is ever freed, whatever the caller drops.
//! - Memory that the host reads or writes is reached through [`Uploader`] and [`Readback`] only, which keep host and
//!   device from touching the same bytes at once. Bind groups, fills and plain copies take device memory only.
//! - Nothing that a caller gives reaches the driver unchecked: kernels are [`ShaderModule`]s of this crate, a
//!   pipeline's layout is read off its module, and what is bound, copied or recorded together belongs to one device.
//! - `Drop` never panics and reports nothing; what it finds wrong goes to the message log of the context.

#![allow(unsafe_code)]

mod address_space;
mod allocation;
mod barrier;
mod bind_group;
pub mod canary;
mod choice;
mod command_slot;
mod commands;
mod context;
mod declared;
mod device;
mod device_info;
mod driver_threads;
mod driver_variables;
mod failure;
mod handle;
mod host_buffer;
mod in_flight;
mod instance;
mod instructions;
mod ledger;
mod memory;
mod messages;
mod pipeline;
mod readback;
mod shader_module;
pub mod shaders;
mod specialise;
mod texel_buffer;
mod thread_limits;
mod timer;
mod transfer;

pub use barrier::Barrier;
pub use bind_group::{BindGroup, Resource};
pub use choice::DeviceChoice;
pub use commands::Recorder;
pub use context::{Context, ContextOptions, list_devices};
pub use device_info::{DeviceInfo, DeviceKind, HeapInfo};
pub use driver_threads::{ThreadShares, share_out_threads};
pub use host_buffer::{HostBuffer, HostMemoryType, host_memory_types};
pub use in_flight::InFlight;
pub use ledger::{Direction, Ledger, LedgerEntry};
pub use memory::{Buffer, BufferUse, Memory};
pub use messages::{ValidationReport, ValidationWatch};
pub use pipeline::{BindingKind, BindingSlot, ComputePipeline, PipelineDesc};
pub use readback::Readback;
pub use shader_module::ShaderModule;
pub use specialise::specialise;
pub use texel_buffer::TexelBuffer;
pub use transfer::Uploader;
