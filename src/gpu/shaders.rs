//! The compute shaders, one static a module.
//!
//! Comes in: `shaders.rs` as `build.rs` wrote it from `glsl/*.comp`; a static is named like its module, in capitals.
//! Goes out: modules for [`PipelineDesc::module`](super::PipelineDesc::module). They may be assumed to be valid
//! SPIR-V 1.3.

use super::shader_module::ShaderModule;

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
