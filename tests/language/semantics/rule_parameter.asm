// a macro may take a rule and run it
asm rule_parameter
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_one = x := 1
  rule r_when($b in Boolean, $then in Rule) = if $b then $then endif
  main rule r_Main = r_when[true, <<r_one>>]
//= step 1: x := 1
