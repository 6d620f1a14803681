asm clash_of_agents
import StandardLibrary
signature:
  domain Robot subsetof Agent
  static a: Robot
  static b: Robot
  controlled next: Robot
  controlled at: Robot -> Integer
definitions:
  rule r_move = par at(self) := 1  next := self endpar  //~ R001
  main rule r_Main = forall $r in Robot do program($r)
default init s0:
  agent Robot: r_move[]
