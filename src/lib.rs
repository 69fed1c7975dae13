//! texray: a Monte Carlo path tracer that drives Vulkan compute shaders directly.
//!
//! Data flows one way; each stage is a value to the next:
//!
//! ```text
//! scene.toml + OBJ/MTL → Scene → Accel → TexelData → GpuScene → path_trace.comp → run sums → Film → EXR/PNG/HDR
//!                        scene   bvh     texels      gpu, render  glsl/           render     film   output
//! ```
//!
//! A later stage may import an earlier one, never the reverse. [`gpu`] is the layer beneath: it alone names Vulkan and
//! holds `unsafe`, and knows nothing of scenes. [`interface`] states what CPU and GPU agree on, [`memory`] what the
//! host has left, [`named`] how choices are called. [`input_file`] reads files of others, and [`quote`] shows their
//! text. [`selftest`] and [`study`] stand above all stages: one asks them hard questions, the other what they cost.
//! [`compare`] holds finished pictures against each other, and [`report`] shows what was found. [`statistics`] lies
//! beneath them all, for whoever judges numbers.

#![deny(unsafe_code)]

pub mod bvh;
pub mod compare;
pub mod error;
pub mod film;
pub mod gpu;
pub mod input_file;
pub mod interface;
pub mod memory;
pub mod named;
pub mod output;
pub mod quote;
pub mod render;
pub mod report;
pub mod scene;
pub mod selftest;
pub mod settings;
pub mod statistics;
pub mod study;
pub mod texels;

pub use error::{Error, Result};
