//! A row of the library: name and domain of a standard function, and its body.

use crate::fault::BuiltinFault;
use asmotion_value::{Value, ValueNames};
use std::fmt;

/// What a body may use besides its arguments.
pub struct BuiltinContext<'a> {
    /// What atoms and rules are called, for `toString` and `print`.
    pub names: &'a dyn ValueNames,
    /// The time of the step, for `currTime…`.
    pub now_ns: i64,
    /// The lines that `print` wrote in this step, the oldest first.
    pub printed: &'a mut Vec<String>,
}

/// Computes a function: one argument for each component of its domain.
pub type BuiltinBody = fn(&[Value], &mut BuiltinContext<'_>) -> Result<Value, BuiltinFault>;

/// A function of the standard library.
#[derive(Clone, Copy)]
pub struct Builtin {
    /// Its name.
    pub name: &'static str,
    /// Its domain as the library declares it, without blanks: `Prod(Integer,Integer)`; empty for a
    /// function without arguments.
    pub domain: &'static str,
    /// Whether `undef` among the arguments makes the result `undef`. The caller sees to that before
    /// it runs the body.
    pub strict: bool,
    /// Its body.
    pub body: BuiltinBody,
}

impl fmt::Debug for Builtin {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}({})", self.name, self.domain)
    }
}

impl Builtin {
    /// Whether it writes a line: then evaluating it twice is not as good as once.
    pub fn prints(&self) -> bool {
        self.name == "print"
    }
}

/// Functions that the standard library declares and the machine itself answers: no bodies here.
pub const RESERVED: &[&str] = &["self", "program", "id", "getAgent", "result"];

/// Functions that the temporal libraries declare without a definition: the verifier's.
pub const TEMPORAL: &[&str] = &[
    "ex", "ax", "ef", "af", "eg", "ag", "eu", "au", "exN", "axN", "ctl", // branching time
    "x", "g", "f", "u", "v", "y", "z", "h", "o", "s", "t", "ltl", // linear time
];

/// A row whose body never meets `undef`.
pub(crate) const fn strict(name: &'static str, domain: &'static str, body: BuiltinBody) -> Builtin {
    Builtin {
        name,
        domain,
        strict: true,
        body,
    }
}

/// A row whose body decides about `undef` itself.
pub(crate) const fn total(name: &'static str, domain: &'static str, body: BuiltinBody) -> Builtin {
    Builtin {
        name,
        domain,
        strict: false,
        body,
    }
}
