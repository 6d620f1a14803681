asm service
// The environment of recovery.asm in a verification: a service that replies to each call or lets it time out
import StandardLibrary

signature:
	enum domain Reply = {NONE | OK | TRANSIENT | FATAL}
	monitored outstanding: Boolean
	out reply: Reply
	out replyIsForMe: Boolean
	out deadlinePassed: Boolean
	out recoveryDone: Boolean

definitions:
	rule r_reply =
		choose $reply in Reply with true do
			par
				reply := $reply
				deadlinePassed := $reply = NONE
			endpar

	main rule r_Main =
		par
			replyIsForMe := true
			recoveryDone := true
			if outstanding then
				r_reply[]
			else
				par
					reply := NONE
					deadlinePassed := false
				endpar
			endif
		endpar

default init s0:
	function reply = NONE
	function replyIsForMe = true
	function deadlinePassed = false
	function recoveryDone = true
