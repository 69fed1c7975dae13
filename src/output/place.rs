//! What a path names as an output: nothing yet, a file, or a stream such as a device or a pipe.
//!
//! Comes in: a path. Goes out: a [`Place`] that bytes can be written to, or why none can. Symbolic links are followed, and stay.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::{
    thread::sleep,
    time::{Duration, Instant},
};

use super::temporary::{Temporary, folder_of};

use crate::quote;

/// Links that are followed at most; Linux follows as many.
const MOST_LINKS: usize = 40;

/// Time within which a pipe has to find a reader once there is something to read.
#[cfg(unix)]
const READER_AFTER: Duration = Duration::from_secs(5);

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
            (Ok(metadata), _) if is_socket(&metadata) => Err("is a socket".into()),
            (Ok(metadata), target) if metadata.is_file() && !is_open_file(&target) => Ok(Place::File(target)),
            // Opened by the name that was given: what /proc shows of a pipe is no path.
            (Ok(_), _) => Ok(Place::Stream(path.into())),
            (Err(error), target) if error.kind() == io::ErrorKind::NotFound => Ok(Place::New(target)),
            (Err(error), _) => Err(error.to_string()),
        }
    }

    /// Whether it can be written to, as far as can be known; the error says why not. Nothing stays of the trial.
    pub fn try_out(&self) -> Result<(), String> {
        match self {
            Place::New(target) => {
                let folder = folder_of(target);
                if !folder.is_dir() {
                    return Err(format!("the folder {} does not exist", quote::path(folder)));
                }
                // The file itself and not some other: a file system may refuse a name, too.
                let made = OpenOptions::new().write(true).create_new(true).open(target);
                made.map_err(|error| format!("the folder {} cannot be written: {error}", quote::path(folder)))?;
                fs::remove_file(target).map_err(|error| error.to_string())
            }
            Place::File(target) => OpenOptions::new()
                .write(true)
                .open(target)
                .map(drop)
                .map_err(|error| format!("cannot be written: {error}")),
            Place::Stream(path) => may_write(path).map_err(|error| format!("cannot be written: {error}")),
        }
    }

    /// Whether it keeps what is written to it, so that it can be written a second time.
    pub fn is_file(&self) -> bool {
        !matches!(self, Place::Stream(_))
    }

    /// Writes `bytes`, whole or not at all where the place allows it. Under `no_clobber` nothing that is there is replaced.
    pub fn write(&self, no_clobber: bool, bytes: &[u8]) -> io::Result<()> {
        match self {
            Place::New(target) if no_clobber => filled(Temporary::new(folder_of(target))?, bytes)?.name(target)?,
            Place::New(target) => filled(Temporary::new(folder_of(target))?, bytes)?.replace(target)?,
            Place::File(_) | Place::Stream(_) if no_clobber => return Err(io::ErrorKind::AlreadyExists.into()),
            // What a new file cannot do for lack of a right, writing over the old one can: it may be a mount point, which cannot be
            // renamed over, or the file of another user in a folder such as /tmp. For lack of room it is not tried, as the old
            // bytes would be lost.
            Place::File(target) => {
                let replaced = match successor(target) {
                    Ok(new) => filled(new, bytes)?.replace(target).is_ok(),
                    Err(_) => false,
                };
                if !replaced {
                    return over(target, bytes);
                }
            }
            Place::Stream(path) => {
                let mut stream = open_stream(path)?;
                return stream.write_all(bytes).and_then(|()| stream.flush());
            }
        }
        sync_folder(self.target());
        Ok(())
    }

    /// The folder that it is in.
    pub fn folder(&self) -> &Path {
        folder_of(self.target())
    }

    fn target(&self) -> &Path {
        match self {
            Place::New(path) | Place::File(path) | Place::Stream(path) => path,
        }
    }
}

/// The path that `path` leads to by symbolic links; its last part need not exist.
fn follow(path: &Path) -> io::Result<PathBuf> {
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

/// Whether `path` is one of the names under which the system shows the files that processes hold open (`/dev/stdout` leads there).
/// Such a file is written to as it is open: who opened it waits for the bytes in that file and no other.
fn is_open_file(path: &Path) -> bool {
    cfg!(target_os = "linux") && fs::canonicalize(folder_of(path)).is_ok_and(|folder| folder.starts_with("/proc"))
}

#[cfg(unix)]
fn may_write(path: &Path) -> io::Result<()> {
    use rustix::fs::{Access, AtFlags, CWD, accessat};
    // Not by opening it: a pipe without a reader would wait, and one with a reader would lose it.
    Ok(accessat(CWD, path, Access::WRITE_OK, AtFlags::EACCESS)?)
}

#[cfg(not(unix))]
fn may_write(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Opens a stream to be written; a file that is open already goes on where it ends.
fn open_stream(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path)?;
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type()) {
        return open_pipe(path);
    }
    match standard_stream(path) {
        Some(stream) => stream,
        None => OpenOptions::new().write(true).append(metadata.is_file()).open(path),
    }
}

