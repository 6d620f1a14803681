asm driver
// drives for twenty steps to every goal, and says where it is
import StandardLibrary
import CommonBehavior

signature:
	//@Backref
	shared client: Agent -> Agent
	controlled goal: Map(String, Any)
	controlled asker: Agent
	controlled left: Integer
	out position: Real

definitions:
	rule r_take =
		par
			asker := client(self)
			r_wreceive[client(self), "call", goal]
			left := 20
		endpar

	rule r_drive =
		par
			left := left - 1
			position := itor(21 - left)
			if left = 1 then r_wreply[asker, "call", {->}] endif
		endpar

	main rule r_Main =
		if left > 0 then r_drive[]
		else if nextRequest(self) = "call" then r_take[] endif endif

default init s0:
	function left = 0
