asm driver_protocol
// The driver of the arm as others see it: after a command it is busy, and idle once the motion has ended.
import StandardLibrary

signature:
	enum domain Event = {BUSY | IDLE | REFRESH | FAULT | STALE}

	//@Port sendingCommand.setJointsPositions
	monitored command: Boolean
	//@Port notifying.notify.event
	out event: Event

	controlled moves: Boolean

definitions:
	rule r_report =
		choose $event in Event with $event != IDLE or moves do
			par
				event := $event
				if $event = IDLE then moves := false endif
			endpar

	main rule r_Main =
		if command then
			par
				moves := true
				event := BUSY
			endpar
		else
			choose $reports in Boolean do if $reports then r_report[] endif
		endif

default init s0:
	function moves = false
