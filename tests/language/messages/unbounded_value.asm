asm unbounded_value
import StandardLibrary
signature:
  controlled x: Any
definitions:
  main rule r_Main = while true do x := [x]  //~ R016
