//! What a path names as an output: nothing yet, a file, or a stream such as a device or a pipe.
//!
//! Comes in: a path. Goes out: a [`Place`] that bytes can be written to, or why none can. Symbolic links are followed,
//! and stay.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::replacing;
use super::stream;
use super::temporary::{Temporary, folder_of};

use crate::quote;

/// Links that are followed at most; Linux follows as many.
const MOST_LINKS: usize = 40;

/// Where bytes go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nothing is there: a new file is made.
    New(PathBuf),
    /// A regular file: its bytes are replaced, and its mode, owner and other names are kept.
    File(PathBuf),
    /// A device, a pipe, or a file that this process holds open already: it is written to and stays what it is.
    Stream(PathBuf),
}

impl Place {
    /// What `path` names now; the error says why it cannot be an output.
    pub fn of(path: &Path) -> Result<Place, String> {
        let target = follow(path).map_err(|error| error.to_string())?;
        match (fs::metadata(&target), target) {
            (Ok(metadata), _) if metadata.is_dir() => Err("is a directory".into()),
            (Ok(metadata), _) if stream::is_unconnected_socket(path, &metadata) => Err("is a socket".into()),
            (Ok(metadata), target) if metadata.is_file() && !is_open_file(&target) => Ok(Place::File(target)),
            // Opened by the name that was given: what /proc shows of a pipe is no path.
            (Ok(_), _) => Ok(Place::Stream(path.into())),
            (Err(error), target) if error.kind() == io::ErrorKind::NotFound => Ok(Place::New(target)),
            (Err(error), _) => Err(error.to_string()),
        }
    }

    /// Whether it can be written to, as far as can be known; the error says why not. Nothing stays of the trial.
    pub fn try_out(&self) -> Result<(), String> {
        let unwritable = |error: io::Error| format!("cannot be written: {error}");
        match self {
            Place::New(target) => {
                let folder = folder_of(target);
                if !folder.is_dir() {
                    return Err(format!("the folder {} does not exist", quote::path(folder)));
                }
                // The file itself and not some other: a file system may refuse a name, too.
                let made = OpenOptions::new().write(true).create_new(true).open(target);
                let made =
                    made.map_err(|error| format!("the folder {} cannot be written: {error}", quote::path(folder)))?;
                match is_same(&made, target) {
                    true => fs::remove_file(target).map_err(unwritable),
                    // Somebody has put another file there meanwhile, which is not ours to remove.
                    false => Ok(()),
                }
            }
            Place::File(target) => OpenOptions::new().write(true).open(target).map(drop).map_err(unwritable),
            Place::Stream(path) => stream::may_write(path).map_err(unwritable),
        }
    }

    /// Whether it keeps what is written to it, so that it can be written a second time.
    pub fn is_file(&self) -> bool {
        !matches!(self, Place::Stream(_))
    }

    /// The path of the file itself, or of the stream as it was named.
    pub fn target(&self) -> &Path {
        match self {
            Place::New(path) | Place::File(path) | Place::Stream(path) => path,
        }
    }

    /// Writes `bytes`. A new file is whole or not there; an old one stays until the new one is complete, wherever it
    /// can be replaced (see [`replacing`]). Under `no_clobber` nothing that is there is replaced.
    pub fn write(&self, no_clobber: bool, bytes: &[u8]) -> io::Result<()> {
        match self {
            Place::New(target) => {
                let take_name = |file: Temporary| if no_clobber { file.name(target) } else { file.replace(target) };
                let folder = folder_of(target);
                match take_name(Temporary::new(folder)?.filled(bytes)?) {
                    // Where a file without a name cannot be given one (a policy may forbid links) one with a name can.
                    Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                        take_name(Temporary::named(folder)?.filled(bytes)?)
                    }
                    named => named,
                }?;
                sync_folder(target);
                Ok(())
            }
            Place::File(_) | Place::Stream(_) if no_clobber => Err(io::ErrorKind::AlreadyExists.into()),
            Place::File(target) => {
                replacing::replace(target, bytes)?;
                sync_folder(target);
                Ok(())
            }
            Place::Stream(path) => stream::write(path, bytes),
        }
    }
}

/// The path that `path` leads to by symbolic links; its last part need not exist.
pub fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&target) {
            Ok(metadata) if metadata.is_symlink() => {}
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => return Ok(target),
        }
        // A link into /proc leads to what is open, whatever its text says.
        if is_open_file(&target) {
            return Ok(target);
        }
        target = target.parent().unwrap_or(Path::new("")).join(fs::read_link(&target)?);
    }
    // The system's own words for too many links.
    fs::metadata(&target).map(|_| target)
}

/// Whether `path` is one of the names under which Linux shows the files that processes hold open (`/dev/stdout` leads
/// there). Such a file is written to as it is open: who opened it waits for the bytes in that file and no other.
fn is_open_file(path: &Path) -> bool {
    cfg!(target_os = "linux") && fs::canonicalize(folder_of(path)).is_ok_and(|folder| folder.starts_with("/proc"))
}

/// Whether the file that is open is the one at `path`.
#[cfg(unix)]
fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    file.metadata().map(identity).is_ok_and(|own| fs::metadata(path).map(identity).is_ok_and(|there| there == own))
}

#[cfg(not(unix))]
fn is_same(_: &File, _: &Path) -> bool {
    true
}

/// Makes the naming itself survive a loss of power. Not every file system can sync a folder; the file is whole by then,
/// so a refusal is no error.
fn sync_folder(target: &Path) {
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
    #[cfg(not(unix))]
    let _ = target;
}
