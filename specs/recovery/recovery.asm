asm recovery
// A service call with a timeout, bounded retries, a round-robin of recovery actions, and escalation
import StandardLibrary
import CTLLibrary

signature:
	enum domain Mode = {CALL | WAIT | RECOVERING | GIVE_UP | SUCCESS}
	enum domain Reply = {NONE | OK | TRANSIENT | FATAL}
	enum domain Rec = {CLEAR_MAP | SPIN | BACK_UP | HUMAN}
	domain N subsetof Integer
	monitored reply: Reply
	monitored deadlinePassed: Boolean
	monitored recoveryDone: Boolean
	monitored replyIsForMe: Boolean
	out sendCall: Boolean
	out cancelCall: Boolean
	out recovery: Rec
	controlled mode: Mode
	controlled retries: N
	controlled nextRec: Rec
	controlled outstanding: Boolean

definitions:
	domain N = {0 : 3}

	macro rule r_fail =
		if retries < 3 then
			par
				retries := retries + 1
				recovery := nextRec
				nextRec :=
					if nextRec = CLEAR_MAP then
						SPIN
					else if nextRec = SPIN then
						BACK_UP
					else
						HUMAN
					endif endif
				mode := RECOVERING
			endpar
		else
			mode := GIVE_UP
		endif

	// a retry must cancel the previous call, or else the action may be executed twice (PlanSys2 #400)
	//@Final SUCCESS GIVE_UP
	CTLSPEC ag((sendCall and outstanding) implies mode = WAIT)
	CTLSPEC ag(mode = CALL implies not outstanding)
	CTLSPEC ag(mode = RECOVERING implies not outstanding)
	CTLSPEC ag(mode = GIVE_UP implies retries = 3)
	CTLSPEC ag(ef(mode = GIVE_UP or mode = SUCCESS))

	main rule r_Main =
		switch mode
			case CALL:
				par
					sendCall := true
					cancelCall := false
					outstanding := true
					mode := WAIT
				endpar
			case WAIT:
				par
					sendCall := false
					if reply != NONE and replyIsForMe then
						par
							outstanding := false
							if reply = OK then
								mode := SUCCESS
							else if reply = FATAL then
								par retries := 3  mode := GIVE_UP endpar
							else
								r_fail[]
							endif endif
						endpar
					else if deadlinePassed then
						par
							outstanding := false
							cancelCall := true
							r_fail[]
						endpar
					endif endif
				endpar
			case RECOVERING:
				if recoveryDone then par cancelCall := false  mode := CALL endpar endif
		endswitch

default init s0:
	function mode = CALL
	function retries = 0
	function nextRec = CLEAR_MAP
	function outstanding = false
	function sendCall = false
	function cancelCall = false
