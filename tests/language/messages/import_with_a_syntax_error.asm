// an import that cannot be read is one mistake: names that it may bring have no findings of their own
asm import_with_a_syntax_error
import StandardLibrary
import mod                                   //~ L058
signature:
  controlled side: Side
  controlled n: Integer
definitions:
  main rule r_Main = par
    side := LEFT
    n := grip + 1
    r_stop[]
  endpar
default init s0:
  function battery = 100
