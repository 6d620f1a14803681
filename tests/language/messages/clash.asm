asm clash
import StandardLibrary
signature:
  controlled mode: Integer
definitions:
  rule r_plan = mode := 1
  rule r_stop = mode := 2  //~ R001
  main rule r_Main = par r_plan[]  r_stop[] endpar
