use crate::signature::FunctionInfo;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Bound function with another number of arguments
///
/// A binding names locations: one for each combination of arguments. `"wants(ROB1)"` is a single location,
/// `"wants($r)"` all of them; `$r` in the rest of the binding is the name of the element. With a key, a field of the
/// message selects the element.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Robot = {ROB1 | ROB2}
///   monitored wants: Robot -> Boolean
///   controlled tries: Integer
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.monitored]
/// wants = { topic = "ROB1/wants" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "$r/wants" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C092, error)]
#[error("`{}` takes {}, but its binding has {}", function.name, count(function.parameters.len()), count(*given))]
pub(crate) struct WrongLocationArity {
    pub function: FunctionInfo,
    pub given: usize,
    pub at: Span,
}

fn count(arguments: usize) -> String {
    match arguments {
        0 => "no arguments".to_owned(),
        1 => "one argument".to_owned(),
        several => format!("{several} arguments"),
    }
}

impl Finding for WrongLocationArity {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { function, .. } = self;
        let declared = if function.domain.is_empty() {
            "declared without arguments".to_owned()
        } else {
            format!("from `{}`", function.domain)
        };
        let diagnostic = diagnostic
            .label(self.at, "bound here")
            .label(function.declared, declared);
        let pattern = function.pattern();
        let variables: Vec<_> = pattern.variables().collect();
        match variables.as_slice() {
            [] => diagnostic.help(format!("bind `{}`", function.name)),
            [first, ..] => diagnostic
                .help(format!(
                    "bind all locations with `\"{pattern}\" = {{ topic = \"${first}/…\" }}`"
                ))
                .help(format!(
                    "or select the element by a field of the message, with `key = {{ {first} = \"…\" }}`"
                )),
        }
    }
}
