asm tracker
// Turns the camera: from side to side while sweeping, towards the ball while tracking.
import StandardLibrary

signature:
	enum domain Command = {REST | SWEEP | TRACK}
	enum domain Sight = {SEEN | LOST}
	monitored command: Command
	monitored sight: Sight
	monitored offset: Real
	// direction of the camera in degrees
	out pan: Real
	out centred: Boolean
	controlled sweeps: Real

definitions:
	rule r_sweep =
		par
			if abs(pan + sweeps) > 45.0 then sweeps := 0.0 - sweeps else pan := pan + sweeps endif
			centred := false
		endpar

	rule r_track =
		if sight = SEEN then
			par pan := pan + offset / 2.0  centred := abs(offset) < 4.0 endpar
		else
			centred := false
		endif

	main rule r_Main =
		switch command
			case REST: centred := false
			case SWEEP: r_sweep[]
			case TRACK: r_track[]
		endswitch

default init s0:
	function pan = 0.0
	function centred = false
	function sweeps = 3.0
