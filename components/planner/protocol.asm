asm protocol
// The planner as others see it: answers each request once, with a path or with the code of a fault.
import StandardLibrary

signature:
	enum domain Answer = {
		OK | BAD_MAP | BAD_ALGORITHM | OUTSIDE | START_OCCUPIED | GOAL_OCCUPIED | NO_PATH
	}

	//@Port planning.plan
	monitored request: Boolean
	//@Port planning.plan
	out answer: Answer

	controlled open: Boolean

definitions:
	main rule r_Main =
		seq
			if request then open := true endif
			if open then
				choose $answers in Boolean do
					if $answers then
						par
							choose $answer in Answer do answer := $answer
							open := false
						endpar
					endif
			endif
		endseq

default init s0:
	function open = false
