asm waits
import StandardLibrary
signature:
	enum domain Event = {PLANNED | NO_PATH | LOST}
	enum domain Action = {PLAN | HALT}
	monitored estop: Boolean
	monitored late: Boolean
	monitored idle: Boolean
	monitored event: Event
	monitored told: Event
	derived stops: Boolean
	out action: Action
definitions:
	function stops = estop
	main rule r_Main =
		switch event
			case PLANNED: action := HALT
			case NO_PATH: action := PLAN
			case LOST: if stops then action := HALT endif
			otherwise skip
		endswitch
