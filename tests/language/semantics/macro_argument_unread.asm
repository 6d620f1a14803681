// an argument that the macro does not read is not computed, and its inputs are not asked for
asm macro_argument_unread
import StandardLibrary
signature:
  controlled x: Integer
  monitored unread: Integer
definitions:
  rule r_maybe($go in Boolean, $v in Integer) = if $go then x := $v endif
  main rule r_Main = par
    r_maybe[false, idiv(1, 0)]
    r_maybe[false, unread]
    r_maybe[true, 3]
  endpar
//= step 1: x := 3
