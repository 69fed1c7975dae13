//! The layer beneath the stages: Vulkan objects, their ownership, and every transfer between CPU and GPU.
#![allow(unsafe_code)]
