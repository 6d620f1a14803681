//! Replacements in a build without the feature `ros2`.

use super::domain::DomainArguments;
use super::printed::Printed;
use crate::exit::Exit;
use crate::feature::{LeftOut, Ros2};
use crate::terminal::TerminalOutput;

fn explain(terminal: &mut TerminalOutput) -> Exit {
    terminal.error(LeftOut::new::<Ros2>());
    Exit::Usage
}

pub(super) mod ros2_list {
    use std::time::Duration;

    use super::{DomainArguments, Exit, TerminalOutput, explain};

    pub(in super::super) fn run(
        _: &DomainArguments,
        _: Duration,
        _: (bool, bool),
        terminal: &mut TerminalOutput,
    ) -> Exit {
        explain(terminal)
    }
}

pub(super) mod ros2_echo {
    use std::path::PathBuf;

    use super::{DomainArguments, Exit, Printed, TerminalOutput, explain};

    pub(in super::super) fn run(
        _: (&str, &DomainArguments, &[PathBuf]),
        _: &Printed,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        explain(terminal)
    }
}
