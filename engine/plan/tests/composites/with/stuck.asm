asm stuck
signature:
	enum domain Mode = {IDLE | RUNNING | PARKED | FAILED}
	monitored estop: Boolean
	monitored parks: Boolean
	controlled mode: Mode
definitions:
	//@Final PARKED
	main rule r_Main =
		switch mode
			case IDLE: if estop then skip else mode := RUNNING endif
			case RUNNING:
				if estop then mode := FAILED
				else if parks then mode := PARKED endif endif
		endswitch
default init s0:
	function mode = IDLE
