//@Remotable
module Guide
import StandardLibrary
import CommonBehavior
export *
signature:
	domain Guide subsetof Agent
	out way: Prod(Agent, Integer) -> Integer
definitions:
