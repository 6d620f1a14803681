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
	out target: Wp
	controlled wp: Wp
	controlled mode: Mode

definitions:
	domain Wp = {0 : 3}
	CTLSPEC ag(mode = ESTOPPED implies ax(mode = ESTOPPED or mode = READY))
	CTLSPEC ag(estop implies ax(mode = ESTOPPED))
	CTLSPEC ag((mode = PAUSED and wp = 2) implies ax(wp = 2))
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
