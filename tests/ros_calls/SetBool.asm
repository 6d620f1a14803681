module SetBool
import StandardLibrary

export *

signature:
	domain SetBool subsetof Agent
	out call: Prod(Agent, Map(String, Boolean)) -> Prod(Boolean, String)

definitions:
