//! Stage 4: the scene's texels as buffers on the device.
//!
//! Comes in: [`TexelData`]. Goes out: a [`GpuScene`], one buffer a record kind, filled through the staging ring. A record
//! kind that the scene does not call for gets no buffer: its bindings point at one shared null buffer, and the ledger says
//! so. Every record buffer has two bindings, a texel view and a storage twin; the one that is not used is null as well.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::gpu::{Buffer, BufferUse, Context, Ledger, Memory, Resource, TexelBuffer, Uploader};
use crate::interface::{
    BINDING_CAMERA, BINDING_CORNERS, BINDING_FILTER, BINDING_LIGHT_NODES, BINDING_LIGHTS, BINDING_MATERIALS,
    BINDING_NODES, BINDING_RANDOM, BINDING_SURFACES, BINDING_TRIANGLES, STORAGE_TWIN,
};
use crate::settings::Buffers;
use crate::texels::{Texel, TexelData};

/// The scene on the device.
pub struct GpuScene {
    resources: Vec<(u32, Resource)>,
    null_texel: Arc<TexelBuffer>,
    /// How the records are bound.
    pub buffers: Buffers,
}

/// A record kind: binding, buffer name, texels, and what the renderer wants it for.
type Record<'a> = (u32, &'static str, &'a [Texel], &'static str);

/// What the camera is wanted for.
const CAMERA_USE: &str = "pose and picture size, read once an invocation";

fn records(data: &TexelData) -> [Record<'_>; 10] {
    [
        (BINDING_NODES, "nodes", &data.nodes, "boxes of the tree, read at every node visit"),
        (BINDING_TRIANGLES, "triangles", &data.triangles, "corner positions, read at every triangle test"),
        (BINDING_SURFACES, "surfaces", &data.surfaces, "normal and material, read once a hit"),
        (BINDING_CORNERS, "corners", &data.corners, "vertex normals, read once a smooth hit"),
        (BINDING_MATERIALS, "materials", &data.materials, "reflectance and emission, read once a hit"),
        (BINDING_LIGHTS, "lights", &data.lights, "emitters and their probabilities, read once a light sample"),
        (BINDING_CAMERA, "camera", &data.camera, CAMERA_USE),
        (BINDING_FILTER, "filter", &data.filter, "inverse distribution of the pixel filter, read once a path"),
        (BINDING_RANDOM, "random", &data.random, "numbers of the table sampler, read at every bounce"),
        (BINDING_LIGHT_NODES, "light nodes", &data.light_nodes, "clusters of lights, read on the way to a light"),
    ]
}

/// Whether every record fits a texel buffer of this device; if not, storage buffers may.
pub fn fits_texel_buffers(data: &TexelData, context: &Context) -> bool {
    records(data).iter().all(|(_, _, texels, _)| TexelBuffer::fits(context, size_of_val(*texels) as u64))
}

impl GpuScene {
    /// Copies the records to the device, bound as `buffers` says.
    pub fn upload(context: &Context, data: &TexelData, buffers: Buffers, ledger: &mut Ledger) -> Result<GpuScene> {
        const STORAGE: BufferUse = BufferUse { texel: false, storage: true };
        let null_texel = TexelBuffer::new(context, "null texels", 16)?;
        let null_storage = Buffer::new(context, "null storage", 16, STORAGE, Memory::Device)?;
        let mut uploader = Uploader::new(context)?;
        // The null buffers are never read, but a buffer that a shader may read should hold something.
        for null in [null_texel.buffer(), &null_storage] {
            uploader.upload(ledger, null, 0, &[0; 16], "bound where a record kind is absent")?;
        }
        let mut resources = Vec::new();
        for (binding, name, texels, why) in records(data) {
            let mut texel = Resource::Texel(null_texel.clone());
            let mut storage = Resource::Storage(null_storage.clone());
            let bytes: &[u8] = bytemuck::cast_slice(texels);
            let size = bytes.len() as u64;
            if texels.is_empty() {
                ledger.absent(name, "the scene does not call for it");
            } else if buffers == Buffers::Texel {
                let view = TexelBuffer::new(context, name, size)?;
                uploader.upload(ledger, view.buffer(), 0, bytes, why)?;
                texel = Resource::Texel(view);
            } else {
                let buffer = Buffer::new(context, name, size, STORAGE, Memory::Device)?;
                uploader.upload(ledger, &buffer, 0, bytes, why)?;
                storage = Resource::Storage(buffer);
            }
            resources.push((binding, texel));
            resources.push((binding + STORAGE_TWIN, storage));
        }
        uploader.finish()?;
        Ok(GpuScene { resources, null_texel, buffers })
    }

    /// Copies another camera over the one that is there.
    pub fn replace_camera(&self, context: &Context, camera: &[Texel], ledger: &mut Ledger) -> Result<()> {
        let bound = match self.buffers {
            Buffers::Texel => BINDING_CAMERA,
            Buffers::Storage => BINDING_CAMERA + STORAGE_TWIN,
        };
        let resource = self.resources.iter().find(|(binding, _)| *binding == bound).map(|(_, resource)| resource);
        let buffer = match resource {
            Some(Resource::Texel(view)) => view.buffer(),
            Some(Resource::Storage(buffer)) => buffer,
            None => return Err(Error::Internal("a scene on the device without a camera".into())),
        };
        let mut uploader = Uploader::new(context)?;
        uploader.upload(ledger, buffer, 0, bytemuck::cast_slice(camera), CAMERA_USE)?;
        uploader.finish()
    }

    /// What to bind as texels where there are none.
    pub fn null_texel(&self) -> &Arc<TexelBuffer> {
        &self.null_texel
    }

    /// What to bind, by binding number.
    pub fn resources(&self) -> &[(u32, Resource)] {
        &self.resources
    }
}
