asm estop
// E-stop: three independent sources, latched; restart in two steps by the operator, never automatically
import StandardLibrary
import CTLLibrary

signature:
	enum domain Mode = {RUN | LATCHED | ARMED}
	domain Speed subsetof Integer
	monitored button: Boolean
	monitored remote: Boolean
	monitored watchdogLost: Boolean
	monitored reset: Boolean
	monitored confirm: Boolean
	derived stopRequested: Boolean
	out speedLimit: Speed
	controlled mode: Mode

definitions:
	domain Speed = {0 : 2}
	function stopRequested = button or remote or watchdogLost
	CTLSPEC ag((button or remote or watchdogLost) implies ax(mode = LATCHED and speedLimit = 0))
	CTLSPEC ag(mode = LATCHED implies ax(mode != RUN))
	CTLSPEC ag((mode = LATCHED and not reset) implies ax(mode = LATCHED))
	CTLSPEC ag((mode = ARMED and not confirm) implies ax(mode != RUN))
	CTLSPEC ag(mode = RUN iff speedLimit = 2)
	CTLSPEC ag(mode != RUN implies speedLimit = 0)
	CTLSPEC ag(ef(mode = RUN))

	main rule r_Main =
		if stopRequested then
			par mode := LATCHED  speedLimit := 0 endpar
		else if mode = LATCHED and reset then
			mode := ARMED
		else if mode = ARMED and confirm then
			par mode := RUN  speedLimit := 2 endpar
		endif endif endif

default init s0:
	function mode = LATCHED
	function speedLimit = 0
