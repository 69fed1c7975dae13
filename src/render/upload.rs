//! Stage 4: the scene's texels as buffers on the device.
//!
//! Comes in: [`TexelData`]. Goes out: a [`GpuScene`], one buffer a record kind, filled through the staging ring. A record
//! kind that the scene does not call for gets no buffer: its bindings point at one shared null buffer, and the ledger says
//! so. Every record buffer has two bindings, a texel view and a storage twin; the one that is not used is null as well.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::gpu::{Buffer, BufferUse, Context, Ledger, Memory, Resource, TexelBuffer, Uploader};
use crate::interface::{Record, RenderConstants, STORAGE_TWIN};
use crate::settings::Buffers;
use crate::texels::{Texel, TexelData};

/// The scene on the device.
pub struct GpuScene {
    resources: Vec<(u32, Resource)>,
    null_texel: Arc<TexelBuffer>,
    /// How the records are bound.
    pub buffers: Buffers,
}

/// The texels of a kind of record.
fn texels(data: &TexelData, record: Record) -> &[Texel] {
    match record {
        Record::Nodes => &data.nodes,
        Record::Triangles => &data.triangles,
        Record::Surfaces => &data.surfaces,
        Record::Corners => &data.corners,
        Record::Materials => &data.materials,
        Record::Lights => &data.lights,
        Record::Camera => &data.camera,
        Record::Filter => &data.filter,
        Record::Random => &data.random,
        Record::LightNodes => &data.light_nodes,
    }
}

/// The camera's texels, and those of the render's constants behind them.
fn camera_bytes(data: &TexelData, constants: &RenderConstants) -> Vec<u8> {
    let mut bytes = bytemuck::cast_slice(&data.camera).to_vec();
    bytes.extend(constants.bytes());
    bytes.resize(bytes.len().next_multiple_of(size_of::<Texel>()), 0);
    bytes
}

/// Whether every record fits a texel buffer of this device; if not, storage buffers may.
pub fn fits_texel_buffers(data: &TexelData, context: &Context) -> bool {
    Record::ALL.iter().all(|&record| TexelBuffer::fits(context, size_of_val(texels(data, record)) as u64))
}

impl GpuScene {
    /// Copies the records and the render's constants to the device, bound as `buffers` says.
    pub fn upload(
        context: &Context,
        data: &TexelData,
        constants: &RenderConstants,
        buffers: Buffers,
        ledger: &mut Ledger,
    ) -> Result<GpuScene> {
        const STORAGE: BufferUse = BufferUse { texel: false, storage: true };
        let null_texel = TexelBuffer::new(context, "null texels", 16)?;
        let null_storage = Buffer::new(context, "null storage", 16, STORAGE, Memory::Device)?;
        let mut uploader = Uploader::new(context)?;
        // The null buffers are never read, but a buffer that a shader may read should hold something.
        for null in [null_texel.buffer(), &null_storage] {
            uploader.upload(ledger, null, 0, &[0; 16], "bound where a record kind is absent")?;
        }
        let mut resources = Vec::new();
        let camera = camera_bytes(data, constants);
        for &record in Record::ALL {
            let (binding, name, why) = (record.binding(), record.name(), record.why());
            let mut texel = Resource::Texel(null_texel.clone());
            let mut storage = Resource::Storage(null_storage.clone());
            let bytes: &[u8] = match record {
                Record::Camera => &camera,
                record => bytemuck::cast_slice(texels(data, record)),
            };
            let size = bytes.len() as u64;
            if bytes.is_empty() {
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

    /// Copies another camera over the one that is there; the render's constants behind it stay.
    pub fn replace_camera(&self, context: &Context, camera: &[Texel], ledger: &mut Ledger) -> Result<()> {
        let bound = match self.buffers {
            Buffers::Texel => Record::Camera.binding(),
            Buffers::Storage => Record::Camera.binding() + STORAGE_TWIN,
        };
        let resource = self.resources.iter().find(|(binding, _)| *binding == bound).map(|(_, resource)| resource);
        let buffer = match resource {
            Some(Resource::Texel(view)) => view.buffer(),
            Some(Resource::Storage(buffer)) => buffer,
            None => return Err(Error::Internal("a scene on the device without a camera".into())),
        };
        let mut uploader = Uploader::new(context)?;
        uploader.upload(ledger, buffer, 0, bytemuck::cast_slice(camera), Record::Camera.why())?;
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
