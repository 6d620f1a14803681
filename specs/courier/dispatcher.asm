asm dispatcher
// Assigns jobs: the destination is always three places further on a circle of ten. Counts finished jobs.
import StandardLibrary
import CommonBehavior
//@Provided
import Dispatch

signature:
	//@Backref
	shared client: Agent -> Agent
	controlled place: Integer
	controlled reported: Integer
	controlled finished: Integer

definitions:
	//@Service
	rule r_job =
		seq
			r_wreceive[client(self), "job", place]
			r_wreply[client(self), "job", (place + 3) mod 10]
		endseq

	//@Service
	rule r_done =
		par
			r_wreceive[client(self), "done", reported]
			finished := finished + 1
		endpar

	main rule r_Main =
		switch nextRequest(self)
			case "job": r_job[]
			case "done": r_done[]
		endswitch

default init s0:
	function finished = 0
