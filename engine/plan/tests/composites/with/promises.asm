asm promises
import StandardLibrary
import CTLLibrary
signature:
	monitored estop: Boolean
	controlled moving: Boolean
definitions:
	CTLSPEC ag(estop implies ax(not moving))
	CTLSPEC ag(ef(moving))
	CTLSPEC ag(estop implies au(estop, not moving))
	//@Within soon
	CTLSPEC ag(estop implies af(not moving))
	main rule r_Main = moving := not estop
default init s0:
	function moving = false
