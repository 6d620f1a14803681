asm youbot
// Locomotor: idle must mean "motion finished", not "command written" (seed listing 1.6)
import StandardLibrary
import CTLLibrary

signature:
	enum domain Mode = {IDLE | BUSY | FAULT}
	enum domain Note = {QUIET | NOTE_IDLE | NOTE_BUSY | NOTE_REFRESH | NOTE_FAULT}
	monitored moveRequest: Boolean
	monitored newStatus: Boolean
	monitored withinTolerance: Boolean
	monitored errorFlags: Boolean
	monitored stale: Boolean
	out notify: Note
	controlled mode: Mode
	out writeCommands: Boolean

definitions:
	CTLSPEC ag(notify = NOTE_IDLE implies mode = IDLE)
	CTLSPEC ag(writeCommands implies mode = BUSY)
	CTLSPEC ag(mode = BUSY implies ef(mode = IDLE))
	CTLSPEC ag((mode = BUSY and errorFlags and newStatus) implies ax(mode = FAULT))

	main rule r_Main =
		if mode = BUSY and (stale or (newStatus and errorFlags)) then
			par mode := FAULT  notify := NOTE_FAULT  writeCommands := false endpar
		else if mode = BUSY and newStatus and withinTolerance then
			par mode := IDLE  notify := NOTE_IDLE  writeCommands := false endpar
		else if newStatus then
			par notify := NOTE_REFRESH  writeCommands := false endpar
		else if mode = IDLE and moveRequest then
			par mode := BUSY  notify := NOTE_BUSY  writeCommands := true endpar
		else if mode = FAULT and moveRequest and not errorFlags then
			par mode := BUSY  notify := NOTE_BUSY  writeCommands := true endpar
		else
			par notify := QUIET  writeCommands := false endpar
		endif endif endif endif endif

default init s0:
	function mode = IDLE
	function notify = QUIET
	function writeCommands = false
