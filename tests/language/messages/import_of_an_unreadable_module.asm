// a module whose text is no module is one mistake: names that it may declare have no findings of their own
asm import_of_an_unreadable_module
import StandardLibrary
import notes
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
//--- notes.asm
Remember to charge.                          //~ L021
