// an agent and its name; elements of the reserve have names too
asm agents_by_name
import StandardLibrary
signature:
  domain Robot subsetof Agent
  static rob: Robot
  controlled name: String
  controlled other: Agent
  controlled nobody: Agent
definitions:
  main rule r_Main = par
    name := id(rob)
    other := getAgent("rob")
    nobody := getAgent("rub")
  endpar
//= step 1: name := "rob", nobody := undef, other := rob
