asm protocol
// The trajectory adapter as others see it: passes paths on, bent around obstacles, and stops the robot before a barrier.
// Reports BLOCKED once for each path that leads nowhere.
import StandardLibrary

signature:
	enum domain Code = {BLOCKED}
	enum domain Route = {NOWHERE | UNDERWAY | GIVEN_UP}
	enum domain Advice = {KEEP | DRIVE | HOLD | GIVE_UP}

	// a path arrived; one without poses is an order to stop
	monitored path: Boolean
	//@Port path.poses
	monitored hasPoses: Boolean
	// a path with poses, or an order to stop; it has the stamp of the newest path
	//@Port adapted.poses
	//@Echo adapted.header.stamp = path.header.stamp
	out adapted: Boolean
	//@Port event.code
	//@Echo event.plan = path.header.stamp
	out event: Code

	controlled route: Route

definitions:
	rule r_accept =
		// a path without usable poses is an order to stop, which is passed on at once
		choose $usable in Boolean with $usable implies hasPoses do
			if $usable then
				route := UNDERWAY
			else
				par
					route := NOWHERE
					adapted := false
				endpar
			endif

	rule r_advise =
		choose $advice in Advice do
			switch $advice
				case DRIVE: adapted := true
				case HOLD: adapted := false
				case GIVE_UP:
					par
						route := GIVEN_UP
						event := BLOCKED
						// the robot may stand already
						choose $stop in Boolean do if $stop then adapted := false endif
					endpar
			endswitch

	main rule r_Main =
		seq
			if path then r_accept[] endif
			if route = UNDERWAY then r_advise[] endif
		endseq

default init s0:
	function route = NOWHERE
