//! What the cases are made of: a test bench, probes of the renderer's own functions, meshes, rays, scenes and their
//! closed forms.
//!
//! Comes in: a device and how much is to be sampled. Goes out: what the device answers. It is public: the test programs
//! and the studies use it too.

pub mod draws;
pub mod faults;
pub mod form_factors;
pub mod furnaces;
pub mod meshes;
pub mod pictures;
pub mod probe;
pub mod probe_calls;
pub mod rays;
pub mod scattering;
pub mod scenes;
pub mod streams;
pub mod test_bench;
pub mod tracing;

pub use test_bench::{TestBench, Tier};
