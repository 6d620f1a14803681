asm local_in_signature
import StandardLibrary
signature:
  local x: Integer  //~ W026
definitions:
  main rule r_Main = x := 1
