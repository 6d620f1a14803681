asm no_program
import StandardLibrary
signature:
  domain Robot subsetof Agent
  static rob: Robot
definitions:
  main rule r_Main = program(rob)  //~ R009
