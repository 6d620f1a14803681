asm unfit_protocol
import StandardLibrary

signature:
	enum domain Speed = {SLOW | FAST}
	enum domain Side = {LEFT | RIGHT}
	monitored command: Side -> Boolean
	// not a message
	controlled speed: Speed
	//@Port maps.getMap
	monitored request: Speed
	//@Port maps.getMap
	out answer: Boolean
	//@Port event.code
	out event: Boolean
	//@Port event.detail
	out detail: Integer

definitions:
	main rule r_Main = skip

default init s0:
