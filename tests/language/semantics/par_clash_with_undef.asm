// undef is a value like any other
asm par_clash_with_undef
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par x := 1  x := undef endpar
//= step 1: R001
