// a new agent has the program of its domain
asm agents_extended
import StandardLibrary
signature:
  domain Worker subsetof Agent
  controlled n: Agent -> Integer
definitions:
  rule r_work = n(self) := size(Worker)
  main rule r_Main = par
    extend Worker with $w do skip
    forall $a in Worker do program($a)
  endpar
default init s0:
  agent Worker: r_work[]
//= step 1: Worker + {worker!1}
//= step 2: Worker + {worker!2}, n(worker!1) := 1
