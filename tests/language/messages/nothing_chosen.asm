asyncr asm nothing_chosen
import StandardLibrary
signature:
  static a: Agent
definitions:
  rule r_agent = skip
  main rule r_Main = forall $a in Agent do program($a)  //~ W029
default init s0:
  agent Agent: r_agent[]
