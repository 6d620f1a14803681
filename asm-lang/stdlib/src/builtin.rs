//! Entries of the library: a standard function's name, domain and body.

use crate::fault::BuiltinFault;
use asmotion_value::{Value, ValueNames};
use std::fmt;

/// The context of a body: everything that it may access besides its arguments.
pub struct BuiltinContext<'a> {
    /// Names of atoms and rules, for `toString` and `print`.
    pub names: &'a dyn ValueNames,
    /// Time of the step in nanoseconds, for `currTime…`.
    pub now_ns: i64,
    /// Lines written by `print` in this step, oldest first.
    pub printed: &'a mut Vec<String>,
}

/// Computes a function, given one argument for each component of its domain.
pub type BuiltinBody = fn(&[Value], &mut BuiltinContext<'_>) -> Result<Value, BuiltinFault>;

/// A function of the standard library.
#[derive(Clone, Copy)]
pub struct Builtin {
    /// Name, shared by overloads.
    pub name: &'static str,
    /// Domain as declared in the library, without blanks: `Prod(Integer,Integer)`. Empty for a
    /// function without arguments.
    pub domain: &'static str,
    /// `true` if the result is `undef` whenever an argument is. The caller checks this before it
    /// calls the body.
    pub strict: bool,
    /// Computes the value; arguments are in the order of the domain.
    pub body: BuiltinBody,
}

impl fmt::Debug for Builtin {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}({})", self.name, self.domain)
    }
}

impl Builtin {
    /// Returns `true` for `print`, which must not be evaluated twice.
    pub fn prints(&self) -> bool {
        self.name == "print"
    }
}

/// Functions declared in the standard library but implemented by the machine.
pub const RESERVED: &[&str] = &["self", "program", "id", "getAgent", "result"];

/// Functions that the temporal libraries declare without a definition, interpreted by a verifier
/// only.
pub const TEMPORAL: &[&str] = &[
    "ex", "ax", "ef", "af", "eg", "ag", "eu", "au", "exN", "axN", "ctl", // branching time
    "x", "g", "f", "u", "v", "y", "z", "h", "o", "s", "t", "ltl", // linear time
];

/// Creates an entry whose body is never called with `undef`.
pub(crate) const fn strict(name: &'static str, domain: &'static str, body: BuiltinBody) -> Builtin {
    Builtin {
        name,
        domain,
        strict: true,
        body,
    }
}

/// Creates an entry whose body handles `undef` itself.
pub(crate) const fn total(name: &'static str, domain: &'static str, body: BuiltinBody) -> Builtin {
    Builtin {
        name,
        domain,
        strict: false,
        body,
    }
}
