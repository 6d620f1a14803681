use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Polling too slow
///
/// The reader looks at its input less often than the writer updates it, so it works with old values or
/// misses some.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
/// activity = { period_ms = 50 }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// policy = { type = "data", delivery = "poll", poll_ms = 500 }
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
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
/// activity = { period_ms = 50 }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// policy = { type = "data", delivery = "poll", poll_ms = 25 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C054, warning)]
#[error("`{to}` polls every {poll_ms} ms, but `{from}` writes every {period_ms} ms")]
pub(crate) struct PollTooSlow {
    pub from: String,
    pub to: String,
    pub poll_ms: u64,
    pub period_ms: u64,
    pub at: Span,
}

impl Finding for PollTooSlow {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            poll_ms, period_ms, ..
        } = self;
        let missed = (poll_ms / period_ms).saturating_sub(1);
        let lost = match missed {
            0 => "some values are read late".to_owned(),
            _ => format!("{missed} of {} values are lost", missed + 1),
        };
        diagnostic.label(self.at, lost).help(format!(
            "poll at least every {} ms, or write `delivery = \"event\"`",
            (period_ms / 2).max(1)
        ))
    }
}
