// values that differ from one element to the next clash
asm forall_clash
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = forall $a in {1, 2} do x := $a
//= step 1: R001
