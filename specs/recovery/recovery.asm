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

	macro rule r_giveUp =
		par
			recovery := HUMAN
			mode := GIVE_UP
		endpar

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
			r_giveUp[]
		endif

	// a retry must cancel the previous call, or else the action may be executed twice (PlanSys2 #400)
	//@Final SUCCESS GIVE_UP
	CTLSPEC ag(sendCall implies (mode = WAIT and outstanding))
	CTLSPEC ag(not (sendCall and cancelCall))
	CTLSPEC ag(mode = CALL implies not cancelCall)
	CTLSPEC ag(mode = WAIT iff outstanding)
	CTLSPEC ag(mode = CALL implies ax(sendCall and mode = WAIT))
	CTLSPEC ag(
		(mode = WAIT and not (reply != NONE and replyIsForMe) and deadlinePassed)
		implies ax(cancelCall)
	)
	CTLSPEC ag(
		(mode = WAIT and not (reply != NONE and replyIsForMe) and not deadlinePassed)
		implies ax(mode = WAIT and not sendCall)
	)
	CTLSPEC ag((mode = WAIT and reply = OK and replyIsForMe) implies ax(mode = SUCCESS))
	CTLSPEC ag(
		(mode = WAIT and reply = TRANSIENT and replyIsForMe and retries < 3)
		implies ax(mode = RECOVERING)
	)
	CTLSPEC ag((mode = WAIT and reply = FATAL and replyIsForMe) implies ax(mode = GIVE_UP))
	CTLSPEC ag((mode = RECOVERING and recoveryDone) implies ax(mode = CALL))
	CTLSPEC ag((mode = RECOVERING and not recoveryDone) implies ax(mode = RECOVERING))
	CTLSPEC ag((mode = RECOVERING and retries = 1) implies recovery = CLEAR_MAP)
	CTLSPEC ag((mode = RECOVERING and retries = 2) implies recovery = SPIN)
	CTLSPEC ag((mode = RECOVERING and retries = 3) implies recovery = BACK_UP)
	CTLSPEC ag(mode = GIVE_UP implies (retries = 3 and recovery = HUMAN))
	CTLSPEC ef(mode = RECOVERING and retries = 3)
	CTLSPEC ag(ef(mode = GIVE_UP or mode = SUCCESS))

	main rule r_Main =
		switch mode
			case CALL:
				par
					sendCall := true
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
								par retries := 3  r_giveUp[] endpar
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
