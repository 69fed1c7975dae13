//! Stages 4 and 5: the scene on the device, and the frame loop that accumulates samples into a film.

pub mod report;
pub mod settings;

pub use report::{Bytes, Observer, Progress, RenderReport, StageSeconds, StopReason};
pub use settings::{AccelKind, Buffers, Hemisphere, Intersector, LightPick, Lights, Roulette, Sampler, Settings};
