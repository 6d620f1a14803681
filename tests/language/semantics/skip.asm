// does nothing
asm skip
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = skip
//= step 1: nothing
