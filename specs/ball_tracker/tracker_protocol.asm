asm tracker_protocol
// The tracker as others see it: it says when the ball is centred, which it can be only while the tracker follows it.
import StandardLibrary

signature:
	enum domain Command = {REST | SWEEP | TRACK}

	//@Port command
	monitored command: Command
	//@Port centred
	out centred: Boolean

	controlled order: Command
	controlled isCentred: Boolean

definitions:
	rule r_say($truth in Boolean) =
		if isCentred != $truth then
			par
				isCentred := $truth
				centred := $truth
			endpar
		endif

	main rule r_Main =
		seq
			if isDef(command) then order := command endif
			if order = TRACK then
				choose $truth in Boolean do r_say[$truth]
			else
				r_say[false]
			endif
		endseq

default init s0:
	function order = REST
	function isCentred = false
