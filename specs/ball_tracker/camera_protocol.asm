asm camera_protocol
// The camera as others see it: after it is switched on, it says once that it is ready, and is quiet again; then it says when it
// sees the ball and when it loses it.
import StandardLibrary

signature:
	enum domain State = {OFF | WARM | ON}
	enum domain Says = {QUIET | READY}
	enum domain Sight = {SEEN | LOST}

	//@Port power.data
	monitored power: Boolean
	//@Port camera
	out says: Says
	//@Port sight
	out sight: Sight

	controlled state: State
	controlled sees: Boolean
	// the last step said READY
	controlled spoke: Boolean

definitions:
	rule r_look =
		choose $seen in Boolean with $seen != sees do
			par
				sees := $seen
				sight := if $seen then SEEN else LOST endif
			endpar

	rule r_hush =
		if spoke then
			par
				spoke := false
				says := QUIET
			endpar
		endif

	main rule r_Main =
		if not (isDef(power) and power) then
			par
				state := OFF
				r_hush[]
				if sees then
					par
						sees := false
						sight := LOST
					endpar
				endif
			endpar
		else
			switch state
				case OFF: state := WARM
				case WARM:
					choose $ready in Boolean do
						if $ready then
							par
								state := ON
								spoke := true
								says := READY
							endpar
						endif
				case ON:
					par
						r_hush[]
						choose $changes in Boolean do if $changes then r_look[] endif
					endpar
			endswitch
		endif

default init s0:
	function state = OFF
	function sees = false
	function spoke = false
