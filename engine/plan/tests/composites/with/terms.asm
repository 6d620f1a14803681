asm terms
import StandardLibrary
signature:
	enum domain Mode = {IDLE | BUSY}
	enum domain Action = {NOACT | SEND | SHOW | STOP}
	monitored late: Boolean
	monitored stuck: Boolean
	monitored tour: Seq(Prod(Real, Real))
	shared near: Mode -> Boolean
	out command: Action
	controlled mode: Mode
	controlled goal: Prod(Real, Real)
definitions:
	main rule r_Main = if late or stuck or near(mode) then goal := first(tour) endif
