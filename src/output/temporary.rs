//! A file without a name until it is whole.
//!
//! Comes in: a folder. Goes out: a [`Temporary`] to write to, which takes its name in one step. Where the system can,
//! the file has no name at all while it is written (Linux, `O_TMPFILE`), so that a process that is killed meanwhile
//! leaves nothing behind. Elsewhere it has a hidden one, and what a killed process has left is removed by a later one
//! that writes into the folder.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use tempfile::NamedTempFile;

/// How names of temporary files begin and end.
const PREFIX: &str = ".texray-";
const SUFFIX: &str = ".tmp";

/// A temporary file of this age was left by a process that was killed: none is written for as long.
const STALE: Duration = Duration::from_secs(3600);

/// A file that is being written.
pub enum Temporary {
    /// It has no name.
    #[cfg(target_os = "linux")]
    Unnamed(File),
    /// It has a hidden name, and goes when it is dropped.
    Named(NamedTempFile),
}

impl Temporary {
    /// Makes a file in `folder`; its mode is what the user's umask leaves, as for any new file.
    pub fn new(folder: &Path) -> io::Result<Temporary> {
        #[cfg(target_os = "linux")]
        if let Some(file) = unnamed(folder) {
            return Ok(Temporary::Unnamed(file));
        }
        Temporary::named(folder)
    }

    /// The file, to be written.
    pub fn file(&mut self) -> &mut File {
        match self {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(file) => file,
            Temporary::Named(file) => file.as_file_mut(),
        }
    }

    /// A file with a hidden name, for where a file without one cannot be named.
    pub fn named(folder: &Path) -> io::Result<Temporary> {
        builder().tempfile_in(folder).map(Temporary::Named)
    }

    /// The same file with `bytes`, which are on the disk.
    pub fn filled(mut self, bytes: &[u8]) -> io::Result<Temporary> {
        self.file().write_all(bytes)?;
        self.file().sync_all()?;
        Ok(self)
    }

    /// Gives it the name `target` in the same folder, in the place of what has that name.
    pub fn replace(self, target: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            // A link cannot take a name that is taken, and a rename can: the file gets a hidden name for a moment.
            Temporary::Unnamed(file) => {
                let hidden = builder().make_in(folder_of(target), |hidden| link(&file, hidden))?;
                hidden.persist(target).map(drop).map_err(|error| error.error)
            }
            Temporary::Named(file) => file.persist(target).map(drop).map_err(|error| error.error),
        }
    }

    /// Gives it the name `target` in the same folder, unless something has that name.
    pub fn name(self, target: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(file) => link(&file, target),
            Temporary::Named(file) => file.persist_noclobber(target).map(drop).map_err(|error| error.error),
        }
    }
}

/// The folder that a file of this path is in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Removes hidden files in `folder` that this user's killed processes have left. Nothing depends on it, so no failure
/// is told.
pub fn remove_stale(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if ours && entry.metadata().is_ok_and(|metadata| is_stale(&metadata)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_stale(metadata: &fs::Metadata) -> bool {
    let age = metadata.modified().ok().and_then(|modified| modified.elapsed().ok());
    metadata.is_file() && is_own(metadata) && age.is_some_and(|age| age > STALE)
}

#[cfg(unix)]
fn is_own(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    metadata.uid() == rustix::process::geteuid().as_raw()
}

#[cfg(not(unix))]
fn is_own(_: &fs::Metadata) -> bool {
    true
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// A file without a name; `None` where the file system has no such, or no way to name one later.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path) -> Option<File> {
    use rustix::fs::{CWD, Mode, OFlags, openat};
    let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
    let file = File::from(openat(CWD, folder, flags, Mode::from_raw_mode(0o666)).ok()?);
    handle(&file).symlink_metadata().is_ok().then_some(file)
}

/// Names a file that has no name; fails where the name is taken.
#[cfg(target_os = "linux")]
fn link(file: &File, name: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    Ok(linkat(CWD, handle(file), CWD, name, AtFlags::SYMLINK_FOLLOW)?)
}

/// The path that an open file has in this process, whatever its name.
#[cfg(target_os = "linux")]
fn handle(file: &File) -> std::path::PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn both_kinds_of_file_take_their_name_when_they_are_whole() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let named = || Temporary::Named(builder().tempfile_in(folder.path()).unwrap());
        let make: [&dyn Fn() -> Temporary; 2] = [&named, &|| Temporary::new(folder.path()).unwrap()];
        for make in make {
            let with = |bytes: &[u8]| make().filled(bytes).unwrap();
            with(b"first").name(&target).unwrap();
            assert_eq!(with(b"second").name(&target).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
            assert_eq!(fs::read(&target).unwrap(), b"first");
            with(b"third").replace(&target).unwrap();
            assert_eq!((fs::read(&target).unwrap(), names(folder.path())), (b"third".to_vec(), vec!["a".to_string()]));
            drop(with(b"dropped"));
            assert!(with(b"x").replace(&folder.path().join("missing/a")).is_err());
            assert_eq!(names(folder.path()), ["a"]);
            fs::remove_file(&target).unwrap();
        }
    }

    #[test]
    fn what_killed_processes_left_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let old = std::time::SystemTime::now() - 2 * STALE;
        for (name, time) in [(".texray-abc.tmp", old), (".texray-new.tmp", old + 2 * STALE), ("texray-abc.tmp", old)] {
            File::create(folder.path().join(name)).unwrap().set_modified(time).unwrap();
        }
        remove_stale(folder.path());
        assert_eq!(names(folder.path()), [".texray-new.tmp", "texray-abc.tmp"]);
    }
}
