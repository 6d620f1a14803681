asm timer
import StandardLibrary
signature:
	monitored late: Boolean
	controlled busy: Boolean
definitions:
	main rule r_Main = if late then busy := false endif
