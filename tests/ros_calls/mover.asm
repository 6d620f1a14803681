asm mover
// sends a goal when it is asked to, cancels it on request, gives it up on an emergency stop, and says what has become of it
import StandardLibrary

signature:
	enum domain Command = {IDLE | GO | LEAVE}
	enum domain Halt = {NO_HALT | HALT}
	enum domain Outcome = {NOTHING | ARRIVED | FAILED | LATE | ABORTED | PREEMPTED | REJECTED | LOST | NO_SERVER}

	monitored asked: Boolean
	monitored cancelled: Boolean
	monitored estop: Boolean
	monitored outcome: Outcome
	monitored position: Real
	out command: Command
	out halt: Halt
	out said: Outcome
	out told: Real

definitions:
	main rule r_Main =
		par
			// leaving the command gives up the call
			if estop then command := LEAVE
			else if asked then command := GO endif endif
			if cancelled then halt := HALT endif
			if outcome != NOTHING then said := outcome endif
			if position > 0.0 then told := position endif
		endpar

default init s0:
	function command = IDLE
	function halt = NO_HALT
