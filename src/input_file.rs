//! Files that are read: only regular ones, whose size is known before anything is allocated.
//!
//! Comes in: a path. Goes out: an [`InputFile`] or its bytes, or in a few words why there are none: the caller knows
//! who names the file. A foundation below all stages, as [`crate::error`] is. A pipe without a writer, a terminal, a
//! device or an endless file of the system never holds the program up: the file is opened without waiting, and what was
//! opened, not the name, is looked at.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use crate::memory;

/// A regular file, open for reading.
#[derive(Debug)]
pub struct InputFile {
    /// The open file.
    pub file: File,
    /// Its size in bytes.
    pub bytes: u64,
}

impl InputFile {
    /// Opens `path`.
    pub fn open(path: &Path) -> Result<InputFile, String> {
        // What cannot be read is not opened if that can be told before: opening a device may do something to it.
        regular(&std::fs::metadata(path).map_err(reason)?)?;
        let file = without_waiting(OpenOptions::new().read(true)).open(path).map_err(reason)?;
        let metadata = file.metadata().map_err(reason)?;
        regular(&metadata)?;
        Ok(InputFile { file, bytes: metadata.len() })
    }

    /// All bytes of the file. Refused where they are not as many as its size says, as in the files of `/proc`, or where
    /// memory is short.
    pub fn read(self) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let room = usize::try_from(self.bytes).ok().and_then(|size| size.checked_add(1)).unwrap_or(usize::MAX);
        let refused = |_| format!("{} bytes cannot be held in memory", self.bytes);
        memory::check("its text", self.bytes).map_err(|error| error.to_string())?;
        bytes.try_reserve_exact(room).map_err(refused)?;
        self.file.take(room as u64).read_to_end(&mut bytes).map_err(reason)?;
        if bytes.len() as u64 > self.bytes {
            return Err("is longer than its size says; allowed is a file that does not grow".to_owned());
        }
        Ok(bytes)
    }
}

/// All bytes of the file at `path`.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    InputFile::open(path)?.read()
}

fn regular(metadata: &Metadata) -> Result<(), String> {
    if metadata.is_dir() {
        return Err("is a directory; allowed is a file".to_owned());
    }
    if !metadata.is_file() {
        return Err("is not a regular file".to_owned());
    }
    Ok(())
}

#[cfg(unix)]
fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    // The flags of the system fit in its own type of them.
    options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32)
}

#[cfg(not(unix))]
fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

fn reason(error: io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "no such file".to_owned(),
        ErrorKind::PermissionDenied => "no permission to read it".to_owned(),
        _ => error.to_string(),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_of_known_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("plain"), "text").unwrap();
        rustix::fs::mknodat(rustix::fs::CWD, at("pipe"), rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
        let socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        std::os::unix::fs::symlink("pipe", at("link")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", at("zero")).unwrap();
        assert_eq!(read(&at("plain")).as_deref(), Ok(b"text".as_slice()));
        for name in ["pipe", "socket", "link", "zero"] {
            assert_eq!(read(&at(name)), Err("is not a regular file".to_owned()), "{name}");
        }
        assert_eq!(read(folder.path()), Err("is a directory; allowed is a file".to_owned()));
        assert_eq!(read(&at("missing")), Err("no such file".to_owned()));
        assert_eq!(read(&at(&"x".repeat(300))).map(|_| ()).unwrap_err().split(' ').next(), Some("File"));
        drop(socket);
    }

    #[test]
    fn a_file_that_is_longer_than_its_size_is_refused() {
        if Path::new("/proc/self/status").exists() {
            assert!(read(Path::new("/proc/self/status")).unwrap_err().starts_with("is longer than its size says"));
        }
    }
}
