// a macro may assign the variable it is given, a turbo rule has its own
asm variable_assigned_by_macro
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  rule r_inc($v in Integer) = $v := $v + 1
  turbo rule r_spoil($v in Integer) = seq $v := $v + 100 y := $v endseq
  main rule r_Main = forall $a in {5} do seq
    r_inc[$a]
    r_spoil($a)
    x := $a
  endseq
//= step 1: x := 6, y := 106