/// Standard output or standard error, if `path` is a name of it. Opened anew, a file would be written from another place than where its
/// other writers are.
#[cfg(unix)]
fn standard_stream(path: &Path) -> Option<io::Result<File>> {
    use std::os::fd::AsFd;
    let target = follow(path).ok()?;
    let own = fs::canonicalize(folder_of(&target)).ok()? == fs::canonicalize("/proc/self/fd").ok()?;
    let stream = match target.file_name()?.to_str()? {
        "1" if own => io::stdout().as_fd().try_clone_to_owned(),
        "2" if own => io::stderr().as_fd().try_clone_to_owned(),
        _ => return None,
    };
    Some(stream.map(File::from))
}

#[cfg(not(unix))]
fn standard_stream(_: &Path) -> Option<io::Result<File>> {
    None
}

/// Opens a pipe once somebody reads it, which is not waited for for ever.
#[cfg(unix)]
fn open_pipe(path: &Path) -> io::Result<File> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    use rustix::io::Errno;
    use std::os::unix::fs::OpenOptionsExt;
    let start = Instant::now();
    loop {
        let opened = OpenOptions::new().write(true).custom_flags(OFlags::NONBLOCK.bits() as i32).open(path);
        match opened {
            Err(error) if Errno::from_io_error(&error) == Some(Errno::NXIO) => {
                if start.elapsed() > READER_AFTER {
                    return Err(io::Error::other(format!("nobody has read the pipe for {} s", READER_AFTER.as_secs())));
                }
                sleep(Duration::from_millis(20));
            }
            opened => {
                let pipe = opened?;
                // From here on a reader may take its time.
                fcntl_setfl(&pipe, fcntl_getfl(&pipe)? - OFlags::NONBLOCK)?;
                return Ok(pipe);
            }
        }
    }
}

#[cfg(unix)]
fn is_socket(metadata: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.file_type().is_socket()
}

#[cfg(not(unix))]
fn is_socket(_: &Metadata) -> bool {
    false
}

/// A file without a name with the mode and owner of the one at `target`, to be put into its place; fails where it could not be.
fn successor(target: &Path) -> io::Result<Temporary> {
    let old = fs::metadata(target)?;
    if has_other_names(&old) {
        return Err(io::Error::other("its other names would keep the old bytes"));
    }
    if is_mounted(&old, &fs::metadata(folder_of(target))?) {
        return Err(io::Error::other("it is a mount point"));
    }
    let mut new = Temporary::new(folder_of(target))?;
    take_after(new.file(), &old)?;
    Ok(new)
}

/// The file with `bytes`, which are on the disk.
fn filled(mut temporary: Temporary, bytes: &[u8]) -> io::Result<Temporary> {
    temporary.file().write_all(bytes)?;
    temporary.file().sync_all()?;
    Ok(temporary)
}

/// Writes over the bytes of the file at `target`. It is cut at the end, not before: where the disk fills up, no more than needed is
/// lost.
fn over(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).open(target)?;
    file.write_all(bytes)?;
    file.set_len(bytes.len() as u64)?;
    file.sync_all()
}

#[cfg(unix)]
fn has_other_names(metadata: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    metadata.nlink() > 1
}

#[cfg(not(unix))]
fn has_other_names(_: &Metadata) -> bool {
    false
}

/// Whether a file lies on another file system than its folder. (One that is mounted from the same file system is found out when it is
/// renamed over.)
#[cfg(unix)]
fn is_mounted(file: &Metadata, folder: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.dev() != folder.dev()
}

#[cfg(not(unix))]
fn is_mounted(_: &Metadata, _: &Metadata) -> bool {
    false
}

/// Gives `new` the owner, group and mode of `old`; fails where this user may not.
#[cfg(unix)]
fn take_after(new: &File, old: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let own = new.metadata()?;
    if (own.uid(), own.gid()) != (old.uid(), old.gid()) {
        fchown(new, Some(old.uid()), Some(old.gid()))?;
    }
    // After the owner, whose change clears bits of the mode.
    new.set_permissions(old.permissions())
}

#[cfg(not(unix))]
fn take_after(_: &File, _: &Metadata) -> io::Result<()> {
    Ok(())
}

/// Makes the naming itself survive a loss of power. Not every file system can sync a folder; the file is whole by then, so a refusal
/// is no error.
fn sync_folder(target: &Path) {
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
    #[cfg(not(unix))]
    let _ = target;
}
