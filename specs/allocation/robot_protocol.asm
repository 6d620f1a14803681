asm robot_protocol
// A robot as others see it: after an order it works, until it has finished or breaks down.
import StandardLibrary

signature:
	enum domain State = {IDLE | WORKING | BROKEN | TIRED}

	// an order has arrived
	//@Port order
	monitored order: Boolean
	//@Port finished.data
	out finished: Boolean
	//@Port lowBattery.data
	out lowBattery: Boolean
	//@Port status.down
	out down: Boolean

	controlled state: State

definitions:
	rule r_end =
		choose $breaks in Boolean do
			if $breaks then
				par
					state := BROKEN
					down := true
				endpar
			else
				par
					state := TIRED
					finished := true
					lowBattery := true
				endpar
			endif

	rule r_act =
		switch state
			case WORKING: r_end[]
			case BROKEN:
				par
					state := IDLE
					down := false
				endpar
			case TIRED:
				par
					state := IDLE
					lowBattery := false
				endpar
		endswitch

	main rule r_Main =
		if order then
			state := WORKING
		else
			choose $acts in Boolean do if $acts then r_act[] endif
		endif

default init s0:
	function state = IDLE
