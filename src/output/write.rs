//! Files that are whole or not there: checked before rendering, written without a name, synced, named.
//!
//! Comes in: a path and bytes. Goes out: a file of the user's usual mode, or of the one that it replaces; or an error
//! that names the path and leaves nothing behind.

use std::io;
use std::path::{Path, PathBuf};

use super::partial;
use super::place::{Place, follow};
use super::temporary::{folder_of, remove_stale};
use super::{Display, Metadata, Picture, exr, hdr, png};
use crate::quote;
use crate::{Error, Result};

/// Format of a picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR, 32-bit floats.
    Exr,
    /// PNG, 8-bit sRGB.
    Png,
    /// Radiance HDR.
    Hdr,
}

impl Format {
    /// The format that the extension of `path` names, whatever its case.
    pub fn of(path: &Path) -> Result<Format> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Format::Exr),
            Some("png") => Ok(Format::Png),
            Some("hdr") => Ok(Format::Hdr),
            Some(other) => {
                Err(Error::Usage(format!("{}: unknown extension .{other}; use .exr, .png or .hdr", quote::path(path))))
            }
            None => Err(Error::Usage(format!("{}: no extension; use .exr, .png or .hdr", quote::path(path)))),
        }
    }
}

/// A picture file that can be written, as far as can be known before rendering.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    path: PathBuf,
    format: Format,
    no_clobber: bool,
}

impl OutputFile {
    /// Checks extension and folder, and, under `no_clobber`, that nothing stands at `path` yet.
    pub fn check(path: &Path, no_clobber: bool) -> Result<OutputFile> {
        let format = Format::of(path)?;
        check_writable(path, no_clobber)?;
        Ok(OutputFile { path: path.into(), format, no_clobber })
    }

    /// Where it will be written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The file for a picture of `spp` samples that was cut short: the same, or, where a picture of the same subject
    /// with more samples is there, another beside it, named `NAME.partial-Nspp.EXT`.
    pub fn beside_better(&self, display: &Display, metadata: &Metadata, spp: u32) -> OutputFile {
        let path = partial::beside_better(&self.path, &self.metadata(display, metadata), spp);
        OutputFile { path: path.unwrap_or_else(|| self.path.clone()), ..self.clone() }
    }

    /// The same file, which is there now by this process's doing and may be replaced.
    pub fn written(&self) -> OutputFile {
        OutputFile { no_clobber: false, ..self.clone() }
    }

    /// What the file says of itself: how an 8-bit picture is shown is part of what it is of.
    fn metadata(&self, display: &Display, metadata: &Metadata) -> Metadata {
        let mut metadata = metadata.clone();
        if self.format == Format::Png {
            metadata.subject("exposure", display.exposure_stops).subject("tonemap", format!("{:?}", display.tonemap));
        }
        metadata
    }

    /// Writes the picture.
    pub fn write(&self, picture: &Picture, display: &Display, metadata: &Metadata) -> Result<()> {
        let metadata = self.metadata(display, metadata);
        let bytes = match self.format {
            Format::Exr => exr::encode(picture, &metadata),
            Format::Png => png::encode(picture, display, &metadata),
            Format::Hdr => hdr::encode(picture, &metadata),
        };
        write_whole(&self.path, self.no_clobber, &bytes.map_err(|message| Error::output(&self.path, message))?)
    }
}

/// Refuses a path that could not be written: a folder that is missing or not writable, a directory in its place, a file
/// that this user may not write, a name that is too long, or, under `no_clobber`, anything in its place. Nothing of the
/// trial stays.
pub fn check_writable(path: &Path, no_clobber: bool) -> Result<()> {
    if no_clobber && path.symlink_metadata().is_ok() {
        return Err(exists(path));
    }
    let place = Place::of(path).map_err(|message| Error::output(path, message))?;
    place.try_out().map_err(|message| Error::output(path, message))?;
    remove_stale(folder_of(place.target()));
    Ok(())
}

/// Whether what is written to `path` stays there, so that it can be written once more: what went to a pipe or a device
/// is gone.
pub fn is_rewritable(path: &Path) -> bool {
    Place::of(path).is_ok_and(|place| place.is_file())
}

/// The path that is written to where `path` is named: links are followed, be there a file at their end or not.
pub fn target_of(path: &Path) -> PathBuf {
    follow(path).unwrap_or_else(|_| path.into())
}

/// Writes `bytes` to `path`: a file is whole or not there, and what stood there before stays until it is complete.
/// Symbolic links are followed; a device or a pipe is written to and stays what it is.
pub fn write_whole(path: &Path, no_clobber: bool, bytes: &[u8]) -> Result<()> {
    let place = Place::of(path).map_err(|message| Error::output(path, message))?;
    place.write(no_clobber, bytes).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => exists(path),
        _ => Error::output(path, error.to_string()),
    })
}

fn exists(path: &Path) -> Error {
    Error::output(path, "exists already (--no-clobber)")
}
