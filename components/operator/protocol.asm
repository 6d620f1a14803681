asm protocol
// The scripted operator as others see it: sends goals, cancels and the state of the e-stop button at any time.
import StandardLibrary

signature:
	out goal: Boolean
	out cancel: Boolean
	//@Port estop.data
	out estop: Boolean

definitions:
	main rule r_Main =
		par
			choose $sends in Boolean do if $sends then goal := true endif
			choose $sends in Boolean do if $sends then cancel := true endif
			choose $sends in Boolean do
				if $sends then choose $pressed in Boolean do estop := $pressed endif
		endpar

default init s0:
