asm gripper
// Closes the gripper and opens it again, three times.
//@Final DONE FAILED
import StandardLibrary

signature:
	enum domain Mode = {CLOSING | OPENING | DONE | FAILED}
	monitored position: Real
	monitored stopped: Boolean
	out command: Real
	controlled mode: Mode
	controlled cycles: Integer

definitions:
	rule r_move($to in Real, $next in Mode) =
		par
			command := $to
			if abs(position - $to) < 0.001 then mode := $next endif
		endpar

	invariant inv_cycles over cycles: cycles >= 0 and cycles <= 3

	main rule r_Main =
		if stopped and (mode = CLOSING or mode = OPENING) then
			mode := FAILED
		else
			switch mode
				case CLOSING: r_move[0.0, OPENING]
				case OPENING:
					par
						r_move[0.08, if cycles < 2 then CLOSING else DONE endif]
						if abs(position - 0.08) < 0.001 then cycles := cycles + 1 endif
					endpar
			endswitch
		endif

default init s0:
	function mode = CLOSING
	function cycles = 0
