asm navigate_to_pose
// Drives to a pose with the servers of Nav2, as its behaviour tree "navigate to pose with replanning and recovery" does:
// computes a path once a second and follows it; clears a costmap and tries once more when a server fails; recovers by clearing
// both costmaps, spinning, waiting or backing up, in turn, at most `maxRecoveries` times.
//
// The order of motion is stricter than that of the tree: whoever moved the robot has ended before anything else moves it, and a new
// goal stops the robot before a path to it is requested.
import StandardLibrary
import CTLLibrary

signature:
	// not ARRIVED and FAILED, with which `asmotion run` ends: goals come one after another
	enum domain Mode = {IDLE | NAVIGATING | RECOVERING | STOPPING | AT_GOAL | GAVE_UP}
	// what an action server does for this robot; it is ENDING from the request to cancel until its result
	enum domain Work = {RESTING | WORKING | CLEARING | ENDING}
	// the result of an action or of a call; HOPELESS if its error code says that no recovery helps
	enum domain Outcome = {NOTHING | SUCCEEDED | ABORTED | HOPELESS}
	enum domain PlannerOrder = {NO_PLANNING | COMPUTE_PATH | CLEAR_GLOBAL}
	enum domain ControllerOrder = {NO_CONTROL | FOLLOW_PATH | CLEAR_LOCAL}
	enum domain BehaviourOrder = {NO_BEHAVIOUR | SPIN | WAIT | BACK_UP}
	enum domain Cancellation = {NO_CANCELLATION | CANCEL}
	enum domain Recovery = {BY_CLEARING | BY_SPINNING | BY_WAITING | BY_BACKING_UP}
	domain Count subsetof Integer

	// inputs: the composite binds them to topics, a timer and the results of actions
	monitored goalArrived: Boolean
	monitored cancelArrived: Boolean
	monitored estop: Boolean
	monitored replanDue: Boolean
	monitored pathResult: Outcome
	monitored followResult: Outcome
	monitored behaviourResult: Outcome

	// outputs: the composite maps them to goals of actions, and to calls
	out plannerOrder: PlannerOrder
	out controllerOrder: ControllerOrder
	out behaviourOrder: BehaviourOrder
	// of all servers; an order of its own, because another order to a server would give up its result
	out cancellation: Cancellation

	controlled mode: Mode
	// the mode after STOPPING
	controlled after: Mode
	controlled planner: Work
	controlled controller: Work
	controlled behaviour: Work
	// whether the costmap of the planner, or of the controller, was cleared since its last success
	controlled globalCleared: Boolean
	controlled localCleared: Boolean
	controlled recovery: Recovery
	// recoveries of this goal, and failed ones in a row
	controlled recoveries: Count
	controlled inVain: Count
	static maxRecoveries: Count

	// a result counts only while its server is at work
	derived planned: Outcome
	derived followed: Outcome
	derived behaved: Outcome
	derived plannerRests: Boolean
	derived controllerRests: Boolean
	derived behaviourRests: Boolean

