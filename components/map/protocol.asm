asm protocol
// The map server as others see it: answers each request once, with a map or with the code of a fault.
import StandardLibrary

signature:
	enum domain Answer = {OK | UNKNOWN_PLACE | BAD_MAP}

	//@Port maps.getMap
	monitored request: Boolean
	//@Port maps.getMap
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
