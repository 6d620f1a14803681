asm annotated
import StandardLibrary
import CommonBehavior
//@Provided
import Guide
signature:
	domain Maps subsetof Agent
	//@Reference
	shared maps: Agent -> Maps
definitions:
	main rule r_Main = skip
