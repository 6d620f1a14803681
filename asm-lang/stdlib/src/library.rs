//! The embedded texts of the standard libraries.

/// A standard library, as imported by specifications.
#[derive(Debug)]
pub struct StandardLibrary {
    /// Name of the module, for example `StandardLibrary`.
    pub name: &'static str,
    /// Source text in AsmetaL.
    pub text: &'static str,
}

static LIBRARIES: [StandardLibrary; 7] = [
    StandardLibrary {
        name: "StandardLibrary",
        text: include_str!("../asm/StandardLibrary.asm"),
    },
    StandardLibrary {
        name: "CTLLibrary",
        text: include_str!("../asm/CTLLibrary.asm"),
    },
    StandardLibrary {
        name: "LTLLibrary",
        text: include_str!("../asm/LTLLibrary.asm"),
    },
    StandardLibrary {
        name: "TimeLibrary",
        text: include_str!("../asm/TimeLibrary.asm"),
    },
    StandardLibrary {
        name: "TimeLibrarySimple",
        text: include_str!("../asm/TimeLibrarySimple.asm"),
    },
    StandardLibrary {
        name: "CommonBehavior",
        text: include_str!("../asm/CommonBehavior.asm"),
    },
    StandardLibrary {
        name: "MAPEpatterns",
        text: include_str!("../asm/MAPEpatterns.asm"),
    },
];

/// Returns the library that an `import` refers to by the last component of its path, with or
/// without `.asm`.
///
/// ```
/// assert!(asmotion_stdlib::library("StandardLibrary.asm").is_some());
/// assert!(asmotion_stdlib::library("Elevator").is_none());
/// ```
pub fn library(last_path_component: &str) -> Option<&'static StandardLibrary> {
    let name = stem(last_path_component);
    LIBRARIES.iter().find(|library| library.name == name)
}

/// Returns the library whose name differs in case only. Models written on case-insensitive file
/// systems contain such spellings, for example `CTLlibrary`.
pub fn library_spelt_like(last_path_component: &str) -> Option<&'static StandardLibrary> {
    let name = stem(last_path_component);
    LIBRARIES
        .iter()
        .find(|library| library.name.eq_ignore_ascii_case(name))
}

fn stem(file: &str) -> &str {
    file.strip_suffix(".asm").unwrap_or(file)
}

/// Returns all libraries, the standard library first.
pub fn libraries() -> &'static [StandardLibrary] {
    &LIBRARIES
}

/// Returns the library that declares a name, for a message about a missing import. Temporal
/// libraries are left out: their operators have names of one or two letters, which are more likely
/// to mean something else.
///
/// ```
/// let name = |name| asmotion_stdlib::library_declaring(name).map(|library| library.name);
/// assert_eq!(name("isDef"), Some("StandardLibrary"));
/// assert_eq!(name("TimerUnit"), Some("TimeLibrary"));
/// assert_eq!(name("r_fly"), None);
/// ```
pub fn library_declaring(name: &str) -> Option<&'static StandardLibrary> {
    let declares = |line: &str| {
        let mut words = line.split(|c: char| c.is_whitespace() || c == ':');
        let begins = words.next().is_some_and(|first| DECLARES.contains(&first));
        begins && words.take(2).any(|word| word == name)
    };
    let mut libraries = ["StandardLibrary", "TimeLibrary"]
        .into_iter()
        .filter_map(library);
    libraries.find(|library| library.text.lines().map(str::trim_start).any(declares))
}

/// The keywords with which declarations begin.
const DECLARES: &[&str] = &[
    "static",
    "derived",
    "monitored",
    "controlled",
    "shared",
    "out",
    "basic",
    "abstract",
    "enum",
    "domain",
    "anydomain",
];
