//! What every code of a composite means: a page for each, like those of the language.
//!
//! The pages stand in the folder `codes`. Their examples are tried with the components of the build, in
//! the root's tests.

use asmotion_lang::codes::Code;

macro_rules! codes {
    ($($name:ident)*) => {
        &[$(Code {
            name: stringify!($name),
            page: include_str!(concat!("../codes/", stringify!($name), ".md")),
        },)*]
    };
}

/// The codes of composites, in order: the file as text, values, names, implementations, wires,
/// connections, topics, promotions, queues and gateways, processes, nesting, bindings, types, proxies and bridges.
pub const CODES: &[Code] = codes! {
    C001 C002 C003 C004 C005 C006 C007 C008 C009 C010 C011 C012 C013 C014 C015 C016
    C017 C018 C019 C020 C021 C022 C023 C024 C025 C026 C027 C028 C029 C030 C031 C032
    C033 C034 C035 C040 C041 C042 C043 C044 C045 C046 C047 C048 C049 C050 C051 C052
    C053 C054 C055 C056 C057 C058 C060 C061 C062 C063 C064 C065 C066 C070 C071 C072 C073 C074 C075 C076
    C080 C081 C082 C090 C091 C092 C093
    C094 C095 C096 C097 C098 C099 C100 C101 C102 C103 C104 C110 C111 C112 C113 C114 C115 C116 C120
    C121 C122 C123 C124 C125 C126 C127
};
