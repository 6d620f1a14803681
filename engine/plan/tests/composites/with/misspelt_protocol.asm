asm misspelt_protocol
import StandardLibrary

signature:
	enum domain Code = {DONE}
	enum domain Answer = {OK}
	// the port is `command`
	monitored comand: Boolean
	//@Port command.linear.q
	monitored speed: Boolean
	//@Port maps.getMaps
	monitored request: Boolean
	//@Port maps.getMap
	out answer: Answer
	//@Port event.code
	//@Echo event.plan = comand.header.stamp
	//@Echo event.plan
	out event: Code
	out finished: Boolean

definitions:
	main rule r_Main = skip

default init s0:
