//! Composites of any number of coordinators with one specification, to measure cost against size.

use asmotion_composite::Tables;
use asmotion_datum::{Message, Schema};

asmotion_datum::message! {
    /// A condition.
    pub struct Flag = "bench/Flag" {
        /// `true` if the condition holds.
        pub data: bool,
    }

    /// A mode.
    pub struct Mode = "bench/Mode" {
        /// Name of the mode.
        pub data: String,
    }
}

/// The specification of a coordinator.
pub const SPECIFICATION: &str = "asm rover
import StandardLibrary
import CTLLibrary
signature:
	enum domain Mode = {IDLE | DRIVING | STOPPED}
	domain Leg subsetof Integer
	controlled mode: Mode
	controlled leg: Leg
	monitored arrived: Boolean
	out resting: Boolean
	out command: Mode
definitions:
	domain Leg = {0 : 99}
	rule r_Drive =
		par
			mode := DRIVING
			command := DRIVING
			leg := (leg + 1) mod 100
			resting := leg = 99
		endpar
	CTLSPEC ag(mode = STOPPED implies command != DRIVING)
	main rule r_Main =
		if arrived then
			par mode := STOPPED command := STOPPED endpar
		else
			r_Drive[]
		endif
default init s0:
	function mode = IDLE
	function leg = 0
	function command = IDLE
	function resting = false
";

/// The messages of its ports.
pub const BUILD: Tables = Tables {
    components: &[],
    messages: &[
        (Flag::NAME, Flag::schema as fn() -> &'static Schema),
        (Mode::NAME, Mode::schema as fn() -> &'static Schema),
    ],
    interfaces: &[],
    builtins: &[],
    ros: None,
};

/// A composite of so many coordinators, which are instances of one element.
pub fn composite(components: usize) -> String {
    format!(
        "schema = \"composite/1\"
[composite]
name = \"fleet\"
[components.Rover]
for = \"$n in 1..{components}\"
implementation = {{ asm = \"rover.asm\" }}
task = {{ period_ms = 100 }}
subscribe = {{ arrived = \"bench/Flag\" }}
publish = {{ command = \"bench/Mode\", resting = \"bench/Flag\" }}
rename = {{ arrived = \"r$n/arrived\", command = \"r$n/command\", resting = \"r$n/arrived\" }}
bind.monitored = {{ arrived = {{ topic = \"arrived\", map = \"data\", none = false }} }}
bind.out = {{ command = {{ topic = \"command\", field = \"data\" }}, resting = {{ topic = \"resting\", field = \"data\" }} }}
"
    )
}
