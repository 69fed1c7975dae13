//! Outputs that are written to and stay what they are: devices, pipes, and what this process holds open already.
//!
//! Comes in: a path that is no file of its own, and bytes. Goes out: the bytes, to whoever is at the other end.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
#[cfg(unix)]
use std::{
    thread::sleep,
    time::{Duration, Instant},
};

/// Time within which a pipe has to find a reader once there is something to read.
#[cfg(unix)]
const READER_AFTER: Duration = Duration::from_secs(5);

/// Writes `bytes`; a file that is open already goes on where it ends.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut stream = open(path)?;
    stream.write_all(bytes)?;
    stream.flush()
}

/// Whether this user may write to it. It is not opened for that: a pipe without a reader would wait, and one with a
/// reader would lose it.
#[cfg(unix)]
pub fn may_write(path: &Path) -> io::Result<()> {
    use rustix::fs::{Access, AtFlags, CWD, accessat};
    Ok(accessat(CWD, path, Access::WRITE_OK, AtFlags::EACCESS)?)
}

#[cfg(not(unix))]
pub fn may_write(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Whether `path` is a socket that cannot be opened by its name, which standard output can.
#[cfg(unix)]
pub fn is_unconnected_socket(path: &Path, metadata: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.file_type().is_socket() && standard_stream(path).is_none()
}

#[cfg(not(unix))]
pub fn is_unconnected_socket(_: &Path, _: &Metadata) -> bool {
    false
}

fn open(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path)?;
    if let Some(stream) = standard_stream(path) {
        return stream;
    }
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type()) {
        return open_pipe(path);
    }
    OpenOptions::new().write(true).append(metadata.is_file()).open(path)
}

/// Standard output or standard error, if `path` is a name of it. Opened anew, a file would be written from another
/// place than where its other writers are.
#[cfg(unix)]
fn standard_stream(path: &Path) -> Option<io::Result<File>> {
    use std::os::fd::AsFd;
    let target = super::place::follow(path).ok()?;
    let own = fs::canonicalize(target.parent()?).ok()? == fs::canonicalize("/proc/self/fd").ok()?;
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
    use std::os::unix::fs::OpenOptionsExt;

    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    use rustix::io::Errno;
    let start = Instant::now();
    loop {
        let opened = OpenOptions::new().write(true).custom_flags(OFlags::NONBLOCK.bits() as i32).open(path);
        match opened {
            Err(error) if Errno::from_io_error(&error) == Some(Errno::NXIO) => {
                if start.elapsed() > READER_AFTER {
                    let seconds = READER_AFTER.as_secs();
                    return Err(io::Error::other(format!("nobody has read the pipe for {seconds} s")));
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
