//@Remotable
module Dispatch
// Who hands out jobs to couriers: what it can be asked.
import StandardLibrary
import CommonBehavior

export *

signature:
	domain Dispatch subsetof Agent

	// where a courier that stands somewhere is to go next
	out job: Prod(Agent, Integer) -> Integer
	// a courier has arrived there; this has no answer
	out done: Prod(Agent, Integer) -> Rule

definitions:
