asm partner
// calls its partner when it is asked to, and says the answer, or why there is none
import StandardLibrary
import CommonBehavior
//@Required
import SetBool

signature:
	enum domain Mode = {IDLE | CALLING}

	//@Reference
	shared gripper: Agent -> SetBool
	monitored asked: Boolean
	controlled mode: Mode
	controlled answer: Prod(Boolean, String)
	out said: String

definitions:
	rule r_call =
		par
			r_wcall[gripper(self), "call", {"data" -> true}, 1000, answer]
			if isDef(answer) then
				par
					said := second(answer)
					answer := undef
					mode := IDLE
				endpar
			endif
			if isDef(callFault(self, "call")) then
				par
					said := toString(callFault(self, "call"))
					r_wcancel[gripper(self), "call"]
					mode := IDLE
				endpar
			endif
		endpar

	main rule r_Main =
		switch mode
			case IDLE: if asked then mode := CALLING endif
			case CALLING: r_call[]
		endswitch

default init s0:
	function mode = IDLE
