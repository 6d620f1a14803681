asm caller
// calls an operation when it is asked to, and says what has become of the call
import StandardLibrary

signature:
	enum domain Command = {IDLE | CALL | SAY}
	enum domain Outcome = {NOTHING | ANSWERED | FAILED | LATE | NO_SERVER | SERVER_DIED | REFUSED | OTHER_TYPE}

	monitored asked: Boolean
	monitored outcome: Outcome
	out command: Command
	out said: Outcome

definitions:
	main rule r_Main =
		par
			if asked then command := CALL
			else if outcome = ANSWERED then command := SAY endif endif
			if outcome != NOTHING then said := outcome endif
		endpar

default init s0:
	function command = IDLE
