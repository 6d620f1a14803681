//! Exit codes, shared by all commands and listed in `docs/diagnostics.md`.

use std::path::Path;
use std::process::ExitCode;

use crate::files::STANDARD_INPUT;

/// Result of a command. Of several results, the greatest one determines the exit code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Success.
    #[default]
    Ok,
    /// A property is not known to hold, because not all states were explored. Less than a violation of another one.
    Undecided,
    /// An error in a file, a failed scenario, a goal not reached, a collision in the simulated world.
    Findings,
    /// Usage error, including an argument that names something unknown.
    Usage,
    /// A step failed at run time.
    Fault,
}

impl Exit {
    /// The result for errors at a path named on the command line: findings if the file exists, a usage error otherwise.
    pub fn refused(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref();
        if path.is_file() || path == Path::new(STANDARD_INPUT) {
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
            Exit::Undecided => 4,
            Exit::Findings => 1,
            Exit::Usage => 2,
            Exit::Fault => 3,
        })
    }
}
