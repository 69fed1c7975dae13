//! How new bytes take the place of a file that is there.
//!
//! Comes in: the path of a regular file, and bytes. Goes out: the file with these bytes, its mode and owner as they
//! were. As a rule a second file is written and renamed, so that the old bytes stay until the new ones are complete.
//! Where that would change what is there, or is not allowed, the old file is written over: a mount point (`docker -v
//! out.exr:/out.exr`), a file with other names, one of another user in a folder such as /tmp, a file in a folder
//! without write permission. Then a process that is killed meanwhile leaves a mixture. For lack of room nothing is
//! written over.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::temporary::{Temporary, folder_of};

/// Replaces the bytes of the file at `target`.
pub fn replace(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let renamed = successor(target).and_then(|new| new.filled(bytes)?.replace(target));
    match renamed {
        Err(error) if is_for_lack_of_a_right(&error) => over(target, bytes),
        renamed => renamed,
    }
}

/// Whether a second file could not be made or renamed for a reason that writing over the first one does not have.
fn is_for_lack_of_a_right(error: &io::Error) -> bool {
    use ErrorKind::{CrossesDevices, PermissionDenied, ReadOnlyFilesystem, ResourceBusy, Unsupported};
    matches!(error.kind(), PermissionDenied | ReadOnlyFilesystem | ResourceBusy | CrossesDevices | Unsupported)
}

/// A file without a name, with the mode and owner of the one at `target`, to be put into its place.
fn successor(target: &Path) -> io::Result<Temporary> {
    let old = fs::metadata(target)?;
    if has_other_names(&old) {
        return Err(io::Error::new(ErrorKind::Unsupported, "its other names would keep the old bytes"));
    }
    if is_mounted(&old, &fs::metadata(folder_of(target))?) {
        return Err(io::Error::new(ErrorKind::Unsupported, "it is a mount point"));
    }
    let mut new = Temporary::new(folder_of(target))?;
    take_after(new.file(), &old)?;
    Ok(new)
}

/// Writes over the bytes of the file at `target`. Room for all of them is made first, and what is too much is cut off
/// last: where the disk is full the old bytes stay.
fn over(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).open(target)?;
    make_room(&file, bytes.len() as u64)?;
    file.write_all(bytes)?;
    file.set_len(bytes.len() as u64)?;
    file.sync_all()
}

/// Has the disk set aside room for `bytes` bytes of the file, where its file system can.
#[cfg(target_os = "linux")]
fn make_room(file: &File, bytes: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    use rustix::io::Errno;
    let before = file.metadata()?.len();
    if bytes <= before {
        return Ok(());
    }
    match fallocate(file, FallocateFlags::empty(), 0, bytes) {
        Err(Errno::OPNOTSUPP | Errno::NOSYS | Errno::INVAL) | Ok(()) => Ok(()),
        Err(error) => {
            // Part of it may have been set aside.
            file.set_len(before)?;
            Err(error.into())
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn make_room(_: &File, _: u64) -> io::Result<()> {
    Ok(())
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

/// Whether a file lies on another file system than its folder. (One that is mounted from the same file system is found
/// out when it is renamed over.)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_over_and_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for [old, new] in [["longer", "new"], ["old", "longer"], ["", "x"], ["x", ""]] {
            fs::write(&path, old).unwrap();
            over(&path, new.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), new);
        }
        assert!(over(&folder.path().join("missing"), b"").is_err());
    }

    #[test]
    fn a_full_disk_is_no_reason_to_write_over() {
        for kind in [ErrorKind::StorageFull, ErrorKind::QuotaExceeded, ErrorKind::FileTooLarge, ErrorKind::Other] {
            assert!(!is_for_lack_of_a_right(&kind.into()), "{kind}");
        }
        assert!(is_for_lack_of_a_right(&ErrorKind::PermissionDenied.into()));
    }
}
