asm simulated
// A simulated gripper: moves 2 mm in each step, and knows when it is closed and when it is open.
import StandardLibrary

signature:
	domain Position subsetof Integer
	monitored closing: Boolean
	out closed: Boolean
	out opened: Boolean
	controlled at: Position

definitions:
	domain Position = {0 : 40}

	invariant inv_one over closed, opened: not (closed and opened)

	main rule r_Main =
		par
			if closing and at > 0 then at := at - 1 endif
			if not closing and at < 40 then at := at + 1 endif
			closed := at = 0
			opened := at = 40
		endpar

default init s0:
	function at = 40
	function closed = false
	function opened = true
