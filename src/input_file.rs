//! Files that are read: regular ones, whose size is known before anything is allocated, and pipes where a caller asks.
//!
//! Comes in: a path. Goes out: an [`InputFile`] or its bytes, or in a few words why there are none: the caller knows
//! who names the file. A foundation below all stages, as [`crate::error`] is. A pipe without a writer, a terminal, a
//! device or an endless file of the system never holds the program up: the file is opened without waiting, and what was
//! opened, not the name, is looked at.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Cursor, ErrorKind, Read, Seek, SeekFrom};
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

/// Most bytes that are read from a pipe: they are held in memory.
pub const MOST_PIPE_BYTES: u64 = 1 << 30;
/// Bytes of a pipe between two looks at the memory that is left.
const STEP_BYTES: u64 = 16 << 20;

/// A file, or all that came through a pipe.
#[derive(Debug)]
pub struct Input {
    source: Source,
    /// Its size in bytes.
    pub bytes: u64,
}

#[derive(Debug)]
enum Source {
    File(File),
    Held(Cursor<Vec<u8>>),
}

impl Input {
    /// Opens a file, or reads a pipe to its end, up to [`MOST_PIPE_BYTES`].
    pub fn open(path: &Path) -> Result<Input, String> {
        let metadata = std::fs::metadata(path).map_err(reason)?;
        if is_pipe(&metadata) {
            let held = read_pipe(path)?;
            return Ok(Input { bytes: held.len() as u64, source: Source::Held(Cursor::new(held)) });
        }
        let InputFile { file, bytes } = InputFile::open(path)?;
        Ok(Input { source: Source::File(file), bytes })
    }
}

impl Read for Input {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match &mut self.source {
            Source::File(file) => file.read(into),
            Source::Held(held) => held.read(into),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.source {
            Source::File(file) => file.seek(to),
            Source::Held(held) => held.seek(to),
        }
    }
}

#[cfg(unix)]
fn is_pipe(metadata: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

/// All that comes through the pipe at `path`, whose writer may take its time; one that has none in a second is refused.
#[cfg(unix)]
fn read_pipe(path: &Path) -> Result<Vec<u8>, String> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    use std::time::{Duration, Instant};
    let mut pipe = without_waiting(OpenOptions::new().read(true)).open(path).map_err(reason)?;
    if !is_pipe(&pipe.metadata().map_err(reason)?) {
        return Err("is a pipe no more".to_owned());
    }
    let mut bytes = vec![0];
    let opened = Instant::now();
    loop {
        match pipe.read(&mut bytes) {
            Ok(0) if opened.elapsed() < Duration::from_secs(1) => std::thread::sleep(Duration::from_millis(5)),
            Ok(0) => return Err("is a pipe that nobody writes to".to_owned()),
            Ok(_) => break,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                bytes.clear();
                break;
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(reason(error)),
        }
    }
    // Its writer is there, and is waited for.
    let flags = fcntl_getfl(&pipe).map_err(|error| error.to_string())?;
    fcntl_setfl(&pipe, flags & !OFlags::NONBLOCK).map_err(|error| error.to_string())?;
    loop {
        memory::check("what comes through the pipe", STEP_BYTES).map_err(|error| error.to_string())?;
        let refused = |_| "what comes through the pipe cannot be held in memory".to_owned();
        bytes.try_reserve(STEP_BYTES as usize).map_err(refused)?;
        let read = (&pipe).take(STEP_BYTES).read_to_end(&mut bytes).map_err(reason)?;
        if bytes.len() as u64 > MOST_PIPE_BYTES {
            return Err(format!("more than {MOST_PIPE_BYTES} bytes come through the pipe; allowed are as many"));
        }
        if (read as u64) < STEP_BYTES {
            return Ok(bytes);
        }
    }
}

#[cfg(not(unix))]
fn read_pipe(_: &Path) -> Result<Vec<u8>, String> {
    Err("is not a regular file".to_owned())
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

    /// The writer of a pipe is waited for, and one without a writer is not.
    #[test]
    fn a_pipe_is_read_to_its_end() {
        use std::io::Write;
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
        assert_eq!(Input::open(&pipe).unwrap_err(), "is a pipe that nobody writes to");
        let text: Vec<u8> = (0..1 << 20).map(|i| (i % 251) as u8).collect();
        let (path, sent) = (pipe.clone(), text.clone());
        let writer = std::thread::spawn(move || {
            let mut pipe = OpenOptions::new().write(true).open(path).unwrap();
            for part in sent.chunks(100_000) {
                std::thread::sleep(std::time::Duration::from_millis(20));
                pipe.write_all(part).unwrap();
            }
        });
        let mut input = Input::open(&pipe).unwrap();
        writer.join().unwrap();
        let mut bytes = Vec::new();
        input.read_to_end(&mut bytes).unwrap();
        assert!(bytes == text && input.bytes == text.len() as u64);
        assert_eq!(input.seek(SeekFrom::Start(5)).unwrap(), 5);
        std::fs::write(folder.path().join("plain"), "text").unwrap();
        assert_eq!(Input::open(&folder.path().join("plain")).unwrap().bytes, 4);
        assert_eq!(Input::open(Path::new("/dev/zero")).unwrap_err(), "is not a regular file");
    }

    #[test]
    fn a_file_that_is_longer_than_its_size_is_refused() {
        if Path::new("/proc/self/status").exists() {
            assert!(read(Path::new("/proc/self/status")).unwrap_err().starts_with("is longer than its size says"));
        }
    }
}
