//! What the exit code says: the one table of all commands, as in `docs/diagnostics.md`.

use std::path::Path;
use std::process::ExitCode;

/// How a command ended. Of several, the greatest counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// All is well.
    #[default]
    Ok,
    /// Something was found: an error in a file, a scenario that fails, a goal not reached.
    Findings,
    /// The command cannot be carried out as it was given: an argument names what is not there.
    Usage,
    /// A step failed at run time.
    Fault,
}

impl Exit {
    /// There are errors at a path that was named on the command line: in the file, or there is none.
    pub fn refused(path: impl AsRef<Path>) -> Self {
        if path.as_ref().is_file() {
            Self::Findings
        } else {
            Self::Usage
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Ok => 0,
            Exit::Findings => 1,
            Exit::Usage => 2,
            Exit::Fault => 3,
        })
    }
}
