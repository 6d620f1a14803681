asm rule_value_arity
import StandardLibrary
signature:
  controlled act: Rule(Integer)
  controlled x: Integer
definitions:
  rule r_set($n in Integer) = x := $n
  main rule r_Main = act  //~ R008
default init s0:
  function act = <<r_set(Integer)>>
