asm gripper
// grips or lets go, as it is asked to
import StandardLibrary
import CommonBehavior
//@Provided
import SetBool

signature:
	//@Backref
	shared client: Agent -> Agent
	controlled wanted: Map(String, Boolean)

definitions:
	//@Service
	rule r_call =
		seq
			r_wreceive[client(self), "call", wanted]
			r_wreply[client(self), "call", (at(wanted, "data"), if at(wanted, "data") then "gripped" else "let go" endif)]
		endseq

	main rule r_Main =
		if nextRequest(self) = "call" then r_call[] endif
