//! Files that are whole or not there: checked before rendering, written under a temporary name, synced, renamed.
//!
//! Comes in: a path and bytes. Goes out: a file of the user's usual mode, or an error that names the path and leaves
//! nothing behind. What stood there before stays until the new file is complete.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::{Display, Metadata, Picture, exr, hdr, png};
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
                Err(Error::Usage(format!("{}: unknown extension .{other}; use .exr, .png or .hdr", path.display())))
            }
            None => Err(Error::Usage(format!("{}: no extension; use .exr, .png or .hdr", path.display()))),
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

    /// Writes the picture.
    pub fn write(&self, picture: &Picture, display: &Display, metadata: &Metadata) -> Result<()> {
        let bytes = match self.format {
            Format::Exr => exr::encode(picture, metadata),
            Format::Png => png::encode(picture, display, metadata),
            Format::Hdr => hdr::encode(picture),
        };
        write_whole(&self.path, self.no_clobber, &bytes.map_err(|message| Error::output(&self.path, message))?)
    }
}

/// Refuses a path that could not be written: a folder that is missing or not writable, a directory in its place, or,
/// under `no_clobber`, anything in its place.
pub fn check_writable(path: &Path, no_clobber: bool) -> Result<()> {
    if path.is_dir() {
        return Err(Error::output(path, "is a directory"));
    }
    if no_clobber && path.symlink_metadata().is_ok() {
        return Err(Error::output(path, "exists already (--no-clobber)"));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Error::output(path, format!("the folder {} does not exist", folder.display())));
    }
    let failed = |error| Error::output(path, format!("the folder {} cannot be written: {error}", folder.display()));
    temporary(&folder).map(drop).map_err(failed)
}

/// Writes `bytes` to `path`, whole or not at all. A symbolic link is followed, so that it stays one.
pub fn write_whole(path: &Path, no_clobber: bool, bytes: &[u8]) -> Result<()> {
    let target = if path.is_symlink() { fs::canonicalize(path).unwrap_or_else(|_| path.into()) } else { path.into() };
    let folder = folder_of(&target);
    let write = || -> io::Result<()> {
        let mut file = temporary(&folder)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        if no_clobber { file.persist_noclobber(&target) } else { file.persist(&target) }
            .map_err(|error| error.error)?;
        sync_folder(&folder)
    };
    write().map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => Error::output(path, "exists already (--no-clobber)"),
        _ => Error::output(path, error.to_string()),
    })
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.into(),
        _ => PathBuf::from("."),
    }
}

/// A file in `folder` that goes when it is dropped; its mode is what the user's umask leaves, as for any new file.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".texray-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Makes the renaming itself survive a loss of power. Not every file system can sync a folder; the file is whole by
/// then, so a refusal is no error.
fn sync_folder(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    if let Ok(folder) = fs::File::open(folder) {
        let _ = folder.sync_all();
    }
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}
