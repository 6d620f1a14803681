// the program of a domain may be a rule with an argument
asm agents_program_with_argument
import StandardLibrary
signature:
  domain Worker subsetof Agent
  static w: Worker
  controlled n: Agent -> Integer
definitions:
  rule r_work($k in Integer) = n(self) := $k
  main rule r_Main = program(w)
default init s0:
  agent Worker: r_work[42]
//= step 1: n(w) := 42
