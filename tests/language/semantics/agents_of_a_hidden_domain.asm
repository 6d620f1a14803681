// an agent finds its domain in an imported file even if that does not export it
asm agents_of_a_hidden_domain
import StandardLibrary
import crew
signature:
  controlled n: Integer
definitions:
  rule r_work = n := 1
  main rule r_Main = r_all[]
default init s0:
  agent Worker: r_work[]
//= step 1: n := 1
//--- crew.asm
module crew
import StandardLibrary
export r_all
signature:
  domain Worker subsetof Agent
  static ann: Worker
definitions:
  rule r_all = forall $w in Worker do program($w)
