asm courier
// Asks the dispatcher for a destination, goes there, reports the arrival, and asks again. Repeats a request that the
// dispatcher does not answer in time.
import StandardLibrary
import CommonBehavior
//@Required
import Dispatch

signature:
	enum domain Mode = {ASKING | UNDERWAY}

	//@Reference
	shared dispatcher: Agent -> Dispatch
	controlled mode: Mode
	controlled position: Integer
	controlled goal: Integer
	controlled jobs: Integer

definitions:
	rule r_ask =
		par
			r_wcall[dispatcher(self), "job", position, 500, goal]
			if isDef(goal) then
				mode := UNDERWAY
			endif
			if isDef(callFault(self, "job")) then
				r_wcancel[dispatcher(self), "job"]
			endif
		endpar

	rule r_drive =
		if position = goal then
			par
				r_wsend[dispatcher(self), "done", goal]
				jobs := jobs + 1
				goal := undef
				mode := ASKING
			endpar
		else
			position := if position < goal then position + 1 else position - 1 endif
		endif

	invariant over jobs: jobs >= 0

	main rule r_Main =
		switch mode
			case ASKING: r_ask[]
			case UNDERWAY: r_drive[]
		endswitch

default init s0:
	function mode = ASKING
	function position = 0
	function jobs = 0
