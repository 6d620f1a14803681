//! A user at a terminal, simulated in a pseudo-terminal: waits for text, presses keys, and repeats.

use std::process::Command;

/// In a terminal of 24 lines: waits for each text, then presses its keys. Exits with the program's exit code, or with
/// 99 if a text never appeared.
pub(super) const PERSON: &str = r#"
import fcntl, json, os, pty, select, struct, sys, termios, time
steps, program = json.loads(sys.argv[1]), sys.argv[2:]
pid, screen = pty.fork()
if pid == 0:
    os.environ["TERM"] = "xterm"
    os.execv(program[0], program)
fcntl.ioctl(screen, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
seen, looked, until = b"", 0, time.time() + 60
while time.time() < until:
    if select.select([screen], [], [], 0.1)[0]:
        try:
            seen += os.read(screen, 65536)
        except OSError:
            break
    found = seen.find(steps[0][0].encode(), looked) if steps else -1
    if found >= 0:
        looked = found + len(steps[0][0].encode())
        os.write(screen, steps.pop(0)[1].encode())
else:
    os.kill(pid, 9)
_, status = os.waitpid(pid, 0)
sys.stdout.buffer.write(seen)
sys.exit(99 if steps else os.waitstatus_to_exitcode(status))
"#;

/// The text on the screen, and the exit code of `asmotion`; `None` without Python.
pub(super) fn person(
    (password, url): (&str, &str),
    arguments: &[&str],
    steps: &[(&str, &str)],
) -> Option<(Option<i32>, String)> {
    let home = tempfile::tempdir().unwrap();
    let person = Command::new("python3")
        .args(["-c", PERSON, &serde_json::to_string(steps).unwrap()])
        .arg(env!("CARGO_BIN_EXE_asmotion"))
        .args(arguments)
        .env("ASMOTION_BUS", url)
        .env("ASMOTION_PASSWORD", password)
        .env("XDG_STATE_HOME", home.path())
        .output();
    let Ok(person) = person else {
        asmotion_skip::PYTHON.skip();
        return None;
    };
    let screen = String::from_utf8_lossy(&person.stdout).into_owned();
    Some((person.status.code(), screen))
}
