// two values for a location: there is no next state
asm par_clash
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par x := 1  x := 2 endpar
//= step 1: R001
