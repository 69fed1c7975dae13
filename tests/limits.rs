//! Little address space, few threads: a picture or an error with need and have, never a death by a signal or a wait
//! without end.
//!
//! Comes in: the program under `ulimit`. Where a limit begins to bind depends on driver and machine, so these tests
//! look at how a run ends, not at which limit it needs. The limit on threads does not bind root: the program then
//! runs as another user, by `setpriv`.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A user that nobody is, and that has no other processes.
const NOBODY_ELSE: &str = "64321";

/// Longer than the start-up probe may take.
const PATIENCE: Duration = Duration::from_secs(90);

/// A folder that every user may use, with the program and a scene of two triangles.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    put("lit.mtl", "newmtl lamp\nKe 1 1 1\nKd 0.5 0.5 0.5\n");
    put("lit.obj", "mtllib lit.mtl\nusemtl lamp\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    fs::copy(env!("CARGO_BIN_EXE_texray"), folder.path().join("texray")).expect("a copy of the program");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o777)).expect("open to all");
    }
    folder
}

fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output().expect("id is a standard program");
    output.stdout.trim_ascii() == b"0"
}

/// Renders under the limits of `command`, to which the program is added. What it said comes back with how it ended.
fn render(folder: &Path, mut command: Command, limit: &str) -> (ExitStatus, String) {
    let said = folder.join("said");
    let file = fs::File::create(&said).expect("a file");
    let _ = fs::remove_file(folder.join("x.png"));
    command.args(["./texray", "render", "lit.obj", "--size", "8x8", "--spp", "1", "-q", "-o", "x.png"]);
    command.current_dir(folder).stdout(Stdio::null()).stderr(file);
    let status = wait(command.spawn().expect("sh, prlimit and setpriv are installed"), limit);
    (status, fs::read_to_string(said).expect("what it said"))
}

/// `sh` that sets a limit on address space for what follows.
fn with_address_space(kibibytes: u64) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {kibibytes}; exec \"$@\""), "sh"]);
    command
}

/// `prlimit` (util-linux) that sets a limit on tasks for what follows, and for root `setpriv` to become a user whom
/// it binds.
fn with_tasks(tasks: u32) -> Command {
    let mut command = Command::new("prlimit");
    command.arg(format!("--nproc={tasks}"));
    if is_root() {
        command.args(["setpriv", &format!("--reuid={NOBODY_ELSE}"), "--clear-groups"]);
    }
    command
}

fn wait(mut child: Child, limit: &str) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("a child of this process") {
            return status;
        }
        if start.elapsed() > PATIENCE {
            child.kill().expect("it still runs");
            panic!("ulimit {limit}: neither picture nor error after {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn little_address_space_is_an_error_that_says_so() {
    let folder = folder();
    let mut refused = 0;
    // From far too little, past where pools of threads do not fit, to plenty.
    for kibibytes in (60_000..1_400_000).step_by(70_000).chain([16_000_000]) {
        let (status, said) = render(folder.path(), with_address_space(kibibytes), &format!("-v {kibibytes}"));
        match status.code() {
            Some(0) => assert!(folder.path().join("x.png").exists(), "ulimit -v {kibibytes}: no picture\n{said}"),
            Some(4) => {
                refused += 1;
                assert!(said.contains("address space") || said.contains("memory"), "ulimit -v {kibibytes}: {said}");
                assert!(said.contains("needed") && said.contains("available"), "ulimit -v {kibibytes}: {said}");
            }
            _ => panic!("ulimit -v {kibibytes}: {status}\n{said}"),
        }
        assert!(kibibytes > 130_000 || status.code() == Some(4), "no driver fits {kibibytes} KiB");
        assert!(kibibytes < 16_000_000 || status.success(), "16 GB are plenty: {said}");
    }
    assert!(refused >= 2);
}

#[test]
fn few_threads_are_a_slower_picture_or_an_error_that_says_so() {
    let folder = folder();
    // Others than root have processes of their own, which count: the least limit is the one that is sure to bind.
    let most = if is_root() { 24 } else { 1 };
    for tasks in 1..=most {
        let (status, said) = render(folder.path(), with_tasks(tasks), &format!("-u {tasks}"));
        match status.code() {
            Some(0) if tasks > 1 => {
                assert!(folder.path().join("x.png").exists(), "ulimit -u {tasks}: no picture\n{said}");
            }
            Some(4) => {
                assert!(said.contains(&format!("ulimit -u is {tasks}")), "ulimit -u {tasks}: {said}");
                assert!(said.contains("needed") && said.contains("available"), "ulimit -u {tasks}: {said}");
            }
            _ => panic!("ulimit -u {tasks}: {status}\n{said}"),
        }
    }
}
