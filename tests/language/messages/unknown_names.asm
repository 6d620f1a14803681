// an unknown name is reported once, with its other places
asm unknown_names
import StandardLibrary
signature:
  controlled n: Integer
  controlled where: Robott -> Integer  //~ A004
  controlled goal: Robott
definitions:
  rule r_stop = n := 0
  main rule r_Main = par
    r_stopp[]  //~ A003
    if n = 1 then r_stopp[] endif
    r_begin[]  //~ A003
    r_begin[]
    r_begin[]
    r_begin[]
    r_begin[]
    n := spede  //~ A001
    if spede > 1 then n := RED endif  //~ A005
    n := RED
  endpar
