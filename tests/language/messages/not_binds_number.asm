// `not` before a comparison of numbers can only mean its negation
asm not_binds_number
import StandardLibrary
signature:
  controlled n: Integer
  controlled b: Boolean
definitions:
  rule r_a = if not n = 0 and b then skip endif  //~ A006
  rule r_b = if (not n > 1) then skip endif  //~ A006
  rule r_c = if not b != (n = 1) then skip endif  //~ W001
  rule r_d = if not (n = 0) and (not b) = b then skip endif
  main rule r_Main = skip
