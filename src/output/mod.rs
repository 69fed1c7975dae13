//! Stage 7: pictures and reports, written whole or not at all.
//!
//! Comes in: a [`Picture`] of linear radiance and its [`Metadata`]. Goes out: files. What can be refused (an unknown
//! extension, a folder that cannot be written) is refused by [`OutputFile::check`], before anything is rendered.

pub mod cost;
mod exr;
mod hdr;
mod layer;
mod metadata;
pub mod partial;
mod picture;
mod place;
mod png;
mod replacing;
mod stored;
mod stream;
mod temporary;
pub mod tonemap;
mod write;

pub use layer::{Aov, Layer};
pub use metadata::Metadata;
pub use picture::Picture;
pub use png::{encode as encode_png, encode_indexed as encode_indexed_png};
pub use stored::Stored;
pub use tonemap::{Display, Tonemap};
pub use write::{Format, OutputFile, check_writable, is_rewritable, target_of, write_whole};
