// an import may ask for some of the names only: the others are free
asm import_named
import StandardLibrary
import lights(r_switch)
signature:
  controlled light: Integer
definitions:
  main rule r_Main = par light := 1  r_switch[] endpar
//= step 1: light := 1, light := true
//--- lights.asm
module lights
import StandardLibrary
export *
signature:
  controlled light: Boolean
definitions:
  rule r_switch = light := true
