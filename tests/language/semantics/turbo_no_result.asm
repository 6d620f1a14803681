// a rule that sets no result gives undef
asm turbo_no_result
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  turbo rule r_none in Integer = skip
  main rule r_Main = x <- r_none()
default init s0:
  function x = 1
//= step 1: x := undef
