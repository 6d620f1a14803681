asm protocol
// The driver of the rover as others see it: reports CONTACT when a wheel stalls, once until another command takes the rover
// away from what it touches.
import StandardLibrary

signature:
	enum domain Code = {CONTACT}

	// a command arrived
	monitored twist: Boolean
	//@Port event.code
	out event: Code

	controlled commanded: Boolean
	controlled touching: Boolean

definitions:
	main rule r_Main =
		seq
			if commanded and not touching then
				choose $stalls in Boolean do
					if $stalls then
						par
							touching := true
							event := CONTACT
						endpar
					endif
			endif
			if twist then
				par
					commanded := true
					choose $leaves in Boolean do if $leaves then touching := false endif
				endpar
			endif
		endseq

default init s0:
	function commanded = false
	function touching = false
