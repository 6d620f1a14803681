asm protocol
// The trajectory follower as others see it: reports REACHED once for each path that it has followed to its end, and HALTED
// once for each order to stop. Velocities are not part of it.
import StandardLibrary

signature:
	enum domain Code = {REACHED | HALTED}
	enum domain Order = {NONE | STOP | FOLLOW | DONE}

	// a path arrived; one without poses is an order to stop
	monitored path: Boolean
	//@Port path.poses
	monitored hasPoses: Boolean
	// no path is driven while the newest permission is false
	//@Port permit.data
	monitored permit: Boolean
	//@Port event.code
	//@Echo event.plan = path.header.stamp
	out event: Code

	controlled order: Order

definitions:
	rule r_accept =
		if hasPoses then
			// a path without usable poses is an order to stop; one that was reached is not driven again
			choose $next in {FOLLOW, STOP, DONE} with $next != DONE or order = DONE do
				order := $next
		else
			order := STOP
		endif

	rule r_report =
		if order = STOP then
			par
				order := NONE
				event := HALTED
			endpar
		else if order = FOLLOW and not (isDef(permit) and not permit) then
			par
				order := DONE
				event := REACHED
			endpar
		endif endif

	main rule r_Main =
		seq
			if path then r_accept[] endif
			// the robot needs time to stop, and to arrive
			choose $stands in Boolean do if $stands then r_report[] endif
		endseq

default init s0:
	function order = NONE
