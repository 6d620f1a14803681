//! The texts of the libraries, compiled in.

/// A library as a specification imports it.
#[derive(Debug)]
pub struct StandardLibrary {
    /// Its module name, `StandardLibrary`.
    pub name: &'static str,
    /// Its source text.
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

/// The library an `import` means, by the last component of its path, with or without `.asm`.
///
/// ```
/// assert!(asmotion_stdlib::library("StandardLibrary.asm").is_some());
/// assert!(asmotion_stdlib::library("Elevator").is_none());
/// ```
pub fn library(last_path_component: &str) -> Option<&'static StandardLibrary> {
    let name = stem(last_path_component);
    LIBRARIES.iter().find(|library| library.name == name)
}

/// The library whose name differs in capitals only: where files are found whatever their capitals,
/// people write `CTLlibrary`.
pub fn library_spelt_like(last_path_component: &str) -> Option<&'static StandardLibrary> {
    let name = stem(last_path_component);
    LIBRARIES
        .iter()
        .find(|library| library.name.eq_ignore_ascii_case(name))
}

fn stem(file: &str) -> &str {
    file.strip_suffix(".asm").unwrap_or(file)
}

/// All libraries, the standard library first.
pub fn libraries() -> &'static [StandardLibrary] {
    &LIBRARIES
}

/// The library that declares a name, for who did not import it. The temporal operators of the others
/// have one letter or two: whoever writes such a name means something else.
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

/// The words that declarations begin with.
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
