asm robot
// A simulated robot: it works on each order for a while and rests afterwards; during its second order it breaks down.
import StandardLibrary

signature:
	enum domain Task = {TASK1 | TASK2 | TASK3}
	monitored order: Task
	out finished: Boolean
	out down: Boolean
	out lowBattery: Boolean
	// steps until the work, the repair and the rest are done
	controlled work: Integer
	controlled repair: Integer
	controlled rest: Integer
	controlled orders: Integer

definitions:
	rule r_work =
		if work = 5 and orders = 2 then
			par work := 0  repair := 10  down := true endpar
		else
			par
				work := work - 1
				if work = 1 then par finished := true  lowBattery := true  rest := 5 endpar endif
			endpar
		endif

	main rule r_Main =
		if isDef(order) then
			par work := 10  orders := orders + 1 endpar
		else if work > 0 then
			r_work[]
		else if repair > 0 then
			par
				repair := repair - 1
				if repair = 1 then down := false endif
			endpar
		else if rest > 0 then
			par
				rest := rest - 1
				if rest = 1 then lowBattery := false endif
			endpar
		endif endif endif endif

default init s0:
	function finished = false
	function down = false
	function lowBattery = false
	function work = 0
	function repair = 0
	function rest = 0
	function orders = 0
