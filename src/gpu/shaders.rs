//! The compute shaders as SPIR-V words, one static a module.
//!
//! Comes in: `shaders.rs` as `build.rs` wrote it from `glsl/*.comp`; a static is named like its module, in capitals.
//! Goes out: words for [`PipelineDesc::spirv`](super::PipelineDesc::spirv). They may be assumed to be valid SPIR-V 1.3.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
