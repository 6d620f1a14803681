// `self.f` is the location of the agent that runs
asm agents_dot
import StandardLibrary
signature:
  domain Worker subsetof Agent
  static w: Worker
  controlled n: Agent -> Integer
definitions:
  rule r_work = self.n := self.n + 1
  main rule r_Main = program(w)
default init s0:
  function n($a in Agent) = 4
  agent Worker: r_work[]
//= step 1: n(w) := 5
