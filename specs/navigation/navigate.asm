asm navigate
// Drives a rover to a goal: gets the map, requests a path, lets the follower drive.
// Replans when the path is blocked or the rover touches something, and repeats a call that timed out; all at most
// `maxTries` times.
// A new goal stops the rover before a path is requested. The e-stop has priority over everything.
import StandardLibrary
import CTLLibrary

signature:
	enum domain Mode = {IDLE | WAIT_MAP | WAIT_PATH | FOLLOWING | STOPPING | ARRIVED | FAILED}
	enum domain Command = {NONE | GET_MAP | PLAN | FOLLOW | HALT}
	enum domain Event = {
		NOTHING | MAP_OK | PATH_OK | NO_PATH | TIMED_OUT | CALL_FAILED | REACHED | BLOCKED |
		HALTED
	}
	domain Tries subsetof Integer

	// inputs: the composite binds them to topics and to the outcomes of service calls
	monitored goalArrived: Boolean
	monitored cancelArrived: Boolean
	monitored estop: Boolean
	monitored event: Event
	// the rover touches something; unlike an event, this answers no order
	monitored contact: Boolean

	// outputs: the composite maps them to service calls and messages
	out command: Command
	// permission to move, published in every step; the rover stops when it no longer arrives
	out permit: Boolean

	controlled mode: Mode
	controlled moving: Boolean
	controlled tries: Tries
	static maxTries: Tries

definitions:
	domain Tries = {0 : 3}
	function maxTries = 3

	macro rule r_enter($next in Mode, $order in Command) =
		par
			command := $order
			mode := $next
		endpar

	macro rule r_move($now in Boolean) =
		par
			moving := $now
			permit := $now
		endpar

	macro rule r_halt($next in Mode) =
		par
			r_enter[$next, HALT]
			r_move[false]
		endpar

	// requests another path, unless there were too many attempts
	macro rule r_planAgain =
		if tries < maxTries then
			par
				tries := tries + 1
				r_move[false]
				r_enter[WAIT_PATH, PLAN]
			endpar
		else
			r_halt[FAILED]
		endif

	rule r_newGoal =
		par
			tries := 0
			if moving then
				r_halt[STOPPING]
			else
				r_enter[WAIT_MAP, GET_MAP]
			endif
		endpar

	rule r_step =
		switch mode
			case WAIT_MAP:
				switch event
					case MAP_OK: r_enter[WAIT_PATH, PLAN]
					case CALL_FAILED: r_halt[FAILED]
					case TIMED_OUT: r_halt[FAILED]
				endswitch
			case WAIT_PATH:
				switch event
					case PATH_OK:
						par
							r_enter[FOLLOWING, FOLLOW]
							r_move[true]
						endpar
					case NO_PATH: r_halt[FAILED]
					case TIMED_OUT: r_planAgain[]
				endswitch
			case FOLLOWING:
				if contact then
					r_planAgain[]
				else
					switch event
						case REACHED: r_halt[ARRIVED]
						case BLOCKED: r_planAgain[]
					endswitch
				endif
			case STOPPING:
				if event = HALTED then r_enter[WAIT_MAP, GET_MAP] endif
		endswitch

	// safety: the rover never moves after a step with the e-stop pressed
	CTLSPEC ag(estop implies ax(not moving))
	// safety: the rover stands after a step that learns of a contact while it follows a path
	CTLSPEC ag((mode = FOLLOWING and contact) implies ax(not moving))
	// exclusivity: the rover moves only while it follows a path
	CTLSPEC ag(moving iff mode = FOLLOWING)
	// the command FOLLOW is given only in the mode FOLLOWING
	CTLSPEC ag(command = FOLLOW implies mode = FOLLOWING)
	// reachability: arrival is possible
	CTLSPEC ef(mode = ARRIVED)
	// liveness: a state of rest is always reachable
	CTLSPEC ag(ef(mode = IDLE or mode = ARRIVED or mode = FAILED))

	invariant inv_bounded over tries: tries <= maxTries
	invariant inv_exclusive over moving, mode: moving iff mode = FOLLOWING

	main rule r_Main =
		if estop then
			if mode != IDLE then r_halt[IDLE] endif
		else if cancelArrived then
			r_halt[IDLE]
		else if goalArrived then
			r_newGoal[]
		else
			r_step[]
		endif endif endif

default init s0:
	function mode = IDLE
	function moving = false
	function tries = 0
	function command = NONE
	function permit = false
