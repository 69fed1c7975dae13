//! A shader module of this crate.
//!
//! Comes in: words that `build.rs` compiled from `glsl/`. Goes out: a [`ShaderModule`], which nothing outside this
//! folder can make. Drivers take SPIR-V on trust: one flipped word ends the process inside a compiler, so safe code
//! must not be able to hand them words of its own.

use std::fmt;
use std::hash::{Hash, Hasher};

/// SPIR-V that `build.rs` compiled: one of [`shaders`](super::shaders).
///
/// There is no other:
///
/// ```compile_fail
/// let module = texray::gpu::ShaderModule { words: &[0x0723_0203, 0x0001_0300, 0, 20, 0] };
/// ```
///
/// ```
/// assert_eq!(texray::gpu::shaders::PROBE_ECHO.words()[0], 0x0723_0203);
/// ```
#[derive(Clone, Copy)]
pub struct ShaderModule {
    words: &'static [u32],
}

impl ShaderModule {
    /// For the statics that `build.rs` writes, and for no others.
    pub(super) const fn built(words: &'static [u32]) -> ShaderModule {
        ShaderModule { words }
    }

    /// Its words, to look at.
    pub fn words(self) -> &'static [u32] {
        self.words
    }
}

impl PartialEq for ShaderModule {
    /// Whether both are the same words; modules are few and long, so their places are compared first.
    fn eq(&self, other: &ShaderModule) -> bool {
        std::ptr::eq(self.words, other.words) || self.words == other.words
    }
}

impl Eq for ShaderModule {}

impl Hash for ShaderModule {
    /// The beginning of a module says little, its length nearly all: there are some twenty, and [`Eq`] decides.
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.words.len().hash(state);
    }
}

impl fmt::Debug for ShaderModule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ShaderModule({} words)", self.words.len())
    }
}
