asm patrol
// Patrols n waypoints endlessly; a pause keeps the waypoint, a low battery sends the robot home, the e-stop is latched
import StandardLibrary
import CTLLibrary

signature:
	enum domain Mode = {READY | MOVING | DWELL | PAUSED | HOMING | CHARGING | ESTOPPED}
	domain Wp subsetof Integer
	monitored start: Boolean
	monitored pause: Boolean
	monitored resume: Boolean
	monitored lowBattery: Boolean
	monitored full: Boolean
	monitored reached: Boolean
	monitored dwellOver: Boolean
	monitored estop: Boolean
	monitored resetByOperator: Boolean
	derived undisturbed: Boolean
	out target: Wp
	controlled wp: Wp
	controlled mode: Mode

definitions:
	domain Wp = {0 : 3}
	function undisturbed = not (estop or lowBattery or pause)

	// the e-stop has priority over everything, and only the operator ends it
	CTLSPEC ag(estop implies ax(mode = ESTOPPED))
	CTLSPEC ag((mode = ESTOPPED and not estop and not resetByOperator) implies ax(mode = ESTOPPED))
	CTLSPEC ag((mode = ESTOPPED and not estop and resetByOperator) implies ax(mode = READY))
	// then the battery, then the pause
	CTLSPEC ag(
		((mode = MOVING or mode = DWELL or mode = PAUSED) and lowBattery and not estop)
		implies ax(mode = HOMING)
	)
	CTLSPEC ag(
		((mode = MOVING or mode = DWELL) and pause and not lowBattery and not estop)
		implies ax(mode = PAUSED)
	)
	CTLSPEC ag((mode = PAUSED and resume and undisturbed) implies ax(mode = MOVING))
	CTLSPEC ag((mode = PAUSED and not resume and undisturbed) implies ax(mode = PAUSED))
	// the tour: it starts on demand, goes from waypoint to waypoint, and dwells at each
	CTLSPEC ag((mode = READY and start and not estop) implies ax(mode = MOVING))
	CTLSPEC ag((mode = READY and not start and not estop) implies ax(mode = READY))
	CTLSPEC ag((mode = MOVING and reached and undisturbed) implies ax(mode = DWELL))
	CTLSPEC ag((mode = MOVING and not reached and undisturbed) implies ax(mode = MOVING))
	CTLSPEC ag((mode = DWELL and dwellOver and undisturbed) implies ax(mode = MOVING))
	CTLSPEC ag((mode = DWELL and not dwellOver and undisturbed) implies ax(mode = DWELL))
	CTLSPEC ag(
		(mode = DWELL and wp = 0)
		implies ax((mode = MOVING and wp = 1) or (mode != MOVING and wp = 0))
	)
	CTLSPEC ag(
		(mode = DWELL and wp = 1)
		implies ax((mode = MOVING and wp = 2) or (mode != MOVING and wp = 1))
	)
	CTLSPEC ag(
		(mode = DWELL and wp = 2)
		implies ax((mode = MOVING and wp = 3) or (mode != MOVING and wp = 2))
	)
	CTLSPEC ag(
		(mode = DWELL and wp = 3)
		implies ax((mode = MOVING and wp = 0) or (mode != MOVING and wp = 3))
	)
	CTLSPEC ag(mode = MOVING implies target = wp)
	// the battery is charged before the tour goes on
	CTLSPEC ag((mode = HOMING and reached and not estop) implies ax(mode = CHARGING))
	CTLSPEC ag((mode = HOMING and not reached and not estop) implies ax(mode = HOMING))
	CTLSPEC ag((mode = CHARGING and full and not estop) implies ax(mode = READY))
	CTLSPEC ag((mode = CHARGING and not full and not estop) implies ax(mode = CHARGING))
	CTLSPEC ag(ef(mode = MOVING))

	main rule r_Main =
		if estop then
			mode := ESTOPPED
		else
			switch mode
				case ESTOPPED:
					if resetByOperator then mode := READY endif
				case READY:
					if start then par mode := MOVING  target := wp endpar endif
				case MOVING:
					if lowBattery then
						mode := HOMING
					else if pause then
						mode := PAUSED
					else if reached then
						mode := DWELL
					endif endif endif
				case DWELL:
					if lowBattery then
						mode := HOMING
					else if pause then
						mode := PAUSED
					else if dwellOver then
						if wp = 3 then
							par wp := 0  target := 0  mode := MOVING endpar
						else
							par wp := wp + 1  target := wp + 1  mode := MOVING endpar
						endif
					endif endif endif
				case PAUSED:
					if lowBattery then
						mode := HOMING
					else if resume then
						par mode := MOVING  target := wp endpar
					endif endif
				case HOMING:
					if reached then mode := CHARGING endif
				case CHARGING:
					if full then mode := READY endif
			endswitch
		endif

default init s0:
	function mode = READY
	function wp = 0
	function target = 0
