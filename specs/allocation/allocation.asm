asm allocation
// Multi-robot task allocation: nondeterministic choice, at most one robot for a task and one task for a robot
import StandardLibrary
import CTLLibrary

signature:
	enum domain Robot = {ROB1 | ROB2}
	enum domain Task = {TASK1 | TASK2 | TASK3}
	enum domain TState = {PENDING | RUNNING | DONE}
	dynamic monitored robotDown: Robot -> Boolean
	dynamic monitored finished: Robot -> Boolean
	dynamic monitored lowBattery: Robot -> Boolean
	dynamic controlled busy: Robot -> Boolean
	dynamic controlled doing: Prod(Robot, Task) -> Boolean
	dynamic controlled tstate: Task -> TState
	// the task that a robot was given last
	out order: Robot -> Task

definitions:
	macro rule r_release($r in Robot) =
		forall $t in Task with doing($r, $t) do
			par
				doing($r, $t) := false
				tstate($t) := PENDING
				busy($r) := false
			endpar

	macro rule r_complete($r in Robot) =
		forall $t in Task with doing($r, $t) do
			par
				doing($r, $t) := false
				tstate($t) := DONE
				busy($r) := false
			endpar

	macro rule r_assign =
		choose $r in Robot, $t in Task
			with not busy($r) and not lowBattery($r) and not robotDown($r) and tstate($t) = PENDING
		do
			par
				busy($r) := true
				doing($r, $t) := true
				tstate($t) := RUNNING
				order($r) := $t
			endpar

	//@Final DONE
	CTLSPEC ag(not (doing(ROB1, TASK1) and doing(ROB2, TASK1)))
	CTLSPEC ag(not (doing(ROB1, TASK2) and doing(ROB2, TASK2)))
	CTLSPEC ag(not (doing(ROB1, TASK1) and doing(ROB1, TASK2)))
	CTLSPEC ag(tstate(TASK1) = RUNNING implies (doing(ROB1, TASK1) or doing(ROB2, TASK1)))
	CTLSPEC ef(tstate(TASK1) = DONE and tstate(TASK2) = DONE and tstate(TASK3) = DONE)

	main rule r_Main =
		par
			forall $r in Robot with busy($r) and robotDown($r) do r_release[$r]
			forall $q in Robot with busy($q) and finished($q) and not robotDown($q) do
				r_complete[$q]
			r_assign[]
		endpar

default init s0:
	function busy($r in Robot) = false
	function doing($r in Robot, $t in Task) = false
	function tstate($t in Task) = PENDING
