asm simulated
// A simulated gripper: moves 2 mm in each step towards the commanded position.
import StandardLibrary

signature:
	monitored command: Real
	out position: Real
	controlled at: Real

definitions:
	main rule r_Main =
		let ($next = if abs(command - at) <= 0.002 then command else if command > at then at + 0.002 else at - 0.002 endif endif) in
			par at := $next  position := $next endpar
		endlet

default init s0:
	function at = 0.08
