asm no_input
import StandardLibrary
signature:
  monitored goal: Integer
  controlled x: Integer
definitions:
  main rule r_Main = x := goal  //~ R013
