//! What the test programs share: an independent path tracer, scenes built in code, statistics, and stored references.
//!
//! Each test program is a crate of its own that uses part of this, so what one of them leaves unused is no mistake.
#![allow(dead_code)]

pub mod comparison;
pub mod device;

pub mod distributions;
pub mod draws;
pub mod golden;
pub mod obj;
pub mod probe;
pub mod random;
pub mod scenes;
pub mod statistics;
pub mod tracer;