definitions:
	domain Count = {0 : 6}
	function maxRecoveries = 6

	function planned = if planner = RESTING then NOTHING else pathResult endif
	function followed = if controller = RESTING then NOTHING else followResult endif
	function behaved = if behaviour = RESTING then NOTHING else behaviourResult endif
	function plannerRests = planner = RESTING or planned != NOTHING
	function controllerRests = controller = RESTING or followed != NOTHING
	function behaviourRests = behaviour = RESTING or behaved != NOTHING

	macro rule r_compute =
		par
			planner := WORKING
			plannerOrder := COMPUTE_PATH
		endpar

	macro rule r_follow =
		par
			controller := WORKING
			controllerOrder := FOLLOW_PATH
		endpar

	macro rule r_clearGlobal =
		par
			planner := CLEARING
			globalCleared := true
			plannerOrder := CLEAR_GLOBAL
		endpar

	macro rule r_clearLocal =
		par
			controller := CLEARING
			localCleared := true
			controllerOrder := CLEAR_LOCAL
		endpar

	macro rule r_behave($order in BehaviourOrder) =
		par
			behaviour := WORKING
			behaviourOrder := $order
		endpar

	// begins the next recovery action; the planner, the controller and the behaviours rest
	macro rule r_recover =
		par
			mode := RECOVERING
			switch recovery
				case BY_CLEARING:
					par
						recovery := BY_SPINNING
						r_clearLocal[]
						planner := RESTING
						behaviour := RESTING
					endpar
				case BY_SPINNING:
					par
						recovery := BY_WAITING
						r_behave[SPIN]
						planner := RESTING
						controller := RESTING
					endpar
				case BY_WAITING:
					par
						recovery := BY_BACKING_UP
						r_behave[WAIT]
						planner := RESTING
						controller := RESTING
					endpar
				case BY_BACKING_UP:
					par
						recovery := BY_CLEARING
						r_behave[BACK_UP]
						planner := RESTING
						controller := RESTING
					endpar
			endswitch
		endpar

	// enters a mode in which everything rests at first
	macro rule r_enter($next in Mode) =
		switch $next
			case NAVIGATING:
				par
					mode := NAVIGATING
					globalCleared := false
					localCleared := false
					r_compute[]
					controller := RESTING
					behaviour := RESTING
				endpar
			case RECOVERING: r_recover[]
			otherwise
				par
					mode := $next
					planner := RESTING
					controller := RESTING
					behaviour := RESTING
				endpar
		endswitch

	// cancels what is at work, waits for the results, and enters a mode; a costmap is cleared to the end
	macro rule r_stop($next in Mode) =
		if plannerRests and controllerRests and behaviourRests then
			par
				cancellation := NO_CANCELLATION
				r_enter[$next]
			endpar
		else
			par
				mode := STOPPING
				after := $next
				if mode != STOPPING then cancellation := CANCEL endif
				planner := if plannerRests then RESTING else ENDING endif
				controller := if controllerRests then RESTING else ENDING endif
				behaviour := if behaviourRests then RESTING else ENDING endif
			endpar
		endif

	rule r_newGoal =
		par
			recoveries := 0
			inVain := 0
			r_stop[NAVIGATING]
		endpar

	// navigation failed: the next recovery, if there is one left
	macro rule r_fail =
		if recoveries < maxRecoveries then
			par
				recoveries := recoveries + 1
				inVain := 0
				r_stop[RECOVERING]
			endpar
		else
			r_stop[GAVE_UP]
		endif

	// a path is computed once a second; if the planner fails, once more with a clear costmap
	rule r_plan =
		switch planner
			case RESTING: if replanDue then r_compute[] endif
			case WORKING:
				switch planned
					case SUCCEEDED:
						par
							planner := RESTING
							globalCleared := false
							if controller != CLEARING and followed != ABORTED then
								r_follow[]
							endif
						endpar
					case ABORTED: r_clearGlobal[]
				endswitch
			case CLEARING: if planned = SUCCEEDED then r_compute[] endif
		endswitch

	// if the controller fails, it follows once more with a clear costmap
	rule r_control =
		switch controller
			case WORKING: if followed = ABORTED then r_clearLocal[] endif
			case CLEARING: if followed = SUCCEEDED then r_follow[] endif
		endswitch

	rule r_navigate =
		if followed = SUCCEEDED and controller = WORKING then
			r_stop[AT_GOAL]
		else if planned = HOPELESS or followed = HOPELESS then
			r_stop[GAVE_UP]
		else if planned = ABORTED and globalCleared or followed = ABORTED and localCleared then
			r_fail[]
		else
			par
				r_plan[]
				r_control[]
			endpar
		endif endif endif

	// after a failed recovery, the next one is tried at once
	macro rule r_recovered($result in Outcome) =
		if $result = SUCCEEDED then
			r_stop[NAVIGATING]
		else if $result != NOTHING then
			if inVain < 3 then
				par
					inVain := inVain + 1
					r_recover[]
				endpar
			else
				r_stop[GAVE_UP]
			endif
		endif endif

	rule r_recovering =
		if controller = CLEARING then
			if followed = SUCCEEDED then
				par
					controller := RESTING
					r_clearGlobal[]
				endpar
			else
				r_recovered[followed]
			endif
		else if planner = CLEARING then
			r_recovered[planned]
		else
			r_recovered[behaved]
		endif endif

	// one of them moves the robot, never two
	invariant inv_oneMover over controller, behaviour: controller = RESTING or behaviour = RESTING
	// a behaviour begins only after the result of the controller
	CTLSPEC ag((controller = WORKING and followed = NOTHING) implies ax(behaviour != WORKING))
	// after an e-stop or a cancellation nothing works on, and nothing is begun
	CTLSPEC ag(
		(estop or cancelArrived)
		implies ax(planner != WORKING and controller != WORKING and behaviour != WORKING)
	)
	// at rest nothing is at work
	CTLSPEC ag(
		(mode = IDLE or mode = AT_GOAL or mode = GAVE_UP)
		implies (planner = RESTING and controller = RESTING and behaviour = RESTING)
	)
	// otherwise something is, so that a result will arrive
	CTLSPEC ag(mode = NAVIGATING implies (planner != RESTING or controller != RESTING))
	CTLSPEC ag(
		mode = RECOVERING
		implies (planner = CLEARING or controller = CLEARING or behaviour = WORKING)
	)
	// the end of the path is the end of the navigation, and so is an error after which no recovery helps
	CTLSPEC ag(
		(mode = NAVIGATING and followed = SUCCEEDED and controller = WORKING)
		implies ax(mode != NAVIGATING and mode != RECOVERING or planner = WORKING)
	)
	CTLSPEC ag((mode = NAVIGATING and planned = HOPELESS) implies ax(mode != RECOVERING))
	// a mode that waits is entered when all have ended
	CTLSPEC ag(
		(mode = STOPPING and plannerRests and controllerRests and behaviourRests)
		implies ax(mode != STOPPING)
	)
	// every goal can be reached, however the last one ended
	CTLSPEC ag(ef(mode = AT_GOAL))

	main rule r_Main =
		if estop or cancelArrived then
			if mode != IDLE then r_stop[IDLE] endif
		else if goalArrived then
			r_newGoal[]
		else
			switch mode
				case NAVIGATING: r_navigate[]
				case RECOVERING: r_recovering[]
				case STOPPING: r_stop[after]
			endswitch
		endif endif

default init s0:
	function mode = IDLE
	function after = IDLE
	function planner = RESTING
	function controller = RESTING
	function behaviour = RESTING
	function globalCleared = false
	function localCleared = false
	function recovery = BY_CLEARING
	function recoveries = 0
	function inVain = 0
	function plannerOrder = NO_PLANNING
	function controllerOrder = NO_CONTROL
	function behaviourOrder = NO_BEHAVIOUR
	function cancellation = NO_CANCELLATION
