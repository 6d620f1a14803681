//! Finds NuSMV, as a program or as the library in the Python package `pynusmv`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Calls the functions of the library that the main function of the program calls.
const DRIVER: &str = "\
import ctypes, sys
library = ctypes.CDLL(sys.argv[1])
addons = (ctypes.c_void_p * 2)(*(
    ctypes.cast(function, ctypes.c_void_p).value
    for function in (library.AddonsCore_Init, library.AddonsCore_Quit)
))
library.NuSMVCore_init_data()
library.NuSMVCore_init(addons, 1)
library.NuSMVCore_init_cmd_options()
arguments = [b'NuSMV'] + [argument.encode() for argument in sys.argv[2:]]
status = ctypes.c_int(0)
library.NuSMVCore_main(
    len(arguments), (ctypes.c_char_p * (len(arguments) + 1))(*arguments, None), ctypes.byref(status)
)
";

/// An installed NuSMV.
#[derive(Clone, Debug)]
pub struct Nusmv {
    /// The library; `None` for the program.
    library: Option<PathBuf>,
}

impl Nusmv {
    pub(crate) fn find() -> Option<Self> {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let library = repository.join("target/nusmv/lib/libdependencies.so");
        let candidates = [None, Some(library)].map(|library| Self { library });
        candidates.into_iter().find(Self::is_installed)
    }

    fn is_installed(&self) -> bool {
        if self.library.as_ref().is_some_and(|it| !it.exists()) {
            return false;
        }
        let mut command = self.command();
        command.arg("-h").stdin(Stdio::null());
        command.output().is_ok_and(|greeting| {
            let text = [greeting.stdout, greeting.stderr].concat();
            String::from_utf8_lossy(&text).contains("This is NuSMV")
        })
    }

    /// Returns a command to which arguments of NuSMV can be added.
    pub fn command(&self) -> Command {
        let Some(library) = &self.library else {
            return Command::new("NuSMV");
        };
        let mut command = Command::new("python3");
        command.args(["-c", DRIVER]).arg(library);
        command
    }
}
