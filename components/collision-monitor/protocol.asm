asm protocol
// The collision monitor as others see it: passes a part of each command on, and corrects it in between if a new scan requires
// less. Reports CONTACT when a scan ends within the robot, once until a scan does not.
import StandardLibrary

signature:
	enum domain Code = {CONTACT}

	// a command arrived
	monitored command: Boolean
	// a scan arrived; one in which most beams failed does not count
	monitored scan: Boolean
	out twist: Boolean
	//@Port event.code
	out event: Code

	controlled commanded: Boolean
	controlled touched: Boolean

definitions:
	rule r_feel =
		choose $touches in Boolean do
			par
				touched := $touches
				if $touches and not touched then event := CONTACT endif
			endpar

	rule r_pass =
		if command then
			par
				commanded := true
				twist := true
			endpar
		else if scan and commanded then
			choose $less in Boolean do if $less then twist := true endif
		endif endif

	main rule r_Main =
		par
			if scan then r_feel[] endif
			r_pass[]
		endpar

default init s0:
	function commanded = false
	function touched = false
