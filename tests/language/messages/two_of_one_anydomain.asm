asm two_of_one_anydomain
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  macro rule r_pair($a in D, $b in D) = x := 1
  main rule r_Main =
    r_pair[1, "one"]  //~ A007
