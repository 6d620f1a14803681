asm youbot
// Locomotor: IDLE means that the motion has ended, not that the commands were written.
import StandardLibrary
import CTLLibrary

signature:
	enum domain Mode = {IDLE | BUSY | FAULT}
	enum domain Note = {QUIET | NOTE_IDLE | NOTE_BUSY | NOTE_REFRESH | NOTE_FAULT}
	// a new goal pose for the hand has arrived
	monitored goal: Boolean
	// the joint positions for a goal have been computed
	monitored moveRequest: Boolean
	monitored newStatus: Boolean
	monitored withinTolerance: Boolean
	monitored errorFlags: Boolean
	monitored stale: Boolean
	// no driver has received the commands
	monitored unsent: Boolean
	// true for the step with a goal; the call that it makes goes on
	out solve: Boolean
	out notify: Note
	controlled mode: Mode
	// a request arrived that could not be served immediately
	controlled waiting: Boolean
	// true while the arm moves; the composite cancels a call that is not answered when it becomes false
	out writeCommands: Boolean
	// no motion can start: a fault of the arm persists, or its status is stale
	derived blocked: Boolean

definitions:
	function blocked = stale or (mode = FAULT and errorFlags)

	rule r_remember =
		if moveRequest and not (mode = FAULT and errorFlags) then waiting := true endif

	rule r_begin =
		par mode := BUSY  notify := NOTE_BUSY  writeCommands := true  waiting := false endpar

	rule r_locomote =
		if mode = BUSY and (stale or unsent or (newStatus and errorFlags)) then
			par mode := FAULT  notify := NOTE_FAULT  writeCommands := false  waiting := false endpar
		else if mode = BUSY and newStatus and withinTolerance then
			par mode := IDLE  notify := NOTE_IDLE  writeCommands := false  r_remember[] endpar
		else if newStatus then
			par notify := NOTE_REFRESH  r_remember[] endpar
		else if mode != BUSY and (moveRequest or waiting) and not blocked then
			r_begin[]
		else
			par notify := QUIET  r_remember[] endpar
		endif endif endif endif

	CTLSPEC ag(notify = NOTE_IDLE implies mode = IDLE)
	CTLSPEC ag(writeCommands implies mode = BUSY)
	CTLSPEC ag(mode = BUSY implies ef(mode = IDLE))
	CTLSPEC ag((mode = BUSY and errorFlags and newStatus) implies ax(mode = FAULT))
	CTLSPEC ag((mode = BUSY and goal) implies ax(not solve))

	main rule r_Main =
		par
			solve := goal and mode != BUSY and not blocked
			r_locomote[]
		endpar

default init s0:
	function mode = IDLE
	function notify = QUIET
	function writeCommands = false
	function solve = false
	function waiting = false
