asm unknown_variable_out_of_scope
import StandardLibrary
signature:
  controlled f: Integer -> Integer
definitions:
  main rule r_Main = par
    forall $i in {1 : 2} do f($i) := 1
    f($i) := 2  //~ W021 R017
  endpar
