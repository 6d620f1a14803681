//! For tests that need something that not every machine has. A skipped test says so past the test harness, which hides the output
//! of tests that pass, and fails where the environment variable `CI` is set.

mod compiler;
mod nusmv;
mod ports;

pub use nusmv::Nusmv;
pub use ports::free_ports;

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Names of requirements that may be missing although `CI` is set, separated by blanks.
const PERMISSION: &str = "ASMOTION_SKIP";

/// Requirements of which a notice has been printed.
static NOTICED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Something that tests need.
#[derive(Clone, Copy, Debug)]
pub struct Requirement<'a> {
    /// Name in the environment variable `ASMOTION_SKIP`.
    pub name: &'a str,
    /// The tests that need it.
    pub tests: &'a str,
    /// Way to get it.
    pub remedy: &'a str,
}

/// Python 3, in which the peers of some tests are written.
pub const PYTHON: Requirement<'_> = Requirement {
    name: "python",
    tests: "the tests with a program in Python",
    remedy: "Install the package `python3`, or run `./test`",
};

/// A compiler for C and C++.
pub const CPP: Requirement<'_> = Requirement {
    name: "cpp",
    tests: "the tests with programs in C and C++",
    remedy: "Install the package `g++`, or run `./test`",
};

/// The compiler of TypeScript.
pub const TYPESCRIPT: Requirement<'_> = Requirement {
    name: "typescript",
    tests: "the tests of generated TypeScript",
    remedy: "Install `tsc` with `npm install --global typescript@5`, or run `./test`",
};

/// The messages of ROS 1 in Python.
pub const GENPY: Requirement<'_> = Requirement {
    name: "genpy",
    tests: "the comparisons with ROS 1",
    remedy: "Install Debian's package `python3-genpy`, or run `./test`",
};

/// Master, tools and nodes of ROS 1.
pub const ROSPY: Requirement<'_> = Requirement {
    name: "rospy",
    tests: "the tests with ROS 1",
    remedy: "Install Debian's packages `python3-rosmaster`, `python3-rosnode`, `python3-rosservice`, `python3-actionlib`, `python3-geometry-msgs`, `python3-nav-msgs` and `python3-std-srvs`, or run `./test`",
};

/// Transforms of ROS 1 in Python.
pub const TF2: Requirement<'_> = Requirement {
    name: "tf2",
    tests: "the comparison of transforms with tf2",
    remedy: "Install Debian's packages `python3-tf2` and `python3-tf2-geometry-msgs`, or run `./test`",
};

/// Cyclone DDS in Python, a peer that is no code of ours.
pub const CYCLONEDDS: Requirement<'_> = Requirement {
    name: "cyclonedds",
    tests: "the tests of ROS 2 with Cyclone DDS",
    remedy: "Run `./test`, which installs the Python package `cyclonedds` in `target/`",
};

/// Nodes of ROS 2 in Python, on Fast DDS.
pub const RCLPY: Requirement<'_> = Requirement {
    name: "rclpy",
    tests: "the tests of ROS 2 with rclpy on Fast DDS",
    remedy: "Run `./test`, which installs the Python packages of ROS 2 Jazzy in `target/`",
};

/// Packages of Python.
pub const PYPI: Requirement<'_> = Requirement {
    name: "pypi",
    tests: "the tests with packages of Python",
    remedy: "Make PyPI reachable for `pip install`",
};

/// RabbitMQ.
pub const BROKER: Requirement<'_> = Requirement {
    name: "broker",
    tests: "the tests on a real broker",
    remedy: "Install the package `rabbitmq-server`, or run `./test`",
};

/// NuSMV, another model checker.
pub const NUSMV: Requirement<'_> = Requirement {
    name: "nusmv",
    tests: "the comparisons with NuSMV",
    remedy: "Put `NuSMV` on the path, or run `./test` on Linux for x86-64",
};

/// The specifications of the ASMETA project.
const CORPUS: Requirement<'_> = Requirement {
    name: "corpus",
    tests: "the tests on the specifications of ASMETA",
    remedy: "Set `ASMETA_CORPUS` to a checkout of asmeta/asmeta",
};

impl Requirement<'_> {
    /// Reports that tests are skipped because this is missing, once for each test program.
    ///
    /// # Panics
    /// Panics if `CI` is set and `ASMOTION_SKIP` does not contain the name.
    #[expect(clippy::panic, reason = "a test without what it needs has failed")]
    pub fn skip(&self) {
        let Self {
            name,
            tests,
            remedy,
        } = self;
        let permitted = std::env::var(PERMISSION).unwrap_or_default();
        if must_fail(std::env::var_os("CI").is_some(), &permitted, name) {
            panic!("{tests} cannot run. {remedy}, or add `{name}` to `{PERMISSION}`.");
        }
        let mut noticed = NOTICED.lock().unwrap_or_else(PoisonError::into_inner);
        if noticed.insert((*name).to_owned()) {
            let notice = format!("\n*** SKIPPED: {tests}. {remedy}.\n\n");
            let _ = std::io::stderr().write_all(notice.as_bytes());
        }
    }
}

fn must_fail(is_ci: bool, permitted: &str, name: &str) -> bool {
    is_ci && !permitted.split_whitespace().any(|word| word == name)
}

/// Returns whether a compiler for C and C++ is installed, and reports that tests are skipped if it is not.
///
/// # Panics
/// See [`Requirement::skip`].
pub fn has_compiler() -> bool {
    let is_installed = compiler::is_installed();
    if !is_installed {
        CPP.skip();
    }
    is_installed
}

/// Compiles a program once for all tests of a build; `None`, with a notice, without a compiler. `source` is a path in the
/// repository that ends with `.c` or `.cpp`.
///
/// # Panics
/// The source does not compile without warnings. See also [`Requirement::skip`].
pub fn compile(source: &str) -> Option<PathBuf> {
    has_compiler().then(|| compiler::compile(source))
}

/// Returns NuSMV; `None`, with a notice, if it is not installed.
///
/// # Panics
/// See [`Requirement::skip`].
pub fn nusmv() -> Option<Nusmv> {
    let found = Nusmv::find();
    if found.is_none() {
        NUSMV.skip();
    }
    found
}

/// Returns the folder of ASMETA's specifications, which `ASMETA_CORPUS` names; `None`, with a notice, if it is not set.
///
/// # Panics
/// See [`Requirement::skip`].
pub fn corpus() -> Option<PathBuf> {
    let corpus = std::env::var_os("ASMETA_CORPUS").map(PathBuf::from);
    if corpus.is_none() {
        CORPUS.skip();
    }
    corpus
}

/// Returns a path in the folder `shared` beside the repository, which contains reference results and data too large for it;
/// `None`, with a notice, if there is no such file or folder.
///
/// # Panics
/// See [`Requirement::skip`].
pub fn shared(path: &str) -> Option<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let found = repository.join("../shared").join(path);
    if found.exists() {
        return Some(found);
    }
    let requirement = Requirement {
        name: "shared",
        tests: &format!("the tests on `../shared/{path}`"),
        remedy: "Put the folder `shared` beside the repository",
    };
    requirement.skip();
    None
}

#[cfg(test)]
mod tests {
    use super::must_fail;

    #[test]
    fn what_is_missing_fails_in_ci_unless_it_is_permitted() {
        assert!(!must_fail(false, "", "corpus"));
        assert!(must_fail(true, "", "corpus"));
        assert!(must_fail(true, "corpus-2 shared", "corpus"));
        assert!(!must_fail(true, "shared corpus", "corpus"));
    }
}
