//@Remotable
module Dispatch
// The operations of a dispatcher, which assigns jobs to couriers.
import StandardLibrary
import CommonBehavior

export *

signature:
	domain Dispatch subsetof Agent

	// returns the next destination of a courier at this place
	out job: Prod(Agent, Integer) -> Integer
	// reports the arrival of a courier at its destination; no reply
	out done: Prod(Agent, Integer) -> Rule

definitions:
