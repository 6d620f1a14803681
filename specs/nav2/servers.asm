asm servers
// The environment of navigate_to_pose.asm in a verification: one goal, and servers that end everything they are asked to do,
// with any result, sooner or later; what was cancelled, too
import StandardLibrary

signature:
	enum domain Work = {RESTING | WORKING | CLEARING | ENDING}
	enum domain Outcome = {NOTHING | SUCCEEDED | ABORTED | HOPELESS}
	domain Patience subsetof Integer
	monitored planner: Work
	monitored controller: Work
	monitored behaviour: Work
	// steps until the controller or a behaviour has to end
	controlled patience: Patience
	controlled hasBegun: Boolean
	derived nothingMoves: Boolean
	out goalArrived: Boolean
	out estop: Boolean
	out cancelArrived: Boolean
	out pathResult: Outcome
	out followResult: Outcome
	out behaviourResult: Outcome

definitions:
	function nothingMoves = controller = RESTING and behaviour = RESTING
	domain Patience = {0 : 3}

	main rule r_Main =
		par
			goalArrived := not hasBegun
			hasBegun := true
			estop := false
			cancelArrived := false
			choose $path in Outcome, $follow in Outcome, $behave in Outcome
				with (planner = RESTING implies $path = NOTHING)
					and (controller = RESTING implies $follow = NOTHING)
					and (behaviour = RESTING implies $behave = NOTHING)
					and (planner != RESTING and nothingMoves implies $path != NOTHING)
					and (patience = 0 and not nothingMoves
							implies $follow != NOTHING or $behave != NOTHING)
			do
				par
					pathResult := $path
					followResult := $follow
					behaviourResult := $behave
					if nothingMoves or $follow != NOTHING or $behave != NOTHING then
						patience := 3
					else
						patience := patience - 1
					endif
				endpar
		endpar

default init s0:
	function goalArrived = false
	function estop = false
	function cancelArrived = false
	function pathResult = NOTHING
	function followResult = NOTHING
	function behaviourResult = NOTHING
	function patience = 3
	function hasBegun = false
