asm protocol
// The laser scanner as others see it: one sweep for each new pose, once the scene is known.
import StandardLibrary

signature:
	// the walls and obstacles arrived
	monitored scene: Boolean
	// a pose arrived
	monitored truth: Boolean
	out scan: Boolean

	controlled known: Boolean

definitions:
	main rule r_Main =
		seq
			if scene then known := true endif
			if truth and known then scan := true endif
		endseq

default init s0:
	function known = false
