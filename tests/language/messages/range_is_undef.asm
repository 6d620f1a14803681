asm range_is_undef
import StandardLibrary
signature:
  controlled open: Powerset(Integer)
  controlled x: Integer
definitions:
  main rule r_Main = forall $n in open do x := $n  //~ R006
