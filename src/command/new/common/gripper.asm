asm gripper
// Closes the gripper and opens it again, three times.
//@Final DONE FAILED
import StandardLibrary

signature:
	enum domain Mode = {CLOSING | OPENING | DONE | FAILED}
	domain Cycles subsetof Integer
	monitored closed: Boolean
	monitored opened: Boolean
	monitored stopped: Boolean
	out closing: Boolean
	controlled mode: Mode
	controlled cycles: Cycles

definitions:
	domain Cycles = {0 : 3}

	// `asmotion verify` proves it for all inputs
	invariant inv_done over mode, cycles: mode = DONE implies cycles = 3

	main rule r_Main =
		if stopped and (mode = CLOSING or mode = OPENING) then
			mode := FAILED
		else
			switch mode
				case CLOSING:
					par
						closing := true
						if closed then mode := OPENING endif
					endpar
				case OPENING:
					par
						closing := false
						if opened then
							par
								cycles := cycles + 1
								mode := if cycles < 2 then CLOSING else DONE endif
							endpar
						endif
					endpar
			endswitch
		endif

default init s0:
	function mode = CLOSING
	function cycles = 0
