// without else it is undef
asm if_term
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  main rule r_Main = par x := if true then 1 else 2 endif + 1  y := if false then 1 endif endpar
//= step 1: x := 2, y := undef
