asm camera
// A simulated camera: it takes a while to warm up, and sees a ball that rolls from side to side and is hidden now and
// then.
import StandardLibrary

signature:
	enum domain State = {OFF | WARM | ON}
	enum domain Says = {QUIET | READY}
	enum domain Sight = {SEEN | LOST}
	monitored power: Boolean
	// direction of the camera in degrees
	monitored pan: Real
	out says: Says
	out sight: Sight
	// offset of the ball from that direction in degrees
	out offset: Real
	controlled state: State
	controlled warmth: Integer
	// position of the ball in degrees, and its change in each step
	controlled ball: Real
	controlled rolls: Real
	controlled hidden: Integer
	derived isSeen: Boolean

definitions:
	function isSeen = abs(ball - pan) < 12.0 and hidden <= 0

	rule r_roll =
		par
			ball := ball + rolls
			if abs(ball + rolls) > 40.0 then
				par rolls := 0.0 - rolls  hidden := 8 endpar
			else
				hidden := hidden - 1
			endif
		endpar

	rule r_look =
		if isSeen then
			par sight := SEEN  offset := ball - pan endpar
		else
			sight := LOST
		endif

	main rule r_Main =
		par
			r_roll[]
			if not power then
				par state := OFF  sight := LOST  warmth := 0  says := QUIET endpar
			else
				switch state
					case OFF: state := WARM
					case WARM:
						if warmth = 10 then
							par state := ON  says := READY endpar
						else
							warmth := warmth + 1
						endif
					case ON: par says := QUIET  r_look[] endpar
				endswitch
			endif
		endpar

default init s0:
	function state = OFF
	function says = QUIET
	function sight = LOST
	function offset = 0.0
	function warmth = 0
	function ball = 36.0
	function rolls = 1.0
	function hidden = 0
