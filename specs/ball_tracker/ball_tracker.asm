asm ball_tracker
// Coordinates a camera and a tracker: powers the camera, searches for the ball, follows it, holds it. Nested states are
// control functions of their own; the order of the conditions determines the priority of transitions.
import StandardLibrary
import CTLLibrary
import TimeLibrary

signature:
	enum domain Mode = {INITIALISE | OPERATE | DONE | FAILED | STOPPED}
	// nested states of OPERATE
	enum domain Operate = {SEARCH | FOLLOW | HOLD}
	enum domain Camera = {QUIET | READY | BROKEN}
	enum domain Sight = {SEEN | LOST}
	enum domain Command = {REST | SWEEP | TRACK}

	monitored camera: Camera
	monitored sight: Sight
	monitored centred: Boolean
	monitored stop: Boolean
	monitored again: Boolean
	out power: Boolean
	out command: Command
	controlled mode: Mode
	controlled operate: Operate
	static warmUp: Timer
	static search: Timer
	static hold: Timer

definitions:
	// ---- entries and exits ----
	rule r_initialise =
		par mode := INITIALISE  power := true  r_reset_timer[warmUp] endpar

	rule r_search =
		par operate := SEARCH  command := SWEEP  r_reset_timer[search] endpar

	rule r_leave($to in Mode) =
		par mode := $to  power := false  command := REST endpar

	// ---- nested states of OPERATE ----
	rule r_operate =
		switch operate
			case SEARCH:
				if sight = SEEN then
					par operate := FOLLOW  command := TRACK endpar
				else if expired(search) then
					r_leave[FAILED]
				endif endif
			case FOLLOW:
				if sight = LOST then
					r_search[]
				else if centred then
					par operate := HOLD  r_reset_timer[hold] endpar
				endif endif
			case HOLD:
				if sight = LOST then
					r_search[]
				else if not centred then
					operate := FOLLOW
				// completion of OPERATE
				else if expired(hold) then
					r_leave[DONE]
				endif endif endif
		endswitch

	CTLSPEC ag(mode = OPERATE implies ef(mode = DONE))
	CTLSPEC ag((stop and mode = OPERATE) implies ax(mode = STOPPED))
	invariant inv_rest over mode: mode != OPERATE implies command = REST
	invariant inv_power over mode: mode = OPERATE implies power

	main rule r_Main =
		// transitions of the outer state have priority over those of nested states
		if (stop or camera = BROKEN) and (mode = INITIALISE or mode = OPERATE) then
			r_leave[if stop then STOPPED else FAILED endif]
		else
			switch mode
				case INITIALISE:
					if camera = READY then
						par mode := OPERATE  r_search[] endpar
					else if expired(warmUp) then
						r_leave[FAILED]
					endif endif
				case OPERATE: r_operate[]
				case DONE: if again then r_initialise[] endif
				case FAILED: if again then r_initialise[] endif
				case STOPPED: if again and not stop then r_initialise[] endif
			endswitch
		endif

default init s0:
	function mode = INITIALISE
	function operate = SEARCH
	function power = true
	function command = REST
	function timerUnit($t in Timer) = MILLISEC
	function start($t in Timer) = currentTime($t)
	function duration($t in Timer) =
		if $t = search then 8000 else if $t = hold then 1000 else 2000 endif endif
