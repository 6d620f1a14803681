//! The texts of the libraries, compiled in.

/// A library as a specification imports it.
#[derive(Debug)]
pub struct Library {
    /// Its module name, `StandardLibrary`.
    pub name: &'static str,
    /// Its source text.
    pub text: &'static str,
}

static LIBRARIES: [Library; 6] = [
    Library {
        name: "StandardLibrary",
        text: include_str!("../asm/StandardLibrary.asm"),
    },
    Library {
        name: "CTLLibrary",
        text: include_str!("../asm/CTLLibrary.asm"),
    },
    Library {
        name: "LTLLibrary",
        text: include_str!("../asm/LTLLibrary.asm"),
    },
    Library {
        name: "TimeLibrary",
        text: include_str!("../asm/TimeLibrary.asm"),
    },
    Library {
        name: "TimeLibrarySimple",
        text: include_str!("../asm/TimeLibrarySimple.asm"),
    },
    Library {
        name: "MAPEpatterns",
        text: include_str!("../asm/MAPEpatterns.asm"),
    },
];

/// The library an `import` means, by the last component of its path, with or without `.asm`.
///
/// ```
/// # use asm_stdlib as stdlib;
/// assert!(stdlib::library("StandardLibrary.asm").is_some());
/// assert!(stdlib::library("Elevator").is_none());
/// ```
pub fn library(last_path_component: &str) -> Option<&'static Library> {
    let name = stem(last_path_component);
    LIBRARIES.iter().find(|library| library.name == name)
}

/// The library whose name differs in capitals only: where files are found whatever their capitals,
/// people write `CTLlibrary`.
pub fn library_spelt_like(last_path_component: &str) -> Option<&'static Library> {
    let name = stem(last_path_component);
    LIBRARIES
        .iter()
        .find(|library| library.name.eq_ignore_ascii_case(name))
}

fn stem(file: &str) -> &str {
    file.strip_suffix(".asm").unwrap_or(file)
}

/// All libraries, the standard library first.
pub fn libraries() -> &'static [Library] {
    &LIBRARIES
}
